//! A library on a Slurm of this machine: one node of one core against two, and against a build without an engine.
//!
//! `cargo bench -p flb --bench slurm`, beside nothing else: three builds of the same species, one after the other.

#[allow(dead_code, reason = "of the tests, which use all of it")]
#[path = "../tests/it/slurm/cluster.rs"]
mod cluster;
#[allow(dead_code, reason = "of the tests, which use all of it")]
#[path = "../tests/it/flb.rs"]
mod flb;

use std::fmt::Write;
use std::fs;
use std::time::Instant;

use cluster::Cluster;
use flb::Folder;

const SPECIES: usize = 24;
/// Seconds that a task is expected to take, of the species that it holds.
const CHUNK_S: &str = "15";

fn farm() -> Folder {
    let folder = Folder::new();
    let mut text = "[bake]\nlattice = 32\n".to_owned();
    for number in 0..SPECIES {
        let (seed, mesh) = (number.to_string(), format!("shrub-{number}.glb"));
        let grow = ["grow", "shrub", "--triangles", "4000", "--seed", &seed, "-o", &mesh];
        folder.flb(&grow).expect_code(0);
        let _ = write!(text, "[[species]]\nmesh = '{mesh}'\n");
    }
    folder.write("library.toml", text);
    folder
}

fn clear(folder: &Folder) {
    for name in ["library", ".flb-cache"] {
        if folder.path(name).exists() {
            fs::remove_dir_all(folder.path(name)).expect("our own folder");
        }
    }
}

/// Seconds from the submission until the queue is empty and the library is there.
fn on_cluster(cluster: &Cluster) -> f64 {
    clear(&cluster.folder);
    let begin = Instant::now();
    cluster.flb(&["farm", "submit", "--engine", "slurm", "--chunk", CHUNK_S, "--cores", "1"]).expect_code(0);
    cluster.flb(&["farm", "wait", "--interval", "0.2"]).expect_code(0);
    begin.elapsed().as_secs_f64()
}

fn main() {
    let folder = farm();
    let begin = Instant::now();
    folder.flb(&["--threads", "1", "library", "build", "--jobs", "1"]).expect_code(0);
    let alone_s = begin.elapsed().as_secs_f64();
    let alone = folder.read("library/library.flb");
    let cluster = Cluster::start(folder);
    let two_s = on_cluster(&cluster);
    assert!(cluster.folder.read("library/library.flb") == alone, "the same bytes");
    let drain = ["update", "NodeName=n2", "State=DRAIN", "Reason=alone"];
    assert!(cluster.command("scontrol").args(drain).status().expect("Slurm").success());
    let one_s = on_cluster(&cluster);
    println!(
        "{SPECIES} species: without an engine, one core {alone_s:.1} s; one node {one_s:.1} s, two nodes {two_s:.1} s"
    );
    println!(
        "two nodes are {:.2} times as fast as one; one node takes {:+.1} % over no engine",
        one_s / two_s,
        100.0 * (one_s / alone_s - 1.0)
    );
}

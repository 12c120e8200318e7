//! Every command of the book's page of a nightly build, as it stands there, on plants of its own and a real Slurm.

use std::process::Command;

use crate::flb::Folder;
use crate::slurm::cluster::Cluster;

const PAGE: &str = include_str!("../../../docs/book/src/nightly.md");

/// A block of the page: its language and its text.
fn blocks() -> Vec<(&'static str, &'static str)> {
    let mut parts = PAGE.split("\n```");
    parts.next();
    let mut blocks = Vec::new();
    while let (Some(block), Some(_)) = (parts.next(), parts.next()) {
        blocks.push(block.split_once('\n').expect("a block has lines"));
    }
    blocks
}

/// Four meshes as the page says.
fn trees() -> Folder {
    let folder = Folder::with_plants(&["oak", "spruce", "shrub"]);
    std::fs::create_dir(folder.path("trees")).expect("a folder");
    for name in ["oak.glb", "spruce.glb"] {
        std::fs::rename(folder.path(name), folder.path("trees").join(name)).expect("one disk");
    }
    let shrub = folder.read("shrub.glb");
    folder.write("trees/torn.glb", &shrub[..shrub.len() / 2]);
    let mut fern = "usemtl mat_07\n".to_owned();
    for at in 0..40 {
        let (x, y) = (f64::from(at % 8) * 0.05, f64::from(at / 8) * 0.06);
        for [u, v] in [[0.0, 0.0], [0.05, 0.02], [0.05, 0.06], [0.0, 0.05]] {
            fern += &format!("v {} {} {}\n", x + u, y + v, 0.3 * x * v + 0.1 * y);
        }
        let first = 4 * at + 1;
        fern += &format!("f {first} {} {} {}\n", first + 1, first + 2, first + 3);
    }
    folder.write("trees/fern.obj", fern);
    folder
}

#[test]
fn every_command_of_the_page_does_what_it_says() {
    let cluster = Cluster::start(trees());
    let program = std::path::Path::new(env!("CARGO_BIN_EXE_flb")).parent().expect("a folder");
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap_or_default());
    let (mut said, mut commands) = (String::new(), 0);
    for (language, text) in blocks() {
        match language {
            "toml" => _ = cluster.folder.write("trees/library.toml", text),
            "text" => {
                for line in text.lines() {
                    let line = line.trim_end_matches("...");
                    assert!(said.contains(line), "{line}: {said}");
                }
            }
            _ => {
                // What writes a file stands in many lines.
                let scripts: Vec<&str> =
                    if text.contains("<<") { vec![text] } else { text.lines().collect() };
                for script in scripts {
                    let code = script
                        .rsplit_once("# exit ")
                        .map_or(0, |(_, code)| code.trim().parse().expect(script));
                    let mut sh = Command::new("sh");
                    sh.args(["-ec", script]).current_dir(cluster.folder.path("")).env("PATH", &path);
                    let output = sh.env("SLURM_CONF", cluster.conf()).output().expect("sh");
                    said = [output.stderr, output.stdout]
                        .map(|bytes| String::from_utf8_lossy(&bytes).into_owned())
                        .concat();
                    assert_eq!(output.status.code(), Some(code), "{script}: {said}");
                    commands += 1;
                }
            }
        }
    }
    assert!(commands >= 15, "{commands}");
    assert!(said.contains("4 species there, 0 missing; in the queue: nothing"), "{said}");
    for file in ["report/junit.xml", "report/index.html", "trees/library/index.html", "last-good/library.flb"]
    {
        assert!(cluster.folder.path(file).is_file(), "{file}");
    }
}

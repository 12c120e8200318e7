//! `flb pack` killed (SIGKILL, which cannot be caught) at random moments of writing over a library: what is there
//! afterwards is the old library or the new one, to the byte. `FLB_LONG=1` kills a thousand times; without it 200.
#![cfg(unix)]

use std::collections::BTreeSet;
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::flb::{self, Folder};

const SEED: u64 = 5;
/// Kills between two measurements of how long a whole run takes, as other work on the machine comes and goes.
const KILLS_PER_MEASUREMENT: usize = 50;
/// Of fifty kills, those of each outcome: fewer say that the moments were badly spread, and the test tests little.
const MIN_KILLED: usize = 1;
const SIGKILL: i32 = 9;

/// Where a run was when it was killed.
#[derive(Debug, Default)]
struct Outcomes {
    /// No temporary file was begun.
    before: usize,
    /// A temporary file was begun, the old library is in its place.
    during: usize,
    /// The new library is in its place, the process had not ended.
    after: usize,
    /// The process had ended by itself.
    ended: usize,
}

/// Starts to write, over `out/library.flb`, the species of these files in this order.
fn start(folder: &Folder, inputs: [&str; 2]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_flb"))
        .args(["pack", inputs[0], inputs[1], "-o", "out/library.flb", "--force"])
        .current_dir(folder.path(""))
        .stdout(Stdio::null())
        .spawn()
        .expect("the command starts")
}

/// Seconds that a run takes when it is left alone: the longest of three.
fn whole_run(folder: &Folder, inputs: [&str; 2]) -> f64 {
    let run = || {
        let begin = Instant::now();
        assert!(start(folder, inputs).wait().expect("it ends").success());
        begin.elapsed().as_secs_f64()
    };
    (0..3).map(|_| run()).fold(0.0, f64::max)
}

/// Everything in the output's folder but the library.
fn left_behind(folder: &Folder) -> BTreeSet<String> {
    let mut names: BTreeSet<String> = flb::names_in(&folder.path("out")).into_iter().collect();
    assert!(names.remove("library.flb"), "the library is gone: {names:?}");
    names
}

#[test]
fn a_killed_write_leaves_the_old_library_or_the_new_one() {
    let folder = Folder::with_plants(&["leaf-card"]);
    for name in ["a", "b"] {
        let bake = ["bake", "leaf-card.glb", "--name", name, "-o", &format!("{name}.flb")];
        let flags = ["--model", "paper", "--lattice", "16", "--voxels", "64", "--codec", "raw-f32"];
        folder.flb_with(&bake, &flags).expect_code(0);
    }
    std::fs::create_dir(folder.path("out")).expect("a temporary folder");
    // The same species in two orders: every page lies elsewhere.
    let orders = [["a.flb", "b.flb"], ["b.flb", "a.flb"]];
    let libraries = orders.map(|order| {
        assert!(start(&folder, order).wait().expect("it ends").success());
        folder.read("out/library.flb")
    });
    assert!(libraries[0] != libraries[1]);

    let mut state = SEED;
    let mut share = || {
        // Knuth's MMIX generator; the upper bits are the random ones.
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let (mut old, mut outcomes, mut run_s) = (1, Outcomes::default(), 0.0);
    let mut seen = BTreeSet::new();
    let kills = if std::env::var_os("FLB_LONG").is_some() { 1000 } else { 200 };
    for kill in 0..kills {
        if kill % KILLS_PER_MEASUREMENT == 0 {
            run_s = whole_run(&folder, orders[old]);
            seen = left_behind(&folder);
            assert_eq!(
                seen,
                BTreeSet::new(),
                "a run that is left alone leaves nothing, and takes away what is left"
            );
        }
        let new = 1 - old;
        let mut child = start(&folder, orders[new]);
        thread::sleep(Duration::from_secs_f64(1.1 * run_s * share()));
        child.kill().expect("it is our child");
        let status = child.wait().expect("it was killed");

        let library = folder.read("out/library.flb");
        let left = left_behind(&folder);
        let strange = left.iter().find(|n| !(n.starts_with(".library.flb.") && n.ends_with(".tmp")));
        assert_eq!(strange, None, "kill {kill}");
        assert!(left.len() <= 1, "kill {kill}: what the run before left was not taken away: {left:?}");
        let begun = !left.is_subset(&seen);
        match (library == libraries[old], library == libraries[new]) {
            (true, _) if begun => outcomes.during += 1,
            (true, _) => outcomes.before += 1,
            (_, true) if status.signal() == Some(SIGKILL) => outcomes.after += 1,
            (_, true) => outcomes.ended += 1,
            _ => panic!("kill {kill}: {} bytes that are neither library", library.len()),
        }
        if library == libraries[new] {
            assert_eq!(
                left,
                BTreeSet::new(),
                "kill {kill}: the new library is in its place, so nothing is left"
            );
            old = new;
        }
        assert!(status.signal() == Some(SIGKILL) || status.success(), "kill {kill}: {status}");
        seen = left;
    }
    eprintln!("{outcomes:?}; {} bytes, {:.1} ms a run", libraries[0].len(), 1000.0 * run_s);
    let Outcomes { before, during, after, ended } = outcomes;
    assert_eq!(before + during + after + ended, kills);
    let least = MIN_KILLED * kills / KILLS_PER_MEASUREMENT;
    assert!(before >= least && during >= least && after + ended >= least, "{outcomes:?}");
}

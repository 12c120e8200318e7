//! Commands killed (SIGKILL, which cannot be caught) at random moments: `flb pack` as it writes over a library, after
//! which the old or the new one is there, to the byte; `flb library build`, which goes on where it was. `FLB_LONG=1`
//! kills each a thousand times.
#![cfg(unix)]

use std::collections::BTreeSet;
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::Value;

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

/// Random numbers, 0 to 1.
fn shares() -> impl FnMut() -> f64 {
    let mut state = SEED;
    move || {
        // Knuth's MMIX generator; the upper bits are the random ones.
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    }
}

fn is_long() -> bool {
    std::env::var_os("FLB_LONG").is_some()
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

    let mut share = shares();
    let (mut old, mut outcomes, mut run_s) = (1, Outcomes::default(), 0.0);
    let mut seen = BTreeSet::new();
    let kills = if is_long() { 1000 } else { 200 };
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

/// Four tiny species of a plant.
const FARM: &str = "
[bake]
quality = 'draft'
lattice = 16
voxels = 64
[[species]]
mesh = 'leaf-card.glb'
[[species.variant]]
name = 'flat'
bake = { leaf_angles = 'planophile' }
[[species.variant]]
name = 'steep'
bake = { leaf_angles = 'erectophile' }
[[species.variant]]
name = 'even'
bake = { leaf_angles = 'spherical' }
";

#[test]
fn a_library_whose_builds_are_killed_has_the_bytes_of_one_that_was_left_alone() {
    let folder = Folder::with_plants(&["leaf-card"]);
    let card = folder.read("leaf-card.glb");
    let mut text = FARM.to_owned();
    for name in ["second", "third"] {
        folder.write(&format!("{name}.glb"), &card);
        text += &FARM[FARM.find("[[species]]").expect("it has species")..].replace("leaf-card", name);
    }
    folder.write("library.toml", text);
    let build = || folder.start(&[], &["library", "build", "--jobs", "2"]);
    let clear = || {
        for name in ["library", ".flb-cache"] {
            std::fs::remove_dir_all(folder.path(name)).expect("it is there");
        }
    };
    let begin = Instant::now();
    assert!(build().wait().expect("it ends").success());
    let run_s = begin.elapsed().as_secs_f64();
    let alone = folder.read("library/library.flb");
    let species = flb::names_in(&folder.path("library/species"));
    assert_eq!(species.len(), 12);
    clear();
    let (mut share, mut rounds, mut kills) = (shares(), 0, 0);
    let wanted = if is_long() { 1000 } else { 60 };
    while kills < wanted || rounds == 0 {
        let mut child = build();
        thread::sleep(Duration::from_secs_f64(0.4 * run_s * share()));
        child.kill().expect("it is our child");
        let status = child.wait().expect("it was killed");
        if status.signal() == Some(SIGKILL) {
            kills += 1;
            continue;
        }
        // Finished in spite of all that: the same bytes, and no temporary file stays.
        assert!(status.success(), "kill {kills}: {status}");
        assert!(folder.read("library/library.flb") == alone, "kill {kills}");
        let mut found = flb::names_in(&folder.path("library/species"));
        found.retain(|name| !name.ends_with(".tmp"));
        assert_eq!(found, species, "kill {kills}");
        let run = folder.flb(&["library", "build"]).expect_code(0);
        assert!(run.stdout.contains("0 baked, 0 from the cache, 12 as they were"), "{}", run.stdout);
        let cache = folder.flb(&["cache", "verify", "--remove", "--json"]).expect_code(0).json();
        let damaged = cache["damaged"].as_array().expect("a list");
        let is_left = |one: &Value| one["name"].as_str().is_some_and(|name| name.starts_with('.'));
        assert!(damaged.iter().all(is_left), "nothing is kept half: {damaged:?}");
        clear();
        rounds += 1;
    }
    eprintln!("{kills} kills, {rounds} whole libraries, {run_s:.2} s for one that is left alone");
}

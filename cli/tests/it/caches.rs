//! A cache under attack: artefacts under the names of others, and many bakes that share one while some are killed and
//! the folder is removed. `FLB_LONG=1` bakes a thousand times; without it a hundred.
#![cfg(target_os = "linux")]

use std::process::Stdio;
use std::time::Duration;

use crate::flb::{self, Folder, names_in};

const BAKE: [&str; 8] = ["--model", "paper", "--lattice", "16", "--voxels", "64", "--cache", "cache"];

fn bake(folder: &Folder, mesh: &str, output: &str) -> flb::Run {
    folder.flb_with(&["bake", mesh, "--force", "-o", output], &BAKE)
}

fn artefacts(folder: &Folder, stage: &str) -> Vec<String> {
    names_in(&folder.path("cache")).into_iter().filter(|name| name.starts_with(stage)).collect()
}

/// Copies what one artefact holds under the name of another.
fn put(folder: &Folder, content: &[u8], name: &str) {
    std::fs::write(folder.path("cache").join(name), content).expect("writable");
}

#[test]
fn an_artefact_under_the_name_of_another_is_made_again_and_gives_the_same_bytes() {
    let folder = Folder::with_plants(&["leaf-card", "shrub"]);
    bake(&folder, "leaf-card.glb", "card.flb").expect_code(0);
    let card = folder.read("card.flb");
    let stages = ["occupancy", "medium", "field"];
    let of_card: Vec<Vec<String>> = stages.iter().map(|stage| artefacts(&folder, stage)).collect();
    bake(&folder, "shrub.glb", "shrub.flb").expect_code(0);
    let shrub = folder.read("shrub.flb");
    assert!(card != shrub);
    for (stage, names) in stages.iter().zip(&of_card) {
        let other =
            artefacts(&folder, stage).into_iter().find(|name| !names.contains(name)).expect("of the shrub");
        let content = folder.read(&format!("cache/{other}"));
        let own = folder.read(&format!("cache/{}", names[0]));
        assert!(own != content, "{stage}");
        put(&folder, &content, &names[0]);
        bake(&folder, "leaf-card.glb", "card.flb").expect_code(0).says(&["made again"]);
        assert!(folder.read("card.flb") == card, "{stage}");
        assert!(folder.read(&format!("cache/{}", names[0])) == own, "{stage}: it is mended");
    }
    // Two fields of one plant, each under the name of the other.
    let fields = &of_card[2];
    let [a, b] = [0, 1].map(|i| folder.read(&format!("cache/{}", fields[i])));
    put(&folder, &b, &fields[0]);
    put(&folder, &a, &fields[1]);
    for _ in 0..2 {
        bake(&folder, "leaf-card.glb", "card.flb").expect_code(0);
        assert!(folder.read("card.flb") == card);
    }
}

#[test]
fn bakes_that_share_a_cache_lose_nothing_though_some_are_killed_and_the_cache_goes() {
    let bakes = if std::env::var_os("FLB_LONG").is_some() { 1000 } else { 100 };
    const AT_ONCE: usize = 4;
    /// A run in so many is killed, and after so many the cache is removed.
    const EVERY: usize = 20;
    let folder = Folder::with_plants(&["leaf-card"]);
    bake(&folder, "leaf-card.glb", "whole.flb").expect_code(0);
    let whole = folder.read("whole.flb");
    let mut lost = Vec::new();
    let mut killed = 0;
    for round in 0..bakes / AT_ONCE {
        let mut running = Vec::new();
        // Half of them write the same output, too.
        for number in 0..AT_ONCE {
            let output = if number % 2 == 0 { "same.flb".to_owned() } else { format!("{number}.flb") };
            let words = [&["bake", "leaf-card.glb", "--force", "-o", &output], &BAKE[..]].concat();
            let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_flb"));
            command.args(&words).current_dir(folder.path("")).stdout(Stdio::null()).stderr(Stdio::piped());
            running.push((output, command.spawn().expect("it starts")));
        }
        if round % (EVERY / AT_ONCE) == 1 {
            std::thread::sleep(Duration::from_millis(5 + (round as u64 * 7) % 90));
            let (_, mut victim) = running.pop().expect("one of them");
            victim.kill().and_then(|()| victim.wait()).expect("it is ours");
            killed += 1;
        }
        if round % (EVERY / AT_ONCE) == 3 {
            std::thread::sleep(Duration::from_millis((round as u64 * 11) % 60));
            let _ = std::fs::remove_dir_all(folder.path("cache")); // they may be writing into it
        }
        for (output, child) in running {
            let ended = child.wait_with_output().expect("it ends");
            let stderr = String::from_utf8_lossy(&ended.stderr).into_owned();
            if ended.status.code() != Some(0) || folder.read(&output) != whole {
                lost.push(format!("round {round}, {output}: {}: {stderr}", ended.status));
            }
        }
    }
    assert!(lost.is_empty(), "{} of {bakes} lost: {lost:#?}", lost.len());
    assert!(killed >= bakes / EVERY - 1, "{killed}");
    bake(&folder, "leaf-card.glb", "whole.flb").expect_code(0);
    assert!(folder.read("whole.flb") == whole);
}

/// The moment in which a writer's new file is not locked yet, and that in which a cleaner removes it, drawn out.
#[test]
fn two_writers_that_meet_at_their_slowest_both_write() {
    let folder = Folder::with_card();
    let slow = |call: &'static str| {
        let mut strace = std::process::Command::new("strace");
        let inject = format!("inject={call}:delay_enter=60000");
        strace.args(["-o", "/dev/null", "-e", &format!("trace={call}"), "-e", &inject]);
        strace.args(["--", env!("CARGO_BIN_EXE_flb"), "pack", "card.flb", "-o", "out.flb", "--force"]);
        strace.current_dir(folder.path("")).stdout(Stdio::null()).stderr(Stdio::piped());
        strace.spawn().expect("scripts/setup installs strace")
    };
    for round in 0..6 {
        let mut both = Vec::new();
        for call in ["flock", "unlinkat", "flock"] {
            both.push(slow(call));
            std::thread::sleep(Duration::from_millis(13 * round));
        }
        for child in both {
            let output = child.wait_with_output().expect("it ends");
            let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
            assert_eq!(output.status.code(), Some(0), "round {round}: {stderr}");
        }
    }
    assert!(folder.names().iter().all(|name| !name.ends_with(".tmp")), "{:?}", folder.names());
}

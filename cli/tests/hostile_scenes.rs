//! Scenes of as many plants as there may be, and files that ask for more memory than there is: a command takes the memory of what
//! it makes of them, or ends in a clear error, and the system never ends it.
#![cfg(target_os = "linux")]

use std::fmt::Write as _;
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::flb::{Folder, Run};

mod flb;

/// Seconds of processor time after which a run counts as endless.
const ENDLESS_S: u32 = 300;

const PLANTS: usize = 1_000_000;
/// Of a plan of so many plants: their text of 49 MB, 112 bytes for each, and what any run takes.
const PLAN_PEAK_KB: u64 = 300_000;

/// A scene of a million plants of one species, with a camera and a sun, as tables or as one array.
fn scene(of_species: &str, is_array: bool) -> String {
    let top = "sun.fixed = [[135.0, 35.0]]\n\
        camera = { position_m = [0.0, 9.0, 600.0], look_at_m = [0.0, 0.0, 0.0], fov_deg = 45.0, height_px = 36 }\n";
    let mut text = top.to_owned();
    let species = format!("[[species]]\nname = \"o\"\n{of_species}\n");
    let plants = (0..PLANTS).map(|i| (i % 1000, i / 1000));
    if is_array {
        text += "instance = [\n";
        for (x, z) in plants {
            writeln!(text, "{{species=\"o\",position_m=[{x},0,{z}]}},").expect("a string takes everything");
        }
        text + "]\n" + &species
    } else {
        text += &species;
        for (x, z) in plants {
            writeln!(text, "[[instance]]\nspecies=\"o\"\nposition_m=[{x},0,{z}]")
                .expect("a string takes everything");
        }
        text
    }
}

/// How a run ends, and the most memory that it had at once, kilobytes.
fn peak(folder: &Folder, words: &[&str]) -> (i32, u64) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_flb"))
        .args(words)
        .current_dir(folder.path(""))
        .stdout(Stdio::null())
        .spawn()
        .expect("the command starts");
    let status = format!("/proc/{}/status", child.id());
    let mut peak_kb = 0;
    loop {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let found = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let found = found.and_then(|rest| rest.trim().strip_suffix(" kB")?.parse().ok());
        peak_kb = peak_kb.max(found.unwrap_or(0));
        if let Some(ended) = child.try_wait().expect("it can be waited for") {
            return (ended.code().unwrap_or(-1), peak_kb);
        }
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn within(folder: &Folder, memory_kb: u32, words: &[&str]) -> Run {
    folder.flb_under(&[format!("-v {memory_kb}"), format!("-t {ENDLESS_S}")], words)
}

#[test]
fn a_million_plants_are_planned_in_300_mb_as_tables_and_as_an_array() {
    let folder = Folder::new();
    for is_array in [false, true] {
        folder.write("a.toml", scene("", is_array));
        let (code, peak_kb) = peak(&folder, &["plan", "a.toml", "-o", "plan.toml", "--force"]);
        eprintln!("array: {is_array}: {peak_kb} kB");
        assert_eq!(code, 0);
        assert!(peak_kb > 100_000, "{peak_kb} kB: the scene itself is larger");
        assert!(peak_kb < PLAN_PEAK_KB, "{peak_kb} kB");
        let plan = String::from_utf8(folder.read("plan.toml")).expect("TOML is text");
        assert!(plan.contains("\"o\""), "{plan}");
    }
}

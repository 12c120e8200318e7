//! Signals at any moment of a run: it ends with a documented code, leaves the old file or the new one, and no temporary
//! file; a signal that the starter ignores stays ignored.
#![cfg(target_os = "linux")]

use std::os::unix::process::ExitStatusExt;
use std::process::{Command, Stdio};

use crate::flb::{Folder, names_in};
use crate::strace;

const INTERRUPTED: i32 = 130;
const PACK: &str = "pack card.flb --codec raw-f32 -o out/a.flb --force";

fn folder() -> Folder {
    let folder = Folder::with_card();
    std::fs::create_dir(folder.path("out")).expect("writable");
    folder
}

#[test]
fn a_small_stack_ends_no_command_by_a_signal() {
    let folder = Folder::with_card();
    let render =
        ["render", "card.flb", "--mesh", "leaf-card.glb", "--sun", "1,40", "--size", "8x8", "-o", "x.png"];
    let bake = ["bake", "leaf-card.glb", "--lattice", "16", "--voxels", "64", "-o", "x.flb"];
    for kb in [64, 100, 128, 8192] {
        for words in [&["--help"][..], &["info", "card.flb"], &["materials", "leaf-card.glb"], &bake, &render]
        {
            let run = folder.try_under(
                &[format!("-s {kb}")],
                &[words, if words.contains(&"-o") { &["--force"] } else { &[] }].concat(),
            );
            let run = run.unwrap_or_else(|| panic!("{words:?} with a stack of {kb} kB: a signal"));
            assert_eq!(run.code, 0, "{words:?} with a stack of {kb} kB: {}", run.stderr);
        }
    }
}

#[test]
fn a_signal_at_any_call_leaves_the_old_file_or_the_new_one_and_no_other() {
    let folder = folder();
    let words: Vec<&str> = PACK.split(' ').collect();
    let (run, trace) = strace::trace(&folder, &words);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let new = folder.read("out/a.flb");
    let (mut ended, mut finished) = (0, 0);
    // Behind the registration of the handlers, which comes with the first calls.
    for call in ["openat", "flock", "write", "fsync", "renameat", "newfstatat", "unlinkat"] {
        let (before, count) = trace.counts().get(call).copied().unwrap_or_default();
        for k in before + 2..=count {
            for signal in ["SIGINT", "SIGTERM", "SIGHUP", "SIGPIPE"] {
                folder.write("out/a.flb", "old");
                let run = strace::inject(&folder, &format!("{call}:signal={signal}:when={k}"), &words);
                let what = format!("{signal} at {call} {k}");
                match run.code {
                    INTERRUPTED if signal != "SIGPIPE" => ended += 1,
                    0 => finished += 1,
                    code => panic!("{what}: {code}: {}", run.stderr),
                }
                let found = folder.read("out/a.flb");
                assert!(found == new || (found == b"old" && run.code == INTERRUPTED), "{what}: {}", run.code);
                assert_eq!(names_in(&folder.path("out")), ["a.flb"], "{what}");
            }
        }
    }
    eprintln!("{ended} ended, {finished} finished");
    assert!(ended > 20 && finished > 10, "{ended}, {finished}");
}

/// The stages of a bake that publish: those that keep what they made in the cache, and the last.
#[test]
fn a_signal_at_any_publication_of_a_bake_leaves_no_temporary_file() {
    let folder = folder();
    let words = "bake leaf-card.glb --model paper --lattice 16 --voxels 64 --cache out -o out/a.flb --force";
    let words: Vec<&str> = words.split(' ').collect();
    let (run, trace) = strace::trace(&folder, &words);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let new = folder.read("out/a.flb");
    let mut ended = 0;
    for call in ["flock", "fsync", "renameat"] {
        let (before, count) = trace.counts().get(call).copied().unwrap_or_default();
        for k in (before + 1..=count).step_by(3) {
            std::fs::remove_dir_all(folder.path("out")).expect("it is ours");
            std::fs::create_dir(folder.path("out")).expect("writable");
            let run = strace::inject(&folder, &format!("{call}:signal=SIGTERM:when={k}"), &words);
            assert!([0, INTERRUPTED].contains(&run.code), "{call} {k}: {}: {}", run.code, run.stderr);
            ended += usize::from(run.code == INTERRUPTED);
            let left = names_in(&folder.path("out"));
            let is_whole = |name: &String| name == "a.flb" || name.ends_with(".artefact");
            assert!(left.iter().all(is_whole), "{call} {k}: {left:?}");
            assert!(!folder.path("out/a.flb").exists() || folder.read("out/a.flb") == new, "{call} {k}");
        }
    }
    assert!(ended > 10, "{ended}");
}

/// A bake that is at work, begun by a shell that ignores some signals: one that takes seconds if it `is_long`, so that
/// a signal finds it at work, however busy the machine is. What the tests themselves were started to ignore counts for
/// nothing.
fn bake(folder: &Folder, ignores: &str, is_long: bool) -> std::process::Child {
    let lattice = if is_long { "--lattice 128 --voxels 1024" } else { "--lattice 32 --voxels 256" };
    let script = format!("trap '' {ignores}; exec \"$0\" bake leaf-card.glb -o out/b.flb --force {lattice}");
    let mut shell = Command::new("env");
    shell
        .args(["--default-signal", "sh", "-c", &script, env!("CARGO_BIN_EXE_flb")])
        .current_dir(folder.path(""));
    shell.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the shell starts")
}

/// Until the command handles signals, however busy the machine is: the last handler that it registers is that of
/// SIGXFSZ.
fn wait_for_handlers(process: u32) {
    const SIGXFSZ: u32 = 25;
    for _ in 0..2000 {
        let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
        let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:"));
        let caught = caught.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
        if caught >> (SIGXFSZ - 1) & 1 == 1 {
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    panic!("it handles no signals after 20 s");
}

#[test]
fn a_signal_that_is_ignored_stays_ignored_and_others_end_a_bake() {
    use rustix::process::{Pid, Signal, kill_process};
    let folder = folder();
    for (ignores, sent, ends) in [
        ("HUP", Signal::HUP, false),
        ("INT", Signal::INT, false),
        ("INT HUP", Signal::HUP, false),
        ("HUP", Signal::INT, true),
        ("INT", Signal::TERM, true),
        ("TERM", Signal::HUP, true),
    ] {
        let mut child = bake(&folder, ignores, ends);
        wait_for_handlers(child.id());
        let pid = Pid::from_child(&child);
        kill_process(pid, sent).expect("it is ours");
        let status = child.wait().expect("it ends");
        assert_eq!(status.signal(), None, "{ignores} {sent:?}");
        match (ends, status.code()) {
            (false, Some(0)) | (true, Some(INTERRUPTED)) => {}
            (_, code) => panic!("{ignores} ignored, {sent:?} sent: {code:?}"),
        }
        let left = names_in(&folder.path("out"));
        assert!(left.iter().all(|name| name == "b.flb"), "{left:?}");
    }
}

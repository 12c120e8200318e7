//! Every system call of a command fails once: what is there afterwards is the old file or the new one, the exit code is
//! a documented one, and nothing else is left. `FLB_LONG=1` tries every call; without it a share of them.
#![cfg(target_os = "linux")]

use std::collections::BTreeMap;

use crate::flb::{Folder, Run, names_in};
use crate::strace;

/// Of the calls of a kind, those that are tried: the first and the last of them, which open and publish, and some
/// between.
const ENDS: usize = 8;
const BETWEEN: usize = 3;

/// How calls fail. Those of `memory` may end in an internal error: a thread that has no stack cannot start.
const FAULTS: [(&str, &[&str]); 17] = [
    ("openat", &["EACCES", "EMFILE", "EIO"]),
    ("read", &["EIO"]),
    ("pread64", &["EIO"]),
    ("write", &["ENOSPC", "EIO", "EPIPE"]),
    ("fsync", &["EIO", "ENOSPC"]),
    ("flock", &["ENOLCK", "EWOULDBLOCK", "ENOSYS"]),
    ("rename", &["EIO", "EACCES"]),
    ("renameat", &["EIO", "EACCES", "EXDEV"]),
    ("renameat2", &["EIO", "EINVAL", "ENOSYS"]),
    ("unlinkat", &["EIO"]),
    ("linkat", &["EPERM"]),
    ("statx", &["EIO", "ENOMEM"]),
    ("newfstatat", &["EIO"]),
    ("fchmod", &["EPERM"]),
    ("getdents64", &["EIO"]),
    ("close", &["EIO"]),
    ("mkdir", &["ENOSPC"]),
];
/// Calls that the system may cut short at any time, after which they are made again.
const INTERRUPTIBLE: [&str; 8] =
    ["openat", "read", "pread64", "write", "fsync", "flock", "renameat", "fchmod"];
/// Kilobytes of address space, from what the program alone needs to more than enough.
const LIMITS_KB: std::ops::Range<u64> = 30_000..400_000;
const LIMITS: u64 = 14;

/// Words of a command, its output, and files that it may leave beside it.
struct Subject {
    words: &'static str,
    output: Option<&'static str>,
    cache: bool,
}

const SUBJECTS: [Subject; 6] = [
    Subject { words: "info card.flb --threads 2", output: None, cache: false },
    Subject { words: "validate card.flb --json --threads 2", output: None, cache: false },
    Subject {
        words: "pack card.flb --codec raw-f32 -o out/a --force --threads 2",
        output: Some("out/a"),
        cache: false,
    },
    Subject {
        words: "extract card.flb --base 1 --format npy -o out/a.npy --threads 2",
        output: Some("out/a.npy"),
        cache: false,
    },
    Subject {
        words: "plan scene.toml -o out/a.toml --force --threads 2",
        output: Some("out/a.toml"),
        cache: false,
    },
    Subject {
        words: "bake leaf-card.glb --model paper --lattice 16 --voxels 64 --cache cache --threads 2 -o out/a.flb --force",
        output: Some("out/a.flb"),
        cache: true,
    },
];

impl Subject {
    fn words(&self) -> Vec<&str> {
        self.words.split(' ').collect()
    }

    /// The folder as it is before each run.
    fn reset(&self, folder: &Folder, has_old: bool) {
        for name in ["out", "cache"] {
            let _ = std::fs::remove_dir_all(folder.path(name)); // not there at first
            std::fs::create_dir(folder.path(name)).expect("writable");
        }
        if let Some(output) = self.output.filter(|_| has_old) {
            folder.write(output, "old");
        }
    }

    /// What a run has left.
    fn check(&self, folder: &Folder, run: &Run, new: &[u8], old: Option<&[u8]>, what: &str) {
        assert!(matches!(run.code, 0..=6), "{what}: {}: {}", run.code, run.stderr);
        let Some(output) = self.output else { return };
        let found = folder.path(output).exists().then(|| folder.read(output));
        let is_new = found.as_deref() == Some(new);
        assert!(is_new || found.as_deref() == old, "{what}: {} bytes", found.map_or(0, |f| f.len()));
        assert!(run.code != 0 || is_new, "{what}: it says that all is well");
        let others = names_in(&folder.path("out"));
        assert!(others.iter().all(|name| output.ends_with(name.as_str())), "{what}: {others:?}");
        let kept = names_in(&folder.path("cache"));
        assert!(kept.iter().all(|name| name.ends_with(".artefact")), "{what}: {kept:?}");
    }
}

/// Those of `count` calls behind `before` that are tried.
fn chosen(before: usize, count: usize) -> Vec<usize> {
    let all: Vec<usize> = (before + 1..=count).collect();
    if std::env::var_os("FLB_LONG").is_some() || all.len() <= ENDS + BETWEEN {
        return all;
    }
    let middle = &all[ENDS / 2..all.len() - ENDS / 2];
    let between = (0..BETWEEN).map(|at| middle[at * middle.len() / BETWEEN]);
    all[..ENDS / 2]
        .iter()
        .copied()
        .chain(between)
        .chain(all[all.len() - ENDS / 2..].iter().copied())
        .collect()
}

/// A folder for all subjects.
fn folder() -> Folder {
    let folder = Folder::with_card();
    folder.write("scene.toml", "[sun]\nfixed = [[90.0, 40.0]]\n[[species]]\nname = \"s\"\nupright = true\n");
    folder
}

/// Calls `act` with each subject, what its whole run makes, and its calls.
fn each_subject(act: impl Fn(&Folder, &Subject, &[u8], &BTreeMap<String, (usize, usize)>)) {
    let folder = folder();
    for subject in &SUBJECTS {
        subject.reset(&folder, false);
        let (run, trace) = strace::trace(&folder, &subject.words());
        assert_eq!(run.code, 0, "{}: {}", subject.words, run.stderr);
        let new = subject.output.map(|output| folder.read(output)).unwrap_or_default();
        act(&folder, subject, &new, &trace.counts());
    }
}

#[test]
fn any_call_that_fails_leaves_the_old_file_or_the_new_one_and_a_documented_code() {
    let runs = std::cell::Cell::new([0usize; 2]);
    each_subject(|folder, subject, new, counts| {
        for (call, errors) in FAULTS {
            let (before, count) = counts.get(call).copied().unwrap_or_default();
            for (number, k) in chosen(before, count).into_iter().enumerate() {
                // One of the errors each, by turns.
                let error = errors[number % errors.len()];
                let has_old = subject.words.contains("--force") && number % 2 == 0;
                subject.reset(folder, has_old);
                let run = strace::inject(folder, &format!("{call}:error={error}:when={k}"), &subject.words());
                let what = format!("{}: {call} {k} of {count}: {error}", subject.words);
                subject.check(folder, &run, new, has_old.then_some(b"old"), &what);
                let [done, failed] = runs.get();
                runs.set([done + 1, failed + usize::from(run.code != 0)]);
            }
        }
    });
    let [done, failed] = runs.get();
    eprintln!("{done} faults, {failed} of which ended a run");
    assert!(done > 300 && failed > 100, "{done}, {failed}");
}

#[test]
fn a_call_that_is_interrupted_is_made_again() {
    let runs = std::cell::Cell::new(0);
    each_subject(|folder, subject, new, counts| {
        for call in INTERRUPTIBLE {
            let (before, count) = counts.get(call).copied().unwrap_or_default();
            for k in chosen(before, count) {
                subject.reset(folder, false);
                let run = strace::inject(folder, &format!("{call}:error=EINTR:when={k}"), &subject.words());
                let what = format!("{}: {call} {k} of {count} interrupted", subject.words);
                assert_eq!(run.code, 0, "{what}: {}", run.stderr);
                subject.check(folder, &run, new, None, &what);
                runs.set(runs.get() + 1);
            }
        }
    });
    assert!(runs.get() > 100, "{}", runs.get());
}

#[test]
fn memory_that_is_refused_ends_a_run_with_a_documented_code() {
    let runs = std::cell::Cell::new(0);
    each_subject(|folder, subject, new, counts| {
        let check = |run: &Run, what: &str| {
            match run.code {
                // The standard library panics where a thread gets no room for its signals.
                70 => assert!(run.stderr.contains("internal error"), "{what}: {}", run.stderr),
                _ => subject.check(folder, run, new, None, what),
            }
            runs.set(runs.get() + 1);
        };
        let (before, count) = counts.get("mmap").copied().unwrap_or_default();
        for k in chosen(before, count) {
            subject.reset(folder, false);
            let run = strace::inject(folder, &format!("mmap:error=ENOMEM:when={k}+"), &subject.words());
            check(&run, &format!("{}: mmap from {k} of {count} on", subject.words));
        }
        let (mut least, mut codes) = (None, std::collections::BTreeSet::new());
        for limit in 0..LIMITS {
            let limit_kb = LIMITS_KB.start + (LIMITS_KB.end - LIMITS_KB.start) * limit / LIMITS;
            let limits = [format!("-v {limit_kb}")];
            // Below this not even the program fits.
            if least.is_none() && folder.try_under(&limits, &["--version"]).is_none_or(|run| run.code != 0) {
                continue;
            }
            least = least.or(Some(limit_kb));
            subject.reset(folder, false);
            let run = folder.flb_under(&limits, &subject.words());
            codes.insert(run.code);
            check(&run, &format!("{}: {limit_kb} kB", subject.words));
        }
        assert!(codes.contains(&0), "{}: {codes:?} from {least:?} kB on", subject.words);
    });
    // Fewer of the limits let the program start, the larger it is.
    assert!(runs.get() > 80, "{}", runs.get());
}

/// Where the program itself just fits, and a thread's stack of 2 MB after it, the first memory that is missing is that
/// of its own start.
#[test]
fn memory_that_is_missing_at_the_start_is_6() {
    let folder = folder();
    let fits = |kb: u64| {
        let run = folder.try_under(&[format!("-v {kb}")], &["--version"]);
        run.is_some_and(|run| run.code == 0)
    };
    let (mut small, mut large) = (LIMITS_KB.start, LIMITS_KB.end);
    while large - small > 16 {
        let middle = (small + large) / 2;
        *if fits(middle) { &mut large } else { &mut small } = middle;
    }
    let mut refused = 0;
    for kb in (large..large + 4096).step_by(32) {
        let run = folder.flb_under(&[format!("-v {kb}")], &["info", "card.flb", "--threads", "2"]);
        assert!([0, 6].contains(&run.code), "{kb} kB: {}: {}", run.code, run.stderr);
        refused += u32::from(run.code == 6);
    }
    assert!(refused > 64, "{refused} of 128 from {large} kB on");
}

/// What fails at the cache alone is a warning.
#[test]
fn a_cache_that_fails_is_a_warning_and_the_bake_goes_on() {
    let folder = folder();
    let subject = SUBJECTS.iter().find(|subject| subject.cache).expect("one has a cache");
    subject.reset(&folder, false);
    let mut words = subject.words();
    folder.flb(&words).expect_code(0);
    let new = folder.read("out/a.flb");
    // It is a file; it is no folder that files can be made in; it is gone in the middle; it is full.
    folder.write("file", "no folder");
    for place in ["file", "file/below", "/proc/self"] {
        subject.reset(&folder, false);
        let at = words.iter().position(|word| *word == "--cache").expect("it is there") + 1;
        words[at] = place;
        folder.flb(&words).expect_code(0).says(&["warning", place, "goes on without"]);
        assert!(folder.read("out/a.flb") == new, "{place}");
    }
    subject.reset(&folder, false);
    let run = strace::inject(&folder, "mkdir:error=ENOSPC", &subject.words());
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(folder.read("out/a.flb") == new);
}

#[test]
fn a_file_that_outgrows_the_limit_of_the_shell_is_4_and_leaves_nothing() {
    let folder = folder();
    folder.write("out.flb", "old");
    // Blocks of 512 or 1024 bytes: the card has more than one of either.
    let run = folder.flb_under(&["-f 1".to_owned()], &["pack", "card.flb", "-o", "out.flb", "--force"]);
    assert_eq!(run.code, 4, "{}", run.stderr);
    assert!(run.stderr.contains("File too large"), "{}", run.stderr);
    assert_eq!(folder.read("out.flb"), b"old");
    assert!(folder.names().iter().all(|name| !name.ends_with(".tmp")), "{:?}", folder.names());
}

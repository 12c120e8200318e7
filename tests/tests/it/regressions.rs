//! Inputs that once found something, and a few made by hand, fed to what the fuzz targets call. `fuzz/README.md` says
//! how one is added.

use std::fs;
use std::path::{Path, PathBuf};

use flb_tests::targets::TARGETS;

fn files_in(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    files.sort();
    files
}

#[test]
fn every_regression_is_replayed() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("regressions");
    let names: Vec<String> = files_in(&root)
        .iter()
        .map(|path| path.file_name().expect("a name").to_string_lossy().into_owned())
        .collect();
    let mut known: Vec<&str> = TARGETS.iter().map(|(name, _)| *name).collect();
    known.sort_unstable();
    assert_eq!(names, known, "one folder for each target");
    for (name, target) in TARGETS {
        let files = files_in(&root.join(name));
        assert!(!files.is_empty(), "{name} has no input");
        for file in files {
            // The last line before a failure says which input it was.
            eprintln!("{}", file.display());
            target(&fs::read(&file).expect("it can be read"));
        }
    }
}

#[test]
fn golden_files_pass_through_every_container_target() {
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("../format-spec/golden");
    let files = files_in(&golden).into_iter().filter(|path| path.extension().is_some_and(|e| e == "flb"));
    let mut count = 0;
    for file in files {
        let bytes = fs::read(&file).expect("it can be read");
        for (_, target) in &TARGETS[..4] {
            target(&bytes);
        }
        count += 1;
    }
    assert!(count >= 8, "found {count} golden files");
}

/// Servers near those of the regressions: bytes changed, cut, doubled and mixed, by a fixed seed.
#[test]
fn servers_that_answer_at_random_keep_the_promises_of_the_client() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("regressions/remote");
    let seeds: Vec<Vec<u8>> =
        files_in(&folder).iter().map(|file| fs::read(file).expect("it can be read")).collect();
    let rounds = std::env::var("FLB_ROUNDS").map_or(4000, |rounds| rounds.parse().expect("a number"));
    let mut state = 1u64;
    let mut below = |limit: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % limit.max(1)
    };
    for round in 0..rounds {
        let mut bytes = seeds[below(seeds.len())].clone();
        for _ in 0..=below(6) {
            let at = below(bytes.len());
            match below(5) {
                0 => bytes[at] = below(256) as u8,
                1 => bytes[at] ^= 1 << below(8),
                2 => bytes.truncate(at.max(1)),
                3 => bytes.insert(at, below(256) as u8),
                _ => {
                    let other = &seeds[below(seeds.len())];
                    let from = below(other.len());
                    bytes.splice(at.max(1).min(bytes.len()).., other[from..].iter().copied());
                    bytes.push(0);
                }
            }
        }
        if std::panic::catch_unwind(|| flb_tests::targets::remote(&bytes)).is_err() {
            panic!("round {round}: {bytes:?}");
        }
    }
}

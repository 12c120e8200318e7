use std::collections::BTreeSet;
use std::path::Path;

use super::*;

/// Those of every version, by name.
fn golden() -> Vec<(String, Vec<u8>)> {
    let mut golden = Vec::new();
    for folder in ["golden", "golden/v0.1"] {
        let files =
            std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("../format-spec").join(folder));
        let paths = files.expect("golden files are in the repository").map(|e| e.expect("an entry").path());
        for path in paths.filter(|path| path.extension().is_some_and(|extension| extension == "flb")) {
            let name = path.file_name().expect("a name").to_string_lossy();
            golden.push((format!("{folder}/{name}"), std::fs::read(&path).expect("it can be read")));
        }
    }
    golden.sort();
    golden
}

const LARGE: [&str; 3] = ["giant-haar-paper", "giant-haar", "many-pages"];

#[test]
fn every_corruption_of_every_golden_file_gets_its_code() {
    let (mut wrong, mut count) = (Vec::new(), 0);
    for (i, (name, file)) in golden().into_iter().enumerate() {
        let subject = Subject::new(file, 1).unwrap_or_else(|error| panic!("{name}: {error}"));
        subject.corrupt(&mut |case| {
            // What unfolds to gigabytes is the same in every file, and takes seconds.
            if i > 0 && LARGE.contains(&case.label.as_str()) {
                return;
            }
            let found = check(&case.bytes, Level::Decode).err();
            count += 1;
            if found.as_ref().map(FormatError::code) != case.expected {
                wrong.push(format!(
                    "{name} {} {}: {:?}, found {found:?}",
                    case.kind, case.label, case.expected
                ));
            }
        });
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(count > 1000, "{count} bad files");
}

#[test]
fn what_the_test_above_leaves_out_is_there() {
    let mut labels = BTreeSet::new();
    Subject::new(golden().remove(0).1, 1).expect("a golden file").corrupt(&mut |case| {
        labels.insert(case.label);
    });
    assert!(LARGE.iter().all(|label| labels.contains(*label)));
}

#[test]
fn a_file_that_is_not_what_it_is_said_to_be_is_found() {
    // The table of the test above would hold anything, were a wrong code not seen: the good file under a bad one's
    // name.
    let (_, file) = golden().remove(0);
    let subject = Subject::new(file.clone(), 1).expect("a golden file");
    let mut seen = 0;
    subject.corrupt(&mut |case| {
        if case.expected.is_some() {
            assert!(case.bytes != file, "{} {} is the good file", case.kind, case.label);
            seen += 1;
        }
    });
    assert!(seen > 100, "{seen}");
}

#[test]
fn every_kind_is_a_file_or_a_test() {
    for (name, file) in golden() {
        let subject = Subject::new(file, 7).expect("a golden file");
        let (mut kinds, mut labels) = (BTreeSet::new(), BTreeSet::new());
        subject.corrupt(&mut |case| {
            kinds.insert(case.kind);
            assert!(
                labels.insert((case.kind, case.label.clone())),
                "{name}: {} {} twice",
                case.kind,
                case.label
            );
            let plain = case.label.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-');
            assert!(plain, "{} makes no plain file name", case.label);
        });
        kinds.extend(CONDITIONS.map(|condition| condition.kind));
        let all: BTreeSet<u8> = (1..=KINDS.len() as u8).collect();
        assert_eq!(kinds, all, "{name}");
    }
}

#[test]
fn the_tests_that_carry_conditions_are_there() {
    for condition in CONDITIONS {
        let (file, test) = condition.carried_by.split_once(": ").expect("file and test");
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(file);
        let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{file}: {error}"));
        assert!(
            text.contains(&format!("#[test]\nfn {test}()")) || text.contains(&format!("\nfn {test}()")),
            "{test}"
        );
    }
}

#[test]
fn another_seed_cuts_and_flips_elsewhere() {
    let (_, file) = golden().remove(0);
    let labels = |seed| {
        let mut labels = Vec::new();
        let subject = Subject::new(file.clone(), seed).expect("a golden file");
        subject.corrupt(&mut |case| labels.push((case.kind, case.label)));
        labels
    };
    assert_eq!(labels(1), labels(1));
    assert_ne!(labels(1), labels(2));
}

#[test]
fn a_bad_file_is_no_subject() {
    let (_, mut file) = golden().remove(0);
    file.pop();
    assert_eq!(Subject::new(file, 1).expect_err("it is cut").code(), 1008);
}

#[test]
fn a_file_taken_apart_and_put_together_is_sound() {
    for (name, file) in golden() {
        let subject = Subject::new(file, 1).expect("a golden file");
        check(&subject.draft.clone().build().bytes, Level::Decode)
            .unwrap_or_else(|error| panic!("{name}: {error}"));
    }
}

//! Every corruption of every golden file gets its code.

use std::collections::BTreeSet;

use flb_format::FormatError;
use flb_format::testing::torture::{CONDITIONS, KINDS, Subject};
use flb_format::testing::{Digests, GOLDEN, Parts, check};

fn subject(file: &[u8], seed: u64) -> Subject {
    Subject::new(file.to_vec(), seed).expect("a golden file")
}

const LARGE: [&str; 3] = ["giant-haar-paper", "giant-haar", "many-pages"];

#[test]
fn every_corruption_of_every_golden_file_gets_its_code() {
    let (mut wrong, mut count) = (Vec::new(), 0);
    for (i, (name, file)) in GOLDEN.iter().enumerate() {
        subject(file, 1).corrupt(&mut |case| {
            // What unfolds to gigabytes is the same in every file, and takes seconds.
            if i > 0 && LARGE.contains(&case.label.as_str()) {
                return;
            }
            let found = check(&case.bytes).err();
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
    subject(GOLDEN[0].1, 1).corrupt(&mut |case| {
        labels.insert(case.label);
    });
    assert!(LARGE.iter().all(|label| labels.contains(*label)));
}

#[test]
fn a_file_that_is_not_what_it_is_said_to_be_is_found() {
    // The table of the test above would hold anything, were a wrong code not seen: the good file under a bad one's
    // name.
    let (_, file) = GOLDEN[0];
    let mut seen = 0;
    subject(file, 1).corrupt(&mut |case| {
        if case.expected.is_some() {
            assert!(case.bytes != file, "{} {} is the good file", case.kind, case.label);
            seen += 1;
        }
    });
    assert!(seen > 100, "{seen}");
}

#[test]
fn every_kind_is_a_file_or_a_test() {
    for (name, file) in GOLDEN {
        let (mut kinds, mut labels) = (BTreeSet::new(), BTreeSet::new());
        subject(file, 7).corrupt(&mut |case| {
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
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(file);
        let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{file}: {error}"));
        assert!(
            text.contains(&format!("#[test]\nfn {test}()")) || text.contains(&format!("\nfn {test}()")),
            "{test}"
        );
    }
}

#[test]
fn another_seed_cuts_and_flips_elsewhere() {
    let labels = |seed| {
        let mut labels = Vec::new();
        subject(GOLDEN[0].1, seed).corrupt(&mut |case| labels.push((case.kind, case.label)));
        labels
    };
    assert_eq!(labels(1), labels(1));
    assert_ne!(labels(1), labels(2));
}

#[test]
fn a_bad_file_is_no_subject() {
    let (_, file) = GOLDEN[0];
    let cut = file[..file.len() - 1].to_vec();
    assert_eq!(Subject::new(cut, 1).expect_err("it is cut").code(), 1008);
}

#[test]
fn a_file_taken_apart_and_put_together_is_sound() {
    for (name, file) in GOLDEN {
        let mut parts = Parts::of(file);
        parts.lay_out();
        check(&parts.seal(Digests::Pages)).unwrap_or_else(|error| panic!("{name}: {error}"));
    }
}

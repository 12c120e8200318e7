//! Damaged files for fuzzing reach the checks behind the digests.

use std::collections::BTreeSet;

use flb_format::testing::damage::damage;
use flb_format::testing::{check, golden};

#[test]
fn damage_gets_past_every_digest() {
    let mut codes = BTreeSet::new();
    for name in ["raw-f32", "haar-paper", "haar-paper-zstd"] {
        let file = golden(name);
        for seed in 0..400 {
            let mut at = seed as usize;
            let mut change = |bytes: &mut Vec<u8>| {
                at = at * 31 % bytes.len();
                bytes[at] ^= 1 << (seed % 8);
                if seed % 3 == 0 {
                    bytes.truncate(bytes.len() - 1);
                }
            };
            let damaged = damage(&file, seed, &mut change).expect("a golden file opens");
            if let Err(error) = check(&damaged) {
                codes.insert(error.code());
            }
        }
    }
    for digest in [1005, 2002, 3002, 4001, 4005] {
        assert!(!codes.contains(&digest), "FLB-{digest} is a digest that was not made to fit: {codes:?}");
    }
    assert!(codes.len() >= 12, "the checks behind the digests are reached: {codes:?}");
}

#[test]
fn what_does_not_open_is_left_alone() {
    assert!(damage(b"", 1, &mut |_| ()).is_none());
    let mut file = golden("raw-f32");
    file[200] ^= 1;
    assert!(damage(&file, 1, &mut |_| ()).is_none());
}

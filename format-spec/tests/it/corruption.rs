//! Exhaustive damage to golden files: every prefix, every flipped bit of header and tables, and the
//! whole-file mishaps of a real life (measurements, section 4).

use flb_format::container::records::{KIND_BASE, PageEntry, SectionEntry};
use flb_format::container::verify;
use flb_format::error::Place;
use flb_format::testing::{Dice, Digests, GOLDEN, Parts, check, golden};
use flb_format::{Container, FormatError};

#[test]
fn every_golden_file_keeps_every_promise() {
    for (name, bytes) in GOLDEN {
        check(&bytes.to_vec()).unwrap_or_else(|error| panic!("{name}: {error}"));
    }
}

#[test]
fn the_kit_has_every_golden_file() {
    let mut names = Vec::new();
    for prefix in ["", "v0.1/"] {
        let folder = format!("{}/golden/{prefix}", env!("CARGO_MANIFEST_DIR"));
        for entry in std::fs::read_dir(folder).expect("the golden folder is in the repository") {
            let path = entry.expect("the folder can be listed").path();
            if path.extension().is_some_and(|extension| extension == "flb") {
                names.push(format!("{prefix}{}", path.file_stem().expect("a name").to_string_lossy()));
            }
        }
    }
    names.sort();
    assert_eq!(GOLDEN.iter().map(|(name, _)| *name).collect::<Vec<_>>(), names);
}

#[test]
fn taking_a_file_apart_and_joining_it_changes_nothing() {
    for (name, bytes) in GOLDEN {
        assert!(Parts::of(bytes).seal(Digests::Pages) == *bytes, "{name}");
    }
}

#[test]
fn every_truncated_prefix_is_refused() {
    for (name, bytes) in GOLDEN {
        for length in 0..bytes.len() {
            let error = Container::open(&bytes[..length].to_vec()).err();
            let error = error.unwrap_or_else(|| panic!("{name}: a prefix of {length} bytes was accepted"));
            let expected: &[u32] = if length < 128 { &[1001] } else { &[1008] };
            assert!(expected.contains(&error.code()), "{name}: {length} bytes: {error}");
        }
    }
}

#[test]
fn bytes_behind_the_end_are_refused() {
    for (name, bytes) in GOLDEN {
        let mut bytes = bytes.to_vec();
        bytes.push(0);
        assert_eq!(check(&bytes).expect_err(name).code(), 1008);
        bytes.extend([0; 1000]);
        assert_eq!(check(&bytes).expect_err(name).code(), 1008);
    }
}

#[test]
fn every_flipped_bit_of_header_and_tables_is_refused() {
    for (name, bytes) in GOLDEN {
        let tables_end = Parts::of(bytes).header.tables_end as usize;
        let mut damaged = bytes.to_vec();
        for bit in 0..tables_end * 8 {
            damaged[bit / 8] ^= 1 << (bit % 8);
            if Container::open(&damaged).is_ok() {
                panic!("{name}: flipped bit {bit} was accepted");
            }
            damaged[bit / 8] ^= 1 << (bit % 8);
        }
    }
}

#[test]
fn every_flipped_byte_behind_the_tables_is_refused_by_the_full_check() {
    for name in ["haar-paper-zstd", "raw-f16"] {
        let bytes = golden(name);
        let tables_end = Parts::of(&bytes).header.tables_end as usize;
        let mut damaged = bytes.clone();
        // Every seventh byte keeps the test short; page digests cover each byte alike.
        for at in (tables_end..bytes.len()).step_by(7) {
            damaged[at] ^= 0x10;
            let error = check(&damaged).expect_err("a flipped byte");
            assert!([4001, 4004].contains(&error.code()), "{name}, byte {at}: {error}");
            damaged[at] ^= 0x10;
        }
    }
}

#[test]
fn flipped_padding_is_found_by_the_padding_check_and_by_the_root() {
    let bytes = golden("raw-f32");
    let parts = Parts::of(&bytes);
    let at = parts.header.tables_end as usize;
    assert!((at as u64) < parts.sections[0].data_offset, "the golden file has padding there");
    let mut damaged = bytes.clone();
    damaged[at] = 7;
    let container = Container::open(&damaged).expect("padding is not looked at on opening");
    let error = verify::check_padding(&container, &damaged).expect_err("padding of 7");
    assert_eq!(error.to_string(), format!("FLB-4004 padding at byte {at}: byte 0x07, expected 0"));
    assert_eq!(error.place(), Some(Place::padding(at as u64)));
    let error = verify::check_root(&container, &damaged).expect_err("another root");
    assert!(matches!(error, FormatError::Root { .. }));
    assert!(error.to_string().starts_with("FLB-4005 header at byte 80: BLAKE3 root "), "{error}");
}

#[test]
fn a_page_in_the_place_of_its_sibling_is_refused() {
    let mut parts = Parts::of(&golden("raw-f32"));
    let base = parts.find(KIND_BASE, 0);
    // Bytes and digests both change places; the tables' own digests are made to fit.
    let (a, b) = (parts.stored(base, 0).to_vec(), parts.stored(base, 1).to_vec());
    assert!(a != b && a.len() == b.len(), "two pages of one length");
    parts.stored(base, 0).copy_from_slice(&b);
    parts.stored(base, 1).copy_from_slice(&a);
    let (first, second) = (parts.tables[base][0].digest, parts.tables[base][1].digest);
    (parts.tables[base][0].digest, parts.tables[base][1].digest) = (second, first);
    let error = check(&parts.seal(Digests::Tables)).expect_err("swapped pages");
    assert_eq!(error.code(), 4001);
    assert!(error.to_string().starts_with("FLB-4001 page 0 of base 0 of species 0 at byte "), "{error}");
}

#[test]
fn a_page_of_another_base_is_refused() {
    let mut parts = Parts::of(&golden("raw-f32"));
    let base = parts.find(KIND_BASE, 0);
    let other = parts.stored(base + 1, 0).to_vec();
    parts.stored(base, 0).copy_from_slice(&other);
    parts.tables[base][0].digest = parts.tables[base + 1][0].digest;
    let mixed = parts.seal(Digests::Tables);
    assert_eq!(check(&mixed).expect_err("a page of another base").code(), 4001);
}

#[test]
fn no_random_damage_panics() {
    let mut dice = Dice(1);
    let mut next = |limit: usize| dice.below(limit);
    for (name, bytes) in GOLDEN {
        for _ in 0..300 {
            let mut parts = Parts::of(bytes);
            let (section, word) = (next(parts.sections.len()), next(12));
            let mut record = parts.sections[section].to_bytes();
            record[word * 8 + next(8)] ^= 1 << next(8);
            if next(2) == 0 {
                record[word * 8..word * 8 + 8].fill(0xFF);
            }
            parts.sections[section] = SectionEntry::from_bytes(&record);
            let pages = parts.tables[section].len();
            let page = next(pages);
            let mut record = parts.tables[section][page].to_bytes();
            // All but the priority, of which any number will do, and the digest, which is made to fit.
            let place = next(36);
            record[if place < 32 { place } else { place + 4 }] ^= 1 << next(8);
            parts.tables[section][page] = PageEntry::from_bytes(&record);
            assert!(check(&parts.seal(Digests::Pages)).is_err(), "{name}: a forged field was accepted");
        }
        for _ in 0..300 {
            let mut parts = Parts::of(bytes);
            let section = next(parts.sections.len());
            let page = next(parts.tables[section].len());
            let stored = parts.stored(section, page);
            let at = next(stored.len());
            stored[at] ^= 1 << next(8);
            // Any verdict will do, as a changed value may be a good one; a panic will not.
            let _ = check(&parts.seal(Digests::Pages));
        }
    }
}

//! Exhaustive damage to golden files: every prefix, every flipped bit of header and tables, and the
//! whole-file mishaps of a real life (measurements, section 4).

use crate::forge::{Parts, forge, golden, golden_file, verdict};
use flb_format::container::verify;
use flb_format::{Container, FormatError, Place};

#[test]
fn every_golden_file_keeps_every_promise() {
    for (name, bytes) in golden() {
        verdict(&bytes).unwrap_or_else(|error| panic!("{name}: {error}"));
    }
}

#[test]
fn taking_a_file_apart_and_joining_it_changes_nothing() {
    for (name, bytes) in golden() {
        assert!(forge(&name, |_| ()) == bytes, "{name}");
    }
}

#[test]
fn every_truncated_prefix_is_refused() {
    for (name, bytes) in golden() {
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
    for (name, mut bytes) in golden() {
        bytes.push(0);
        assert_eq!(verdict(&bytes).expect_err(&name).code(), 1008);
        bytes.extend([0; 1000]);
        assert_eq!(verdict(&bytes).expect_err(&name).code(), 1008);
    }
}

#[test]
fn every_flipped_bit_of_header_and_tables_is_refused() {
    for (name, bytes) in golden() {
        let tables_end = Parts::of(&bytes).header.tables_end as usize;
        let mut damaged = bytes.clone();
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
        let bytes = golden_file(name);
        let tables_end = Parts::of(&bytes).header.tables_end as usize;
        let mut damaged = bytes.clone();
        // Every seventh byte keeps the test short; page digests cover each byte alike.
        for at in (tables_end..bytes.len()).step_by(7) {
            damaged[at] ^= 0x10;
            let error = verdict(&damaged).expect_err("a flipped byte");
            assert!([4001, 4004].contains(&error.code()), "{name}, byte {at}: {error}");
            damaged[at] ^= 0x10;
        }
    }
}

#[test]
fn flipped_padding_is_found_by_the_padding_check_and_by_the_root() {
    let bytes = golden_file("raw-f32");
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
fn transfers_that_spoil_bytes_are_named() {
    let bytes = golden_file("raw-f32");
    let replace = |from: &[u8], to: &[u8]| {
        let mut out = Vec::new();
        let mut at = 0;
        while at < bytes.len() {
            if bytes[at..].starts_with(from) {
                out.extend(to);
                at += from.len();
            } else {
                out.push(bytes[at]);
                at += 1;
            }
        }
        out
    };
    let swapped: Vec<u8> = bytes.chunks(8).flat_map(|word| word.iter().rev().copied()).collect();
    let table: [(&str, Vec<u8>, &str); 7] = [
        ("CR LF to LF", replace(b"\r\n", b"\n"), "line ends were converted"),
        ("LF to CR LF", replace(b"\n", b"\r\n"), "line ends were converted"),
        ("seven bits", bytes.iter().map(|b| b & 0x7F).collect(), "high bit"),
        ("byte-swapped", swapped, "bytes are swapped"),
        ("ZIP", [b"PK\x03\x04".as_slice(), &bytes].concat(), "not an .flb file"),
        ("PDF", [b"%PDF-1.7\n".as_slice(), &bytes].concat(), "not an .flb file"),
        ("zeros", vec![0; bytes.len()], "not an .flb file"),
    ];
    for (kind, spoilt, hint) in table {
        let error = verdict(&spoilt).expect_err(kind);
        assert_eq!(error.code(), 1002, "{kind}: {error}");
        assert!(error.to_string().contains(hint), "{kind}: {error}");
    }
}

#[test]
fn a_page_in_the_place_of_its_sibling_is_refused() {
    let swapped = forge("raw-f32", |parts| {
        let base = parts.base();
        // Bytes and digests both change places; the tables' own digests are made to fit.
        let (a, b) = (parts.stored(base, 0).to_vec(), parts.stored(base, 1).to_vec());
        assert!(a != b && a.len() == b.len(), "two pages of one length");
        parts.stored(base, 0).copy_from_slice(&b);
        parts.stored(base, 1).copy_from_slice(&a);
        let (first, second) = (parts.tables[base][0].digest, parts.tables[base][1].digest);
        (parts.tables[base][0].digest, parts.tables[base][1].digest) = (second, first);
        parts.repair_pages = false;
    });
    let error = verdict(&swapped).expect_err("swapped pages");
    assert_eq!(error.code(), 4001);
    assert!(error.to_string().starts_with("FLB-4001 page 0 of base 0 of species 0 at byte "), "{error}");
}

#[test]
fn a_page_of_another_base_is_refused() {
    let mixed = forge("raw-f32", |parts| {
        let base = parts.base();
        let other = parts.stored(base + 1, 0).to_vec();
        parts.stored(base, 0).copy_from_slice(&other);
        parts.tables[base][0].digest = parts.tables[base + 1][0].digest;
        parts.repair_pages = false;
    });
    assert_eq!(verdict(&mixed).expect_err("a page of another base").code(), 4001);
}

#[test]
fn no_random_damage_panics() {
    // A linear congruential generator (Knuth's MMIX constants) picks places and values.
    let mut state = 1u64;
    let mut next = |limit: usize| {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 33) as usize % limit
    };
    for (name, bytes) in golden() {
        for _ in 0..300 {
            let mut parts = Parts::of(&bytes);
            let (section, word) = (next(parts.sections.len()), next(12));
            let mut record = parts.sections[section].to_bytes();
            record[word * 8 + next(8)] ^= 1 << next(8);
            if next(2) == 0 {
                record[word * 8..word * 8 + 8].fill(0xFF);
            }
            parts.sections[section] = flb_format::SectionEntry::from_bytes(&record);
            let pages = parts.tables[section].len();
            let page = next(pages);
            let mut record = parts.tables[section][page].to_bytes();
            // All but the priority, of which any number will do, and the digest, which is made to fit.
            let place = next(36);
            record[if place < 32 { place } else { place + 4 }] ^= 1 << next(8);
            parts.tables[section][page] = flb_format::records::PageEntry::from_bytes(&record);
            assert!(verdict(&parts.join()).is_err(), "{name}: a forged field was accepted");
        }
        for _ in 0..300 {
            let mut parts = Parts::of(&bytes);
            let section = next(parts.sections.len());
            let page = next(parts.tables[section].len());
            let stored = parts.stored(section, page);
            let at = next(stored.len());
            stored[at] ^= 1 << next(8);
            // Any verdict will do, as a changed value may be a good one; a panic will not.
            let _ = verdict(&parts.join());
        }
    }
}

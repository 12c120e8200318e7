//! Blocks near geometry that break a promise.

use flb_format::records::*;

use super::content::{Case, relayout, set_first_page};
use super::forge;

/// Two species: bases 0 and 4 of three bands, base 18 of one band; nothing is compressed.
const CLASSED: &str = "classed";
/// Codec `haar`, compressed.
const HAAR: &str = "haar";

/// With an edit of the first section of a kind and item.
fn section(name: &str, kind: u32, item: u32, edit: fn(&mut SectionEntry)) -> Vec<u8> {
    forge(name, |parts| {
        let section = parts.find(kind, item);
        edit(&mut parts.sections[section]);
    })
}

/// With an edit of the first page's payload of such a section.
fn payload(kind: u32, item: u32, edit: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    forge(CLASSED, |parts| {
        let section = parts.find(kind, item);
        assert_eq!(parts.tables[section].len(), 1, "a section of one page");
        let (units, mut bytes) = (parts.sections[section].units, parts.stored(section, 0).to_vec());
        edit(&mut bytes);
        set_first_page(parts, section, &bytes);
        if kind == KIND_DETAIL {
            // Its units are blocks, not bytes.
            (parts.sections[section].units, parts.tables[section][0].count) = (units, units as u32);
        }
    })
}

fn without(kind: u32, item: u32) -> Vec<u8> {
    forge(CLASSED, |parts| {
        let section = parts.find(kind, item);
        parts.sections.remove(section);
        parts.tables.remove(section);
        relayout(parts);
    })
}

/// The last base of a file of raw floats in the clothes of another kind.
fn base_as(edit: fn(&mut SectionEntry)) -> Vec<u8> {
    forge("raw-f32", |parts| {
        let last = parts.sections.len() - 1;
        edit(&mut parts.sections[last]);
        set_first_page(parts, last, &[1; 8]);
        parts.tables[last].truncate(1);
        parts.sections[last].page_count = 1;
        let blocks = parts.sections[last].key.kind == KIND_BLOCKS;
        parts.header.required_features = if blocks { FEATURE_BLOCKS } else { 0 };
        relayout(parts);
    })
}

pub(crate) fn near_cases() -> Vec<Case> {
    let float = |kind, item, at: usize, value: f32| {
        payload(kind, item, |bytes| bytes[at..at + 4].copy_from_slice(&value.to_le_bytes()))
    };
    let last_bit = |kind, item| {
        payload(kind, item, |bytes| {
            let last = bytes.len() - 1;
            assert_eq!(bytes[last] & 0x80, 0, "the last bit is filling");
            bytes[last] |= 0x80;
        })
    };
    vec![
        (
            1010,
            "feature bit 3 (blocks) is false, but the kinds of sections say true",
            forge(CLASSED, |parts| parts.header.required_features = 0),
        ),
        (
            1010,
            "feature bit 3 (blocks) is true, but the kinds of sections say false",
            forge("raw-f32", |parts| parts.header.required_features = FEATURE_BLOCKS),
        ),
        (2006, "codec 2 is not known", section(CLASSED, KIND_DETAIL, 0, |s| s.codec = CODEC_HAAR_PAPER)),
        (2006, "codec 10 is not known", section(CLASSED, KIND_BLOCKS, 0, |s| s.codec = CODEC_CLASSES)),
        (2007, "item is 2", section(CLASSED, KIND_BLOCKS, 1, |s| s.key.item = 2)),
        (2007, "number of units is 9, expected 8", section(CLASSED, KIND_BLOCKS, 0, |s| s.units = 9)),
        (
            2007,
            "number of units is 67, expected 68 to 16388",
            section(CLASSED, KIND_BLOCKS, 1, |s| s.units = 67),
        ),
        (
            2007,
            "number of units is 1048, expected 1 to 1047",
            section(CLASSED, KIND_AVERAGES, 0, |s| s.units = 1048),
        ),
        (2007, "number of units is 65, expected 1 to 64", section(CLASSED, KIND_DETAIL, 0, |s| s.units = 65)),
        (2007, "size of payloads is 268435457, expected at most 268435456", {
            section(CLASSED, KIND_DETAIL, 0, |s| s.raw_bytes = MAX_DETAIL_BYTES + 1)
        }),
        (3005, "number of units is 1, expected a payload of whole words, at most 761 bits", {
            forge(CLASSED, |parts| {
                let detail = parts.find(KIND_DETAIL, 0);
                parts.tables[detail][0].count = 1;
            })
        }),
        (3005, "a payload of whole words", {
            forge(CLASSED, |parts| {
                let detail = parts.find(KIND_DETAIL, 0);
                let page = &mut parts.tables[detail][0];
                (page.raw_bytes, page.stored_bytes) = (page.raw_bytes - 1, page.stored_bytes - 1);
            })
        }),
        (2007, "bands is 2, expected 1", section(CLASSED, KIND_BLOCKS, 0, |s| s.bands = 2)),
        (
            2007,
            "bands is 2, expected 3, as in the metadata",
            section(CLASSED, KIND_AVERAGES, 0, |s| s.bands = 2),
        ),
        (
            2007,
            "lattice is 32, expected 16, as in the metadata",
            section(CLASSED, KIND_DETAIL, 0, |s| s.lattice = 32),
        ),
        (
            2007,
            "codec is 8, expected 7, as the species' class tables say",
            section(CLASSED, KIND_DETAIL, 4, |s| s.codec = CODEC_HAAR),
        ),
        (
            2007,
            "codec is 7, expected 8, as the species' class tables say",
            section(HAAR, KIND_DETAIL, 0, |s| s.codec = CODEC_CLASSED),
        ),
        (
            2007,
            "as in the species' first base",
            forge(CLASSED, |parts| {
                let detail = parts.find(KIND_DETAIL, 4);
                parts.sections[detail].units -= 1;
                parts.tables[detail].last_mut().expect("a page").count -= 1;
            }),
        ),
        (
            2007,
            "kind is 4, expected 3, as of the species' bases",
            base_as(|s| {
                (s.key.kind, s.key.item, s.codec, s.bands) = (KIND_BLOCKS, 0, CODEC_BLOCK_MAP, 1);
            }),
        ),
        (
            2008,
            "species 0 has no block map",
            base_as(|s| (s.key.kind, s.codec) = (KIND_AVERAGES, CODEC_AVERAGES)),
        ),
        (2008, "species 0 has no block map", without(KIND_BLOCKS, 0)),
        (2008, "species 0 has no detail of base 4", without(KIND_DETAIL, 4)),
        (
            2008,
            "species 1 has no averages of base 17",
            forge(CLASSED, |parts| parts.sections.last_mut().expect("there").key.item = 17),
        ),
        (
            3005,
            "a unit per byte",
            forge(CLASSED, |parts| {
                let map = parts.find(KIND_BLOCKS, 0);
                parts.tables[map][0].count -= 1;
            }),
        ),
        (5010, "M41: the number of stored blocks is 0", payload(KIND_BLOCKS, 0, |bytes| bytes.fill(0))),
        (5011, "M42: ", payload(KIND_BLOCKS, 1, |bytes| bytes.truncate(bytes.len() - 1))),
        (5011, "M43: ", payload(KIND_BLOCKS, 1, |bytes| bytes[4 + 31] |= 0x10)),
        (5011, "M44: ", payload(KIND_BLOCKS, 1, |bytes| bytes[4..68].rotate_left(32))),
        (5012, "M45: ", payload(KIND_AVERAGES, 0, |bytes| bytes.truncate(31))),
        (5012, "M46: the unit is 0", float(KIND_AVERAGES, 0, 4, 0.0)),
        (5012, "M46: the peak is NaN", float(KIND_AVERAGES, 0, 20, f32::NAN)),
        (5013, "M47: ", last_bit(KIND_AVERAGES, 0)),
        (5013, "M47: ", payload(KIND_AVERAGES, 0, |bytes| bytes.extend([0; 4]))),
        (
            5014,
            "M50: the number of its blocks is 55, expected 56, as in the block map",
            forge(CLASSED, |parts| {
                for (section, table) in parts.sections.iter_mut().zip(&mut parts.tables) {
                    if section.key.kind == KIND_DETAIL {
                        section.units -= 1;
                        table.last_mut().expect("a page").count -= 1;
                    }
                }
            }),
        ),
        (5014, "M51: ", last_bit(KIND_DETAIL, 0)),
        (5014, "M51: ", payload(KIND_DETAIL, 4, |bytes| bytes.extend([0; 4]))),
        (5014, "M51: ", payload(KIND_DETAIL, 18, |bytes| bytes.truncate(4))),
    ]
}

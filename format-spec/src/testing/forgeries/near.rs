//! Blocks near geometry that break a promise.

use super::List;
use crate::container::records::*;

/// Two species: bases 0 and 4 of three bands, base 18 of one band; nothing is compressed.
const CLASSED: &str = "classed";
/// Codec `haar`, compressed.
const HAAR: &str = "haar";
const RAW: &str = "raw-f32";

const MAP: (u32, u32) = (KIND_BLOCKS, BLOCKS_MAP);
const CLASSES: (u32, u32) = (KIND_BLOCKS, BLOCKS_CLASSES);
const AVERAGES: (u32, u32) = (KIND_AVERAGES, 0);
const DETAIL: (u32, u32) = (KIND_DETAIL, 0);

pub(super) fn add(list: &mut List) {
    foreign(list);
    let mut of = list.of(CLASSED);
    let words = "feature bit 3 (blocks) is false, but the kinds of sections say true";
    of.header(1010, words, |h| h.required_features = 0);
    of.section(DETAIL, 2006, "codec 2 is not known", |s| s.codec = CODEC_HAAR_PAPER);
    of.section(MAP, 2006, "codec 10 is not known", |s| s.codec = CODEC_CLASSES);
    of.section(CLASSES, 2007, "item is 2", |s| s.key.item = 2);
    of.section(MAP, 2007, "number of units is 9, expected 8", |s| s.units = 9);
    of.section(CLASSES, 2007, "number of units is 67, expected 68 to 16388", |s| s.units = 67);
    of.section(AVERAGES, 2007, "number of units is 1048, expected 1 to 1047", |s| s.units = 1048);
    of.section(DETAIL, 2007, "number of units is 65, expected 1 to 64", |s| s.units = 65);
    let words = "size of payloads is 268435457, expected at most 268435456";
    of.section(DETAIL, 2007, words, |s| s.raw_bytes = MAX_DETAIL_BYTES + 1);
    of.section(MAP, 2007, "bands is 2, expected 1", |s| s.bands = 2);
    of.section(AVERAGES, 2007, "bands is 2, expected 3, as in the metadata", |s| s.bands = 2);
    of.section(DETAIL, 2007, "lattice is 32, expected 16, as in the metadata", |s| s.lattice = 32);
    let words = "codec is 8, expected 7, as the species' class tables say";
    of.section((KIND_DETAIL, 4), 2007, words, |s| s.codec = CODEC_HAAR);
    of.forge(2007, "as in the species' first base", |parts| {
        let detail = parts.find(KIND_DETAIL, 4);
        parts.sections[detail].units -= 1;
        parts.tables[detail].last_mut().expect("a page").count -= 1;
    });
    of.without(KIND_BLOCKS, 0, BLOCKS_MAP, 2008, "species 0 has no block map");
    of.without(KIND_DETAIL, 0, 4, 2008, "species 0 has no detail of base 4");
    of.forge(2008, "species 1 has no averages of base 17", |parts| {
        parts.sections.last_mut().expect("there").key.item = 17;
    });
    let words = "number of units is 1, expected a payload of whole words, at most 761 bits";
    of.first_page(DETAIL, 3005, words, |page| page.count = 1);
    of.first_page(DETAIL, 3005, "a payload of whole words", |page| {
        (page.raw_bytes, page.stored_bytes) = (page.raw_bytes - 1, page.stored_bytes - 1);
    });
    of.first_page(MAP, 3005, "a unit per byte", |page| page.count -= 1);
    of.payload(CLASSES, 5011, "M43: ", |bytes| bytes[4 + 31] |= 0x10);
    of.payload(CLASSES, 5011, "M44: ", |bytes| bytes[4..68].rotate_left(32));
    of.payload(AVERAGES, 5012, "M45: ", |bytes| bytes.truncate(31));
    let float = |at: usize, value: f32| {
        move |bytes: &mut Vec<u8>| bytes[at..at + 4].copy_from_slice(&value.to_le_bytes())
    };
    of.payload(AVERAGES, 5012, "M46: the unit is 0", float(4, 0.0));
    of.payload(AVERAGES, 5012, "M46: the peak is NaN", float(20, f32::NAN));
    let last_bit = |bytes: &mut Vec<u8>| {
        let last = bytes.last_mut().expect("a payload");
        assert_eq!(*last & 0x80, 0, "the last bit is filling");
        *last |= 0x80;
    };
    of.payload(AVERAGES, 5013, "M47: filling", last_bit);
    of.forge(5014, "M50: the number of its blocks is 55, expected 56, as in the block map", |parts| {
        for (section, table) in parts.sections.iter_mut().zip(&mut parts.tables) {
            if section.key.kind == KIND_DETAIL {
                section.units -= 1;
                table.last_mut().expect("a page").count -= 1;
            }
        }
    });
    of.payload(DETAIL, 5014, "M51: filling", last_bit);
    of.payload((KIND_DETAIL, 18), 5014, "M51: ", |bytes| bytes.truncate(4));
}

/// Sections and features of other kinds of bases than the file has.
fn foreign(list: &mut List) {
    let words = "codec is 7, expected 8, as the species' class tables say";
    list.of(HAAR).section(DETAIL, 2007, words, |s| s.codec = CODEC_CLASSED);
    let words = "feature bit 3 (blocks) is true, but the kinds of sections say false";
    list.of(RAW).header(1010, words, |h| h.required_features = FEATURE_BLOCKS);
    // The last base in the clothes of another kind.
    let mut base_as = |code, words, features, edit: fn(&mut SectionEntry)| {
        list.of(RAW).rebuild(code, words, |parts| {
            let last = parts.sections.len() - 1;
            edit(&mut parts.sections[last]);
            parts.replace(last, &[1; 8]);
            parts.header.required_features = features;
        });
    };
    base_as(2007, "kind is 4, expected 3, as of the species' bases", FEATURE_BLOCKS, |s| {
        (s.key.kind, s.key.item, s.codec, s.bands) = (KIND_BLOCKS, BLOCKS_MAP, CODEC_BLOCK_MAP, 1);
    });
    base_as(2008, "species 0 has no block map", 0, |s| {
        (s.key.kind, s.codec) = (KIND_AVERAGES, CODEC_AVERAGES);
    });
}

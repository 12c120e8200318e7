//! Headers, tables and pages that break a promise.

use super::{List, base};
use crate::container::records::*;
use crate::testing::{Page, Parts, golden};

const RAW: &str = "raw-f32";
const F16: &str = "raw-f16";
const HAAR: &str = "haar-paper";
const ZSTD: &str = "haar-paper-zstd";
const DRAFT: &str = "v0.1/raw-f32";

pub(super) fn add(list: &mut List) {
    headers(list);
    sections(list);
    tables(list);
    pages(list);
}

fn headers(list: &mut List) {
    let patched = |at: usize, value: u8| {
        let mut bytes = golden(RAW);
        bytes[at] = value;
        bytes
    };
    list.give(1002, "header at byte 0: magic [88, 46, 4c", patched(0, 0x88));
    list.give(1005, "header digest ", patched(40, 0));
    list.of(DRAFT).header(1004, "required feature bit 3", |h| h.required_features |= FEATURE_BLOCKS);
    list.of(ZSTD).header(1010, "is false, but", |h| h.required_features = 0);
    let mut raw = list.of(RAW);
    raw.header(1006, "header of 256 bytes, expected 128", |h| h.header_bytes = 256);
    raw.header(1008, "header promises 5", |h| h.file_bytes = 5);
    let words = "feature bit 0 (zstd) is true, but the page tables say false";
    raw.header(1010, words, |h| h.required_features = FEATURE_ZSTD);
    raw.header(2001, "offset of the table of contents", |h| h.contents_offset = u64::MAX - 3);
    raw.header(2001, "size of the table of contents", |h| h.contents_bytes += 1);
    raw.header(2001, "end of the page tables is 0", |h| h.tables_end = 0);
    raw.header(2001, "end of the page tables is", |h| h.tables_end += 16);
    raw.header(2009, "data at byte", |h| h.tables_end -= 48);
    raw.header(2009, "expected", |h| h.tables_end += 64);
}

fn sections(list: &mut List) {
    let mut raw = list.of(RAW);
    let first = (KIND_METADATA, 0);
    raw.section(first, 2007, "kind is 0, expected at least 1", |s| (s.key.kind, s.flags) = (0, 0));
    raw.section(first, 2007, "item is 1", |s| s.key.item = 1);
    raw.section(first, 2007, "threshold is 1, expected 0", |s| s.threshold = 1.0);
    raw.section(first, 2007, "lattice is 16, expected 0", |s| s.lattice = 16);
    raw.section(first, 2007, "bands is 1, expected 0", |s| s.bands = 1);
    raw.section(first, 1009, "size of metadata is 1048577, over", |s| s.units = MAX_METADATA_BYTES + 1);
    raw.section(first, 2008, "species 0 has no metadata", |s| s.key.species = 1);
    raw.section((KIND_MEDIUM, 0), 2006, "codec 6", |s| s.codec = CODEC_RAW_F16);
    let last = (KIND_BASE, 1);
    let words = "species is 1, expected a species of the file, or 4294967295";
    raw.section(last, 2007, words, |s| (s.key.kind, s.key.species, s.flags) = (77, 1, 0));
    let words = "flags is 4, expected bits 0 and 1 only";
    raw.section(last, 2007, words, |s| (s.key.kind, s.flags) = (77, 4));
    raw.forge(1008, "the file has", |parts| parts.sections.last_mut().expect("a section").data_bytes -= 1);
    raw.forge(2008, "species 7 has no metadata", |parts| parts.sections[6].key.species = 7);
    raw.rebuild(2008, "species 0 has no wood_area_density", |parts| parts.remove(4));
    raw.forge(2008, "species 0 has no base", |parts| {
        // Of a kind that sorts behind all others, and may be skipped.
        parts.sections[5..].iter_mut().for_each(|section| (section.key.kind, section.flags) = (9, 0));
    });
    let words = "required section kind 6 is not known";
    list.of(DRAFT).section(last, 2005, words, |s| s.key.kind = KIND_DETAIL);
    list.of(F16).base(2007, "threshold is 1, expected 0", |s| s.threshold = 1.0);
    let mut haar = list.of(HAAR);
    haar.base(2006, "codec 3 is not known", |s| s.codec = CODEC_SPARSE_F32);
    haar.base(2006, "codec 7", |s| s.codec = CODEC_CLASSED);
    haar.base(2007, "flags is 3, expected 1", |s| s.flags = 3);
    haar.base(2007, "flags is 0, expected 1", |s| s.flags = 0);
    haar.base(2007, "page size is 0", |s| s.page_bytes = 0);
    haar.base(2007, "page size is 4294967295", |s| s.page_bytes = u32::MAX);
    haar.base(2007, "threshold is -0, expected", |s| s.threshold = -0.0);
    haar.base(2007, "threshold is NaN", |s| s.threshold = f32::NAN);
    haar.base(2007, "threshold is inf", |s| s.threshold = f32::INFINITY);
    haar.base(2007, "lattice is 24", |s| s.lattice = 24);
    haar.base(2007, "bands is 65, expected 1 to 64", |s| s.bands = 65);
    haar.base(2007, "bands is 2, expected 3, as in the metadata", |s| s.bands = 2);
    haar.base(2009, "data at byte", |s| s.data_offset += 64);
    haar.base(2009, "expected 0 (no hole", |s| s.data_bytes = 0);
    haar.base(2009, "data at byte 18446744073709551615", |s| s.data_offset = u64::MAX);
    haar.base(3006, "size of data is", |s| s.data_bytes -= 1);
}

fn tables(list: &mut List) {
    // Page 1 has the bytes of page 0: no fault of its place but in the draft.
    let twice = |parts: &mut Parts| {
        let base = base(parts);
        parts.tables[base][1] = parts.tables[base][0];
    };
    list.of(DRAFT).forge(3003, "page table entry 1", twice);
    list.of(DRAFT).page(1007, "reserved field holds 0x3f800000", |p| p.priority = 1.0);
    let mut raw = list.of(RAW);
    raw.forge(3005, "first unit is 0, expected 5120", twice);
    raw.page(3003, "the page lies at byte", |p| p.offset += 16);
    raw.forge(3003, "page table entry 1", |parts| {
        // Its bytes are those of page 0, but compressed.
        let base = base(parts);
        let first = parts.tables[base][0];
        let second = &mut parts.tables[base][1];
        (second.offset, second.raw_bytes, second.compression) = (first.offset, 20_480, STORED_ZSTD);
    });
    raw.page(3004, "stored size is 100, expected 20480", |p| p.stored_bytes = 100);
    raw.page(3005, "number of units is 5121, expected a unit per 4 bytes", |p| p.count += 1);
    raw.forge(3005, "a unit for each value", |parts| parts.tables[1][0].count = 64);
    raw.forge(3005, "8 units per byte", |parts| parts.tables[1][0].count = 1 << 30);
    raw.forge(3005, "a unit per byte", |parts| parts.tables[0][0].count -= 1);
    let words = "priority is 158456330000000000000000000000,";
    raw.page(3008, words, |p| p.priority = 2.0 * MAX_MAGNITUDE);
    raw.page(3008, "priority is inf", |p| p.priority = f32::INFINITY);
    raw.page(3008, "priority is -0", |p| p.priority = -0.0);
    let mut zstd = list.of(ZSTD);
    zstd.page(3004, "stored size is 4294967295", |p| p.stored_bytes = u32::MAX);
    zstd.page(3004, "stored size is 0, expected 1 to", |p| p.stored_bytes = 0);
    let mut f16 = list.of(F16);
    f16.page(3005, "number of units is 10241, expected a unit per 2 bytes", |p| p.count += 1);
    f16.forge(3005, "number of units is 10240, expected a unit per 4 bytes", |parts| {
        // The codec of another file's base: the sizes give it away.
        for section in parts.sections.iter_mut().filter(|section| section.codec == CODEC_RAW_F16) {
            section.codec = CODEC_RAW_F32;
        }
        parts.header.required_features = FEATURE_PHYSICAL;
    });
    let mut haar = list.of(HAAR);
    haar.page(3005, "at most a unit per 12 bytes", |p| p.count = u32::MAX);
    haar.page(3005, "a unit per 12 bytes and 256 a band", |p| p.count = 1);
    let words = "number of units is 125, but its pages give 124";
    list.of("haar-paper-exact").forge(3006, words, |parts| {
        let base = base(parts);
        parts.tables[base].last_mut().expect("a page").count -= 1;
    });
}

fn pages(list: &mut List) {
    list.of(RAW).forge(4004, "padding at byte", |parts| parts.bytes[parts.header.tables_end as usize] = 1);
    list.of(ZSTD).rebuild(4002, "it ends after", |parts| {
        let (section, page) = last(parts);
        let stored = [&*parts.stored(section, page), &[0]].concat();
        parts.store(section, page, &stored);
    });
    list.of(HAAR).rebuild(4003, "page 0 of base 18 of species 1 at byte", |parts| {
        let (section, page) = last(parts);
        let stored = parts.stored(section, page).to_vec();
        parts.set_payload(section, page, &stored[..stored.len() - 4]);
    });
    // Much work in a small file: pages that are one page, again and again.
    list.of(RAW).forge(1009, "over the limit of 1099511627776", |parts| {
        let page = Page { stored: vec![0], raw_bytes: MAX_PAGE_BYTES, count: 1, compression: STORED_ZSTD };
        parts.add_unknown(0, &vec![page; (1 << 18) + 1]);
        parts.lay_out();
        let section = parts.sections.last_mut().expect("it was added");
        let table = parts.tables.last_mut().expect("it was added");
        table.iter_mut().for_each(|page| page.offset = section.data_offset);
        section.data_bytes = 1;
        parts.header.file_bytes = section.data_offset + 1;
        parts.bytes.truncate(parts.header.file_bytes as usize);
    });
}

fn last(parts: &Parts) -> (usize, usize) {
    (parts.sections.len() - 1, parts.tables.last().expect("a file has sections").len() - 1)
}

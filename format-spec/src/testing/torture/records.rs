//! Kinds 10 to 28, 31 and 45 to 46: fields of header and tables, one at a time, behind sound digests.

use super::{Cases, PASSES};
use crate::container::records::*;
use crate::testing::{Digests, Parts};

pub(super) fn header_cases(cases: &mut Cases) {
    let length = cases.subject.parts.bytes.len() as u64;
    for major in [VERSION.0 + 1, u16::MAX] {
        let done = format!("major version {major}");
        cases.header(10, &format!("major-{major}"), &done, 1003, |h| h.version.0 = major);
    }
    let minor = |parts: &mut Parts| parts.header.version.1 = u16::MAX;
    cases.poke(10, "minor-65535", "a later minor version, which is read", PASSES, minor);
    for bit in [FEATURES_KNOWN.trailing_ones(), 63] {
        let done = format!("required feature bit {bit}");
        cases.header(11, &format!("feature-{bit}"), &done, 1004, |h| h.required_features |= 1 << bit);
    }
    let optional = |parts: &mut Parts| parts.header.optional_features = u64::MAX;
    cases.poke(12, "optional-features", "every optional feature bit", PASSES, optional);
    cases.header(13, "header-60", "1 in the header's reserved u32", 1007, |h| h.reserved_60 = 1);
    cases.header(13, "header-112", "1 in the header's reserved u64", 1007, |h| h.reserved_112 = 1);
    cases.header(16, "one-short", "a file length of one less", 1008, |h| h.file_bytes = length - 1);
    cases.header(16, "one-long", "a file length of one more", 1008, |h| h.file_bytes = length + 1);
    cases.header(16, "endless", "a file length of 2^64 - 1", 1008, |h| h.file_bytes = u64::MAX);
    cases.header(17, "contents", "a table of contents at byte 64", 2001, |h| h.contents_offset = 64);
    cases.header(18, "contents", "a table of contents at the end", 2001, |h| h.contents_offset = length);
    let done = "page tables that end behind the end";
    cases.header(18, "tables-end", done, 2001, |h| h.tables_end = length + 48);
    let done = "a table of contents of 2^64 - 1 bytes";
    cases.header(19, "contents", done, 2001, |h| h.contents_bytes = u64::MAX);
    cases.header(20, "sections", "2^32 - 1 sections", 1009, |h| h.section_count = u32::MAX);
    cases.header(20, "tables-end", "page tables of 2^64 - 1 bytes", 1009, |h| h.tables_end = u64::MAX);
    cases.header(21, "no-section", "0 sections", 2001, |h| h.section_count = 0);
    digests(cases);
}

/// Name of a digest, code of a wrong one, those that are sound, and where it stands.
type Place = (&'static str, u32, Digests, fn(&mut Parts, usize) -> &mut u64);

const PLACES: [Place; 3] = [
    ("page", 4001, Digests::Tables, |parts, area| &mut parts.tables[area][0].digest),
    ("page-table", 3002, Digests::Contents, |parts, area| &mut parts.sections[area].table_digest),
    ("contents", 2002, Digests::Root, |parts, _| &mut parts.header.contents_digest),
];

/// Kinds 14 and 15: each digest wrong, those that cover it sound.
fn digests(cases: &mut Cases) {
    let (good, area) = (&cases.subject.parts, cases.subject.area());
    let spoilt = |from: Digests, edit: &dyn Fn(&mut Parts)| {
        let mut parts = good.clone();
        edit(&mut parts);
        parts.seal(from)
    };
    let mut broken = |name: &str, code: u32, flipped: Vec<u8>, zero: Vec<u8>| {
        let done = format!("a bit of the digest ({name}) flipped, those that cover it sound");
        cases.give(14, name, &done, code, flipped);
        let done = format!("the digest ({name}) 0, those that cover it sound");
        cases.give(15, name, &done, code, zero);
    };
    for (name, code, from, digest) in PLACES {
        let flipped = spoilt(from, &|parts| *digest(parts, area) ^= 1);
        broken(name, code, flipped, spoilt(from, &|parts| *digest(parts, area) = 0));
    }
    let flipped = spoilt(Digests::Header, &|parts| parts.header.root[0] ^= 1);
    broken("root", 4005, flipped, spoilt(Digests::Header, &|parts| parts.header.root.fill(0)));
    let of_header = |edit: fn(&mut [u8])| {
        let mut bytes = good.bytes.clone();
        edit(&mut bytes[HEADER_DIGESTED_BYTES..][..8]);
        bytes
    };
    broken("header", 1005, of_header(|digest| digest[0] ^= 1), of_header(|digest| digest.fill(0)));
}

pub(super) fn section_cases(cases: &mut Cases) {
    let (parts, area) = (&cases.subject.parts, cases.subject.area());
    let length = parts.bytes.len() as u64;
    let good = parts.sections[area];
    cases.section(13, "section", "1 in a section's reserved u64", 1007, |s| s.reserved = 1);
    cases.section(17, "page-table", "a page table at byte 64", 3001, |s| s.table_offset = 64);
    cases.section(18, "page-table", "a page table at the end", 3001, |s| s.table_offset = length);
    cases.section(18, "section", "a section's data at the end", 2009, |s| s.data_offset = length);
    cases.section(19, "section", "data of 2^64 - 1 bytes", 2007, |s| s.data_bytes = u64::MAX);
    let done = "a page table at byte 2^64 - 48";
    cases.section(19, "page-table", done, 3001, |s| s.table_offset = u64::MAX - 47);
    cases.section(20, "units", "2^62 + 1 units of 4 bytes", 2007, |s| s.units = (1 << 62) + 1);
    cases.section(21, "no-unit", "0 units", 2007, |s| s.units = 0);
    let done = "data that begin 64 bytes early, in those before";
    cases.section(24, "section", done, 2009, |s| s.data_offset -= 64);
    let done = "data that lie in the page tables";
    cases.section(26, "section", done, 2009, |s| s.data_offset = s.table_offset);
    cases.section(27, "data-offset", "data one byte late", 2009, |s| s.data_offset += 1);
    cases.section(27, "raw-bytes", "a sum of payloads of one more", 3006, |s| s.raw_bytes += 1);
    cases.section(27, "units", "one unit more", 2007, |s| s.units += 1);
    // The next section begins at a multiple of 64, and is looked at first.
    let ends_full = (good.data_offset + good.data_bytes).is_multiple_of(SECTION_ALIGN);
    let code = if ends_full { 2009 } else { 3006 };
    cases.section(27, "data-bytes", "data of one byte more", code, |s| s.data_bytes += 1);
    cases.section(28, "section", "data at no multiple of 64", 2009, |s| s.data_offset += 8);
    cases.section(45, "units", "2^64 - 1 units", 2007, |s| s.units = u64::MAX);
    cases.section(20, "pages", "2^32 - 1 pages of 48 bytes", 3001, |s| s.page_count = u32::MAX);
    cases.section(21, "no-page", "0 pages", 2007, |s| s.page_count = 0);
    cases.section(27, "page-count", "one page more", 3001, |s| s.page_count += 1);
    let done = "pages of up to 20481 bytes, no multiple of 4096";
    cases.section(28, "page-bytes", done, 2007, |s| s.page_bytes = 20_481);
    cases.section(31, "codec-99", "codec 99", 2006, |s| s.codec = 99);
    let done = "the medium in a codec of bases";
    cases.section(31, "codec-of-bases", done, 2006, |s| s.codec = CODEC_HAAR_PAPER);
    cases.section(44, "threshold-nan", "a threshold that is no number", 2007, |s| s.threshold = f32::NAN);
    cases.section(45, "lattice", "a lattice of 2^31", 2007, |s| s.lattice = 1 << 31);
    cases.section(45, "bands", "2^32 - 1 bands", 2007, |s| s.bands = u32::MAX);
    cases.section(46, "lattice", "a lattice of 0", 2007, |s| s.lattice = 0);
    cases.section(46, "bands", "0 bands", 2007, |s| s.bands = 0);
    cases.section(13, "flags", "a flag that has no meaning", 2007, |s| s.flags = FLAG_REQUIRED | 1 << 31);
    cases.poke(22, "sections", "two sections in the wrong order", 2003, |parts| {
        (parts.sections[area].key.item, parts.sections[area + 1].key.item) = (3, 2);
    });
    cases.poke(23, "section", "a section listed twice", 2004, |parts| parts.sections[area + 1].key.item = 2);
    cases.poke(12, "required-section", "a required section of a kind that no reader knows", 2005, |parts| {
        let last = parts.sections.last_mut().expect("a file has sections");
        (last.key.kind, last.flags) = (Parts::UNKNOWN_KIND, FLAG_REQUIRED);
    });
}

pub(super) fn page_cases(cases: &mut Cases) {
    let length = cases.subject.parts.bytes.len() as u64;
    cases.page(18, "page", "a page at the end", 3003, |p| p.offset = length);
    cases.page(19, "page", "a page at byte 2^64 - 16", 3003, |p| p.offset = u64::MAX - 15);
    cases.page(24, "page", "a page 16 bytes early, in the section before", 3003, |p| p.offset -= 16);
    cases.page(26, "page", "a page that lies in the table of contents", 3003, |p| p.offset = HEADER_BYTES);
    cases.page(27, "page-offset", "a page one byte late", 3003, |p| p.offset += 1);
    cases.page(27, "first-unit", "a first unit of 1", 3005, |p| p.first = 1);
    cases.page(28, "page", "a page at no multiple of 16", 3003, |p| p.offset += 4);
    cases.page(45, "first-unit", "a first unit of 2^64 - 1", 3005, |p| p.first = u64::MAX);
    cases.page(13, "page", "1 in a page's reserved field", 1007, |p| p.reserved = 1);
    // The priority is the lower half of the draft's reserved field.
    let code = if cases.subject.parts.header.is_draft() { 1007 } else { 3008 };
    cases.page(44, "priority-nan", "a priority that is no number", code, |p| p.priority = f32::NAN);
    cases.page(44, "priority-minus-1", "a priority of -1", code, |p| p.priority = -1.0);
    cases.page(21, "no-unit-in-a-page", "a page of 0 units", 3005, |p| p.count = 0);
    cases.page(21, "units-of-a-page", "a page of 2^32 - 1 units", 3005, |p| p.count = u32::MAX);
    cases.page(21, "empty-page", "a payload of 0 bytes", 3004, |p| p.raw_bytes = 0);
    cases.page(21, "raw-bytes", "a payload of 2^32 - 1 bytes", 3004, |p| p.raw_bytes = u32::MAX);
    cases.page(21, "stored-bytes", "2^32 - 1 stored bytes", 3004, |p| p.stored_bytes = u32::MAX);
    cases.page(27, "page-units", "a page of one unit more", 3005, |p| p.count += 1);
    cases.page(31, "compression", "compression 2", 3007, |p| p.compression = 2);
}

//! Kinds 10 to 28, 31 and 45 to 46: fields of header and tables, one at a time, behind sound digests.

use flb_format::records::*;

use super::draft::{Digests, Image, header, page, section};
use super::{Cases, PASSES};

pub(super) fn header_cases(cases: &mut Cases) {
    let length = cases.subject.image.bytes.len() as u64;
    let unknown_bit = FEATURES_KNOWN.trailing_ones();
    let number = |at: usize, value: u64| move |image: &mut Image| image.put_u64(at, value);
    for major in [VERSION.0 + 1, u16::MAX] {
        let done = format!("major version {major}");
        let edit = |image: &mut Image| image.put(header::MAJOR, &major.to_le_bytes());
        cases.poke(10, &format!("major-{major}"), done, 1003, edit);
    }
    let minor = |image: &mut Image| image.put(header::MINOR, &u16::MAX.to_le_bytes());
    cases.poke(10, "minor-65535", "a later minor version, which is read", PASSES, minor);
    for bit in [unknown_bit, 63] {
        let done = format!("required feature bit {bit}");
        cases.poke(11, &format!("feature-{bit}"), done, 1004, |image| {
            image.put_u64(header::REQUIRED, image.u64(header::REQUIRED) | 1 << bit);
        });
    }
    cases.poke(
        12,
        "optional-features",
        "every optional feature bit",
        PASSES,
        number(header::OPTIONAL, u64::MAX),
    );
    cases
        .poke(13, "header-60", "1 in the header's reserved u32", 1007, |i| i.put_u32(header::RESERVED_60, 1));
    cases.poke(13, "header-112", "1 in the header's reserved u64", 1007, number(header::RESERVED_112, 1));
    cases.poke(16, "one-short", "a file length of one less", 1008, number(header::FILE_BYTES, length - 1));
    cases.poke(16, "one-long", "a file length of one more", 1008, number(header::FILE_BYTES, length + 1));
    cases.poke(16, "endless", "a file length of 2^64 - 1", 1008, number(header::FILE_BYTES, u64::MAX));
    cases.poke(17, "contents", "a table of contents at byte 64", 2001, number(header::CONTENTS_OFFSET, 64));
    cases.poke(
        18,
        "contents",
        "a table of contents at the end",
        2001,
        number(header::CONTENTS_OFFSET, length),
    );
    cases.poke(
        18,
        "tables-end",
        "page tables that end behind the end",
        2001,
        number(header::TABLES_END, length + 48),
    );
    cases.poke(
        19,
        "contents",
        "a table of contents of 2^64 - 1 bytes",
        2001,
        number(header::CONTENTS_BYTES, u64::MAX),
    );
    cases.poke(20, "sections", "2^32 - 1 sections", 1009, |i| i.put_u32(header::SECTION_COUNT, u32::MAX));
    cases.poke(20, "tables-end", "page tables of 2^64 - 1 bytes", 1009, number(header::TABLES_END, u64::MAX));
    cases.poke(21, "no-section", "0 sections", 2001, |i| i.put_u32(header::SECTION_COUNT, 0));
    digests(cases);
}

/// Kinds 14 and 15: each digest wrong, those that cover it sound.
fn digests(cases: &mut Cases) {
    let subject = cases.subject;
    let area = subject.area();
    let table = |image: &Image| {
        [
            ("page", image.page(area, 0) + page::DIGEST, 8, Some(Digests::Tables), 4001),
            ("page-table", image.section(area) + section::DIGEST, 8, Some(Digests::Contents), 3002),
            ("contents", header::CONTENTS_DIGEST, 8, Some(Digests::Root), 2002),
            ("root", header::ROOT, 32, Some(Digests::Header), 4005),
            ("header", header::DIGEST, 8, None, 1005),
        ]
    };
    let good = &subject.image;
    for (name, at, length, seal, code) in table(good) {
        let broken = |edit: &dyn Fn(&mut [u8])| {
            let mut image = good.clone();
            edit(&mut image.bytes[at..at + length]);
            seal.into_iter().for_each(|from| image.seal(from));
            image.bytes
        };
        let done = format!("a bit of the digest ({name}) flipped, those that cover it sound");
        cases.give(14, name, done, code, broken(&|digest| digest[0] ^= 1));
        let done = format!("the digest ({name}) 0, those that cover it sound");
        cases.give(15, name, done, code, broken(&|digest| digest.fill(0)));
    }
}

pub(super) fn section_cases(cases: &mut Cases) {
    let area = cases.subject.area();
    let length = cases.subject.image.bytes.len() as u64;
    let good = &cases.subject.image;
    let entry = good.section(area);
    let (data, bytes) = (good.u64(entry + section::DATA_OFFSET), good.u64(entry + section::DATA_BYTES));
    let table = good.u64(entry + section::TABLE_OFFSET);
    // Of the leaf area density, unless a name says otherwise: the sections around it have its shape.
    let mut long = |kind, label: &str, done: &str, code: u32, at: usize, value: u64| {
        cases.poke(kind, label, done, code, |image| image.put_u64(entry + at, value));
    };
    long(13, "section", "1 in a section's reserved u64", 1007, section::RESERVED, 1);
    long(17, "page-table", "a page table at byte 64", 3001, section::TABLE_OFFSET, 64);
    long(18, "page-table", "a page table at the end", 3001, section::TABLE_OFFSET, length);
    long(18, "section", "a section's data at the end", 2009, section::DATA_OFFSET, length);
    long(19, "section", "data of 2^64 - 1 bytes", 2007, section::DATA_BYTES, u64::MAX);
    long(19, "page-table", "a page table at byte 2^64 - 48", 3001, section::TABLE_OFFSET, u64::MAX - 47);
    long(20, "units", "2^62 + 1 units of 4 bytes", 2007, section::UNITS, (1 << 62) + 1);
    long(21, "no-unit", "0 units", 2007, section::UNITS, 0);
    long(
        24,
        "section",
        "data that begin 64 bytes early, in those before",
        2009,
        section::DATA_OFFSET,
        data - 64,
    );
    long(26, "section", "data that lie in the page tables", 2009, section::DATA_OFFSET, table);
    long(27, "data-offset", "data one byte late", 2009, section::DATA_OFFSET, data + 1);
    long(
        27,
        "raw-bytes",
        "a sum of payloads of one more",
        3006,
        section::RAW_BYTES,
        good.u64(entry + section::RAW_BYTES) + 1,
    );
    long(27, "units", "one unit more", 2007, section::UNITS, good.u64(entry + section::UNITS) + 1);
    // The next section begins at a multiple of 64, and is looked at first.
    let code = if (data + bytes).is_multiple_of(SECTION_ALIGN) { 2009 } else { 3006 };
    long(27, "data-bytes", "data of one byte more", code, section::DATA_BYTES, bytes + 1);
    long(28, "section", "data at no multiple of 64", 2009, section::DATA_OFFSET, data + 8);
    long(45, "units", "2^64 - 1 units", 2007, section::UNITS, u64::MAX);

    let mut short = |kind, label: &str, done: &str, code: u32, at: usize, value: u32| {
        cases.poke(kind, label, done, code, |image| image.put_u32(entry + at, value));
    };
    short(20, "pages", "2^32 - 1 pages of 48 bytes", 3001, section::PAGE_COUNT, u32::MAX);
    short(21, "no-page", "0 pages", 2007, section::PAGE_COUNT, 0);
    short(
        27,
        "page-count",
        "one page more",
        3001,
        section::PAGE_COUNT,
        good.u32(entry + section::PAGE_COUNT) + 1,
    );
    short(
        28,
        "page-bytes",
        "pages of up to 20481 bytes, no multiple of 4096",
        2007,
        section::PAGE_BYTES,
        20_481,
    );
    short(31, "codec-99", "codec 99", 2006, section::CODEC, 99);
    short(31, "codec-of-bases", "the medium in a codec of bases", 2006, section::CODEC, CODEC_HAAR_PAPER);
    short(44, "threshold-nan", "a threshold that is no number", 2007, section::THRESHOLD, f32::NAN.to_bits());
    short(45, "lattice", "a lattice of 2^31", 2007, section::LATTICE, 1 << 31);
    short(45, "bands", "2^32 - 1 bands", 2007, section::BANDS, u32::MAX);
    short(46, "lattice", "a lattice of 0", 2007, section::LATTICE, 0);
    short(46, "bands", "0 bands", 2007, section::BANDS, 0);
    short(13, "flags", "a flag that has no meaning", 2007, section::FLAGS, FLAG_REQUIRED | 1 << 31);

    let next = good.section(area + 1);
    cases.poke(22, "sections", "two sections in the wrong order", 2003, |image| {
        image.put_u32(entry + section::ITEM, 3);
        image.put_u32(next + section::ITEM, 2);
    });
    cases.poke(23, "section", "a section listed twice", 2004, |image| image.put_u32(next + section::ITEM, 2));
    let last = good.section(good.sections() - 1);
    cases.poke(12, "required-section", "a required section of a kind that no reader knows", 2005, |image| {
        image.put_u32(last + section::KIND, super::draft::UNKNOWN_KIND);
        image.put_u32(last + section::FLAGS, FLAG_REQUIRED);
    });
}

pub(super) fn page_cases(cases: &mut Cases) {
    let area = cases.subject.area();
    let length = cases.subject.image.bytes.len() as u64;
    let good = &cases.subject.image;
    let draft = cases.subject.container.header().is_draft();
    let entry = good.page(area, 0);
    let data = good.u64(entry + page::OFFSET);
    let count = good.u32(entry + page::COUNT);
    let mut long = |kind, label: &str, done: &str, code: u32, at: usize, value: u64| {
        cases.poke(kind, label, done, code, |image| image.put_u64(entry + at, value));
    };
    long(18, "page", "a page at the end", 3003, page::OFFSET, length);
    long(19, "page", "a page at byte 2^64 - 16", 3003, page::OFFSET, u64::MAX - 15);
    long(24, "page", "a page 16 bytes early, in the section before", 3003, page::OFFSET, data - 16);
    long(26, "page", "a page that lies in the table of contents", 3003, page::OFFSET, 128);
    long(27, "page-offset", "a page one byte late", 3003, page::OFFSET, data + 1);
    long(27, "first-unit", "a first unit of 1", 3005, page::FIRST, 1);
    long(28, "page", "a page at no multiple of 16", 3003, page::OFFSET, data + 4);
    long(45, "first-unit", "a first unit of 2^64 - 1", 3005, page::FIRST, u64::MAX);
    let mut short = |kind, label: &str, done: &str, code: u32, at: usize, value: u32| {
        cases.poke(kind, label, done, code, |image| image.put_u32(entry + at, value));
    };
    short(13, "page", "1 in a page's reserved field", 1007, page::RESERVED_UPPER, 1);
    // The upper half of the draft's reserved field is all that other versions leave of it.
    let code = if draft { 1007 } else { 3008 };
    short(44, "priority-nan", "a priority that is no number", code, page::PRIORITY, f32::NAN.to_bits());
    short(44, "priority-minus-1", "a priority of -1", code, page::PRIORITY, (-1f32).to_bits());
    short(21, "no-unit-in-a-page", "a page of 0 units", 3005, page::COUNT, 0);
    short(21, "units-of-a-page", "a page of 2^32 - 1 units", 3005, page::COUNT, u32::MAX);
    short(21, "empty-page", "a payload of 0 bytes", 3004, page::RAW_BYTES, 0);
    short(21, "raw-bytes", "a payload of 2^32 - 1 bytes", 3004, page::RAW_BYTES, u32::MAX);
    short(21, "stored-bytes", "2^32 - 1 stored bytes", 3004, page::STORED_BYTES, u32::MAX);
    short(27, "page-units", "a page of one unit more", 3005, page::COUNT, count + 1);
    short(31, "compression", "compression 2", 3007, page::COMPRESSION, 2);
}

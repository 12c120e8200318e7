//! Kinds 12, 22, 25, 29, 30 and 40 to 42, 47: pages and sections in places, or of contents, that are not theirs.

use super::{Cases, PASSES};
use crate::container::records::{FLAG_COPY, MAX_PAGE_BYTES, PAGE_ALIGN, SECTION_ALIGN};
use crate::testing::{Digests, Page, Parts};

pub(super) fn cases(cases: &mut Cases) {
    for (label, flags) in [("optional-section", 0), ("optional-section-to-copy", FLAG_COPY)] {
        let done = "an optional section of a kind that no reader knows, which is skipped";
        cases.rebuild(12, label, done, PASSES, |parts| parts.add_unknown(flags, &pages()));
    }
    pages_and_padding(cases);
    other_builds(cases);
}

/// Of 3, 20 and 3 bytes: bytes of padding behind the first two.
fn pages() -> [Page; 3] {
    [b"one".as_slice(), &[2; 20], b"end"].map(|payload| Page::plain(payload, 1))
}

/// In the file with an optional section of three pages.
fn pages_and_padding(cases: &mut Cases) {
    let mut good = cases.subject.parts.clone();
    good.add_unknown(0, &pages());
    good.lay_out();
    let last = good.sections.len() - 1;
    let mut changed = |kind, label: &str, done: &str, code: u32, edit: &dyn Fn(&mut Parts)| {
        let mut parts = good.clone();
        edit(&mut parts);
        cases.give(kind, label, done, code, parts.seal(Digests::Pages));
    };
    let offset = |p: usize| good.tables[last][p].offset;
    changed(22, "pages", "two entries of a page table in the wrong order", 3003, &|parts| {
        parts.tables[last].swap(0, 1);
    });
    let done = "a page at the place of an earlier one of another size";
    changed(25, "of-another-size", done, 3003, &|parts| parts.tables[last][1].offset = offset(0));
    let done = "a page at the place of a later one";
    changed(47, "page-ahead", done, 3003, &|parts| parts.tables[last][0].offset = offset(2));
    changed(29, "between-pages", "1 in the padding between two pages", 4004, &|parts| {
        parts.bytes[offset(0) as usize + 3] = 1;
    });
    changed(30, "between-pages", "16 bytes of 0 between two pages", 3003, &|parts| {
        hole(parts, offset(1), PAGE_ALIGN);
        parts.tables[last][1..].iter_mut().for_each(|page| page.offset += PAGE_ALIGN);
        parts.sections[last].data_bytes += PAGE_ALIGN;
    });
    changed(30, "between-sections", "64 bytes of 0 between two sections", 2009, &|parts| {
        hole(parts, offset(0), SECTION_ALIGN);
        parts.tables[last].iter_mut().for_each(|page| page.offset += SECTION_ALIGN);
        parts.sections[last].data_offset += SECTION_ALIGN;
    });
}

fn hole(parts: &mut Parts, at: u64, bytes: u64) {
    parts.bytes.splice(at as usize..at as usize, std::iter::repeat_n(0, bytes as usize));
    parts.header.file_bytes += bytes;
}

/// Pages that were sound at another place or in another build: their digests are theirs, all others fit.
fn other_builds(cases: &mut Cases) {
    let (subject, area) = (cases.subject, cases.subject.area());
    let mut parts = subject.parts.clone();
    parts.tables.swap(area, area + 1);
    parts.sections[area..area + 2].iter_mut().for_each(|section| section.page_bytes = MAX_PAGE_BYTES);
    parts.lay_out();
    let done = "the pages of two sections of one shape in each other's place, with their digests";
    cases.give(40, "sibling", done, 4001, parts.seal(Digests::Tables));

    let mut parts = subject.parts.clone();
    parts.stored(area, 0)[0] ^= 1;
    let done = "one page of another build, under the digest of this one";
    cases.give(41, "earlier-page", done, 4001, parts.seal(Digests::Tables));

    let mut other = subject.file.clone();
    let tables_end = subject.container.header().tables_end as usize;
    other[tables_end..].iter_mut().for_each(|byte| *byte = !*byte);
    let done = "header and tables of this build, all data of another (as over HTTP, when a file is replaced meanwhile)";
    cases.give(42, "old-tables-new-data", done, 4001, other);
}

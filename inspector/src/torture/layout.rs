//! Kinds 12, 22, 25, 29, 30 and 40 to 42, 47: pages and sections in places, or of contents, that are not theirs.

use flb_format::records::{FLAG_COPY, PAGE_ALIGN, SECTION_ALIGN};

use super::draft::{Digests, Draft, Image, PageDraft, header, page, section};
use super::{Cases, PASSES};

pub(super) fn cases(cases: &mut Cases) {
    for (label, flags) in [("optional-section", 0), ("optional-section-to-copy", FLAG_COPY)] {
        let done = "an optional section of a kind that no reader knows, which is skipped";
        cases.rebuild(12, label, done, PASSES, |draft| draft.add_unknown(flags, pages()));
    }
    two_pages(cases);
    padding(cases);
    other_builds(cases);
}

/// Of 3, 20 and 3 bytes: bytes of padding behind the first two.
fn pages() -> Vec<PageDraft> {
    [b"one".as_slice(), &[2; 20], b"end"].map(|payload| PageDraft::plain(payload, 1)).into()
}

/// The file with an optional section of three pages, and the index of that section.
fn with_pages(draft: &Draft) -> (Image, usize) {
    let mut draft = draft.clone();
    draft.add_unknown(0, pages());
    let last = draft.sections.len() - 1;
    (draft.build(), last)
}

fn two_pages(cases: &mut Cases) {
    let (good, section) = with_pages(&cases.subject.draft);
    let entry = |p: usize| good.page(section, p);
    let mut changed = |kind, label: &str, done: &str, edit: &dyn Fn(&mut Image)| {
        let mut image = good.clone();
        edit(&mut image);
        image.seal(Digests::Pages);
        cases.give(kind, label, done, 3003, image.bytes);
    };
    let offset = |p: usize| good.u64(entry(p) + page::OFFSET);
    changed(22, "pages", "two entries of a page table in the wrong order", &|image| {
        let (one, two) = (good.bytes[entry(0)..entry(1)].to_vec(), good.bytes[entry(1)..entry(2)].to_vec());
        image.put(entry(0), &two);
        image.put(entry(1), &one);
    });
    changed(25, "of-another-size", "a page at the place of an earlier one of another size", &|image| {
        image.put_u64(entry(1) + page::OFFSET, offset(0));
    });
    changed(47, "page-ahead", "a page at the place of a later one", &|image| {
        image.put_u64(entry(0) + page::OFFSET, offset(2));
    });
}

fn padding(cases: &mut Cases) {
    let (good, last) = with_pages(&cases.subject.draft);
    let gap = good.u64(good.page(last, 0) + page::OFFSET) as usize + 3;
    let mut image = good.clone();
    image.bytes[gap] = 1;
    image.seal(Digests::Pages);
    cases.give(29, "between-pages", "1 in the padding between two pages", 4004, image.bytes);

    let mut image = good.clone();
    let (second, third) = (good.page(last, 1), good.page(last, 2));
    let at = good.u64(second + page::OFFSET) as usize;
    image.bytes.splice(at..at, [0; PAGE_ALIGN as usize]);
    [second, third].into_iter().for_each(|entry| add(&mut image, entry + page::OFFSET, PAGE_ALIGN));
    add(&mut image, good.section(last) + section::DATA_BYTES, PAGE_ALIGN);
    add(&mut image, header::FILE_BYTES, PAGE_ALIGN);
    image.seal(Digests::Pages);
    cases.give(30, "between-pages", "16 bytes of 0 between two pages", 3003, image.bytes);

    let mut image = good.clone();
    let at = good.u64(good.section(last) + section::DATA_OFFSET);
    image.bytes.splice(at as usize..at as usize, [0; SECTION_ALIGN as usize]);
    add(&mut image, good.section(last) + section::DATA_OFFSET, SECTION_ALIGN);
    (0..good.pages(last)).for_each(|p| add(&mut image, good.page(last, p) + page::OFFSET, SECTION_ALIGN));
    add(&mut image, header::FILE_BYTES, SECTION_ALIGN);
    image.seal(Digests::Pages);
    cases.give(30, "between-sections", "64 bytes of 0 between two sections", 2009, image.bytes);
}

fn add(image: &mut Image, at: usize, more: u64) {
    image.put_u64(at, image.u64(at) + more);
}

/// Pages that were sound at another place or in another build: their digests are theirs, all others fit.
fn other_builds(cases: &mut Cases) {
    let subject = cases.subject;
    let area = subject.area();
    let mut draft = subject.draft.clone();
    let digests = |draft: &Draft, section: usize| -> Vec<Vec<u8>> {
        draft.sections[section].pages.iter().map(|p| p.record[page::DIGEST..].to_vec()).collect()
    };
    let kept = [digests(&draft, area + 1), digests(&draft, area)];
    let (one, two) = (draft.sections[area].pages.clone(), draft.sections[area + 1].pages.clone());
    for (section, pages) in [(area, two), (area + 1, one)] {
        draft.sections[section].pages = pages;
        draft.sections[section].set_u32(section::PAGE_BYTES, flb_format::records::MAX_PAGE_BYTES);
    }
    let mut image = draft.build();
    for (section, digests) in [area, area + 1].into_iter().zip(kept) {
        for (p, digest) in digests.iter().enumerate() {
            let at = image.page(section, p) + page::DIGEST;
            image.put(at, digest);
        }
    }
    image.seal(Digests::Tables);
    let done = "the pages of two sections of one shape in each other's place, with their digests";
    cases.give(40, "sibling", done, 4001, image.bytes);

    let mut image = subject.image.clone();
    let at = image.u64(image.page(area, 0) + page::OFFSET) as usize;
    image.bytes[at] ^= 1;
    image.seal(Digests::Tables);
    cases.give(
        41,
        "earlier-page",
        "one page of another build, under the digest of this one",
        4001,
        image.bytes,
    );

    let mut other = subject.file.clone();
    let tables_end = subject.container.header().tables_end as usize;
    other[tables_end..].iter_mut().for_each(|byte| *byte = !*byte);
    let done = "header and tables of this build, all data of another (as over HTTP, when a file is replaced meanwhile)";
    cases.give(42, "old-tables-new-data", done, 4001, other);
}

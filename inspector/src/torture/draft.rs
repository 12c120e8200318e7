//! A file taken apart, to be put together wrongly: records and pages apart from each other, and an [`Image`] laid out
//! by SPEC.md section 2, in which single bytes can be changed and digests made to fit again.
//!
//! Records stay bytes, and fields are named by their offsets in SPEC.md: a corruption must be able to write what no
//! type of ours can hold. Pages that share bytes are written apart, which every version of the format allows.

use flb_format::container::digest::{self, Root};
use flb_format::records::*;
use flb_format::{Container, FormatError, Source};

/// Offsets of fields in a header.
#[allow(missing_docs, reason = "the names are those of SPEC.md")]
pub mod header {
    pub const MAJOR: usize = 8;
    pub const MINOR: usize = 10;
    pub const HEADER_BYTES: usize = 12;
    pub const REQUIRED: usize = 16;
    pub const OPTIONAL: usize = 24;
    pub const FILE_BYTES: usize = 32;
    pub const CONTENTS_OFFSET: usize = 40;
    pub const CONTENTS_BYTES: usize = 48;
    pub const SECTION_COUNT: usize = 56;
    pub const RESERVED_60: usize = 60;
    pub const CONTENTS_DIGEST: usize = 64;
    pub const TABLES_END: usize = 72;
    pub const ROOT: usize = 80;
    pub const RESERVED_112: usize = 112;
    pub const DIGEST: usize = 120;
}

/// Offsets of fields in an entry of the table of contents.
#[allow(missing_docs, reason = "the names are those of SPEC.md")]
pub mod section {
    pub const KIND: usize = 0;
    pub const SPECIES: usize = 4;
    pub const ITEM: usize = 8;
    pub const FLAGS: usize = 12;
    pub const DATA_OFFSET: usize = 16;
    pub const DATA_BYTES: usize = 24;
    pub const RAW_BYTES: usize = 32;
    pub const TABLE_OFFSET: usize = 40;
    pub const PAGE_COUNT: usize = 48;
    pub const CODEC: usize = 52;
    pub const THRESHOLD: usize = 56;
    pub const PAGE_BYTES: usize = 60;
    pub const LATTICE: usize = 64;
    pub const BANDS: usize = 68;
    pub const UNITS: usize = 72;
    pub const RESERVED: usize = 80;
    pub const DIGEST: usize = 88;
}

/// Offsets of fields in an entry of a page table.
#[allow(missing_docs, reason = "the names are those of SPEC.md")]
pub mod page {
    pub const OFFSET: usize = 0;
    pub const STORED_BYTES: usize = 8;
    pub const RAW_BYTES: usize = 12;
    pub const FIRST: usize = 16;
    pub const COUNT: usize = 24;
    pub const COMPRESSION: usize = 28;
    /// 0 in the draft.
    pub const PRIORITY: usize = 32;
    /// 0 in every version.
    pub const RESERVED_UPPER: usize = 36;
    pub const DIGEST: usize = 40;
}

const HEAD: usize = HEADER_BYTES as usize;
const ENTRY: usize = SECTION_ENTRY_BYTES as usize;
const PAGE: usize = PAGE_ENTRY_BYTES as usize;

/// A file in parts.
#[derive(Debug, Clone)]
pub struct Draft {
    /// As in the file; what the layout decides is written anew.
    pub header: [u8; HEAD],
    /// In the order of the table of contents.
    pub sections: Vec<SectionDraft>,
}

/// A section in parts.
#[derive(Debug, Clone)]
pub struct SectionDraft {
    /// Its entry; places, sums and digest are written anew.
    pub record: [u8; ENTRY],
    /// In order.
    pub pages: Vec<PageDraft>,
}

/// A page in parts.
#[derive(Debug, Clone)]
pub struct PageDraft {
    /// Its entry; place, stored size, first unit and digest are written anew.
    pub record: [u8; PAGE],
    /// Its stored bytes.
    pub stored: Vec<u8>,
}

impl PageDraft {
    /// A plain page of `count` units.
    pub fn plain(payload: &[u8], count: u32) -> PageDraft {
        PageDraft::stored(payload.to_vec(), payload.len() as u32, count, STORED_PLAIN)
    }

    /// A page that holds its payload as a zstd frame.
    pub fn zstd(frame: Vec<u8>, raw_bytes: u32, count: u32) -> PageDraft {
        PageDraft::stored(frame, raw_bytes, count, STORED_ZSTD)
    }

    fn stored(stored: Vec<u8>, raw_bytes: u32, count: u32, compression: u32) -> PageDraft {
        let mut record = [0; PAGE];
        put(&mut record, page::RAW_BYTES, &raw_bytes.to_le_bytes());
        put(&mut record, page::COUNT, &count.to_le_bytes());
        put(&mut record, page::COMPRESSION, &compression.to_le_bytes());
        PageDraft { record, stored }
    }

    /// The number at an offset of its entry.
    pub fn u32(&self, at: usize) -> u32 {
        u32_at(&self.record, at)
    }

    /// Writes a number of its entry.
    pub fn set_u32(&mut self, at: usize, value: u32) {
        put(&mut self.record, at, &value.to_le_bytes());
    }
}

impl SectionDraft {
    /// The number at an offset of its entry.
    pub fn u32(&self, at: usize) -> u32 {
        u32_at(&self.record, at)
    }

    /// Writes a number of its entry.
    pub fn set_u32(&mut self, at: usize, value: u32) {
        put(&mut self.record, at, &value.to_le_bytes());
    }
}

impl Draft {
    /// Takes a sound file apart.
    ///
    /// # Errors
    /// Read errors, and digests of pages.
    pub fn of(container: &Container, source: &dyn Source) -> Result<Draft, FormatError> {
        let mut sections = Vec::with_capacity(container.sections().len());
        for (i, entry) in container.sections().iter().enumerate() {
            let mut pages = Vec::with_capacity(container.pages(i).len());
            for (p, page) in container.pages(i).iter().enumerate() {
                let stored = container.read_stored(source, i, p as u32)?;
                pages.push(PageDraft { record: page.to_bytes(), stored });
            }
            sections.push(SectionDraft { record: entry.to_bytes(), pages });
        }
        Ok(Draft { header: container.header().to_bytes(), sections })
    }

    /// Index of the first section of a kind and item.
    pub fn find(&self, kind: u32, item: u32) -> Option<usize> {
        self.sections.iter().position(|s| s.u32(section::KIND) == kind && s.u32(section::ITEM) == item)
    }

    /// Gives a section one plain page, whose units are as many as before, or bytes.
    pub fn replace(&mut self, index: usize, payload: &[u8]) {
        let section = &mut self.sections[index];
        let of_bytes = [CODEC_JSON, CODEC_BLOCK_MAP, CODEC_CLASSES, CODEC_AVERAGES]
            .contains(&section.u32(section::CODEC));
        let units: u32 = section.pages.iter().map(|page| page.u32(page::COUNT)).sum();
        let count = if of_bytes { payload.len() as u32 } else { units };
        section.pages = vec![PageDraft::plain(payload, count)];
        section.set_u32(section::PAGE_BYTES, MAX_PAGE_BYTES);
    }

    /// Adds a section of a kind that no reader knows, behind all others; `flags` as in SPEC.md section 4.
    pub fn add_unknown(&mut self, flags: u32, pages: Vec<PageDraft>) {
        let mut record = [0; ENTRY];
        put(&mut record, section::KIND, &UNKNOWN_KIND.to_le_bytes());
        put(&mut record, section::FLAGS, &flags.to_le_bytes());
        put(&mut record, section::PAGE_BYTES, &MAX_PAGE_BYTES.to_le_bytes());
        self.sections.push(SectionDraft { record, pages });
    }

    /// The file, laid out without holes, sums and digests made to fit, bit 0 of the features as the pages say.
    pub fn build(self) -> Image {
        let pages = |s: &SectionDraft| s.pages.len();
        let counts: Vec<usize> = self.sections.iter().map(pages).collect();
        let mut image = Image { bytes: self.header.to_vec(), counts };
        let contents_bytes = ENTRY * self.sections.len();
        let tables_end = HEAD + contents_bytes + PAGE * image.counts.iter().sum::<usize>();
        image.bytes.resize(tables_end, 0);
        let mut zstd = false;
        for (i, draft) in self.sections.into_iter().enumerate() {
            image.pad_to(SECTION_ALIGN);
            let start = image.bytes.len() as u64;
            let (mut units, mut raw_bytes) = (0u64, 0u64);
            for (p, page) in draft.pages.into_iter().enumerate() {
                image.pad_to(PAGE_ALIGN);
                let mut record = page.record;
                put(&mut record, page::OFFSET, &(image.bytes.len() as u64).to_le_bytes());
                put(&mut record, page::STORED_BYTES, &(page.stored.len() as u32).to_le_bytes());
                put(&mut record, page::FIRST, &units.to_le_bytes());
                units += u64::from(u32_at(&record, page::COUNT));
                raw_bytes += u64::from(u32_at(&record, page::RAW_BYTES));
                zstd |= u32_at(&record, page::COMPRESSION) == STORED_ZSTD;
                let at = image.page(i, p);
                image.put(at, &record);
                image.bytes.extend(page.stored);
            }
            let mut record = draft.record;
            put(&mut record, section::DATA_OFFSET, &start.to_le_bytes());
            put(&mut record, section::DATA_BYTES, &(image.bytes.len() as u64 - start).to_le_bytes());
            put(&mut record, section::RAW_BYTES, &raw_bytes.to_le_bytes());
            put(&mut record, section::UNITS, &units.to_le_bytes());
            put(&mut record, section::TABLE_OFFSET, &(image.page(i, 0) as u64).to_le_bytes());
            put(&mut record, section::PAGE_COUNT, &(image.counts[i] as u32).to_le_bytes());
            let at = image.section(i);
            image.put(at, &record);
        }
        let features =
            u64_at(&image.bytes, header::REQUIRED) & !FEATURE_ZSTD | if zstd { FEATURE_ZSTD } else { 0 };
        image.put_u64(header::REQUIRED, features);
        image.put_u64(header::FILE_BYTES, image.bytes.len() as u64);
        image.put_u64(header::CONTENTS_BYTES, contents_bytes as u64);
        image.put_u32(header::SECTION_COUNT, image.counts.len() as u32);
        image.put_u64(header::TABLES_END, tables_end as u64);
        image.seal(Digests::Pages);
        image
    }
}

/// A kind of section that no version has.
pub const UNKNOWN_KIND: u32 = 0x7FFF_FFFF;

/// The digests of a file, in the order in which one covers the one before.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Digests {
    /// Of each page.
    Pages,
    /// Of each page table.
    Tables,
    /// Of the table of contents.
    Contents,
    /// Of the whole file.
    Root,
    /// Of the header.
    Header,
}

/// A file laid out, with the number of pages of each section.
#[derive(Debug, Clone)]
pub struct Image {
    /// The file.
    pub bytes: Vec<u8>,
    counts: Vec<usize>,
}

impl Image {
    /// The bytes of a file that opens, laid out as they are.
    pub fn of(container: &Container, bytes: Vec<u8>) -> Image {
        let counts = (0..container.sections().len()).map(|i| container.pages(i).len()).collect();
        Image { bytes, counts }
    }

    /// Where the entry of a section lies.
    pub fn section(&self, index: usize) -> usize {
        HEAD + ENTRY * index
    }

    /// Where the entry of a page lies.
    pub fn page(&self, section: usize, page: usize) -> usize {
        HEAD + ENTRY * self.counts.len() + PAGE * (self.counts[..section].iter().sum::<usize>() + page)
    }

    /// Number of sections.
    pub fn sections(&self) -> usize {
        self.counts.len()
    }

    /// Pages of a section.
    pub fn pages(&self, section: usize) -> usize {
        self.counts[section]
    }

    /// A number at an offset of the file.
    pub fn u32(&self, at: usize) -> u32 {
        u32_at(&self.bytes, at)
    }

    /// A number at an offset of the file.
    pub fn u64(&self, at: usize) -> u64 {
        u64_at(&self.bytes, at)
    }

    /// Writes bytes at an offset.
    pub fn put(&mut self, at: usize, value: &[u8]) {
        put(&mut self.bytes, at, value);
    }

    /// Writes a number at an offset.
    pub fn put_u32(&mut self, at: usize, value: u32) {
        self.put(at, &value.to_le_bytes());
    }

    /// Writes a number at an offset.
    pub fn put_u64(&mut self, at: usize, value: u64) {
        self.put(at, &value.to_le_bytes());
    }

    /// Makes the digests fit, from these on. Pages that lie outside the file keep theirs.
    pub fn seal(&mut self, from: Digests) {
        for i in 0..self.counts.len() {
            let (entry, key) = (self.section(i), key_of(&self.bytes[self.section(i)..]));
            for p in (0..self.counts[i]).filter(|_| from <= Digests::Pages) {
                let at = self.page(i, p);
                let (offset, stored) =
                    (self.u64(at + page::OFFSET) as usize, self.u32(at + page::STORED_BYTES) as usize);
                if let Some(stored) = offset.checked_add(stored).and_then(|end| self.bytes.get(offset..end)) {
                    self.put_u64(at + page::DIGEST, digest::page(key, p as u32, stored));
                }
            }
            if from <= Digests::Tables {
                let table = &self.bytes[self.page(i, 0)..][..PAGE * self.counts[i]];
                self.put_u64(entry + section::DIGEST, digest::plain(table));
            }
        }
        if from <= Digests::Contents {
            let contents = &self.bytes[HEAD..][..ENTRY * self.counts.len()];
            self.put_u64(header::CONTENTS_DIGEST, digest::plain(contents));
        }
        if from <= Digests::Root {
            let mut root = Root::new(&self.bytes[..HEAD]);
            root.update(&self.bytes[HEAD..]);
            self.put(header::ROOT, &root.finish());
        }
        self.put_u64(header::DIGEST, digest::plain(&self.bytes[..HEADER_DIGESTED_BYTES]));
    }

    fn pad_to(&mut self, align: u64) {
        self.bytes.resize(self.bytes.len().next_multiple_of(align as usize), 0);
    }
}

fn put(bytes: &mut [u8], at: usize, value: &[u8]) {
    bytes[at..at + value.len()].copy_from_slice(value);
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"))
}

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight bytes"))
}

fn key_of(record: &[u8]) -> SectionKey {
    let number = |at| u32_at(record, at);
    SectionKey { kind: number(section::KIND), species: number(section::SPECIES), item: number(section::ITEM) }
}

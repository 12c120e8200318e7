//! A file taken apart, changed, and put together with sound digests.
//!
//! Records are those of the format, whose fields hold any number; pages are bytes of the file that their entries point
//! at. A corruption changes records behind [`Parts::of`], or pages and sections and then calls [`Parts::lay_out`];
//! [`Parts::seal`] makes digests fit from the level on that the corruption leaves to them.

use crate::container::digest::{self, Root};
use crate::container::records::*;

const CONTENTS_AT: usize = HEADER_BYTES as usize;
const ENTRY: usize = SECTION_ENTRY_BYTES as usize;
const PAGE: usize = PAGE_ENTRY_BYTES as usize;

/// A file in parts.
#[derive(Debug, Clone)]
pub struct Parts {
    /// Header without magic and digest.
    pub header: Header,
    /// The table of contents.
    pub sections: Vec<SectionEntry>,
    /// The page tables: `[section][page]`.
    pub tables: Vec<Vec<PageEntry>>,
    /// The file. What stands where records go is written over by [`Parts::seal`].
    pub bytes: Vec<u8>,
}

/// Stored bytes of a page to be, and what its entry says of them.
#[derive(Debug, Clone)]
pub struct Page {
    /// Bytes as in the file.
    pub stored: Vec<u8>,
    /// Bytes of the payload.
    pub raw_bytes: u32,
    /// Number of units.
    pub count: u32,
    /// [`STORED_PLAIN`] or [`STORED_ZSTD`].
    pub compression: u32,
}

/// The digests of a file, in the order in which one covers the one before.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Digests {
    /// Digest of each page.
    Pages,
    /// Digest of each page table.
    Tables,
    /// Digest of the table of contents.
    Contents,
    /// Digest of the whole file.
    Root,
    /// Digest of the header.
    Header,
}

impl Page {
    /// A page that holds its payload as it is.
    pub fn plain(payload: &[u8], count: u32) -> Page {
        Page { stored: payload.to_vec(), raw_bytes: payload.len() as u32, count, compression: STORED_PLAIN }
    }

    /// A page that holds its payload as a zstd frame.
    pub fn zstd(stored: Vec<u8>, raw_bytes: u32, count: u32) -> Page {
        Page { stored, raw_bytes, count, compression: STORED_ZSTD }
    }
}

impl Parts {
    /// Takes a file apart.
    ///
    /// # Panics
    /// If its records do not lie in it. Those of a file that opens do.
    pub fn of(file: &[u8]) -> Parts {
        let (header, _) = Header::from_bytes(file.first_chunk().expect("a header"));
        let contents = &file[CONTENTS_AT..][..header.contents_bytes as usize];
        let sections: Vec<_> = contents.as_chunks().0.iter().map(SectionEntry::from_bytes).collect();
        let table = |section: &SectionEntry| {
            let table = &file[section.table_offset as usize..][..PAGE * section.page_count as usize];
            table.as_chunks().0.iter().map(PageEntry::from_bytes).collect()
        };
        let tables = sections.iter().map(table).collect();
        Parts { header, sections, tables, bytes: file.to_vec() }
    }

    /// Index of the first section of a kind and item.
    ///
    /// # Panics
    /// If there is none.
    pub fn find(&self, kind: u32, item: u32) -> usize {
        let is_it = |section: &SectionEntry| section.key.kind == kind && section.key.item == item;
        self.sections.iter().position(is_it).unwrap_or_else(|| panic!("no section {kind}, {item}"))
    }

    /// The stored bytes of a page.
    ///
    /// # Panics
    /// If they do not lie in the file.
    pub fn stored(&mut self, section: usize, page: usize) -> &mut [u8] {
        let entry = self.tables[section][page];
        &mut self.bytes[entry.offset as usize..][..entry.stored_bytes as usize]
    }

    /// Gives a page other stored bytes, behind all that the file has.
    pub fn store(&mut self, section: usize, page: usize, stored: &[u8]) {
        let entry = &mut self.tables[section][page];
        (entry.offset, entry.stored_bytes) = (self.bytes.len() as u64, stored.len() as u32);
        self.bytes.extend(stored);
    }

    /// Gives a page another payload, plain, of as many units, or of as many bytes where those are the units. Pages of
    /// the section may be as large as the format allows.
    pub fn set_payload(&mut self, section: usize, page: usize, payload: &[u8]) {
        let (entry, length) = (&mut self.sections[section], payload.len() as u32);
        entry.page_bytes = MAX_PAGE_BYTES;
        let of_bytes = [CODEC_JSON, CODEC_BLOCK_MAP, CODEC_CLASSES, CODEC_AVERAGES].contains(&entry.codec);
        let page_entry = &mut self.tables[section][page];
        page_entry.count = if of_bytes { length } else { page_entry.count };
        (page_entry.raw_bytes, page_entry.compression, page_entry.priority) = (length, STORED_PLAIN, 0.0);
        self.store(section, page, payload);
    }

    /// Gives a section one plain page in place of all, of as many units, or of as many bytes where those are the units.
    pub fn replace(&mut self, section: usize, payload: &[u8]) {
        let units = self.tables[section].iter().map(|page| page.count).sum();
        self.tables[section].truncate(1);
        self.tables[section][0].count = units;
        self.set_payload(section, 0, payload);
    }

    /// Gives a section these pages in place of all.
    pub fn set_pages(&mut self, section: usize, pages: &[Page]) {
        self.sections[section].page_bytes = MAX_PAGE_BYTES;
        self.tables[section].clear();
        for (p, page) in pages.iter().enumerate() {
            let mut entry = PageEntry::from_bytes(&[0; PAGE]);
            (entry.raw_bytes, entry.count, entry.compression) =
                (page.raw_bytes, page.count, page.compression);
            self.tables[section].push(entry);
            self.store(section, p, &page.stored);
        }
    }

    /// Puts a section before the one of this index; pages of it may be as large as the format allows.
    pub fn insert(&mut self, index: usize, key: SectionKey, flags: u32, pages: &[Page]) -> &mut SectionEntry {
        let entry = SectionEntry { key, flags, ..SectionEntry::from_bytes(&[0; ENTRY]) };
        self.sections.insert(index, entry);
        self.tables.insert(index, Vec::new());
        self.set_pages(index, pages);
        &mut self.sections[index]
    }

    /// Puts a section of a kind that no version has behind all others; `flags` as in SPEC.md section 4.
    pub fn add_unknown(&mut self, flags: u32, pages: &[Page]) {
        let key = SectionKey { kind: Parts::UNKNOWN_KIND, species: 0, item: 0 };
        self.insert(self.sections.len(), key, flags, pages);
    }

    /// A kind of section that no version has.
    pub const UNKNOWN_KIND: u32 = 0x7FFF_FFFF;

    /// Takes a section out.
    pub fn remove(&mut self, section: usize) {
        self.sections.remove(section);
        self.tables.remove(section);
    }

    /// Moves tables and pages to where SPEC.md section 2 wants them, without holes, and makes places, sums and feature
    /// bit 0 fit. Pages that share bytes lie apart afterwards, which every version of the format allows.
    ///
    /// # Panics
    /// If the stored bytes of a page do not lie in the file.
    pub fn lay_out(&mut self) {
        let old = std::mem::take(&mut self.bytes);
        let mut table_at = CONTENTS_AT + ENTRY * self.sections.len();
        let tables_end = table_at + PAGE * self.tables.iter().map(Vec::len).sum::<usize>();
        self.bytes.resize(tables_end, 0);
        for (section, table) in self.sections.iter_mut().zip(&mut self.tables) {
            pad(&mut self.bytes, SECTION_ALIGN);
            (section.data_offset, section.table_offset) = (self.bytes.len() as u64, table_at as u64);
            (section.units, section.raw_bytes, section.page_count) = (0, 0, table.len() as u32);
            table_at += PAGE * table.len();
            for page in table {
                pad(&mut self.bytes, PAGE_ALIGN);
                let stored = &old[page.offset as usize..][..page.stored_bytes as usize];
                (page.offset, page.first) = (self.bytes.len() as u64, section.units);
                self.bytes.extend(stored);
                section.units += u64::from(page.count);
                section.raw_bytes += u64::from(page.raw_bytes);
            }
            section.data_bytes = self.bytes.len() as u64 - section.data_offset;
        }
        let header = &mut self.header;
        header.required_features &= !FEATURE_ZSTD;
        if self.tables.iter().flatten().any(|page| page.compression == STORED_ZSTD) {
            header.required_features |= FEATURE_ZSTD;
        }
        (header.file_bytes, header.tables_end) = (self.bytes.len() as u64, tables_end as u64);
        header.section_count = self.sections.len() as u32;
        header.contents_bytes = (ENTRY * self.sections.len()) as u64;
    }

    /// The file, with digests made to fit from these on. Pages that do not lie in the file keep theirs.
    pub fn seal(mut self, from: Digests) -> Vec<u8> {
        // First all records as they are: a page may be said to lie among them.
        self.write_header();
        let tables_at = CONTENTS_AT + ENTRY * self.sections.len();
        let contents: Vec<u8> = self.sections.iter().flat_map(SectionEntry::to_bytes).collect();
        put(&mut self.bytes, CONTENTS_AT, &contents);
        let tables: Vec<u8> = self.tables.iter().flatten().flat_map(PageEntry::to_bytes).collect();
        put(&mut self.bytes, tables_at, &tables);
        let mut at = tables_at;
        for (i, (section, table)) in self.sections.iter_mut().zip(&mut self.tables).enumerate() {
            let start = at;
            for (p, page) in table.iter_mut().enumerate() {
                let end = page.offset.saturating_add(page.stored_bytes.into());
                if let Some(stored) = self.bytes.get(page.offset as usize..end as usize)
                    && from <= Digests::Pages
                {
                    page.digest = digest::page(section.key, p as u32, stored);
                    put(&mut self.bytes, at, &page.to_bytes());
                }
                at += PAGE;
            }
            if from <= Digests::Tables {
                section.table_digest = digest::plain(&self.bytes[start..at]);
                put(&mut self.bytes, CONTENTS_AT + ENTRY * i, &section.to_bytes());
            }
        }
        if from <= Digests::Contents {
            self.header.contents_digest = digest::plain(&self.bytes[CONTENTS_AT..tables_at]);
        }
        if from <= Digests::Root {
            let mut root = Root::new(&self.header.to_bytes());
            root.update(&self.bytes[CONTENTS_AT..]);
            self.header.root = root.finish();
        }
        self.write_header();
        self.bytes
    }

    fn write_header(&mut self) {
        put(&mut self.bytes, 0, &self.header.to_bytes());
    }
}

fn pad(bytes: &mut Vec<u8>, align: u64) {
    bytes.resize(bytes.len().next_multiple_of(align as usize), 0);
}

fn put(bytes: &mut [u8], at: usize, value: &[u8]) {
    bytes[at..at + value.len()].copy_from_slice(value);
}

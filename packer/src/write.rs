//! Species to the bytes of a file: where everything lies is known before the first byte is written, so
//! the tables stand in front and the output needs no seeking.

use std::collections::HashMap;
use std::io::{self, Write};
use std::path::Path;

use flb_files::{Existing, FileError, publish};
use flb_format::container::digest::{self, Root};
use flb_format::container::records::*;

use crate::encode::EncodedSection;
use crate::{EncodedSpecies, PackError};

/// Writes a library to `path`, whole or not at all; returns its length in bytes.
///
/// # Errors
/// No species, two of one name, a library over the format's limits; what [`publish`] refuses.
pub fn write_library(path: &Path, species: &[&EncodedSpecies], existing: Existing) -> Result<u64, PackError> {
    let layout = Layout::plan(species)?;
    publish(path, existing, |out| layout.write(out))?;
    Ok(layout.header.file_bytes)
}

/// Writes a library to any writer; returns its length in bytes.
///
/// # Errors
/// As [`write_library`], with write errors named after `<writer>`.
pub fn write_library_to(out: &mut dyn Write, species: &[&EncodedSpecies]) -> Result<u64, PackError> {
    let layout = Layout::plan(species)?;
    layout.write(out).map_err(|source| FileError::Write { path: "<writer>".into(), source })?;
    Ok(layout.header.file_bytes)
}

/// A file that is known to the byte.
struct Layout<'a> {
    header: Header,
    /// Table of contents and page tables.
    tables: Vec<u8>,
    /// Offset and bytes of every page, ascending.
    pages: Vec<(u64, &'a [u8])>,
}

impl<'a> Layout<'a> {
    fn plan(species: &[&'a EncodedSpecies]) -> Result<Layout<'a>, PackError> {
        check_names(species)?;
        let mut sections: Vec<(SectionKey, &EncodedSection)> = Vec::new();
        for (i, species) in (0u32..).zip(species) {
            let key = |s: &EncodedSection| SectionKey { kind: s.kind, species: i, item: s.item };
            sections.extend(species.sections.iter().map(|section| (key(section), section)));
        }
        sections.sort_by_key(|(key, _)| *key);
        let of_payloads = |of: fn(u32) -> bool| -> u64 {
            sections.iter().filter(|(key, _)| of(key.kind)).map(|(_, section)| section.raw_bytes()).sum()
        };
        let largest_detail = sections
            .iter()
            .filter(|(key, _)| key.kind == KIND_DETAIL)
            .map(|(_, section)| section.raw_bytes());
        let page_count: u64 = sections.iter().map(|(_, section)| section.pages.len() as u64).sum();
        for (what, found, limit) in [
            ("number of sections", sections.len() as u64, MAX_SECTIONS.into()),
            ("number of pages", page_count, MAX_PAGES),
            ("size of all metadata", of_payloads(|kind| kind == KIND_METADATA), MAX_ALL_METADATA_BYTES),
            ("size of all payloads", of_payloads(|_| true), MAX_ALL_BYTES),
            ("size of the detail of a base", largest_detail.max().unwrap_or(0), MAX_DETAIL_BYTES),
        ] {
            if found > limit {
                return Err(PackError::Limit { what, found, limit });
            }
        }

        let contents_bytes = sections.len() as u64 * SECTION_ENTRY_BYTES;
        let tables_end = HEADER_BYTES + contents_bytes + page_count * PAGE_ENTRY_BYTES;
        let (mut table_at, mut data_at) = (HEADER_BYTES + contents_bytes, tables_end);
        let mut contents = Vec::with_capacity(contents_bytes as usize);
        let mut page_tables = Vec::with_capacity((page_count * PAGE_ENTRY_BYTES) as usize);
        let mut pages = Vec::with_capacity(page_count as usize);
        let mut compressed = false;
        let is_f16 = |s: &EncodedSection| s.kind == KIND_BASE && s.codec == CODEC_RAW_F16;
        let raw_f16 = sections.iter().any(|(_, section)| is_f16(section));
        let blocks = sections.iter().any(|(key, _)| key.kind == KIND_BLOCKS);
        let physical = species.iter().any(|species| species.meta.model.has_extinction());
        let leaning = species.iter().any(|species| species.meta.model.suns().is_leaning());
        let mut stored: HashMap<(u32, u32, &[u8]), u64> = HashMap::new();
        for (key, section) in &sections {
            let start = aligned(data_at, SECTION_ALIGN);
            let mut end = start;
            let mut table = Vec::with_capacity(section.pages.len() * PAGE_ENTRY_BYTES as usize);
            let mut first = 0u64;
            for (p, page) in (0u32..).zip(&section.pages) {
                // What an earlier page stores is not stored again, whatever section or species it is of.
                let place = stored.entry((page.raw_bytes, page.compression, &page.stored[..]));
                let offset = *place.or_insert_with(|| {
                    let offset = aligned(end, PAGE_ALIGN);
                    pages.push((offset, &page.stored[..]));
                    end = offset + page.stored.len() as u64;
                    offset
                });
                let entry = PageEntry {
                    offset,
                    stored_bytes: page.stored.len() as u32,
                    raw_bytes: page.raw_bytes,
                    first,
                    count: page.count,
                    compression: page.compression,
                    priority: page.priority,
                    reserved: 0,
                    digest: digest::page(*key, p, &page.stored),
                };
                table.extend(entry.to_bytes());
                compressed |= page.compression == STORED_ZSTD;
                first += u64::from(page.count);
            }
            let is_shared = end == start;
            if !is_shared {
                data_at = end;
            }
            let entry = SectionEntry {
                key: *key,
                flags: section.flags,
                data_offset: if is_shared { 0 } else { start },
                data_bytes: end - start,
                raw_bytes: section.raw_bytes(),
                table_offset: table_at,
                page_count: section.pages.len() as u32,
                codec: section.codec,
                threshold: section.threshold,
                page_bytes: section.page_bytes,
                lattice: section.lattice,
                bands: section.bands,
                units: first,
                reserved: 0,
                table_digest: digest::plain(&table),
            };
            contents.extend(entry.to_bytes());
            table_at += table.len() as u64;
            page_tables.extend(table);
        }
        let required_features = if compressed { FEATURE_ZSTD } else { 0 }
            | if physical { FEATURE_PHYSICAL } else { 0 }
            | if raw_f16 { FEATURE_RAW_F16 } else { 0 }
            | if blocks { FEATURE_BLOCKS } else { 0 }
            | if leaning { FEATURE_LEANING } else { 0 };
        let header = Header {
            version: version_of(required_features),
            header_bytes: HEADER_BYTES as u32,
            required_features,
            optional_features: 0,
            file_bytes: data_at,
            contents_offset: HEADER_BYTES,
            contents_bytes,
            section_count: sections.len() as u32,
            reserved_60: 0,
            contents_digest: digest::plain(&contents),
            tables_end,
            root: [0; 32],
            reserved_112: 0,
        };
        contents.extend(page_tables);
        let mut layout = Layout { header, tables: contents, pages };
        layout.header.root = layout.root();
        Ok(layout)
    }

    fn root(&self) -> [u8; 32] {
        let mut root = Root::new(&self.header.to_bytes());
        self.body(&mut |bytes| {
            root.update(bytes);
            Ok(())
        })
        .expect("hashing does not fail");
        root.finish()
    }

    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        out.write_all(&self.header.to_bytes())?;
        self.body(&mut |bytes| out.write_all(bytes))
    }

    /// Every byte behind the header, in order.
    fn body(&self, take: &mut dyn FnMut(&[u8]) -> io::Result<()>) -> io::Result<()> {
        const ZEROS: [u8; SECTION_ALIGN as usize] = [0; SECTION_ALIGN as usize];
        take(&self.tables)?;
        let mut at = self.header.tables_end;
        for (offset, bytes) in &self.pages {
            take(&ZEROS[..(offset - at) as usize])?;
            take(bytes)?;
            at = offset + bytes.len() as u64;
        }
        Ok(())
    }
}

fn aligned(offset: u64, align: u64) -> u64 {
    align_up(offset, align).expect("what lies in memory is far shorter than 2^64 bytes")
}

fn check_names(species: &[&EncodedSpecies]) -> Result<(), PackError> {
    if species.is_empty() {
        return Err(PackError::Empty);
    }
    for (i, entry) in species.iter().enumerate() {
        if species[..i].iter().any(|other| other.meta.name == entry.meta.name) {
            return Err(PackError::SameName { name: entry.meta.name.clone() });
        }
    }
    Ok(())
}

//! Header, table of contents, page tables and metadata: read, checked against every promise of
//! SPEC.md sections 3 to 5 and 9, and joined into a [`Container`].
//!
//! The order of checks is part of the specification (section 11): the first broken promise is the one
//! that is reported. No number of the file sizes an allocation before it is bounded.

use std::ops::RangeInclusive;

mod join;
mod tables;

use super::records::*;
use super::{Container, digest};
use crate::error::{FormatError, Place};
use crate::{Source, block, blocks};

pub(super) use join::read_section;
pub(super) use join::stored_bytes;

pub(super) fn open(source: &dyn Source) -> Result<Container, FormatError> {
    let header = read_header(source)?;
    let sections = read_contents(source, &header)?;
    let tables = tables::read_page_tables(source, &header, &sections)?;
    tables::check_work(&sections)?;
    let zstd = tables.iter().flatten().any(|page: &PageEntry| page.compression == STORED_ZSTD);
    check_feature_use(&header, FEATURE_ZSTD, "0 (zstd)", "the page tables", zstd)?;
    let is_f16 = |s: &SectionEntry| s.key.kind == KIND_BASE && s.codec == CODEC_RAW_F16;
    let raw_f16 = sections.iter().any(is_f16);
    check_feature_use(&header, FEATURE_RAW_F16, "2 (raw-f16)", "the codecs of bases", raw_f16)?;
    let blocks = !header.is_draft() && sections.iter().any(|s| s.key.kind == KIND_BLOCKS);
    check_feature_use(&header, FEATURE_BLOCKS, "3 (blocks)", "the kinds of sections", blocks)?;
    let species = join::join_species(source, header.kinds(), &sections, &tables)?;
    let physical = species.iter().any(|species| species.meta.model.has_extinction());
    check_feature_use(&header, FEATURE_PHYSICAL, "1 (physical)", "the metadata", physical)?;
    let leaning = species.iter().any(|species| species.meta.model.suns().is_leaning());
    check_feature_use(&header, FEATURE_LEANING, "4 (leaning)", "the metadata", leaning)?;
    let chosen = vec![None; species.len()];
    Ok(Container { header, sections, tables, species, chosen })
}

/// Reads and verifies the header alone.
///
/// # Errors
/// The promises of SPEC.md section 3.
pub fn read_header(source: &dyn Source) -> Result<Header, FormatError> {
    let start = Place::file(0);
    let actual = source.len_bytes().map_err(|source| FormatError::Read { place: start, bytes: 0, source })?;
    let mut bytes = [0; HEADER_BYTES as usize];
    let there = actual.min(HEADER_BYTES) as usize;
    read(source, start, 0, &mut bytes[..there])?;
    if there < MAGIC.len() {
        return Err(FormatError::TooShort { place: start, found: actual, expected: HEADER_BYTES });
    }
    let found: [u8; 8] = bytes[..8].try_into().expect("eight bytes make an array of eight");
    if found != MAGIC {
        let hint = magic_hint(found);
        return Err(FormatError::Magic { place: Place::header(0), found, expected: MAGIC, hint });
    }
    if (there as u64) < HEADER_BYTES {
        return Err(FormatError::TooShort { place: start, found: actual, expected: HEADER_BYTES });
    }

    let (header, stored) = Header::from_bytes(&bytes);
    if header.version.0 != VERSION.0 && !header.is_draft() {
        return Err(FormatError::Version { place: Place::header(8), found: header.version });
    }
    if u64::from(header.header_bytes) != HEADER_BYTES {
        let (found, expected) = (header.header_bytes, HEADER_BYTES as u32);
        return Err(FormatError::HeaderSize { place: Place::header(12), found, expected });
    }
    let computed = digest::plain(&bytes[..HEADER_DIGESTED_BYTES]);
    if stored != computed {
        return Err(FormatError::HeaderDigest { place: Place::header(120), stored, computed });
    }
    let known = if header.is_draft() { DRAFT_FEATURES } else { FEATURES_KNOWN };
    let unknown = header.required_features & !known;
    if unknown != 0 {
        let bit = unknown.trailing_zeros();
        return Err(FormatError::Feature { place: Place::header(16), bit });
    }
    for (offset, found) in [(60, u64::from(header.reserved_60)), (112, header.reserved_112)] {
        if found != 0 {
            return Err(FormatError::Reserved { place: Place::header(offset), found });
        }
    }
    if header.file_bytes != actual {
        let expected = header.file_bytes;
        return Err(FormatError::FileLength { place: Place::header(32), found: actual, expected });
    }
    check_contents_place(&header)?;
    Ok(header)
}

fn magic_hint(found: [u8; 8]) -> &'static str {
    let mut swapped = MAGIC;
    swapped.reverse();
    let stripped = MAGIC.map(|byte| byte & 0x7F);
    match found {
        _ if found[..5] == MAGIC[..5] => "line ends were converted, as by a transfer in text mode",
        _ if found[..4] == MAGIC[..4] => "line ends were converted, as by a transfer in text mode",
        _ if found == stripped => "the high bit of every byte was stripped",
        _ if found == swapped => "the bytes are swapped",
        _ => "this is not an .flb file",
    }
}

fn check_contents_place(header: &Header) -> Result<(), FormatError> {
    let fault = |offset, what, found, expected| FormatError::ContentsPlace {
        place: Place::header(offset),
        what,
        found,
        expected,
    };
    if header.contents_offset != HEADER_BYTES {
        return Err(fault(40, "offset of the table of contents", header.contents_offset, HEADER_BYTES));
    }
    if header.section_count == 0 {
        return Err(fault(56, "number of sections", 0, 1));
    }
    let limit = |offset, what, found, limit| {
        if found <= limit {
            return Ok(());
        }
        Err(FormatError::Limit { place: Place::header(offset), what, found, limit })
    };
    limit(56, "number of sections", header.section_count.into(), MAX_SECTIONS.into())?;
    let contents_bytes = u64::from(header.section_count) * SECTION_ENTRY_BYTES;
    if header.contents_bytes != contents_bytes {
        return Err(fault(48, "size of the table of contents", header.contents_bytes, contents_bytes));
    }
    let contents_end = HEADER_BYTES + contents_bytes;
    if header.tables_end < contents_end {
        return Err(fault(72, "end of the page tables", header.tables_end, contents_end));
    }
    let pages = (header.tables_end - contents_end) / PAGE_ENTRY_BYTES;
    limit(72, "number of pages", pages, MAX_PAGES)?;
    if header.tables_end > header.file_bytes {
        return Err(fault(72, "end of the page tables", header.tables_end, header.file_bytes));
    }
    Ok(())
}

fn read_contents(source: &dyn Source, header: &Header) -> Result<Vec<SectionEntry>, FormatError> {
    let place = Place::contents(header.contents_offset, None);
    let mut bytes = vec![0; header.contents_bytes as usize];
    read(source, place, header.contents_offset, &mut bytes)?;
    let computed = digest::plain(&bytes);
    if computed != header.contents_digest {
        let stored = header.contents_digest;
        return Err(FormatError::ContentsDigest { place, stored, computed });
    }
    let records = bytes.as_chunks::<{ SECTION_ENTRY_BYTES as usize }>().0;
    let mut sections: Vec<SectionEntry> = Vec::with_capacity(records.len());
    let mut table_end = HEADER_BYTES + header.contents_bytes;
    let mut data_end = header.tables_end;
    for (i, record) in records.iter().enumerate() {
        let section = SectionEntry::from_bytes(record);
        let offset = HEADER_BYTES + i as u64 * SECTION_ENTRY_BYTES;
        let place = Place::contents(offset, Some(section.key));
        if let Some(previous) = sections.last() {
            if previous.key == section.key {
                return Err(FormatError::SectionTwice { place });
            }
            if previous.key > section.key {
                return Err(FormatError::SectionOrder { place, previous: previous.key });
            }
        }
        check_section(&section, &header.kinds(), place)?;
        table_end = check_section_place(&section, place, header, table_end, &mut data_end)?;
        sections.push(section);
    }
    let place = Place::header(72);
    if table_end != header.tables_end {
        let (found, what) = (header.tables_end, "end of the page tables");
        return Err(FormatError::ContentsPlace { place, what, found, expected: table_end });
    }
    if data_end != header.file_bytes {
        let (found, expected) = (header.file_bytes, data_end);
        return Err(FormatError::FileLength { place: Place::header(32), found, expected });
    }
    Ok(sections)
}

/// Checks the fields of an entry that say what the section is.
fn check_section(
    section: &SectionEntry,
    kinds: &RangeInclusive<u32>,
    place: Place,
) -> Result<(), FormatError> {
    let field = |holds: bool, what, found: &dyn std::fmt::Display, expected: &str| {
        if holds {
            return Ok(());
        }
        let (found, expected) = (found.to_string(), expected.to_owned());
        Err(FormatError::SectionField { place, what, found, expected })
    };
    if section.reserved != 0 {
        return Err(FormatError::Reserved { place, found: section.reserved });
    }
    field(section.flags & !(FLAG_REQUIRED | FLAG_COPY) == 0, "flags", &section.flags, "bits 0 and 1 only")?;
    let page_bytes_fit = (MIN_PAGE_BYTES..=MAX_PAGE_BYTES).contains(&section.page_bytes)
        && section.page_bytes.is_multiple_of(PAGE_BYTES_STEP);
    let expected = "a multiple of 4096 from 20480 to 4194304";
    field(page_bytes_fit, "page size", &section.page_bytes, expected)?;
    field(section.page_count > 0, "number of pages", &section.page_count, "at least 1")?;
    field(section.units > 0, "number of units", &section.units, "at least 1")?;

    let SectionKey { kind, item, .. } = section.key;
    field(kind > 0, "kind", &kind, "at least 1")?;
    if !kinds.contains(&kind) {
        if section.flags & FLAG_REQUIRED != 0 {
            return Err(FormatError::SectionKind { place, kind });
        }
        return Ok(());
    }
    let required_only = section.flags == FLAG_REQUIRED;
    field(required_only, "flags", &section.flags, "1, as the kind is known")?;
    let (items, codecs): (u32, &[u32]) = match (kind, item) {
        (KIND_METADATA, _) => (1, &[CODEC_JSON]),
        (KIND_MEDIUM, 1) => (MEDIUM_ITEMS.len() as u32, &[CODEC_SPARSE_U8]),
        (KIND_MEDIUM, _) => (MEDIUM_ITEMS.len() as u32, &[CODEC_SPARSE_F32]),
        (KIND_BASE, _) => (BASE_ITEMS, &[CODEC_RAW_F32, CODEC_HAAR_PAPER, CODEC_RAW_F16]),
        (KIND_BLOCKS, BLOCKS_CLASSES) => (2, &[CODEC_CLASSES]),
        (KIND_BLOCKS, _) => (2, &[CODEC_BLOCK_MAP]),
        (KIND_AVERAGES, _) => (BASE_ITEMS, &[CODEC_AVERAGES]),
        _ => (BASE_ITEMS, &[CODEC_CLASSED, CODEC_HAAR]),
    };
    field(item < items, "item", &item, "an item that the kind has")?;
    if !codecs.contains(&section.codec) {
        return Err(FormatError::Codec { place, found: section.codec });
    }
    let bits = section.threshold.to_bits();
    if section.codec == CODEC_HAAR_PAPER {
        let fits = section.threshold.is_sign_positive() && section.threshold <= MAX_MAGNITUDE;
        field(fits, "threshold", &section.threshold, "a number from +0 to 2^96")?;
    } else {
        field(bits == 0, "threshold", &section.threshold, "0")?;
    }
    if kind == KIND_METADATA {
        field(section.lattice == 0, "lattice", &section.lattice, "0")?;
        field(section.bands == 0, "bands", &section.bands, "0")?;
        if section.units > MAX_METADATA_BYTES {
            let (found, limit) = (section.units, MAX_METADATA_BYTES);
            return Err(FormatError::Limit { place, what: "size of metadata", found, limit });
        }
        return Ok(());
    }
    let lattice_fits = LATTICES.contains(&section.lattice) && section.lattice.is_power_of_two();
    field(lattice_fits, "lattice", &section.lattice, "a power of two from 16 to 256")?;
    let (most_bands, expected) = match kind {
        KIND_BASE | KIND_AVERAGES | KIND_DETAIL => (MAX_BANDS, "1 to 64"),
        _ => (1, "1"),
    };
    field((1..=most_bands).contains(&section.bands), "bands", &section.bands, expected)?;
    let units = units_of(section);
    let expected = if units.start() == units.end() {
        units.end().to_string()
    } else {
        format!("{} to {}", units.start(), units.end())
    };
    field(units.contains(&section.units), "number of units", &section.units, &expected)?;
    let fits = kind != KIND_DETAIL || section.raw_bytes <= MAX_DETAIL_BYTES;
    field(fits, "size of payloads", &section.raw_bytes, &format!("at most {MAX_DETAIL_BYTES}"))
}

/// Units that a section over a lattice may have.
fn units_of(section: &SectionEntry) -> RangeInclusive<u64> {
    let (lattice, bands) = (u64::from(section.lattice), u64::from(section.bands));
    let blocks = (lattice / blocks::EDGE as u64).pow(3);
    match section.codec {
        CODEC_HAAR_PAPER => {
            let all = u64::from(block::blocks_per_axis(section.lattice)).pow(3);
            all..=all
        }
        CODEC_BLOCK_MAP => blocks / 8..=blocks / 8,
        CODEC_CLASSES => blocks::classes::BYTES,
        CODEC_AVERAGES => 1..=blocks::averages::most_bytes(section.lattice, section.bands),
        CODEC_CLASSED | CODEC_HAAR => 1..=blocks,
        _ => lattice.pow(3) * bands..=lattice.pow(3) * bands,
    }
}

/// Checks where an entry's table and data lie; moves `data_end` and returns the table's end.
fn check_section_place(
    section: &SectionEntry,
    place: Place,
    header: &Header,
    table_start: u64,
    data_end: &mut u64,
) -> Result<u64, FormatError> {
    if section.table_offset != table_start {
        let (found, expected) = (section.table_offset, table_start);
        return Err(FormatError::TablePlace { place, found, expected });
    }
    // At most 2^32 * 48 beyond an offset within the file: no overflow.
    let table_end = table_start + u64::from(section.page_count) * PAGE_ENTRY_BYTES;
    if table_end > header.tables_end {
        let (found, expected) = (table_end, header.tables_end);
        return Err(FormatError::TablePlace { place, found, expected });
    }
    // All its pages may be shared with sections before it: then it has no data and no place for them.
    let is_shared = section.data_bytes == 0 && !header.is_draft();
    let aligned = align_up(*data_end, SECTION_ALIGN).unwrap_or(u64::MAX);
    let expected = if is_shared { 0 } else { aligned };
    if section.data_offset != expected {
        let found = section.data_offset;
        return Err(FormatError::SectionPlace { place, found, expected });
    }
    if is_shared {
        return Ok(table_end);
    }
    let end = section.data_offset.checked_add(section.data_bytes);
    match end.filter(|end| *end <= header.file_bytes) {
        Some(end) => *data_end = end,
        None => {
            let (found, expected) = (section.data_bytes, header.file_bytes.saturating_sub(expected));
            let (found, expected) = (found.to_string(), format!("at most {expected}"));
            return Err(FormatError::SectionField { place, what: "size of data", found, expected });
        }
    }
    Ok(table_end)
}

/// A feature bit is set if and only if something uses the feature.
fn check_feature_use(
    header: &Header,
    mask: u64,
    bit: &'static str,
    source_of_truth: &'static str,
    expected: bool,
) -> Result<(), FormatError> {
    let found = header.required_features & mask != 0;
    if found != expected {
        let place = Place::header(16);
        return Err(FormatError::FeatureUse { place, bit, found, source_of_truth, expected });
    }
    Ok(())
}

fn read(source: &dyn Source, place: Place, at: u64, buffer: &mut [u8]) -> Result<(), FormatError> {
    source.read_exact_at(at, buffer).map_err(|source| FormatError::Read {
        place,
        bytes: buffer.len() as u64,
        source,
    })
}

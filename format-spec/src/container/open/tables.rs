//! Page tables: read, and checked against the entries of the table of contents. SPEC.md, section 5.

use super::super::digest;
use super::super::records::*;
use super::read;
use crate::error::{FormatError, Place};
use crate::{Source, room};

/// Most bits of a block's component: a width, a mask, and 63 coefficients of 11 bits.
const DETAIL_BITS: u32 = 4 + 64 + 63 * 11;

/// The page tables of all sections, in their order.
pub(super) fn read_page_tables(
    source: &dyn Source,
    header: &Header,
    sections: &[SectionEntry],
) -> Result<Vec<Vec<PageEntry>>, FormatError> {
    let mut stored = Vec::new();
    let tables = sections.iter().map(|section| read_page_table(source, header, section, &mut stored));
    tables.collect()
}

/// What all sections together may ask of a reader: without a limit, a small file of compressed or shared pages could
/// ask for any amount. The sums of sections are those of their pages.
pub(super) fn check_work(sections: &[SectionEntry]) -> Result<(), FormatError> {
    let place = Place::contents(HEADER_BYTES, None);
    // Sums of at most MAX_PAGES u32: no overflow.
    let metadata = sections.iter().filter(|s| s.key.kind == KIND_METADATA).map(|s| s.raw_bytes).sum();
    let payloads = sections.iter().map(|s| s.raw_bytes).sum();
    for (what, found, limit) in [
        ("size of all metadata", metadata, MAX_ALL_METADATA_BYTES),
        ("size of all payloads", payloads, MAX_ALL_BYTES),
    ] {
        if found > limit {
            return Err(FormatError::Limit { place, what, found, limit });
        }
    }
    Ok(())
}

/// Bytes that some page of the file stores: what a later one may share.
#[derive(PartialEq)]
struct Stored {
    offset: u64,
    stored_bytes: u32,
    raw_bytes: u32,
    compression: u32,
}

impl Stored {
    fn of(page: &PageEntry) -> Stored {
        let PageEntry { offset, stored_bytes, raw_bytes, compression, .. } = *page;
        Stored { offset, stored_bytes, raw_bytes, compression }
    }
}

/// `stored` ascends; the section's own pages are added to it.
fn read_page_table(
    source: &dyn Source,
    header: &Header,
    section: &SectionEntry,
    stored: &mut Vec<Stored>,
) -> Result<Vec<PageEntry>, FormatError> {
    let place = Place::page_table(section.table_offset, section.key, None);
    // Bounded: open checked that all tables end within the file and hold at most MAX_PAGES.
    let table_bytes = section.page_count as usize * PAGE_ENTRY_BYTES as usize;
    let mut bytes = room::filled(place, "the page table", 0, table_bytes)?;
    // Its entries, and where their pages are.
    room::ask(place, "pages", 2 * table_bytes as u64)?;
    read(source, place, section.table_offset, &mut bytes)?;
    let computed = digest::plain(&bytes);
    if computed != section.table_digest {
        let stored = section.table_digest;
        return Err(FormatError::TableDigest { place, stored, computed });
    }
    let records = bytes.as_chunks::<{ PAGE_ENTRY_BYTES as usize }>().0;
    let pages: Vec<PageEntry> = records.iter().map(PageEntry::from_bytes).collect();

    let mut end = section.data_offset;
    let (mut units, mut raw_bytes) = (0u64, 0u64);
    for (i, page) in pages.iter().enumerate() {
        let offset = section.table_offset + i as u64 * PAGE_ENTRY_BYTES;
        let place = Place::page_table(offset, section.key, Some(i as u32));
        let expected = align_up(end, PAGE_ALIGN).unwrap_or(u64::MAX);
        let is_own = page.offset == expected && section.data_offset > 0;
        if !is_own && !is_stored(page, stored, header) {
            return Err(FormatError::PagePlace { place, found: page.offset, expected });
        }
        check_page(page, header, section, place)?;
        if page.first != units {
            let (what, found, expected) = ("first unit", page.first, units.to_string());
            return Err(FormatError::PageUnits { place, what, found, expected });
        }
        // Sums of at most MAX_PAGES u32 on top of an offset within the file: no overflow.
        units += u64::from(page.count);
        raw_bytes += u64::from(page.raw_bytes);
        if is_own {
            end = page.offset + u64::from(page.stored_bytes);
            stored.push(Stored::of(page));
        }
    }
    let sums = [
        ("number of units", section.units, units),
        ("size of payloads", section.raw_bytes, raw_bytes),
        ("size of data", section.data_bytes, end - section.data_offset),
    ];
    for (what, found, expected) in sums {
        if found != expected {
            return Err(FormatError::SectionSum { place, what, found, expected });
        }
    }
    Ok(pages)
}

/// Whether a page is, byte for byte, one that is stored already.
fn is_stored(page: &PageEntry, stored: &[Stored], header: &Header) -> bool {
    let found = stored.binary_search_by_key(&page.offset, |stored| stored.offset);
    !header.is_draft() && found.is_ok_and(|i| stored[i] == Stored::of(page))
}

/// Checks the fields of a page entry that stand for themselves.
fn check_page(
    page: &PageEntry,
    header: &Header,
    section: &SectionEntry,
    place: Place,
) -> Result<(), FormatError> {
    let size = |holds: bool, what, found: u32, expected: String| {
        if holds {
            return Ok(());
        }
        Err(FormatError::PageSize { place, what, found: found.into(), expected })
    };
    let draft = if header.is_draft() { u64::from(page.priority.to_bits()) } else { 0 };
    let reserved = u64::from(page.reserved) << 32 | draft;
    if reserved != 0 {
        return Err(FormatError::Reserved { place, found: reserved });
    }
    // Written so that NaN fails.
    if !(page.priority.is_sign_positive() && page.priority <= MAX_MAGNITUDE) {
        let (found, expected) = (page.priority, "a number from +0 to 2^96");
        return Err(FormatError::PagePriority { place, found, expected });
    }
    let raw_fits = (1..=section.page_bytes).contains(&page.raw_bytes);
    size(raw_fits, "payload size", page.raw_bytes, format!("1 to {}", section.page_bytes))?;
    let stored = page.stored_bytes;
    match page.compression {
        STORED_PLAIN => size(stored == page.raw_bytes, "stored size", stored, page.raw_bytes.to_string())?,
        STORED_ZSTD => {
            let fits = (1..page.raw_bytes).contains(&stored);
            size(fits, "stored size", stored, format!("1 to {}", page.raw_bytes - 1))?;
        }
        found => return Err(FormatError::Compression { place, found }),
    }
    let count = u64::from(page.count);
    let units = |holds: bool, expected: &str| {
        if holds {
            return Ok(());
        }
        let (found, expected) = (count, expected.to_owned());
        Err(FormatError::PageUnits { place, what: "number of units", found, expected })
    };
    units(count > 0, "at least 1")?;
    if !header.kinds().contains(&section.key.kind) {
        return Ok(());
    }
    let (raw, bands) = (u64::from(page.raw_bytes), u64::from(section.bands));
    match section.codec {
        CODEC_JSON | CODEC_BLOCK_MAP | CODEC_CLASSES | CODEC_AVERAGES => {
            units(count == raw, "a unit per byte of payload")
        }
        // How many bits a block has is for its fields to say: at most 11 for each coefficient, a mask and a width.
        CODEC_CLASSED | CODEC_HAAR => {
            let most = (u64::from(DETAIL_BITS) * bands * count).div_ceil(32) * 4;
            units(
                raw.is_multiple_of(4) && raw <= most,
                "a payload of whole words, at most 761 bits a unit and band",
            )
        }
        CODEC_RAW_F32 => units(count * 4 == raw, "a unit per 4 bytes of payload"),
        CODEC_RAW_F16 => units(count * 2 == raw, "a unit per 2 bytes of payload"),
        CODEC_HAAR_PAPER => {
            units(count * 12 <= raw, "at most a unit per 12 bytes of payload")?;
            units(raw <= count * (12 + 256 * bands), "a unit per 12 bytes and 256 a band, at least")
        }
        codec => {
            units(count.is_multiple_of(64), "a multiple of 64")?;
            units(count / 8 <= raw, "at most 8 units per byte of payload")?;
            let width = if codec == CODEC_SPARSE_U8 { 1 } else { 4 };
            units(raw <= count / 8 + width * count, "a unit for each value of the payload")
        }
    }
}

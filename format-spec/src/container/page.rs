//! One page: stored bytes read, digest checked, a zstd frame vetted and decompressed. SPEC.md section 7.

use zstd::zstd_safe;

use super::digest;
use super::records::{MAX_WINDOW_BYTES, PageEntry, STORED_ZSTD, SectionKey};
use crate::error::{FormatError, Place};
use crate::{Source, room};

/// Reads a page whose entry was verified and returns its payload.
pub(super) fn read(
    source: &dyn Source,
    key: SectionKey,
    page: u32,
    entry: &PageEntry,
) -> Result<Vec<u8>, FormatError> {
    let stored = read_stored(source, key, page, entry)?;
    if entry.compression != STORED_ZSTD {
        return Ok(stored);
    }
    decompress(&stored, entry.raw_bytes, Place::page(entry.offset, key, page))
}

/// Reads a page's stored bytes and checks their digest.
pub(super) fn read_stored(
    source: &dyn Source,
    key: SectionKey,
    page: u32,
    entry: &PageEntry,
) -> Result<Vec<u8>, FormatError> {
    let place = Place::page(entry.offset, key, page);
    let mut stored = room::filled(place, "the page as stored", 0, entry.stored_bytes as usize)?;
    source.read_exact_at(entry.offset, &mut stored).map_err(|source| FormatError::Read {
        place,
        bytes: u64::from(entry.stored_bytes),
        source,
    })?;
    let computed = digest::page(key, page, &stored);
    if computed != entry.digest {
        return Err(FormatError::PageDigest { place, stored: entry.digest, computed });
    }
    Ok(stored)
}

/// How zstd ends its name of that error (zstd, lib/common/error_private.c).
const NOT_ENOUGH_MEMORY: &str = "not enough memory";

/// Decompresses one zstd frame that must declare, and give, exactly `raw_bytes`.
fn decompress(stored: &[u8], raw_bytes: u32, place: Place) -> Result<Vec<u8>, FormatError> {
    let refuse = |reason: String| FormatError::Frame { place, reason };
    check_frame_header(stored, raw_bytes).map_err(refuse)?;
    let frame_bytes = zstd_safe::find_frame_compressed_size(stored)
        .map_err(|code| refuse(zstd_safe::get_error_name(code).to_owned()))?;
    if frame_bytes != stored.len() {
        return Err(refuse(format!("it ends after {frame_bytes} of {} stored bytes", stored.len())));
    }
    let mut payload = room::empty(place, "the page", raw_bytes as usize)?;
    let decompressed = zstd::bulk::Decompressor::new()
        .and_then(|mut decompressor| decompressor.decompress_to_buffer(stored, &mut payload));
    decompressed.map_err(|error| match error.to_string() {
        text if text.ends_with(NOT_ENOUGH_MEMORY) => {
            FormatError::Memory { place, what: "decompressing the page", bytes: raw_bytes.into() }
        }
        text => refuse(format!("it does not decompress: {text}")),
    })?;
    if payload.len() != raw_bytes as usize {
        return Err(refuse(format!("it gives {} bytes, expected {raw_bytes}", payload.len())));
    }
    Ok(payload)
}

/// Vets a frame header (RFC 8878, section 3.1.1.1) before the library sees it.
fn check_frame_header(stored: &[u8], raw_bytes: u32) -> Result<(), String> {
    let cut = || "it is cut in its header".to_owned();
    let magic = stored.get(..4).ok_or_else(cut)?;
    if magic != [0x28, 0xB5, 0x2F, 0xFD] {
        return Err(format!("it begins with {magic:02x?}, expected a zstd frame"));
    }
    let descriptor = *stored.get(4).ok_or_else(cut)?;
    if descriptor & 0b0000_1000 != 0 {
        return Err("its reserved bit is set".to_owned());
    }
    if descriptor & 0b0000_0011 != 0 {
        return Err("it wants a dictionary".to_owned());
    }
    let single_segment = descriptor & 0b0010_0000 != 0;
    let mut at = 5;
    if !single_segment {
        let window = *stored.get(at).ok_or_else(cut)?;
        let base = 1u64 << (10 + (window >> 3));
        let window_bytes = base + (base / 8) * u64::from(window & 7);
        if window_bytes > MAX_WINDOW_BYTES {
            return Err(format!("it wants a window of {window_bytes} bytes, over {MAX_WINDOW_BYTES}"));
        }
        at += 1;
    }
    let (size_bytes, offset) = match (descriptor >> 6, single_segment) {
        (0, false) => return Err("it declares no content size".to_owned()),
        (0, true) => (1, 0),
        (1, _) => (2, 256),
        (2, _) => (4, 0),
        _ => (8, 0),
    };
    let field = stored.get(at..at + size_bytes).ok_or_else(cut)?;
    let mut size = [0; 8];
    size[..size_bytes].copy_from_slice(field);
    let declared = u64::from_le_bytes(size).saturating_add(offset);
    if declared != u64::from(raw_bytes) {
        return Err(format!("it declares {declared} bytes, the page table {raw_bytes}"));
    }
    Ok(())
}

//! Kinds 32 to 39: zstd frames made by hand (RFC 8878), and payloads that unfold.
//!
//! A block of type RLE is a byte and how often it stands: four bytes for up to 128 KiB. So a bomb needs no compressor.

use super::{Cases, PASSES};
use crate::container::records::MAX_PAGE_BYTES;
use crate::testing::Page;

/// Zstandard's magic number, and one of the sixteen of skippable frames.
const MAGIC: [u8; 4] = [0x28, 0xB5, 0x2F, 0xFD];
const SKIPPABLE: [u8; 4] = [0x50, 0x2A, 0x4D, 0x18];
/// Frame header descriptor: one segment, so no window; content size of 4 bytes.
const SINGLE_SEGMENT: u8 = 0b1010_0000;
/// No segment flag: a window byte follows; content size of 4 bytes.
const WINDOW: u8 = 0b1000_0000;
/// Largest block.
const BLOCK_BYTES: u64 = 128 * 1024;

/// A frame that declares so many bytes and holds these blocks.
pub(super) fn frame(declared: u32, blocks: &[u8]) -> Vec<u8> {
    sized(&[SINGLE_SEGMENT], declared, blocks)
}

fn sized(descriptor: &[u8], declared: u32, blocks: &[u8]) -> Vec<u8> {
    [&MAGIC[..], descriptor, &declared.to_le_bytes(), blocks].concat()
}

/// Blocks that hold `head`, then bytes of 0 up to `total`. `head` fits one block.
pub(super) fn blocks(head: &[u8], total: u64) -> Vec<u8> {
    let mut out = Vec::new();
    let mut left = total - head.len() as u64;
    if !head.is_empty() {
        out.extend(block_header(head.len() as u64, 0, left == 0));
        out.extend(head);
    }
    while left > 0 {
        let size = left.min(BLOCK_BYTES);
        left -= size;
        out.extend(block_header(size, 1, left == 0));
        out.push(0);
    }
    out
}

/// Size, type (0 raw, 1 RLE), and whether it is the last.
fn block_header(size: u64, kind: u32, last: bool) -> [u8; 3] {
    let word = (size as u32) << 3 | kind << 1 | u32::from(last);
    [word as u8, (word >> 8) as u8, (word >> 16) as u8]
}

/// A page of `count` units whose payload is so many bytes of 0.
pub(super) fn zeros(raw_bytes: u32, count: u32) -> Page {
    Page::zstd(frame(raw_bytes, &blocks(&[], raw_bytes.into())), raw_bytes, count)
}

pub(super) fn cases(cases: &mut Cases) {
    let area = cases.subject.area();
    let units = cases.subject.parts.sections[area].units as u32;
    // Masks alone: leaf area nowhere.
    let raw_bytes = units / 8;
    let mut framed = |kind, label: &str, done: &str, code: u32, stored: Vec<u8>| {
        cases.rebuild(kind, label, done, code, |parts| {
            parts.set_pages(area, &[Page::zstd(stored, raw_bytes, units)]);
        });
    };
    let sound = blocks(&[], raw_bytes.into());
    let with = |descriptor: &[u8]| sized(descriptor, raw_bytes, &sound);
    let whole = frame(raw_bytes, &sound);
    framed(32, "sound-frame", "a frame that is as it should be, which passes", PASSES, whole.clone());
    let huge = [&MAGIC[..], &[0b1110_0000], &(1u64 << 63).to_le_bytes(), &sound].concat();
    framed(32, "claims-2-63", "a frame that declares 2^63 bytes", 4002, huge);
    let done = "a frame with a window of 1 MiB, which passes";
    framed(33, "with-a-window", done, PASSES, with(&[WINDOW, 0x50]));
    let unsized_frame = [&MAGIC[..], &[0, 0x50], &sound].concat();
    framed(33, "no-size", "a frame that declares no size", 4002, unsized_frame);
    let twice = [&whole[..], &whole].concat();
    framed(34, "two-frames", "two frames, one behind the other", 4002, twice);
    let skipped = [&SKIPPABLE[..], &4u32.to_le_bytes(), b"skip"].concat();
    let in_front = [&skipped[..], &whole].concat();
    framed(34, "skippable-in-front", "a skippable frame in front", 4002, in_front);
    let behind = [&whole[..], &skipped].concat();
    framed(34, "skippable-behind", "a skippable frame behind", 4002, behind);
    framed(34, "only-skippable", "a skippable frame alone", 4002, skipped);
    let done = "a frame that wants a window of 3.75 TiB";
    framed(35, "window-of-2-41", done, 4002, with(&[WINDOW, 0xFF]));
    let (short, long) = (blocks(&[], u64::from(raw_bytes) - 1), blocks(&[], u64::from(raw_bytes) + 1));
    let done = "a frame that holds a byte less than it declares";
    framed(36, "decodes-short", done, 4002, frame(raw_bytes, &short));
    let done = "a frame that holds a byte more than it declares";
    framed(36, "decodes-long", done, 4002, frame(raw_bytes, &long));
    let done = "a frame that declares a byte more than its page";
    framed(36, "declares-more", done, 4002, frame(raw_bytes + 1, &long));
    framed(36, "cut", "a frame without its last byte", 4002, whole[..whole.len() - 1].to_vec());
    let reserved = with(&[SINGLE_SEGMENT | 0b1000]);
    framed(36, "reserved-bit", "a frame whose reserved bit is set", 4002, reserved);
    let dictionary = with(&[SINGLE_SEGMENT | 1, 7]);
    framed(37, "dictionary-7", "a frame that wants dictionary 7", 4002, dictionary);
    bombs(cases);
}

/// What unfolds is bounded by what the tables say, and that by the format: such files are sound, and cost time alone.
fn bombs(cases: &mut Cases) {
    let mut unknown = |kind, label: &str, done: &str, code: u32, pages: &[Page]| {
        cases.rebuild(kind, label, done, code, |parts| parts.add_unknown(0, pages));
    };
    let largest = zeros(MAX_PAGE_BYTES, 1);
    let done = "an optional page of 4 MiB in 150 bytes, which passes";
    unknown(38, "largest-page", done, PASSES, std::slice::from_ref(&largest));
    let bomb = Page::zstd(frame(MAX_PAGE_BYTES, &blocks(&[], 1 << 30)), MAX_PAGE_BYTES, 1);
    let done = "an optional page that declares 4 MiB and holds 1 GiB";
    unknown(38, "a-gibibyte", done, 4002, &[bomb]);
    let over = zeros(MAX_PAGE_BYTES + 1, 1);
    unknown(38, "over-the-limit", "an optional page of 4 MiB and a byte", 3004, &[over]);
    let done = "320 optional pages of 4 MiB in 60 kB, 1.25 GiB in all, which pass one after another";
    unknown(39, "many-pages", done, PASSES, &vec![largest; 320]);
}

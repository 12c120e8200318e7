//! Kinds 32 to 39: zstd frames made by hand (RFC 8878), and payloads that unfold.
//!
//! A block of type RLE is a byte and how often it stands: four bytes for up to 128 KiB. So a bomb needs no compressor.

use flb_format::records::{MAX_PAGE_BYTES, STORED_ZSTD};

use super::draft::{PageDraft, page, section};
use super::{Cases, PASSES};

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
    with_header(&[&[SINGLE_SEGMENT][..], &declared.to_le_bytes()].concat(), blocks)
}

fn with_header(header: &[u8], blocks: &[u8]) -> Vec<u8> {
    [&MAGIC[..], header, blocks].concat()
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
pub(super) fn zeros(raw_bytes: u32, count: u32) -> PageDraft {
    PageDraft::zstd(frame(raw_bytes, &blocks(&[], raw_bytes.into())), raw_bytes, count)
}

pub(super) fn cases(cases: &mut Cases) {
    let area = cases.subject.area();
    let units = cases.subject.container.sections()[area].units as u32;
    // Masks alone: leaf area nowhere.
    let raw_bytes = units / 8;
    let sound = blocks(&[], raw_bytes.into());
    let mut framed = |kind, label: &str, done: &str, expected: Option<u32>, stored: Vec<u8>| {
        cases.rebuild(kind, label, done, expected, |draft| {
            draft.sections[area].pages = vec![PageDraft::zstd(stored, raw_bytes, units)];
            draft.sections[area].set_u32(section::PAGE_BYTES, MAX_PAGE_BYTES);
        });
    };
    let size = raw_bytes.to_le_bytes();
    framed(
        32,
        "sound-frame",
        "a frame that is as it should be, which passes",
        PASSES,
        frame(raw_bytes, &sound),
    );
    let huge = [&[0b1110_0000][..], &(1u64 << 63).to_le_bytes()].concat();
    framed(32, "claims-2-63", "a frame that declares 2^63 bytes", Some(4002), with_header(&huge, &sound));
    let small_window = [&[WINDOW, 0x50][..], &size].concat();
    framed(
        33,
        "with-a-window",
        "a frame with a window of 1 MiB, which passes",
        PASSES,
        with_header(&small_window, &sound),
    );
    framed(33, "no-size", "a frame that declares no size", Some(4002), with_header(&[0, 0x50], &sound));
    let whole = frame(raw_bytes, &sound);
    framed(34, "two-frames", "two frames, one behind the other", Some(4002), [&whole[..], &whole].concat());
    let skipped = [&SKIPPABLE[..], &4u32.to_le_bytes(), b"skip"].concat();
    framed(
        34,
        "skippable-in-front",
        "a skippable frame in front",
        Some(4002),
        [&skipped[..], &whole].concat(),
    );
    framed(34, "skippable-behind", "a skippable frame behind", Some(4002), [&whole[..], &skipped].concat());
    framed(34, "only-skippable", "a skippable frame alone", Some(4002), skipped);
    let wide = [&[WINDOW, 0xFF][..], &size].concat();
    framed(
        35,
        "window-of-2-41",
        "a frame that wants a window of 3.75 TiB",
        Some(4002),
        with_header(&wide, &sound),
    );
    let short = blocks(&[], u64::from(raw_bytes) - 1);
    framed(
        36,
        "decodes-short",
        "a frame that holds a byte less than it declares",
        Some(4002),
        frame(raw_bytes, &short),
    );
    let long = blocks(&[], u64::from(raw_bytes) + 1);
    framed(
        36,
        "decodes-long",
        "a frame that holds a byte more than it declares",
        Some(4002),
        frame(raw_bytes, &long),
    );
    framed(
        36,
        "declares-more",
        "a frame that declares a byte more than its page",
        Some(4002),
        frame(raw_bytes + 1, &long),
    );
    framed(36, "cut", "a frame without its last byte", Some(4002), whole[..whole.len() - 1].to_vec());
    framed(36, "reserved-bit", "a frame whose reserved bit is set", Some(4002), {
        with_header(&[&[SINGLE_SEGMENT | 0b1000][..], &size].concat(), &sound)
    });
    let dictionary = [&[SINGLE_SEGMENT | 1, 7][..], &size].concat();
    framed(
        37,
        "dictionary-7",
        "a frame that wants dictionary 7",
        Some(4002),
        with_header(&dictionary, &sound),
    );
    bombs(cases);
}

/// What unfolds is bounded by what the tables say, and that by the format: such files are sound, and cost time alone.
fn bombs(cases: &mut Cases) {
    let mut unknown = |kind, label: &str, done: &str, expected: Option<u32>, pages: Vec<PageDraft>| {
        cases.rebuild(kind, label, done, expected, |draft| draft.add_unknown(0, pages));
    };
    let largest = zeros(MAX_PAGE_BYTES, 1);
    unknown(
        38,
        "largest-page",
        "an optional page of 4 MiB in 150 bytes, which passes",
        PASSES,
        vec![largest.clone()],
    );
    let bomb = frame(MAX_PAGE_BYTES, &blocks(&[], 1 << 30));
    let done = "an optional page that declares 4 MiB and holds 1 GiB";
    unknown(38, "a-gibibyte", done, Some(4002), vec![PageDraft::zstd(bomb, MAX_PAGE_BYTES, 1)]);
    let mut over = zeros(MAX_PAGE_BYTES + 1, 1);
    over.record[page::COMPRESSION] = STORED_ZSTD as u8;
    unknown(38, "over-the-limit", "an optional page of 4 MiB and a byte", Some(3004), vec![over]);
    let done = "320 optional pages of 4 MiB in 60 kB, 1.25 GiB in all, which pass one after another";
    unknown(39, "many-pages", done, PASSES, vec![largest; 320]);
}

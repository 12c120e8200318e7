//! Kinds 38, 39 and 45: sound species of the largest lattice and 64 bands in a few kilobytes, as nearly all of their
//! bytes are 0; and more metadata than a file may have. A check that puts fields together would need 4 GiB for each
//! base.

use flb_format::canonical;
use flb_format::records::*;
use serde_json::{Value, json};

use super::draft::{Draft, PageDraft, SectionDraft, header, section};
use super::frames::{blocks, frame, zeros};
use super::{Cases, PASSES};

const LATTICE: u32 = 256;
const BANDS: u32 = 64;
const SITES: u32 = LATTICE * LATTICE * LATTICE;

pub(super) fn cases(cases: &mut Cases) {
    let header = cases.subject.draft.header;
    let done = "a species of 256^3 sites and 64 bands, 4 GiB a base, in haar-paper blocks of mask 0";
    cases.give(38, "giant-haar-paper", done, PASSES, giant(header, haar_paper(), 0));
    let done = "a species of 256^3 sites and 64 bands, 4 GiB a base, in haar blocks of width 0";
    cases.give(38, "giant-haar", done, PASSES, giant(header, haar(), FEATURE_BLOCKS));
    let done = "metadata of 1 MiB each for 32 species, in 5 kB";
    cases.rebuild(39, "metadata", done, 1009, |draft| many_metadata(draft, 32));
}

fn giant(header: [u8; HEADER_BYTES as usize], bases: Vec<SectionDraft>, features: u64) -> Vec<u8> {
    let text = canonical::to_bytes(&metadata()).expect("names and small numbers");
    let mut sections = vec![entry(KIND_METADATA, 0, CODEC_JSON, 0, 0)];
    sections[0].pages = vec![PageDraft::plain(&text, text.len() as u32)];
    for (item, codec) in
        [CODEC_SPARSE_F32, CODEC_SPARSE_U8, CODEC_SPARSE_F32, CODEC_SPARSE_F32].iter().enumerate()
    {
        let mut medium = entry(KIND_MEDIUM, item as u32, *codec, LATTICE, 1);
        medium.pages = vec![zeros(SITES / 8, SITES)];
        sections.push(medium);
    }
    sections.extend(bases);
    let mut draft = Draft { header, sections };
    // The draft has no blocks near geometry.
    draft.header[self::header::MAJOR..][..2].copy_from_slice(&VERSION.0.to_le_bytes());
    draft.header[self::header::MINOR..][..2].copy_from_slice(&VERSION.1.to_le_bytes());
    draft.header[self::header::REQUIRED..][..8].copy_from_slice(&features.to_le_bytes());
    draft.build().bytes
}

fn entry(kind: u32, item: u32, codec: u32, lattice: u32, bands: u32) -> SectionDraft {
    let mut section = SectionDraft { record: [0; SECTION_ENTRY_BYTES as usize], pages: Vec::new() };
    for (at, value) in [
        (section::KIND, kind),
        (section::ITEM, item),
        (section::FLAGS, FLAG_REQUIRED),
        (section::CODEC, codec),
        (section::PAGE_BYTES, MAX_PAGE_BYTES),
        (section::LATTICE, lattice),
        (section::BANDS, bands),
    ] {
        section.set_u32(at, value);
    }
    section
}

fn metadata() -> Value {
    let optics = |band: u32| json!({"leaf": {"g": 0, "sigma_a": 0}, "name": band.to_string(), "wood": {"g": 0, "sigma_a": 0}});
    json!({
        "bounds_m": {"max": [1, 1, 1], "min": [0, 0, 0]},
        "grid": {"lattice": LATTICE, "origin_m": [0, 0, 0], "spacing_m": 1},
        "model": "paper",
        "name": "giant",
        "optics": (0..BANDS).map(optics).collect::<Vec<_>>(),
        "settings": {},
        "sources": [],
        "tool": "flb torture",
        "triangles": {"leaf": 0, "total": 0, "wood": 0},
    })
}

/// Two bases of which no block keeps a coefficient: masks and indices are 0.
fn haar_paper() -> Vec<SectionDraft> {
    let mut left = flb_format::block::blocks_per_axis(LATTICE).pow(3);
    let mut pages = Vec::new();
    while left > 0 {
        let count = left.min(MAX_PAGE_BYTES / 12);
        pages.push(zeros(12 * count, count));
        left -= count;
    }
    let base = |item| SectionDraft {
        pages: pages.clone(),
        ..entry(KIND_BASE, item, CODEC_HAAR_PAPER, LATTICE, BANDS)
    };
    vec![base(0), base(1)]
}

/// A base of 64 components whose averages and widths are all 0. (A Rice parameter of 0 and codes of one bit of 0.)
fn haar() -> Vec<SectionDraft> {
    let count = (LATTICE / 4).pow(3);
    let mut map = entry(KIND_BLOCKS, BLOCKS_MAP, CODEC_BLOCK_MAP, LATTICE, 1);
    map.pages = vec![PageDraft::plain(&vec![0xFF; count as usize / 8], count / 8)];
    let mut head = vec![BANDS as u8, 0, 1, 2];
    head.extend(1f32.to_le_bytes());
    let group_bits = 5 + 32;
    let averages_bytes = (BANDS * (count / 32) * group_bits).div_ceil(32) * 4;
    let payload_bytes = 32 + 4 * BANDS * BANDS + averages_bytes;
    let averages = PageDraft::zstd(
        frame(payload_bytes, &blocks(&head, payload_bytes.into())),
        payload_bytes,
        payload_bytes,
    );
    let widths = |count: u32| zeros(BANDS * count / 2, count);
    let of = |kind, codec, pages| SectionDraft { pages, ..entry(kind, 0, codec, LATTICE, BANDS) };
    vec![
        map,
        of(KIND_AVERAGES, CODEC_AVERAGES, vec![averages]),
        of(KIND_DETAIL, CODEC_HAAR, vec![widths(count / 2); 2]),
    ]
}

/// Metadata of further species, whatever they hold: their sizes alone are over the limit.
fn many_metadata(draft: &mut Draft, more: u32) {
    let species = draft.sections.iter().filter(|s| s.u32(section::KIND) == KIND_METADATA).count();
    for i in (0..more).rev() {
        let mut section = entry(KIND_METADATA, 0, CODEC_JSON, 0, 0);
        section.set_u32(section::SPECIES, species as u32 + i);
        let bytes = MAX_METADATA_BYTES as u32;
        section.pages = vec![zeros(bytes, bytes)];
        draft.sections.insert(species, section);
    }
}

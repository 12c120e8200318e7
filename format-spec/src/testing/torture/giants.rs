//! Kinds 38, 39 and 45: sound species of the largest lattice and 64 bands in a few kilobytes, as nearly all of their
//! bytes are 0; and more metadata than a file may have. A check that puts fields together would need 4 GiB for each
//! base.

use serde_json::{Value, json};

use super::frames::{blocks, frame, zeros};
use super::{Cases, PASSES};
use crate::container::records::*;
use crate::testing::{Digests, Page, Parts};
use crate::{block, canonical};

const LATTICE: u32 = 256;
const BANDS: u32 = 64;
const SITES: u32 = LATTICE * LATTICE * LATTICE;

pub(super) fn cases(cases: &mut Cases) {
    let header = cases.subject.parts.header;
    let done = "a species of 256^3 sites and 64 bands, 4 GiB a base, in haar-paper blocks of mask 0";
    cases.give(38, "giant-haar-paper", done, PASSES, giant(header, 0, haar_paper));
    let done = "a species of 256^3 sites and 64 bands, 4 GiB a base, in haar blocks of width 0";
    cases.give(38, "giant-haar", done, PASSES, giant(header, FEATURE_BLOCKS, haar));
    let done = "metadata of 1 MiB each for 32 species, in 5 kB";
    cases.rebuild(39, "metadata", done, 1009, |parts| many_metadata(parts, 32));
}

fn giant(header: Header, required_features: u64, add_bases: fn(&mut Parts)) -> Vec<u8> {
    // The draft has no blocks near geometry.
    let header = Header { version: VERSION, required_features, ..header };
    let mut parts = Parts { header, sections: Vec::new(), tables: Vec::new(), bytes: Vec::new() };
    let text = canonical::to_bytes(&metadata()).expect("names and small numbers");
    add(&mut parts, KIND_METADATA, 0, CODEC_JSON, [0, 0], &[Page::plain(&text, text.len() as u32)]);
    let codecs = [CODEC_SPARSE_F32, CODEC_SPARSE_U8, CODEC_SPARSE_F32, CODEC_SPARSE_F32];
    for (item, codec) in codecs.into_iter().enumerate() {
        add(&mut parts, KIND_MEDIUM, item as u32, codec, [LATTICE, 1], &[zeros(SITES / 8, SITES)]);
    }
    add_bases(&mut parts);
    parts.lay_out();
    parts.seal(Digests::Pages)
}

fn add(parts: &mut Parts, kind: u32, item: u32, codec: u32, [lattice, bands]: [u32; 2], pages: &[Page]) {
    let key = SectionKey { kind, species: 0, item };
    let entry = parts.insert(parts.sections.len(), key, FLAG_REQUIRED, pages);
    (entry.codec, entry.lattice, entry.bands) = (codec, lattice, bands);
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
fn haar_paper(parts: &mut Parts) {
    let mut left = block::blocks_per_axis(LATTICE).pow(3);
    let mut pages = Vec::new();
    while left > 0 {
        let count = left.min(MAX_PAGE_BYTES / 12);
        pages.push(zeros(12 * count, count));
        left -= count;
    }
    for item in [0, 1] {
        add(parts, KIND_BASE, item, CODEC_HAAR_PAPER, [LATTICE, BANDS], &pages);
    }
}

/// A base of 64 components whose averages and widths are all 0. (A Rice parameter of 0 and codes of one bit of 0.)
fn haar(parts: &mut Parts) {
    let count = (LATTICE / 4).pow(3);
    let map = Page::plain(&vec![0xFF; count as usize / 8], count / 8);
    add(parts, KIND_BLOCKS, BLOCKS_MAP, CODEC_BLOCK_MAP, [LATTICE, 1], &[map]);
    let mut head = vec![BANDS as u8, 0, 1, 2];
    head.extend(1f32.to_le_bytes());
    let group_bits = 5 + 32;
    let averages_bytes = (BANDS * (count / 32) * group_bits).div_ceil(32) * 4;
    let length = 32 + 4 * BANDS * BANDS + averages_bytes;
    let averages = Page::zstd(frame(length, &blocks(&head, length.into())), length, length);
    add(parts, KIND_AVERAGES, 0, CODEC_AVERAGES, [LATTICE, BANDS], &[averages]);
    let widths = zeros(BANDS * count / 4, count / 2);
    add(parts, KIND_DETAIL, 0, CODEC_HAAR, [LATTICE, BANDS], &[widths.clone(), widths]);
}

/// Metadata of further species, whatever they hold: their sizes alone are over the limit.
fn many_metadata(parts: &mut Parts, more: u32) {
    let species = parts.sections.iter().filter(|section| section.key.kind == KIND_METADATA).count();
    let bytes = MAX_METADATA_BYTES as u32;
    for i in (0..more).rev() {
        let key = SectionKey { kind: KIND_METADATA, species: species as u32 + i, item: 0 };
        parts.insert(species, key, FLAG_REQUIRED, &[zeros(bytes, bytes)]).codec = CODEC_JSON;
    }
}

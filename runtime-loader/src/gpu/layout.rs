//! Rust values to the words of the WGSL structs of light.wgsl, field by field. A test holds names and offsets against
//! what naga reads from the WGSL.

use flb_format::Grid;
#[cfg(test)]
use flb_format::blocks::transform::AVERAGE_TEXEL;
use flb_format::blocks::{BlockMap, CodedBase, Coding, Shared, coarse};

use half::f16;

use crate::extinction::Extinction;

/// Largest number of species; `FLB_SPECIES` of light.wgsl.
pub const MAX_SPECIES: u32 = 256;
/// Largest number of terms of a sample; `FLB_TERMS` of light.wgsl.
pub const MAX_TERMS: u32 = crate::resident::MAX_TERMS as u32;
/// Bands of a colour, and most components.
pub(super) const COLORS: usize = 3;
/// Bytes of a `FlbSpecies`.
pub(super) const SPECIES_BYTES: u64 = 48;
/// `FLB_NONE` of light.wgsl.
pub(super) const NONE: u32 = u32::MAX;
/// `FLB_RELATIVE` of near.wgsl.
pub(super) const RELATIVE: u32 = 257;
/// Bytes of a `FlbBase`.
pub(super) const BASE_BYTES: u64 = 64;
/// Bytes of a `FlbTerm`.
pub(super) const TERM_BYTES: u64 = 8;
/// `FLB_COARSE` of light.wgsl.
#[cfg(test)]
pub(super) const COARSE: i32 = AVERAGE_TEXEL / 16;

/// Share of a base in an instance's light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Term {
    /// Index of the base, as [`GpuLight::base`](super::GpuLight::base) returns it.
    pub base: u32,
    /// Weight times the strength of the light.
    pub factor: f32,
}

/// Where a species' words begin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct SpeciesPlaces {
    /// First word of the block map.
    pub map: u32,
    /// First word of the extinction, or [`NONE`].
    pub extinction: u32,
    /// Whether the species' fields need light scattered once.
    pub single: bool,
    /// First word of the beams of skies, or [`NONE`], and their means.
    pub sky: [u32; 2],
}

/// `FlbSpecies`.
pub(super) fn species_fields(
    grid: &Grid,
    shared: &Shared,
    places: SpeciesPlaces,
) -> [(&'static str, [u32; 3]); 10] {
    let middle_m = grid.middle_m([grid.lattice / 2; 3]);
    let one = |word: u32| [word, 0, 0];
    [
        ("middle_m", middle_m.map(|c| (c as f32).to_bits())),
        ("sites_per_m", one(((1.0 / grid.spacing_m) as f32).to_bits())),
        ("lattice", one(grid.lattice)),
        ("map", one(places.map)),
        ("coarse_edge", one(coarse::edge(&shared.map))),
        ("haar", one(u32::from(shared.coding == Coding::Haar))),
        ("extinction", one(places.extinction)),
        ("single", one(u32::from(places.single))),
        ("sky", one(places.sky[0])),
        ("sky_means", one(places.sky[1])),
    ]
}

/// The words of a `FlbSpecies`.
pub(super) fn species_words(grid: &Grid, shared: &Shared, places: SpeciesPlaces) -> [u32; 12] {
    let [(_, [x, y, z]), rest @ ..] = species_fields(grid, shared, places);
    let [per_m, lattice, map, edge, haar, extinction, single, sky, means] = rest.map(|(_, [word, ..])| word);
    [x, y, z, per_m, lattice, map, edge, haar, extinction, single, sky, means]
}

/// `FlbBase` behind its colours. Records and coarse averages begin at words of the buffer.
pub(super) fn base_fields(base: &CodedBase, records: u32, coarse: u32) -> [(&'static str, u32); 4] {
    let components = base.head().components() as u32;
    [("components", components), ("records", records), ("coarse", coarse), ("unused", 0)]
}

/// The words of a `FlbBase`; its bands and components are at most [`COLORS`].
pub(super) fn base_words(base: &CodedBase, records: u32, coarse: u32) -> [u32; 16] {
    let bands = base.head().bands as usize;
    let mut words = [0; 16];
    for (component, colors) in base.head().colors().chunks_exact(bands).enumerate() {
        for (band, color) in colors.iter().enumerate() {
            words[4 * component + band] = color.to_bits();
        }
    }
    for (word, (_, value)) in words[4 * COLORS..].iter_mut().zip(base_fields(base, records, coarse)) {
        *word = value;
    }
    words
}

/// `FlbTerm`.
pub(super) fn term_fields(term: Term) -> [(&'static str, u32); 2] {
    [("base", term.base), ("factor", term.factor.to_bits())]
}

/// Pairs of 32 blocks' bits and the number of stored blocks before them, in Morton order.
pub(super) fn map_words(map: &BlockMap) -> Vec<u32> {
    let (mut words, mut before) = (Vec::new(), 0);
    for bytes in map.to_bytes().chunks_exact(4) {
        let bits = u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
        words.extend([bits, before]);
        before += bits.count_ones();
    }
    words
}

/// The words of an extinction: as near.wgsl has them.
pub(super) fn extinction_words(extinction: &Extinction) -> Vec<u32> {
    let relative =
        |i: u32| (extinction.angles().relative(f64::from(i) / f64::from(RELATIVE - 1)) as f32).to_bits();
    let mut words = map_words(extinction.map());
    words.extend((0..RELATIVE).map(relative));
    // A site that lets less than 1e-26000 through is as good as one that lets nothing.
    let half = |depth: f32| u32::from(f16::from_f32_const(depth.min(60_000.0)).to_bits());
    let pair = |of_site: &[f32; 2]| half(of_site[0]) | half(of_site[1]) << 16;
    let behind_masks = 4 * extinction.blocks().len() as u32;
    for block in extinction.blocks() {
        let [low, high] = [block.mask as u32, (block.mask >> 32) as u32];
        let first = behind_masks + block.first;
        words.extend([low, first, high, first + low.count_ones()]);
    }
    words.extend(extinction.depths().iter().map(pair));
    words
}

/// Coarse averages, two a word: `[component][Morton code]`.
pub(super) fn coarse_words(base: &CodedBase) -> Vec<u32> {
    let all: Vec<u16> = base.coarse_averages().iter().flatten().map(|average| *average as u16).collect();
    all.chunks(2)
        .map(|pair| u32::from(pair[0]) | u32::from(pair.get(1).copied().unwrap_or(0)) << 16)
        .collect()
}

//! Rust values -> the words of the WGSL structs, field by field. A test holds names and offsets against what naga reads
//! from the WGSL.

use super::super::march::{Slant, SlantedTracks};

/// `Params`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Params {
    pub sites: u32,
    pub lanes: u32,
    pub moments: u32,
}

impl Params {
    /// Numbers that a segment adds in each lane.
    pub(super) fn parities(&self) -> u32 {
        if self.moments == 1 { 1 } else { 2 }
    }

    pub(super) fn fields(&self) -> [(&'static str, u32); 4] {
        let &Params { sites, lanes, moments } = self;
        [("sites", sites), ("lanes", lanes), ("moments", moments), ("parities", self.parities())]
    }
}

/// Words of `Axis`: direction, index, rays, three that are not used, moments four by four.
pub(super) const AXIS_WORDS: usize = 20;

/// Where the moments begin.
pub(super) const AXIS_MOMENTS: usize = 8;

/// `Axis` of number `index`.
pub(super) fn axis_words(axis: &SlantedTracks, index: usize, rays: usize) -> [u32; AXIS_WORDS] {
    let mut words = [0; AXIS_WORDS];
    words[..3].copy_from_slice(&axis.direction.map(f32::to_bits));
    words[3] = index as u32;
    words[4] = rays as u32;
    let moments: [f32; 9] = axis.moments(1.0);
    words[AXIS_MOMENTS..][..9].copy_from_slice(&moments.map(f32::to_bits));
    words
}

/// `Segment` that adds to a slot.
pub(super) fn segment_fields(
    segment: &flb_format::beam::single::Segment,
    slot: u32,
) -> [(&'static str, u32); 4] {
    [
        ("place", segment.place() as u32),
        ("slot", slot),
        ("transmittance", segment.transmittance.to_bits()),
        ("adds", segment.adds.to_bits()),
    ]
}

/// `Matter`.
pub(super) fn matter_fields(gains: [f32; 3], escape: f32, leaning: f32) -> [(&'static str, u32); 5] {
    let [even, first, second] = gains.map(f32::to_bits);
    [
        ("even", even),
        ("first", first),
        ("second", second),
        ("escape", escape.to_bits()),
        ("leaning", leaning.to_bits()),
    ]
}

/// `Slant`.
pub(super) fn slant_fields(slant: &Slant) -> [(&'static str, u32); 3] {
    let [x, y, z] = slant.offset.map(|c| c as u8);
    let offset = u32::from_le_bytes([x, y, z, 0]);
    [("depth", slant.depth.to_bits()), ("length", slant.length.to_bits()), ("offset", offset)]
}

/// Words of a struct.
pub(super) fn words<const N: usize>(fields: [(&'static str, u32); N]) -> [u32; N] {
    fields.map(|(_, word)| word)
}

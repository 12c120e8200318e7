//! Rust values to the words of the WGSL structs, in the order of their members. A test holds the lists of members
//! (`members.rs`), and the constants here, against what naga reads from the shaders; that words are in that order, the
//! pictures show.

#[cfg(test)]
pub(crate) mod members;

/// Invocations of a workgroup, and pixels of a square; `WORKGROUP`.
pub(crate) const WORKGROUP: u32 = 64;
/// Pixels along the edge of a square; `EDGE`.
pub(crate) const EDGE: u32 = 8;
/// Most species; `MODELS`.
pub(crate) const MAX_MODELS: usize = 256;
/// Most materials of all species; `MATERIALS`.
pub(crate) const MAX_MATERIALS: usize = 512;
/// Boxes that a ray can have waiting; `STACK`.
pub(crate) const STACK: u32 = 96;
/// What a fragment of the sky has as its instance; `SKY`.
pub(crate) const SKY: u32 = u32::MAX;
/// Of the ground; `GROUND`.
pub(crate) const GROUND: u32 = u32::MAX - 1;
/// No word; `NONE`.
pub(crate) const NONE: u32 = u32::MAX;
/// No texel at all; `NOTHING`.
pub(crate) const NOTHING: u32 = u32::MAX - 1;
/// Of a triangle's material: alpha has to be looked up; `TRIANGLE_CUT`.
pub(crate) const TRIANGLE_CUT: u32 = 1 << 31;
/// Of a triangle's material: it is met from the side alone from which its vertices run counter-clockwise;
/// `TRIANGLE_FRONT`.
pub(crate) const TRIANGLE_FRONT: u32 = 1 << 30;
/// From the other side alone; `TRIANGLE_BACK`.
pub(crate) const TRIANGLE_BACK: u32 = 1 << 29;
/// Of a fragment's triangle: it was met by way of the water; `BY_WATER`.
pub(crate) const BY_WATER: u32 = 1 << 31;
/// `CLASS_LEAF`
pub(crate) const CLASS_LEAF: u32 = 1;

/// Bytes between two uniforms of one buffer: the alignment that WebGPU asks for.
pub(crate) const UNIFORM_STRIDE: u64 = 256;

/// Words of a `Daylight`.
pub(crate) const DAYLIGHT_WORDS: usize = 48;

/// Words of a `SpeciesTerms`.
pub(crate) const LIGHT_WORDS: usize = 12;

/// Bytes of a `Fragment`.
pub(crate) const FRAGMENT_BYTES: u64 = 24;
/// Bytes of a `Lit`.
pub(crate) const LIT_BYTES: u64 = 48;

/// Words in the order of a struct's members.
#[derive(Default)]
pub(crate) struct Words(pub Vec<u32>);

impl Words {
    pub(crate) fn whole(&mut self, word: u32) -> &mut Words {
        self.0.push(word);
        self
    }

    pub(crate) fn float(&mut self, value: f32) -> &mut Words {
        self.whole(value.to_bits())
    }

    pub(crate) fn floats(&mut self, values: impl IntoIterator<Item = f32>) -> &mut Words {
        self.0.extend(values.into_iter().map(f32::to_bits));
        self
    }

    /// f64 rounded.
    pub(crate) fn rounded(&mut self, values: impl IntoIterator<Item = f64>) -> &mut Words {
        self.floats(values.into_iter().map(|value| value as f32))
    }
}

/// A coordinate as two floats whose sum it is.
pub(crate) fn split(value: f64) -> [f32; 2] {
    let high = value as f32;
    [high, (value - f64::from(high)) as f32]
}

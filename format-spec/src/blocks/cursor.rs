//! Samples at points that lie near one another: blocks once read stay expanded, as far as they fit.

use super::base::CodedBase;
use super::map;
use super::sample::At;
use super::transform::{EDGE, TEXELS};

/// Blocks kept along an axis, a power of two: those whose coordinates differ by a multiple of it take each other's place.
const KEPT: u32 = 4;
const SLOTS: usize = KEPT.pow(3) as usize;
/// Of a slot without a block.
const NONE: u32 = u32::MAX;

/// Samples a base like [`CodedBase::sample`], with a memory of the blocks last read: for each component 16 KiB. The same
/// texels give the same samples, but for the rounding of sums in another order.
#[derive(Debug, Clone)]
pub struct Cursor<'a> {
    base: &'a CodedBase,
    /// `[slot]` Morton code of its block.
    codes: [u32; SLOTS],
    /// `[slot][component][texel]` in the integers of texels.
    texels: Vec<[f32; TEXELS]>,
}

impl<'a> Cursor<'a> {
    /// Over a base to which nothing is added meanwhile.
    pub fn new(base: &'a CodedBase) -> Cursor<'a> {
        let texels = vec![[0.0; TEXELS]; SLOTS * base.head.components()];
        Cursor { base, codes: [NONE; SLOTS], texels }
    }

    /// Light at a point in lattice coordinates, one value per band.
    ///
    /// # Panics
    /// If `out` is not as long as the field has bands.
    #[inline]
    pub fn sample(&mut self, point: [f64; 3], out: &mut [f32]) {
        assert_eq!(out.len(), self.base.head.bands as usize, "a value per band");
        let at = At::of(self.base.shared.map.lattice(), point);
        let components = self.base.head.components();
        let straddled = at.straddled();
        // First texel of the slot of each of the blocks, by the axes on which it is the upper one.
        let mut slots = [0usize; 8];
        let mut upper = 0;
        loop {
            slots[upper] =
                self.slot(std::array::from_fn(|a| at.texel[a] / EDGE as u32 + (upper >> a & 1) as u32));
            if upper == straddled {
                break;
            }
            upper = upper.wrapping_sub(straddled) & straddled;
        }
        // `[corner]` first component's block in `texels`, and the texel in it.
        let corners: [(usize, usize); 8] = std::array::from_fn(|corner| {
            let texel = |a: usize| (at.texel[a] as usize + (corner >> a & 1)) % EDGE;
            (slots[corner & straddled], (texel(2) * EDGE + texel(1)) * EDGE + texel(0))
        });
        let [x, y, z] = at.part;
        let mix = |a: f32, b: f32, t: f32| a * (1.0 - t) + b * t;
        out.fill(0.0);
        for c in 0..components {
            let v = corners.map(|(slot, texel)| self.texels[slot + c][texel % TEXELS]);
            let rows: [f32; 4] = std::array::from_fn(|i| mix(v[2 * i], v[2 * i + 1], x));
            let part = mix(mix(rows[0], rows[1], y), mix(rows[2], rows[3], y), z);
            let colours = &self.base.colours[c * out.len()..][..out.len()];
            out.iter_mut().zip(colours).for_each(|(o, colour)| *o += colour * part);
        }
    }

    /// Where the block `[x, y, z]` lies expanded: its first component.
    #[inline]
    fn slot(&mut self, block: [u32; 3]) -> usize {
        let [x, y, z] = block.map(|b| b % KEPT);
        let slot = ((z * KEPT + y) * KEPT + x) as usize;
        let code = map::encode(block);
        if self.codes[slot] != code {
            self.expand(block, slot);
            self.codes[slot] = code;
        }
        slot * self.base.head.components()
    }

    #[cold]
    fn expand(&mut self, block: [u32; 3], slot: usize) {
        let components = self.base.head.components();
        let texels = &mut self.texels[slot * components..][..components];
        for (c, texels) in texels.iter_mut().enumerate() {
            *texels = self.base.block_texels(block, c).map(|texel| texel as f32);
        }
    }
}

//! Samples at points that lie near one another: blocks once read stay expanded, as far as they fit.

use super::base::CodedBase;
use super::map;
use super::sample::At;
use super::transform::{EDGE, TEXELS};

/// Blocks kept along an axis, a power of two: those whose coordinates differ by a multiple of it take each other's place.
const KEPT: u32 = 4;
const SLOTS: usize = KEPT.pow(3) as usize;
/// Components side by side.
const FOUR: usize = 4;
/// Of a slot without a block.
const NONE: u32 = u32::MAX;

/// Samples a base like [`CodedBase::sample`], with a memory of the blocks last read: 64 KiB for up to four components. The same
/// texels give the same samples, but for the rounding of sums in another order.
#[derive(Debug, Clone)]
pub struct Cursor<'a> {
    base: &'a CodedBase,
    /// `[slot]` Morton code of its block.
    codes: [u32; SLOTS],
    /// `[slot][component / 4][texel][component % 4]` in the integers of texels.
    texels: Vec<[[f32; FOUR]; TEXELS]>,
    /// Fours of components.
    fours: usize,
}

impl<'a> Cursor<'a> {
    /// Over a base to which nothing is added meanwhile.
    pub fn new(base: &'a CodedBase) -> Cursor<'a> {
        let fours = base.head.components().div_ceil(FOUR);
        let texels = vec![[[0.0; FOUR]; TEXELS]; SLOTS * fours];
        Cursor { base, codes: [NONE; SLOTS], texels, fours }
    }

    /// Light at a point in lattice coordinates, one value per band.
    ///
    /// # Panics
    /// If `out` is not as long as the field has bands.
    #[inline]
    pub fn sample(&mut self, point: [f64; 3], out: &mut [f32]) {
        assert_eq!(out.len(), self.base.head.bands as usize, "a value per band");
        let at = At::of(self.base.shared.map.lattice(), point);
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
        // `[corner]` first four's block in `texels`, and the texel in it.
        let corners: [(usize, usize); 8] = std::array::from_fn(|corner| {
            let texel = |a: usize| (at.texel[a] as usize + (corner >> a & 1)) % EDGE;
            (slots[corner & straddled], (texel(2) * EDGE + texel(1)) * EDGE + texel(0))
        });
        let [x, y, z] = at.part;
        let mix = |a: [f32; FOUR], b: [f32; FOUR], t: f32| -> [f32; FOUR] {
            std::array::from_fn(|i| a[i] * (1.0 - t) + b[i] * t)
        };
        out.fill(0.0);
        for (four, colours) in self.base.colours.chunks(FOUR * out.len()).enumerate() {
            let v = corners.map(|(slot, texel)| self.texels[slot + four][texel % TEXELS]);
            let rows: [_; 4] = std::array::from_fn(|i| mix(v[2 * i], v[2 * i + 1], x));
            let parts = mix(mix(rows[0], rows[1], y), mix(rows[2], rows[3], y), z);
            for (colours, part) in colours.chunks_exact(out.len()).zip(parts) {
                out.iter_mut().zip(colours).for_each(|(o, colour)| *o += colour * part);
            }
        }
    }

    /// Where the block `[x, y, z]` lies expanded: its first four components.
    #[inline]
    fn slot(&mut self, block: [u32; 3]) -> usize {
        let [x, y, z] = block.map(|b| b % KEPT);
        let slot = ((z * KEPT + y) * KEPT + x) as usize;
        let code = map::encode(block);
        if self.codes[slot] != code {
            self.expand(block, slot);
            self.codes[slot] = code;
        }
        slot * self.fours
    }

    #[cold]
    fn expand(&mut self, block: [u32; 3], slot: usize) {
        for c in 0..self.base.head.components() {
            let texels = self.base.block_texels(block, c);
            let kept = &mut self.texels[slot * self.fours + c / FOUR];
            kept.iter_mut().zip(texels).for_each(|(kept, texel)| kept[c % FOUR] = texel as f32);
        }
    }
}

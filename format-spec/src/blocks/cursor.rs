//! Samples of sums of bases at points that lie near one another: blocks once read and added up stay expanded, as far as
//! they fit.

use super::Coding;
use super::base::{CodedBase, Shared};
use super::lanes::{self, Job, Lanes};
use super::map;
use super::sample::{At, subsets};
use super::transform::{EDGE, HAAR, SMOOTH, TEXELS, in_floats, inverse};

/// Blocks kept along an axis, a power of two: those whose coordinates differ by a multiple of it take each other's
/// place.
const KEPT: u32 = 4;
const SLOTS: usize = KEPT.pow(3) as usize;
/// Channels side by side.
const FOUR: usize = 4;
/// Of a slot without a block.
const NONE: u32 = u32::MAX;

/// Samples sums of bases of one species, each base times a factor, with a memory of the blocks last read: 64 KiB for
/// every four of sums times bands. Bases are added up once for a block, not for every sample: the more bases, the more
/// it gains. The same points give the same samples whatever was sampled before, and those of [`CodedBase::sample`] but
/// for the rounding of sums in another order.
#[derive(Debug, Clone)]
pub struct Cursor<'a> {
    shared: &'a Shared,
    /// `[sum]`
    sums: Vec<Vec<(&'a CodedBase, f32)>>,
    bands: usize,
    /// `[slot]` Morton code of its block.
    codes: [u32; SLOTS],
    /// `[slot][channel / 4][texel][channel % 4]`, channels being `[sum][band]`.
    texels: Vec<[[f32; FOUR]; TEXELS]>,
    /// Fours of channels.
    fours: usize,
    /// `[band]` of a block that is expanded.
    work: Vec<[f32; TEXELS]>,
}

/// A block to be expanded into a slot.
struct Expand<'c, 'a> {
    cursor: &'c mut Cursor<'a>,
    block: [u32; 3],
    slot: usize,
}

impl Job for Expand<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn call<L: Lanes>(self, lanes: L) {
        self.cursor.expand_with(lanes, self.block, self.slot);
    }
}

impl<'a> Cursor<'a> {
    /// Makes a cursor over a base to which nothing is added meanwhile.
    pub fn new(base: &'a CodedBase) -> Cursor<'a> {
        Cursor::of_sums(vec![vec![(base, 1.0)]])
    }

    /// Makes a cursor over sums of bases and factors.
    ///
    /// # Panics
    /// If no sum has a base, or they are not all of one species.
    pub fn of_sums(sums: Vec<Vec<(&'a CodedBase, f32)>>) -> Cursor<'a> {
        let first = sums.iter().flatten().next().expect("a base").0;
        let is_alike = |base: &CodedBase| base.shared == first.shared && base.head.bands == first.head.bands;
        assert!(sums.iter().flatten().all(|(base, _)| is_alike(base)), "bases of one species");
        let bands = first.head.bands as usize;
        let fours = (bands * sums.len()).div_ceil(FOUR);
        let texels = vec![[[0.0; FOUR]; TEXELS]; SLOTS * fours];
        Cursor {
            shared: &first.shared,
            sums,
            bands,
            codes: [NONE; SLOTS],
            texels,
            fours,
            work: vec![[0.0; TEXELS]; bands],
        }
    }

    /// Sums at a point in lattice coordinates, `[sum][band]`.
    ///
    /// # Panics
    /// If `out` is not as long as all sums have bands.
    #[inline]
    pub fn sample(&mut self, point: [f64; 3], out: &mut [f32]) {
        assert_eq!(out.len(), self.bands * self.sums.len(), "a value per sum and band");
        let at = At::of(self.shared.map.lattice(), point);
        let straddled = at.straddled();
        // First four of the slot of each of the blocks, by the axes on which it is the upper one.
        let mut slots = [0usize; 8];
        for upper in subsets(straddled) {
            slots[upper] =
                self.slot(std::array::from_fn(|a| at.texel[a] / EDGE as u32 + (upper >> a & 1) as u32));
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
        for (four, out) in out.chunks_mut(FOUR).enumerate() {
            let v = corners.map(|(slot, texel)| self.texels[slot + four][texel % TEXELS]);
            let rows: [_; 4] = std::array::from_fn(|i| mix(v[2 * i], v[2 * i + 1], x));
            let all = mix(mix(rows[0], rows[1], y), mix(rows[2], rows[3], y), z);
            out.copy_from_slice(&all[..out.len()]);
        }
    }

    /// Sums at the centres of the texels of the block `[x, y, z]`, which lies in the lattice, `[z][y][x][sum][band]`.
    ///
    /// # Panics
    /// If `out` is not as long as all sums of all texels have bands.
    pub fn block(&mut self, block: [u32; 3], out: &mut [f32]) {
        let channels = self.bands * self.sums.len();
        assert_eq!(out.len(), TEXELS * channels, "a value per texel, sum and band");
        let slot = self.slot(block);
        for (texel, out) in out.chunks_exact_mut(channels).enumerate() {
            for (four, out) in out.chunks_mut(FOUR).enumerate() {
                out.copy_from_slice(&self.texels[slot + four][texel][..out.len()]);
            }
        }
    }

    /// Where the block `[x, y, z]` lies expanded: its first four channels.
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
        lanes::run(Expand { cursor: self, block, slot });
    }

    /// Adds up coefficients and turns their sums into texels: one transform for all bases of a sum.
    #[inline(always)]
    fn expand_with<L: Lanes>(&mut self, lanes: L, block: [u32; 3], slot: usize) {
        const ROWS: [[[f32; EDGE]; EDGE]; 2] = [in_floats(&SMOOTH), in_floats(&HAAR)];
        let rank = self.shared.map.rank(block).map(|rank| rank as usize);
        let kept = &mut self.texels[slot * self.fours..][..self.fours];
        for (sum, terms) in self.sums.iter().enumerate() {
            self.work.fill([0.0; TEXELS]);
            for (base, factor) in terms {
                for (component, colors) in base.colors.chunks_exact(self.bands).enumerate() {
                    let values = match rank {
                        Some(rank) => base.coefficients_with(lanes, rank, component),
                        None => base.coarse_texels(block, component),
                    };
                    let values = values.map(|value| value as f32);
                    for (work, color) in self.work.iter_mut().zip(colors) {
                        let factor = factor * color;
                        work.iter_mut().zip(&values).for_each(|(sum, value)| *sum += factor * value);
                    }
                }
            }
            for (band, work) in self.work.iter_mut().enumerate() {
                match (rank, &self.shared.coding) {
                    (Some(_), Coding::Classed(_)) => inverse(&ROWS[0], work),
                    (Some(_), Coding::Haar) => inverse(&ROWS[1], work),
                    (None, _) => {}
                }
                let channel = sum * self.bands + band;
                let kept = &mut kept[channel / FOUR];
                kept.iter_mut().zip(&*work).for_each(|(kept, texel)| kept[channel % FOUR] = *texel);
            }
        }
    }
}

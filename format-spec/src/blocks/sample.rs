//! Trilinear samples straight from the coded bits: one to eight blocks a sample, and no block expanded.
//!
//! Why so: the rows of the transform are separable, and so is the trilinear weight, so a block's share is the sum over
//! its coefficients of `coefficient * wz * wy * wx`, with `w` the linear weights of its texels along an axis projected
//! on the four rows. Texels lie where [`crate::sample`] has them. At the centre of a texel all sums are of integers,
//! hence exact up to 2^24, and the sample is the texel to the bit. Every machine adds in one order, so samples are the
//! same bits on all of them; [`super::Cursor`] adds in another, and differs by rounding.

use super::base::{CodedBase, Shared, average_of};
use super::coarse::Coarse;
use super::lanes::{self, Job, Lanes, Weights};
use super::transform::{AVERAGE_COEFFICIENT, EDGE, HAAR, Rows, SMOOTH};
use super::{Coding, MAX_HALVINGS, TEXELS, detail};
use crate::container::records::MAX_BANDS;

/// Most components of the fast path.
const FEW: usize = 4;

/// Texels of a sample: the lower one of eight, and how far the sample lies towards the next.
#[derive(Debug, Clone)]
pub struct At {
    /// The lower texel, `[x, y, z]`.
    pub texel: [u32; 3],
    /// Share of the next one, along each axis.
    pub part: [f32; 3],
}

impl At {
    /// In lattice coordinates (site i covers i..i+1). Points outside are clamped; NaN is read as the lower end.
    #[inline]
    pub fn of(lattice: u32, point: [f64; 3]) -> At {
        let place = point.map(|x| (x - 0.5).max(0.0).min(f64::from(lattice - 1)));
        let texel = place.map(|x| (x as u32).min(lattice - 2));
        At { texel, part: std::array::from_fn(|axis| (place[axis] - f64::from(texel[axis])) as f32) }
    }

    /// Bit `axis` says that the sample lies between two blocks along that axis.
    #[inline]
    pub fn straddled(&self) -> usize {
        (0..3).fold(0, |bits, a| bits | usize::from(self.texel[a] as usize % EDGE == EDGE - 1) << a)
    }
}

/// A point among the blocks of a species, for samples of several of its bases.
#[derive(Debug, Clone)]
pub struct SpeciesPoint<'a> {
    shared: &'a Shared,
    at: At,
    /// Bits of the axes along which two blocks are straddled.
    straddled: usize,
    /// `[upper]` ranks of the blocks that it lies in: in those of all subsets of these axes.
    ranks: [Option<u32>; 8],
    /// `[axis][upper]` linear weights of texels, projected on the rows.
    along: [[[f32; EDGE]; 2]; 3],
}

impl<'a> SpeciesPoint<'a> {
    /// Locates a point in lattice coordinates (site i covers i..i+1). Points outside are clamped; NaN is read as the
    /// lower end.
    #[inline]
    pub fn new(shared: &'a Shared, point: [f64; 3]) -> SpeciesPoint<'a> {
        let (map, at) = (&shared.map, At::of(shared.map.lattice(), point));
        let columns = match shared.coding {
            Coding::Classed(_) => &SMOOTH_COLUMNS,
            Coding::Haar => &HAAR_COLUMNS,
        };
        let along = std::array::from_fn(|axis| {
            let local = at.texel[axis] as usize % EDGE;
            [along(columns, local, 0, at.part[axis]), along(columns, local, 1, at.part[axis])]
        });
        let (straddled, mut ranks) = (at.straddled(), [None; 8]);
        for upper in subsets(straddled) {
            let block = std::array::from_fn(|a| at.texel[a] / EDGE as u32 + (upper >> a & 1) as u32);
            ranks[upper] = map.rank(block);
        }
        SpeciesPoint { shared, at, straddled, ranks, along }
    }

    /// Whether the point was located in `shared` itself (not in an equal value).
    #[inline]
    pub fn is_among(&self, shared: &Shared) -> bool {
        std::ptr::eq(self.shared, shared)
    }
}

/// All subsets of bits, ascending.
#[inline(always)]
pub(super) fn subsets(bits: usize) -> impl Iterator<Item = usize> {
    std::iter::successors(Some(0usize), move |at| (*at != bits).then(|| at.wrapping_sub(bits) & bits))
}

/// A sample to be taken.
struct Sample<'a> {
    base: &'a CodedBase,
    place: &'a SpeciesPoint<'a>,
    out: &'a mut [f32],
}

impl Job for Sample<'_> {
    type Output = ();

    #[inline(always)]
    fn call<L: Lanes>(self, lanes: L) {
        self.base.sample_with(lanes, self.place, self.out);
    }
}

impl CodedBase {
    /// Light at a point in lattice coordinates (site i covers i..i+1), one value per band. Points outside are clamped;
    /// NaN is read as the lower end. Where no block is stored the coarse level answers.
    ///
    /// # Panics
    /// If `out` is not as long as the field has bands.
    #[inline]
    pub fn sample(&self, point: [f64; 3], out: &mut [f32]) {
        self.sample_at(&SpeciesPoint::new(&self.shared, point), out);
    }

    /// Samples the base as [`CodedBase::sample`] does, at a point that is located already.
    ///
    /// # Panics
    /// If `out` is not as long as the field has bands, or the place is not among the base's own [`Shared`], be another
    /// one equal ([`SpeciesPoint::is_among`]).
    #[inline]
    pub fn sample_at(&self, place: &SpeciesPoint<'_>, out: &mut [f32]) {
        lanes::run(Sample { base: self, place, out });
    }

    /// [`CodedBase::sample_at`] by one of the ways to add up fields.
    #[inline(always)]
    pub(super) fn sample_with<L: Lanes>(&self, lanes: L, place: &SpeciesPoint<'_>, out: &mut [f32]) {
        assert!(place.is_among(&self.shared), "a place among the base's own blocks");
        assert_eq!(out.len(), self.head.bands as usize, "a value per band");
        let components = self.head.components();
        if components <= FEW {
            self.mix(&self.parts::<L, FEW>(lanes, place)[..components], out);
        } else {
            self.mix(&self.parts::<L, { MAX_BANDS as usize }>(lanes, place)[..components], out);
        }
    }

    /// Components to bands.
    #[inline(always)]
    pub(super) fn mix(&self, parts: &[f32], out: &mut [f32]) {
        out.fill(0.0);
        for (colors, part) in self.colors.chunks_exact(out.len()).zip(parts) {
            out.iter_mut().zip(colors).for_each(|(o, color)| *o += color * part);
        }
    }

    /// `[component]` in the integers of texels.
    #[inline(always)]
    fn parts<L: Lanes, const C: usize>(&self, lanes: L, place: &SpeciesPoint<'_>) -> [f32; C] {
        let mut parts = [0.0; C];
        let axes = self.head.axes.map(usize::from);
        for upper in subsets(place.straddled) {
            match place.ranks[upper] {
                Some(rank) => {
                    let digit = |d: usize| &place.along[axes[d]][upper >> axes[d] & 1];
                    let weights = Weights::new([digit(0), digit(1), digit(2)]);
                    self.add_block(lanes, rank as usize, &weights, &mut parts);
                }
                None => self.add_coarse(place, upper, &mut parts),
            }
        }
        parts
    }

    /// Adds a stored block's share.
    #[inline(always)]
    fn add_block<L: Lanes, const C: usize>(
        &self,
        lanes: L,
        rank: usize,
        weights: &Weights,
        parts: &mut [f32; C],
    ) {
        let components = self.head.components();
        let block = &self.blocks[rank * (1 + components)..][..1 + components];
        let scale = (1 << (MAX_HALVINGS - self.head.halvings(average_of(block[1])))) as f32;
        let mut at = block[0] as usize;
        for (c, part) in parts.iter_mut().enumerate().take(components) {
            let class = (block[1 + c] >> 16) as u16;
            let detail = match &self.shared.coding {
                Coding::Classed(classes) => {
                    let first = at;
                    at += classes.bytes(class);
                    lanes.sum(classes.groups(class), &self.bytes[first..], weights)
                }
                Coding::Haar => self.masked(self.masks[rank * components + c], class, &mut at, weights),
            };
            let average = i32::from(average_of(block[1 + c])) * AVERAGE_COEFFICIENT;
            *part += average as f32 * weights.at(0) + scale * detail;
        }
    }

    /// Sum of the coefficients of a mask times their weights, in half steps; moves `bit` behind them.
    #[inline(always)]
    fn masked(&self, mask: u64, width: u16, bit: &mut usize, weights: &Weights) -> f32 {
        let width = u32::from(width);
        let mut sum = 0.0;
        let mut left = mask;
        while left != 0 {
            let place = left.trailing_zeros() as usize % TEXELS;
            left &= left - 1;
            let bytes = self.bytes[*bit / 8..].first_chunk::<4>();
            let word = u32::from_le_bytes(*bytes.expect("a window lies behind the last field"));
            let field = word >> (*bit % 8) & ((1 << width) - 1);
            sum += detail::mask_value(field, width) as f32 * weights.at(place);
            *bit += width as usize;
        }
        sum
    }

    /// Adds the coarse level's share of the texels in a block that is not stored.
    #[cold]
    fn add_coarse<const C: usize>(&self, place: &SpeciesPoint<'_>, upper: usize, parts: &mut [f32; C]) {
        let coarse: Vec<Coarse> = (0..self.head.components()).filter_map(|c| self.coarse(c)).collect();
        let at = &place.at;
        for corner in (0..8usize).filter(|corner| corner & place.straddled == upper) {
            let texel = std::array::from_fn(|a| at.texel[a] + (corner >> a & 1) as u32);
            let weight = |a: usize| if corner >> a & 1 == 1 { at.part[a] } else { 1.0 - at.part[a] };
            let weight = weight(2) * weight(1) * weight(0);
            for (part, coarse) in parts.iter_mut().zip(&coarse) {
                *part += weight * coarse.texel(texel) as f32;
            }
        }
    }
}

/// `[texel][k]`: rows by column, in floats; behind the last one again the first.
type Columns = [[f32; EDGE]; EDGE + 1];
const SMOOTH_COLUMNS: Columns = columns(&SMOOTH);
const HAAR_COLUMNS: Columns = columns(&HAAR);

const fn columns(rows: &Rows) -> Columns {
    let mut columns = [[0.0; EDGE]; EDGE + 1];
    let mut i = 0;
    while i < EDGE * (EDGE + 1) {
        columns[i / EDGE][i % EDGE] = rows[i % EDGE][i / EDGE % EDGE] as f32;
        i += 1;
    }
    columns
}

/// The linear weights of a block's texels along an axis, projected on the rows. `local` is the lower texel of the
/// sample in its own block; where it is the last one, the upper texel is the first of the block above (`upper` 1).
#[inline(always)]
fn along(columns: &Columns, local: usize, upper: usize, part: f32) -> [f32; EDGE] {
    let is_last = local == EDGE - 1;
    let (texel, first, second) = match upper {
        0 => (local, 1.0 - part, if is_last { 0.0 } else { part }),
        _ => (0, part, 0.0),
    };
    let (a, b) = (&columns[texel % EDGE], &columns[texel % EDGE + 1]);
    std::array::from_fn(|k| a[k] * first + b[k] * second)
}

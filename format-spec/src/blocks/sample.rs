//! Trilinear samples straight from the coded bits: one to eight blocks a sample, and no block expanded.
//!
//! Why so: the rows of the transform are separable, and so is the trilinear weight, so a block's share is the sum over
//! its coefficients of `coefficient * wz * wy * wx`, with `w` the linear weights of its texels along an axis projected on
//! the four rows. Texels lie where [`crate::sample`] has them. At the centre of a texel all sums are of integers, hence
//! exact up to 2^24, and the sample is the texel to the bit.

use super::base::{CodedBase, WINDOW_BYTES};
use super::classes::{Classes, Field};
use super::transform::{AVERAGE_COEFFICIENT, EDGE, Rows};
use super::{Coding, MAX_HALVINGS, TEXELS, detail};
use crate::records::MAX_BANDS;

/// Most components of the fast path.
const FEW: usize = 4;

/// Place of a sample: `[x, y, z]` of its lower texel, and how far it lies towards the next.
struct At {
    texel: [u32; 3],
    part: [f32; 3],
}

impl CodedBase {
    /// Light at a point in lattice coordinates (site i covers i..i+1), one value per band. Points outside are clamped; NaN
    /// is read as the lower end. Where no block is stored the coarse level answers.
    ///
    /// # Panics
    /// If `out` is not as long as the field has bands.
    pub fn sample(&self, point: [f64; 3], out: &mut [f32]) {
        let bands = self.head.bands as usize;
        assert_eq!(out.len(), bands, "a value per band");
        let at = locate(self.shared.map.lattice(), point);
        let components = self.head.components();
        if components <= FEW {
            self.mix(&self.parts::<FEW>(&at)[..components], out);
        } else {
            self.mix(&self.parts::<{ MAX_BANDS as usize }>(&at)[..components], out);
        }
    }

    fn mix(&self, parts: &[f32], out: &mut [f32]) {
        out.fill(0.0);
        for (colours, part) in self.colours.chunks_exact(out.len()).zip(parts) {
            out.iter_mut().zip(colours).for_each(|(o, colour)| *o += colour * part);
        }
    }

    /// `[component]` in the integers of texels.
    #[inline]
    fn parts<const C: usize>(&self, at: &At) -> [f32; C] {
        let mut parts = [0.0; C];
        let rows = self.shared.coding.rows();
        let local = at.texel.map(|t| t as usize % EDGE);
        let straddled = (0..3).fold(0usize, |bits, a| bits | usize::from(local[a] == EDGE - 1) << a);
        // A sample lies in every block of the axes on which it straddles two: in all subsets of them.
        let mut upper = 0;
        loop {
            let block = std::array::from_fn(|a| at.texel[a] / EDGE as u32 + (upper >> a & 1) as u32);
            match self.shared.map.rank(block) {
                Some(rank) => {
                    let weights = std::array::from_fn(|digit| {
                        let axis = usize::from(self.head.axes[digit]);
                        along(rows, local[axis], upper >> axis & 1, at.part[axis])
                    });
                    self.add_block(rank as usize, &weights, &mut parts);
                }
                None => self.add_coarse(at, upper, straddled, &mut parts),
            }
            if upper == straddled {
                return parts;
            }
            upper = upper.wrapping_sub(straddled) & straddled;
        }
    }

    /// Adds a stored block's share; `weights` is `[digit][k]`.
    #[inline]
    fn add_block<const C: usize>(&self, rank: usize, weights: &[[f32; EDGE]; 3], parts: &mut [f32; C]) {
        let mut table = [0.0f32; TEXELS];
        for (i, row) in table.as_chunks_mut::<EDGE>().0.iter_mut().enumerate() {
            let w = weights[2][i / EDGE] * weights[1][i % EDGE];
            (0..EDGE).for_each(|k| row[k] = w * weights[0][k]);
        }
        let components = self.head.components();
        let block = &self.blocks[rank * (1 + components)..][..1 + components];
        let scale = (1 << (MAX_HALVINGS - self.head.halvings(self.average(block[1])))) as f32;
        let mut bit = block[0];
        for c in 0..components.min(C) {
            let class = (block[1 + c] >> 16) as u16;
            let detail = match &self.shared.coding {
                Coding::Classed(classes) => self.classed(classes, class, &mut bit, &table),
                Coding::Haar => self.masked(self.masks[rank * components + c], class, &mut bit, &table),
            };
            let average = i32::from(self.average(block[1 + c])) * AVERAGE_COEFFICIENT;
            parts[c] += average as f32 * table[0] + scale * detail;
        }
    }

    /// Sum of the coefficients of a class times their weights, in half steps; moves `bit` behind them.
    #[inline]
    fn classed(&self, classes: &Classes, class: u16, bit: &mut u32, table: &[f32; TEXELS]) -> f32 {
        // A window of fixed size: no offset of a field leaves it, so none pays for a check.
        let window = self.bytes[(*bit / 8) as usize..].first_chunk::<WINDOW_BYTES>();
        let window = window.expect("a window lies behind the last field");
        let mut sums = [0.0f32; 4];
        // One loop over all fields, four at a time: loops for each width would lose more at their ends.
        for group in classes.fields(class).as_chunks::<4>().0 {
            for j in 0..4 {
                let field = Field(group[j]);
                let at = *bit % 8 + field.offset();
                let i = (at / 8) as usize & 127;
                let word = u32::from_le_bytes([window[i], window[i + 1], window[i + 2], window[i + 3]]);
                sums[j] += field.value(word >> (at % 8)) as f32 * table[field.place()];
            }
        }
        *bit += classes.bits(class);
        (sums[0] + sums[1]) + (sums[2] + sums[3])
    }

    /// The same of a mask.
    #[inline]
    fn masked(&self, mask: u64, width: u16, bit: &mut u32, table: &[f32; TEXELS]) -> f32 {
        let width = u32::from(width);
        let mut sum = 0.0;
        let mut left = mask;
        while left != 0 {
            let place = left.trailing_zeros() as usize;
            left &= left - 1;
            let bytes = self.bytes[(*bit / 8) as usize..].first_chunk::<4>();
            let word = u32::from_le_bytes(*bytes.expect("a window lies behind the last field"));
            let field = word >> (*bit % 8) & ((1 << width) - 1);
            sum += detail::mask_value(field, width) as f32 * table[place & 63];
            *bit += width;
        }
        sum
    }

    /// Adds the coarse level's share of the texels in a block that is not stored.
    #[cold]
    fn add_coarse<const C: usize>(&self, at: &At, upper: usize, straddled: usize, parts: &mut [f32; C]) {
        for corner in (0..8usize).filter(|corner| corner & straddled == upper) {
            let texel = std::array::from_fn(|a| at.texel[a] + (corner >> a & 1) as u32);
            let weight = |a: usize| if corner >> a & 1 == 1 { at.part[a] } else { 1.0 - at.part[a] };
            let weight = weight(2) * weight(1) * weight(0);
            for (c, part) in parts.iter_mut().enumerate() {
                if let Some(coarse) = self.averages.coarse(&self.shared.map, c) {
                    *part += weight * coarse.texel(texel) as f32;
                }
            }
        }
    }
}

fn locate(lattice: u32, point: [f64; 3]) -> At {
    let place = point.map(|x| (x - 0.5).max(0.0).min(f64::from(lattice - 1)));
    let texel = place.map(|x| (x as u32).min(lattice - 2));
    At { texel, part: std::array::from_fn(|axis| (place[axis] - f64::from(texel[axis])) as f32) }
}

/// The linear weights of a block's texels along an axis, projected on the rows. `local` is the lower texel of the sample in
/// its own block; where it is the last one, the upper texel is the first of the block above (`upper` 1).
#[inline]
fn along(rows: &Rows, local: usize, upper: usize, part: f32) -> [f32; EDGE] {
    let (texel, first, second) = match (upper, local) {
        (1, _) => (0, part, 0.0),
        (_, 3) => (3, 1.0 - part, 0.0),
        _ => (local, 1.0 - part, part),
    };
    std::array::from_fn(|k| rows[k][texel] as f32 * first + rows[k][(texel + 1) & 3] as f32 * second)
}

//! Trilinear samples of a field: from its texels, and straight from the kept coefficients of one block.
//!
//! Where: texel `i` lies at the lattice coordinate `i + 0.5`; a sample at `x` lies between the texels `i`
//! and `i + 1` with `i = min(floor(x - 0.5), N - 2)` (Steele 2009, equations 4.4 and 4.5; lighting model,
//! section 8). Points outside take the nearest point on the hull of the texel centres.
//!
//! Why straight from coefficients: the 4^3 Haar basis is separable, and so is the trilinear weight, so the
//! sample is `sum over kept coefficients of coefficient * wz * wy * wx`, where `w` along an axis is the
//! pair of linear weights projected on the four basis functions. No block is ever expanded; the cost goes
//! with what was kept. Full decode, then [`trilinear`], is the oracle.

pub use crate::field::site_of;

use crate::Field;
use crate::block::{STRIDE, blocks_per_axis};
use crate::haar::{BASIS, EDGE};

/// Distance off a solid's surface at which its light is sampled, along the normal, in sites. Nearer by, samples reach
/// into sites behind the surface; further off, they miss the shade of what stands near.
pub const SOLID_OFFSET: f64 = 0.75;

/// The block that answers a sample, and the place in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlockPoint {
    /// Block, `[x, y, z]`.
    pub block: [u32; 3],
    /// Coordinates in the block, in texels, each in 0..=3; `[x, y, z]`.
    pub local: [f32; 3],
}

/// Finds the block of a point in lattice coordinates (site i covers i..i+1) of a lattice of `lattice` >= 2
/// sites. Points outside are clamped; NaN is read as the lower end.
pub fn locate(lattice: u32, point: [f64; 3]) -> BlockPoint {
    let mut block = [0; 3];
    let mut local = [0.0; 3];
    for axis in 0..3 {
        let x = texel_coordinate(lattice, point[axis]);
        let texel = (x as u32).min(lattice - 2);
        block[axis] = texel / STRIDE as u32;
        local[axis] = (x - f64::from(block[axis] * STRIDE as u32)) as f32;
    }
    BlockPoint { block, local }
}

impl BlockPoint {
    /// Index of the block in the order of a file: `[z][y][x]`, x fastest.
    pub fn block_index(&self, lattice: u32) -> u32 {
        let edge = blocks_per_axis(lattice);
        (self.block[2] * edge + self.block[1]) * edge + self.block[0]
    }
}

/// The corners `[x, y, z]` of a cell, 0 or 1 along each axis, x fastest, and their trilinear weights at `part` of it.
pub fn corners(part: [f32; 3]) -> [([usize; 3], f32); 8] {
    std::array::from_fn(|corner| {
        let upper = [corner & 1, corner >> 1 & 1, corner >> 2];
        let along = |axis: usize| if upper[axis] == 1 { part[axis] } else { 1.0 - part[axis] };
        (upper, along(0) * along(1) * along(2))
    })
}

/// Trilinear sample of a whole field at a point in lattice coordinates; one value per band.
///
/// # Panics
/// If `out` is shorter than the field's bands or the lattice has fewer than 2 sites per edge.
pub fn trilinear(field: &Field, point: [f64; 3], out: &mut [f32]) {
    let n = field.lattice as usize;
    let mut texel = [0; 3];
    let mut t = [0.0; 3];
    for axis in 0..3 {
        let x = texel_coordinate(field.lattice, point[axis]);
        texel[axis] = (x as usize).min(n - 2);
        t[axis] = (x - texel[axis] as f64) as f32;
    }
    let first = (texel[2] * n + texel[1]) * n + texel[0];
    for (band, out) in (0..field.bands).zip(out) {
        let along_x = |start: usize| {
            let [low, high] = field.row(band, start);
            lerp(low, high, t[0])
        };
        let along_y = |start: usize| lerp(along_x(start), along_x(start + n), t[1]);
        *out = lerp(along_y(first), along_y(first + n * n), t[2]);
    }
}

/// Trilinear sample of a block from its kept coefficients, `[kept][band]`; `local` is `[x, y, z]` in
/// 0..=3 texels. Writes one value per band.
///
/// # Panics
/// If `coefficients` is shorter than the mask says or `out` shorter than `bands`.
pub fn sample(mask: u64, coefficients: &[f32], bands: usize, local: [f32; 3], out: &mut [f32]) {
    out[..bands].fill(0.0);
    Weights::at(local).add(mask, coefficients, 1.0, &mut out[..bands]);
}

/// The weights of one place for all coefficients of a block: computed once, used for every base that
/// is sampled there.
#[derive(Debug, Clone, Copy)]
pub struct Weights {
    /// `wz * wy`, `[z][y]`.
    zy: [f32; EDGE * EDGE],
    /// `wx`.
    x: [f32; EDGE],
}

impl Weights {
    /// Weights at `local`, `[x, y, z]`, each in 0..=3 texels (clamped to that).
    #[inline]
    pub fn at(local: [f32; 3]) -> Weights {
        let [x, y, z] = local.map(along_axis);
        Weights { zy: std::array::from_fn(|i| z[i / EDGE] * y[i % EDGE]), x }
    }

    /// Adds `factor` times the sample to `out`; the number of bands is `out.len()`. Coefficients are
    /// taken in ascending order of their bits.
    ///
    /// # Panics
    /// If `coefficients` is shorter than the mask says.
    #[inline]
    pub fn add(&self, mask: u64, coefficients: &[f32], factor: f32, out: &mut [f32]) {
        match out {
            [r, g, b] => {
                let sum = self.sum::<3>(mask, coefficients);
                *r += factor * sum[0];
                *g += factor * sum[1];
                *b += factor * sum[2];
            }
            [value] => *value += factor * self.sum::<1>(mask, coefficients)[0],
            _ => {
                let mut kept = coefficients.chunks_exact(out.len().max(1));
                let mut left = mask;
                while left != 0 {
                    let weight = factor * self.of(left.trailing_zeros() as usize);
                    left &= left - 1;
                    let coefficient = kept.next().expect("as many coefficients as bits");
                    out.iter_mut().zip(coefficient).for_each(|(o, c)| *o += weight * c);
                }
            }
        }
    }

    #[inline]
    fn sum<const BANDS: usize>(&self, mask: u64, coefficients: &[f32]) -> [f32; BANDS] {
        let kept = &coefficients.as_chunks::<BANDS>().0[..mask.count_ones() as usize];
        let mut sum = [0.0; BANDS];
        let mut left = mask;
        for coefficient in kept {
            let weight = self.of(left.trailing_zeros() as usize & 63);
            left &= left.wrapping_sub(1);
            for band in 0..BANDS {
                sum[band] += weight * coefficient[band];
            }
        }
        sum
    }

    #[inline]
    fn of(&self, bit: usize) -> f32 {
        self.zy[bit / EDGE] * self.x[bit % EDGE]
    }
}

/// The two linear weights at `local`, projected on the four basis functions of one axis.
#[inline]
fn along_axis(local: f32) -> [f32; EDGE] {
    let local = local.clamp(0.0, STRIDE as f32);
    let first = (local as usize).min(EDGE - 2);
    let t = local - first as f32;
    std::array::from_fn(|k| BASIS[k][first] * (1.0 - t) + BASIS[k][first + 1] * t)
}

/// Clamped coordinate in texels, 0..=N-1; NaN becomes 0.
#[inline]
fn texel_coordinate(lattice: u32, coordinate: f64) -> f64 {
    (coordinate - 0.5).max(0.0).min(f64::from(lattice - 1))
}

#[inline]
fn lerp(a: f32, b: f32, t: f32) -> f32 {
    a * (1.0 - t) + b * t
}

#[cfg(test)]
mod tests;

//! The block codec "haar-paper": 4^3 texels of a field to a mask and its kept coefficients, and back.
//!
//! Source: Steele 2009, sections 4.5 and 5.3. Blocks lie at stride 3, so that each holds the forward
//! neighbours of its 3^3 own texels and one block answers any trilinear sample in it. Block `b` along an
//! axis covers the texels `3b ..= 3b + 3`; texels past `N - 1` repeat texel `N - 1`.
//!
//! A coded block is a 64-bit mask and `popcount(mask)` coefficients of every band, `[kept][band]`. Bit `i`
//! stands for the coefficient at `[z][y][x]`, `i = 16 z + 4 y + x` (positions of `haar.rs`), and
//! coefficients follow in ascending order of their bits. Bit 0, the average, is set unless the average is
//! exactly 0 in every band; any other bit is set where any band's magnitude exceeds the threshold.
//!
//! # Decoding, to the bit
//!
//! 1. Mask 0: every texel is `+0`. Mask 1: every texel is the coefficient, unchanged.
//! 2. Otherwise write the coefficients to their places and `+0` to the others, then run the inverse
//!    transform of `haar.rs`: axis x, then y, then z, in binary32 as written there.
//!
//! An encoder never writes `-0`.

use crate::{Field, haar};

pub use crate::haar::EDGE;

/// Texels from one block to the next along an axis.
pub const STRIDE: usize = EDGE - 1;
/// Texels of a block.
pub const TEXELS: usize = haar::SAMPLES;

/// Blocks along an axis of a lattice of `lattice` >= 2 sites: `floor((N - 2) / 3) + 1`.
pub fn blocks_per_axis(lattice: u32) -> u32 {
    lattice.saturating_sub(2) / STRIDE as u32 + 1
}

/// Whether each block, `[z][y][x]`, is one that a sampler asks anywhere in the sites that are `sampled`, or that
/// [`scatter`] takes a texel from which is sampled there.
///
/// # Panics
/// If `sampled` does not have a value for each site.
pub fn near(lattice: u32, sampled: &[bool]) -> Vec<bool> {
    let (n, per_axis) = (lattice as usize, blocks_per_axis(lattice) as usize);
    assert_eq!(sampled.len(), n * n * n, "a value for each site");
    // A point in site `i` lies between the texels `i - 1` and `i + 1`.
    let of = |i: usize| [i.saturating_sub(1), i + 1].map(|texel| (texel / STRIDE).min(per_axis - 1));
    let mut near = vec![false; per_axis * per_axis * per_axis];
    for (site, _) in sampled.iter().enumerate().filter(|(_, sampled)| **sampled) {
        let [x, y, z] = [site % n, site / n % n, site / (n * n)].map(of);
        for block in 0..8 {
            near[(z[block >> 2] * per_axis + y[block >> 1 & 1]) * per_axis + x[block & 1]] = true;
        }
    }
    near
}

/// Reads the texels of block `[x, y, z]` out of a field.
///
/// `texels` are `[z][y][x][band]`, x faster than y, bands fastest.
///
/// # Panics
/// If the block begins outside the field, or `texels` is not `64 * field.bands` long.
pub fn gather(field: &Field, block: [u32; 3], texels: &mut [f32]) {
    let n = field.lattice as usize;
    let bands = field.bands as usize;
    assert_eq!(texels.len(), TEXELS * bands, "a block has 64 texels of {bands} bands");
    let [x, y, z] =
        block.map(|b| std::array::from_fn::<usize, EDGE, _>(|k| (b as usize * STRIDE + k).min(n - 1)));
    for band in 0..bands {
        for (row, target) in texels.chunks_exact_mut(EDGE * bands).enumerate() {
            let start = (z[row / EDGE] * n + y[row % EDGE]) * n;
            for k in 0..EDGE {
                target[k * bands + band] = field.value(band as u32, start + x[k]);
            }
        }
    }
}

/// Writes the texels of block `[x, y, z]` into a field; those past its upper end are dropped.
/// The inverse of [`gather`].
///
/// Neighbouring blocks share a layer of texels, which a lossy coding may have left different. Such a
/// layer belongs to the block that it BEGINS (texel `i` is of block `i / 3`), because a sampler asks that
/// block; this function therefore writes a block's last layer only where no further block begins there.
/// So a decoded field does not depend on the order of its blocks.
///
/// # Panics
/// If the block begins outside the field, or `texels` is not `64 * field.bands` long.
pub fn scatter(field: &mut Field, block: [u32; 3], texels: &[f32]) {
    let n = field.lattice as usize;
    let bands = field.bands as usize;
    assert_eq!(texels.len(), TEXELS * bands, "a block has 64 texels of {bands} bands");
    let last = blocks_per_axis(field.lattice) - 1;
    let start = block.map(|b| b as usize * STRIDE);
    let own: [usize; 3] =
        std::array::from_fn(|axis| (if block[axis] == last { EDGE } else { STRIDE }).min(n - start[axis]));
    for (band, values) in field.values_mut().chunks_exact_mut(n * n * n).enumerate() {
        for z in 0..own[2] {
            for y in 0..own[1] {
                let row = ((start[2] + z) * n + start[1] + y) * n + start[0];
                for x in 0..own[0] {
                    values[row + x] = texels[((z * EDGE + y) * EDGE + x) * bands + band];
                }
            }
        }
    }
}

/// Codes one block: returns its mask and appends the kept coefficients, `[kept][band]`.
///
/// `texels` are as [`gather`] leaves them, finite, of magnitude below `f32::MAX / 2`. `threshold` >= 0 is
/// absolute, in the field's unit. With threshold 0 only coefficients that are exactly 0 are left out.
///
/// # Panics
/// If `texels` is not `64 * bands` long.
pub fn encode(texels: &[f32], bands: usize, threshold: f32, coefficients: &mut Vec<f32>) -> u64 {
    if bands == 3 {
        let mut values: [f32; TEXELS * 3] = texels.try_into().expect("a block has 64 texels of 3 bands");
        return encode_in_place(&mut values, 3, threshold, coefficients);
    }
    encode_in_place(&mut texels.to_vec(), bands, threshold, coefficients)
}

#[inline(always)]
fn encode_in_place(values: &mut [f32], bands: usize, threshold: f32, coefficients: &mut Vec<f32>) -> u64 {
    haar::forward(values, bands);
    let mut mask = 0u64;
    for (bit, coefficient) in values.chunks_exact(bands).enumerate() {
        let limit = if bit == 0 { 0.0 } else { threshold };
        // Written so that a NaN is kept and later found, not dropped in silence.
        if coefficient.iter().any(|c| !matches!(c.abs().partial_cmp(&limit), Some(o) if o.is_le())) {
            mask |= 1 << bit;
            coefficients.extend(coefficient.iter().map(|c| c + 0.0)); // -0 + 0 = +0
        }
    }
    mask
}

/// Expands a coded block to its texels, `[z][y][x][band]`.
///
/// # Panics
/// If `coefficients` is not `popcount(mask) * bands` long or `texels` not `64 * bands`.
pub fn decode(mask: u64, coefficients: &[f32], bands: usize, texels: &mut [f32]) {
    assert_eq!(
        coefficients.len(),
        mask.count_ones() as usize * bands,
        "mask {mask:016x} and its coefficients"
    );
    assert_eq!(texels.len(), TEXELS * bands, "a block has 64 texels of {bands} bands");
    if mask == 1 {
        texels.chunks_exact_mut(bands).for_each(|texel| texel.copy_from_slice(coefficients));
        return;
    }
    texels.fill(0.0);
    if mask == 0 {
        return;
    }
    let mut left = mask;
    for coefficient in coefficients.chunks_exact(bands) {
        let bit = left.trailing_zeros() as usize;
        left &= left - 1;
        texels[bit * bands..][..bands].copy_from_slice(coefficient);
    }
    if bands == 3 { haar::inverse(texels, 3) } else { haar::inverse(texels, bands) }
}

#[cfg(test)]
mod tests;

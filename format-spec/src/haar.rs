//! The unnormalised Haar transform of four samples, and of the 4^3 samples of a block.
//!
//! One axis (Steele 2009, section 2.3, both levels of a sequence of four): the samples `a b c d` become
//!
//! | position | coefficient | basis function over the four samples |
//! |---|---|---|
//! | 0 | average of all | `+1 +1 +1 +1` |
//! | 1 | first half less second half | `+1 +1 -1 -1` |
//! | 2 | detail of the first half | `+1 -1  0  0` |
//! | 3 | detail of the second half | ` 0  0 +1 -1` |
//!
//! Three axes (section 4.5): all of axis z first, then y, then x; the inverse runs x, then y, then z.
//!
//! # Arithmetic, to the bit
//!
//! Every `+`, `-` and `*` below is one IEEE 754 binary32 operation, rounded to nearest even; nothing is
//! fused. A reader in a language with binary64 only may compute each operation in binary64 and round the
//! result to binary32: for one addition the result is the same.
//!
//! Forward, for `a b c d` along an axis:
//! `s = (a + b) * 0.5`, `t = (c + d) * 0.5`, and the coefficients
//! `(s + t) * 0.5`, `(s - t) * 0.5`, `(a - b) * 0.5`, `(c - d) * 0.5`.
//!
//! Inverse, for the coefficients `k0 k1 k2 k3` along an axis:
//! `s = k0 + k1`, `t = k0 - k1`, and the samples `s + k2`, `s - k2`, `t + k3`, `t - k3`.
//!
//! The three axes are done one after the other over the whole block; every band by itself.

/// Samples along one edge of a block.
pub const EDGE: usize = 4;
/// Samples in a block.
pub(crate) const SAMPLES: usize = EDGE * EDGE * EDGE;

/// `BASIS[position][sample]`: the basis function of each coefficient of one axis.
pub(crate) const BASIS: [[f32; EDGE]; EDGE] =
    [[1.0, 1.0, 1.0, 1.0], [1.0, 1.0, -1.0, -1.0], [1.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0]];

/// Forward transform in place: samples `[z][y][x][band]` to coefficients `[z][y][x][band]`.
///
/// # Panics
/// If `values` is not `64 * bands` long.
pub(crate) fn forward(values: &mut [f32], bands: usize) {
    along_each_axis(values, bands, [16, 4, 1], |[a, b, c, d]| {
        let s = (a + b) * 0.5;
        let t = (c + d) * 0.5;
        [(s + t) * 0.5, (s - t) * 0.5, (a - b) * 0.5, (c - d) * 0.5]
    });
}

/// Inverse transform in place: coefficients `[z][y][x][band]` to samples `[z][y][x][band]`.
///
/// # Panics
/// If `values` is not `64 * bands` long.
pub(crate) fn inverse(values: &mut [f32], bands: usize) {
    along_each_axis(values, bands, [1, 4, 16], |[k0, k1, k2, k3]| {
        let s = k0 + k1;
        let t = k0 - k1;
        [s + k2, s - k2, t + k3, t - k3]
    });
}

/// Applies `step` to every line of four, one axis after the other. `strides` are in samples.
#[inline(always)]
fn along_each_axis(
    values: &mut [f32],
    bands: usize,
    strides: [usize; 3],
    step: impl Fn([f32; EDGE]) -> [f32; EDGE],
) {
    assert_eq!(values.len(), SAMPLES * bands, "a block has 64 samples of {bands} bands");
    for stride in strides {
        // The lines of one axis come in groups whose four members are `run` consecutive values each.
        let run = stride * bands;
        for group in values.chunks_exact_mut(EDGE * run) {
            let (first, second) = group.split_at_mut(2 * run);
            let (a, b) = first.split_at_mut(run);
            let (c, d) = second.split_at_mut(run);
            for i in 0..run {
                [a[i], b[i], c[i], d[i]] = step([a[i], b[i], c[i], d[i]]);
            }
        }
    }
}

#[cfg(test)]
mod tests;

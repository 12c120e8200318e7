//! Filling: what the texels of a block should be that no sample reads. Their values are free, and the smoothest ones
//! cost the fewest bits. The filled coefficients `c` minimise `(c - c0)^T G (c - c0) + c^T R c` with a ridge `R` that
//! grows with frequency, the average tied to its own value: `c = c0 - (G + R)^-1 R' c0`, where `R'` is `R` without the
//! average.

use flb_format::blocks::TEXELS;

use super::geometry::Gram;

/// How much the average is tied to its own.
const AVERAGE_RIDGE: f64 = 2e-5;
/// Ridge of a frequency of 1.
const RIDGE: f64 = 1e-3;

/// `[coefficient]`
static RIDGES: [f64; TEXELS] = {
    let mut ridges = [0.0; TEXELS];
    let mut i = 0;
    while i < TEXELS {
        ridges[i] = ridge(i);
        i += 1;
    }
    ridges
};

const fn ridge(i: usize) -> f64 {
    let (x, y, z) = (i % 4, i / 4 % 4, i / 16);
    if i == 0 { AVERAGE_RIDGE } else { RIDGE * (x * x + y * y + z * z) as f64 }
}

/// `G` times what filling took from the coefficients, which it was chosen to make `R` times those that are left.
#[inline(always)]
pub(super) fn filled_slope(filled: &[f32; TEXELS]) -> [f32; TEXELS] {
    std::array::from_fn(|i| if i == 0 { 0.0 } else { RIDGES[i] as f32 * filled[i] })
}

/// Fills coefficients of one place in several fields, by Cholesky's decomposition.
#[inline(always)]
pub(super) fn fill(gram: &Gram, blocks: &mut [[f32; TEXELS]]) {
    const N: usize = TEXELS;
    // Rows of the lower triangle, the rest 0; columns of it follow for the way back.
    let mut lower = vec![[0.0f32; N]; N];
    let mut scale = [0.0f32; N];
    for i in 0..N {
        let (above, rest) = lower.split_at_mut(i);
        let row = &mut rest[0];
        for (j, other) in above.iter().enumerate() {
            row[j] = (gram.row(i)[j] - dot(row, other, j)) * scale[j];
        }
        let left = gram.row(i)[i] + RIDGES[i] as f32 - dot(row, row, i);
        row[i] = left.max(1e-12).sqrt();
        scale[i] = 1.0 / row[i];
    }
    // Right-hand sides side by side: [coefficient][block].
    let count = blocks.len();
    let mut x = vec![0.0f32; N * count];
    for (b, block) in blocks.iter().enumerate() {
        (1..N).for_each(|i| x[i * count + b] = RIDGES[i] as f32 * block[i]);
    }
    for i in 0..N {
        let (done, rest) = x.split_at_mut(i * count);
        let row = &mut rest[..count];
        for k in 0..i {
            subtract(row, lower[i][k], &done[k * count..][..count]);
        }
        row.iter_mut().for_each(|r| *r *= scale[i]);
    }
    for i in (0..N).rev() {
        let (head, done) = x.split_at_mut((i + 1) * count);
        let row = &mut head[i * count..];
        for k in i + 1..N {
            subtract(row, lower[k][i], &done[(k - i - 1) * count..][..count]);
        }
        row.iter_mut().for_each(|r| *r *= scale[i]);
    }
    for (b, block) in blocks.iter_mut().enumerate() {
        (0..N).for_each(|i| block[i] -= x[i * count + b]);
    }
}

/// Of the first `count` numbers; in whole eights, as those behind are 0 in one of them.
#[inline(always)]
fn dot(a: &[f32; TEXELS], b: &[f32; TEXELS], count: usize) -> f32 {
    let mut sums = [0.0f32; 8];
    for (a, b) in a.as_chunks::<8>().0.iter().zip(b.as_chunks::<8>().0).take(count.div_ceil(8)) {
        (0..8).for_each(|k| sums[k] += a[k] * b[k]);
    }
    ((sums[0] + sums[4]) + (sums[2] + sums[6])) + ((sums[1] + sums[5]) + (sums[3] + sums[7]))
}

#[inline(always)]
fn subtract(row: &mut [f32], factor: f32, other: &[f32]) {
    row.iter_mut().zip(other).for_each(|(r, o)| *r -= factor * o);
}

//! Filling: what the texels of a block should be that no sample reads. Their values are free, and the smoothest ones cost
//! the fewest bits. The filled coefficients `c` minimise `(c - c0)^T G (c - c0) + c^T R c` with a ridge `R` that grows with
//! frequency, the average tied to its own value: `c = c0 - (G + R)^-1 R' c0`, where `R'` is `R` without the average.

use flb_format::blocks::TEXELS;

use super::geometry::GRAM;

/// How much the average is tied to its own.
const AVERAGE_RIDGE: f64 = 2e-5;
/// Ridge of a frequency of 1.
const RIDGE: f64 = 1e-3;

fn ridge(i: usize) -> f64 {
    let squares = [i % 4, i / 4 % 4, i / 16].iter().map(|k| (k * k) as f64).sum::<f64>();
    if i == 0 { AVERAGE_RIDGE } else { RIDGE * squares }
}

/// Fills all of `blocks`, coefficients of one place in several fields, by Cholesky's decomposition.
pub fn fill(gram: &[f32; GRAM], blocks: &mut [[f32; TEXELS]]) {
    const N: usize = TEXELS;
    let mut lower = vec![0.0f64; N * N];
    for i in 0..N {
        for j in 0..=i {
            let tied = if i == j { ridge(i) } else { 0.0 };
            let (upper, row) = lower.split_at(i * N);
            let other = if i == j { &row[..j] } else { &upper[j * N..][..j] };
            let mut sums = [0.0f64; 4];
            for (k, (a, b)) in row[..j].iter().zip(other).enumerate() {
                sums[k % 4] += a * b;
            }
            let sum = f64::from(gram[i * N + j]) + tied - ((sums[0] + sums[1]) + (sums[2] + sums[3]));
            lower[i * N + j] = if i == j { libm::sqrt(sum.max(1e-12)) } else { sum / lower[j * N + j] };
        }
    }
    // Right-hand sides side by side: [coefficient][block].
    let count = blocks.len();
    let mut x: Vec<f32> = (0..N)
        .flat_map(|i| blocks.iter().map(move |block| if i == 0 { 0.0 } else { (ridge(i) as f32) * block[i] }))
        .collect();
    for i in 0..N {
        let (done, rest) = x.split_at_mut(i * count);
        let row = &mut rest[..count];
        for k in 0..i {
            subtract(row, lower[i * N + k] as f32, &done[k * count..][..count]);
        }
        let scale = (1.0 / lower[i * N + i]) as f32;
        row.iter_mut().for_each(|r| *r *= scale);
    }
    for i in (0..N).rev() {
        let (head, done) = x.split_at_mut((i + 1) * count);
        let row = &mut head[i * count..];
        for k in i + 1..N {
            subtract(row, lower[k * N + i] as f32, &done[(k - i - 1) * count..][..count]);
        }
        let scale = (1.0 / lower[i * N + i]) as f32;
        row.iter_mut().for_each(|r| *r *= scale);
    }
    for (b, block) in blocks.iter_mut().enumerate() {
        (0..N).for_each(|i| block[i] -= x[i * count + b]);
    }
}

#[inline]
fn subtract(row: &mut [f32], factor: f32, other: &[f32]) {
    row.iter_mut().zip(other).for_each(|(r, o)| *r -= factor * o);
}

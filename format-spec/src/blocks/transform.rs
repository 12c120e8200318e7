//! The integer transform of a block: 64 coefficients to 4^3 texels, exactly, and back in floats for encoders.
//!
//! One axis has four orthogonal rows in small integers. The rows of [`SMOOTH`] have the shape of H.264's 4-point
//! transform, each times a factor that makes high frequencies coarser, since a trilinear sample hardly sees them:
//!
//! | k | row | norm / norm of row 0 |
//! |---|---|---|
//! | 0 | `3 3 3 3` | 1 |
//! | 1 | `4 2 -2 -4` | 1.054 |
//! | 2 | `4 -4 -4 4` | 1.333 |
//! | 3 | `3 -6 6 -3` | 1.581 |
//!
//! [`HAAR`] has the rows of the Haar transform. Coefficient `i = 16 kz + 4 ky + kx`, texel `i = 16 z + 4 y + x`.

use std::ops::{Add, Mul};

/// Texels of a block along an axis.
pub const EDGE: usize = 4;
/// Texels, and coefficients, of a block.
pub const TEXELS: usize = EDGE * EDGE * EDGE;

/// `[k][texel]`: the rows of one axis.
pub type Rows = [[i32; EDGE]; EDGE];

/// Rows of the coding `classed`.
pub const SMOOTH: Rows = [[3, 3, 3, 3], [4, 2, -2, -4], [4, -4, -4, 4], [3, -6, 6, -3]];
/// Rows of the coding `haar`.
pub const HAAR: Rows = [[3, 3, 3, 3], [3, 3, -3, -3], [5, -5, 0, 0], [0, 0, 5, -5]];

/// A texel of a block whose only coefficient is an average of 1: 16 steps' sixteenths times 3 along each axis.
pub const AVERAGE_TEXEL: i32 = AVERAGE_COEFFICIENT * 27;
/// Coefficient 0 of an average of 1; a coefficient is in sixteenths of a step.
pub const AVERAGE_COEFFICIENT: i32 = 16;

/// Coefficients to texels, axis x, then y, then z. No sum of integers overflows: averages are below 2^15, other
/// coefficients below 2^14, and the rows add at most 15 times a value along an axis.
#[inline(always)]
pub fn inverse<T: Copy + Add<Output = T> + Mul<Output = T>>(
    rows: &[[T; EDGE]; EDGE],
    values: &mut [T; TEXELS],
) {
    for stride in [1, EDGE, EDGE * EDGE] {
        for line in lines(stride) {
            let c: [T; EDGE] = std::array::from_fn(|k| values[line + k * stride]);
            for t in 0..EDGE {
                values[line + t * stride] =
                    c[0] * rows[0][t] + c[1] * rows[1][t] + c[2] * rows[2][t] + c[3] * rows[3][t];
            }
        }
    }
}

/// Rows for sums of coefficients in floats.
pub const fn in_floats(rows: &Rows) -> [[f32; EDGE]; EDGE] {
    let mut floats = [[0.0; EDGE]; EDGE];
    let mut i = 0;
    while i < EDGE * EDGE {
        floats[i / EDGE][i % EDGE] = rows[i / EDGE][i % EDGE] as f32;
        i += 1;
    }
    floats
}

/// Texels to coefficients in floats: [`inverse`] of them, unrounded, gives the texels back.
#[inline(always)]
pub fn forward(rows: &Rows, texels: &mut [f32; TEXELS]) {
    let rows = rows.map(|row| row.map(|r| r as f32 / row.iter().map(|r| r * r).sum::<i32>() as f32));
    for stride in [1, EDGE, EDGE * EDGE] {
        for line in lines(stride) {
            let v: [f32; EDGE] = std::array::from_fn(|k| texels[line + k * stride]);
            for (k, row) in rows.iter().enumerate() {
                texels[line + k * stride] = v[0] * row[0] + v[1] * row[1] + v[2] * row[2] + v[3] * row[3];
            }
        }
    }
}

/// First index of each of the 16 lines along the axis of a stride.
#[inline(always)]
fn lines(stride: usize) -> impl Iterator<Item = usize> {
    (0..EDGE * EDGE).map(move |i| match stride {
        1 => i * EDGE,
        EDGE => i / EDGE * (EDGE * EDGE) + i % EDGE,
        _ => i,
    })
}

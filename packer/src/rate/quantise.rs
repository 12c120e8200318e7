//! Coefficients to integers: coordinate descent on `e^T G e`, the error that samples at surfaces will have. It costs no
//! bits and gains 1.5 to 1.8 dB over rounding.

use flb_format::blocks::TEXELS;

use super::choose::{WIDTHS, nearest_kept};
use super::fill;
use super::geometry::Gram;

/// Rounds of the descent at most.
const SWEEPS: usize = 3;
/// Largest magnitude of an average.
const MAX_AVERAGE: f32 = 32_767.0;

/// Half of the number of codes of a width.
const HALF: [f32; WIDTHS] = {
    let mut half = [0.0; WIDTHS];
    let mut width = 1;
    while width < WIDTHS {
        half[width] = (1 << (width - 1)) as f32;
        width += 1;
    }
    half
};

/// The values that a block's coefficients may take.
pub(super) enum Grid {
    /// Widths of `classed`, by index.
    Widths([u8; TEXELS]),
    /// A width of `haar` and whether each coefficient is kept, by index.
    Mask(u8, [bool; TEXELS]),
}

impl Grid {
    /// Nearest value in half steps, of a coefficient that has bits.
    #[inline(always)]
    fn nearest(&self, i: usize, value: f32) -> f32 {
        match self {
            Grid::Widths(widths) => {
                let half = HALF[usize::from(widths[i]) % WIDTHS];
                2.0 * value.floor().max(-half).min(half - 1.0) + 1.0
            }
            Grid::Mask(width, _) => nearest_kept(value, HALF[usize::from(*width) % WIDTHS]),
        }
    }

    #[inline(always)]
    fn is_free(&self, i: usize) -> bool {
        match self {
            Grid::Widths(widths) => widths[i] > 0,
            Grid::Mask(_, kept) => kept[i],
        }
    }
}

/// The nearest average in half steps of a block, of which so many steps are an average of 1.
#[inline(always)]
fn average(value: f32, steps: f32) -> f32 {
    2.0 * steps * whole(value / steps)
}

/// The nearest average.
#[inline(always)]
pub(super) fn whole(value: f32) -> f32 {
    (value + 0.5).floor().clamp(-MAX_AVERAGE, MAX_AVERAGE)
}

/// Integers in half steps, and their error. `filled` is in steps of the block; its error counts as that of the unfilled
/// coefficients, since [`fill::filled_slope`] tells their difference. The average stays as it starts where the block's
/// halvings depend on it.
#[inline(always)]
pub(super) fn descend(
    filled: &[f32; TEXELS],
    gram: &Gram,
    grid: &Grid,
    steps_per_average: f32,
    keep_average: bool,
) -> ([i16; TEXELS], f32) {
    let mut v = [0.0f32; TEXELS];
    let (mut free, mut count) = ([0u8; TEXELS], 0);
    v[0] = average(filled[0], steps_per_average);
    for i in 1..TEXELS {
        if grid.is_free(i) {
            v[i] = grid.nearest(i, filled[i]);
            free[count] = i as u8;
            count += 1;
        }
    }
    // Half of the slope of the error along each coefficient.
    let mut slope = fill::filled_slope(filled);
    for j in 0..TEXELS {
        let error = filled[j] - 0.5 * v[j];
        let row = gram.row(j);
        (0..TEXELS).for_each(|i| slope[i] += row[i] * error);
    }
    for _ in 0..SWEEPS {
        let mut changed = false;
        if !keep_average {
            let next = average(0.5 * v[0] + slope[0] * gram.inverse[0], steps_per_average);
            changed |= step(gram, &mut slope, &mut v, 0, next);
        }
        for i in free[..count].iter().map(|i| usize::from(*i) % TEXELS) {
            let next = grid.nearest(i, 0.5 * v[i] + slope[i] * gram.inverse[i]);
            changed |= step(gram, &mut slope, &mut v, i, next);
        }
        if !changed {
            break;
        }
    }
    let mut errors = [0.0f32; 8];
    for first in (0..TEXELS).step_by(8) {
        for i in 0..8 {
            errors[i] += slope[first + i] * (filled[first + i] - 0.5 * v[first + i]);
        }
    }
    let error: f32 = errors.iter().sum();
    let mut out = v.map(|v| v as i16);
    out[0] = (v[0] / (2.0 * steps_per_average)) as i16;
    (out, error.max(0.0))
}

/// Moves coefficient `i` to a value in half steps.
#[inline(always)]
fn step(gram: &Gram, slope: &mut [f32; TEXELS], v: &mut [f32; TEXELS], i: usize, next: f32) -> bool {
    let moved = 0.5 * (next - v[i]);
    if moved == 0.0 {
        return false;
    }
    v[i] = next;
    let row = gram.row(i);
    (0..TEXELS).for_each(|j| slope[j] -= row[j] * moved);
    true
}

//! What a page is worth to a reader that streams: the squared error that it removes (SPEC.md, section 5.1).
//!
//! All transforms here have orthogonal rows, so that the squares of a block's texels sum to the squares of its
//! coefficients, each times the squares of its rows: no field is decoded. Sums are in binary64, in the order of the
//! page.

use flb_format::blocks::{CodedBlock, Coding, EDGE, Head, TEXELS};
use flb_format::container::payload::BlockPage;
use flb_format::container::records::MAX_MAGNITUDE;

/// What coefficient 0 of a block is of its average.
const AVERAGE_TEXEL: f64 = flb_format::blocks::transform::AVERAGE_TEXEL as f64;
/// Squares of the rows of `haar-paper` along an axis: two of 4 texels, two of 2.
const PAPER_SQUARES: [f64; EDGE] = [4.0, 4.0, 2.0, 2.0];

/// Of a page of values of a field whose value in empty space is `unit`, against a field of zeros.
pub(crate) fn of_values(values: &[f32], unit: f32) -> f32 {
    let sum: f64 = values.iter().map(|value| square(f64::from(*value))).sum();
    priority(sum, unit)
}

/// Of a page of `haar-paper`, against a field of zeros. Texels that two blocks share count in both.
pub(crate) fn of_blocks(page: &BlockPage, bands: usize, unit: f32) -> f32 {
    let squares = squares_of(&PAPER_SQUARES);
    let mut sum = 0.0;
    for block in 0..page.masks.len() {
        let (mask, coefficients) = page.block(block, bands);
        let kept = (0..TEXELS).filter(|c| mask >> c & 1 == 1);
        for (c, values) in kept.zip(coefficients.chunks_exact(bands)) {
            sum += squares[c] * values.iter().map(|value| square(f64::from(*value))).sum::<f64>();
        }
    }
    priority(sum, unit)
}

/// Of the averages of a base, against a field of zeros. Blocks are `[block][component]`.
pub(crate) fn of_averages(head: &Head, blocks: &[CodedBlock]) -> f32 {
    let weights = weights(head);
    let of_block = |(i, block): (usize, &CodedBlock)| {
        weights[i % weights.len()] * square(f64::from(block.values[0]) * AVERAGE_TEXEL)
    };
    let sum: f64 = blocks.iter().enumerate().map(of_block).sum();
    priority(sum * TEXELS as f64, head.peak)
}

/// Of a page of detail, against the averages of its blocks. Blocks are `[block][component]`.
pub(crate) fn of_detail(head: &Head, coding: &Coding, blocks: &[CodedBlock]) -> f32 {
    let rows = coding.rows().map(|row| f64::from(row.iter().map(|r| r * r).sum::<i32>()));
    let squares = squares_of(&rows);
    let weights = weights(head);
    let mut sum = 0.0;
    for block in blocks.chunks_exact(weights.len()) {
        let half_step = f64::from(8 >> head.halvings(block[0].values[0]));
        let of_component = |component: &CodedBlock| -> f64 {
            let of = |(value, row): (&i16, &f64)| square(f64::from(*value) * half_step) * row;
            component.values[1..].iter().zip(&squares[1..]).map(of).sum()
        };
        sum += block.iter().zip(&weights).map(|(block, weight)| weight * of_component(block)).sum::<f64>();
    }
    priority(sum, head.peak)
}

/// `[component]` squares of the light of a texel of 1, summed over bands.
fn weights(head: &Head) -> Vec<f64> {
    let colors = head.colors();
    let bands = colors.chunks_exact(head.bands as usize);
    bands.map(|color| color.iter().map(|c| square(f64::from(*c))).sum()).collect()
}

/// `[coefficient]` sum of the squares of its texels, from those of its rows.
fn squares_of(rows: &[f64; EDGE]) -> [f64; TEXELS] {
    std::array::from_fn(|c| rows[c % EDGE] * rows[c / EDGE % EDGE] * rows[c / (EDGE * EDGE)])
}

fn square(value: f64) -> f64 {
    value * value
}

fn priority(sum: f64, unit: f32) -> f32 {
    (sum / square(f64::from(unit))).min(f64::from(MAX_MAGNITUDE)) as f32
}

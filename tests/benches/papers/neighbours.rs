//! What blocks without their forward neighbours would take: the papers have 42 % of the size, and samples of more than
//! six times the time.
//!
//! Both ways keep blocks of 4^3 texels near geometry, coded alike. With neighbours, blocks lie at stride 3 and one
//! answers a sample. Without, they lie at stride 4, and a sample that lies between two blocks along an axis needs both:
//! up to eight. In both a sample decodes each block that it needs, and then mixes eight texels.

use std::hint::black_box;

use flb_format::matter::Class;
use flb_format::{Field, SpeciesFields, block};
use rayon::prelude::*;

use crate::light::timed;

/// The papers' threshold, of what lies outside of the plant.
const THRESHOLD: f32 = 0.05;
const BANDS: usize = 3;

/// Coded blocks of a field.
struct Blocks {
    stride: usize,
    per_axis: usize,
    /// `[block]`: mask, and where its coefficients begin; mask 0 away from geometry.
    heads: Vec<(u64, usize)>,
    coefficients: Vec<f32>,
}

impl Blocks {
    fn of(field: &Field, stride: usize, is_needed: &[bool], threshold: f32) -> Blocks {
        let n = field.lattice as usize;
        let per_axis = if stride == 4 { n / 4 } else { block::blocks_per_axis(field.lattice) as usize };
        let mut blocks = Blocks { stride, per_axis, heads: Vec::new(), coefficients: Vec::new() };
        let mut texels = vec![0.0; block::TEXELS * BANDS];
        for (b, is_needed) in is_needed.iter().enumerate() {
            let first = blocks.coefficients.len();
            let mut mask = 0;
            if *is_needed {
                let at =
                    [b % per_axis, b / per_axis % per_axis, b / (per_axis * per_axis)].map(|c| c * stride);
                for t in 0..block::TEXELS {
                    let [x, y, z] = [at[0] + t % 4, at[1] + t / 4 % 4, at[2] + t / 16].map(|c| c.min(n - 1));
                    for band in 0..BANDS {
                        texels[t * BANDS + band] = field.band(band as u32)[(z * n + y) * n + x];
                    }
                }
                mask = block::encode(&texels, BANDS, threshold, &mut blocks.coefficients);
            }
            blocks.heads.push((mask, first));
        }
        blocks
    }

    /// 12 bytes of mask and index a block, and the floats.
    fn bytes(&self) -> usize {
        12 * self.heads.len() + 4 * self.coefficients.len()
    }

    /// Of a cell of eight texels, whose lowest is `low`: the mean of these.
    fn sample(&self, low: [usize; 3], texels: &mut [f32; block::TEXELS * BANDS]) -> [f32; BANDS] {
        let texel = |corner: usize| [0, 1, 2].map(|axis| low[axis] + (corner >> axis & 1));
        // With neighbours all eight texels lie in the block of the lowest.
        let of = |corner: usize| if self.stride == 4 { texel(corner) } else { low };
        let block = |corner: usize| of(corner).map(|c| (c / self.stride).min(self.per_axis - 1));
        let mut sum = [0.0; BANDS];
        for first in (0..8).filter(|first| (0..*first).all(|before| block(before) != block(*first))) {
            let at = block(first);
            let (mask, begin) = self.heads[(at[2] * self.per_axis + at[1]) * self.per_axis + at[0]];
            let kept = mask.count_ones() as usize * BANDS;
            block::decode(mask, &self.coefficients[begin..][..kept], BANDS, texels);
            for corner in (first..8).filter(|corner| block(*corner) == at) {
                let texel = texel(corner);
                let [x, y, z] = [0, 1, 2].map(|axis| texel[axis] - at[axis] * self.stride);
                for (band, sum) in sum.iter_mut().enumerate() {
                    *sum += texels[((z * 4 + y) * 4 + x) * BANDS + band] / 8.0;
                }
            }
        }
        sum
    }
}

pub(crate) fn table(fields: &SpeciesFields) {
    let n = fields.medium.grid.lattice;
    let sites: Vec<usize> =
        (0..fields.medium.class.len()).filter(|site| fields.medium.class[*site] != Class::Empty).collect();
    let is_sampled: Vec<bool> = fields.medium.class.iter().map(|class| *class != Class::Empty).collect();
    let near = block::near(n, &is_sampled);
    let apart = texels_near(n as usize, &sites);
    let code = |stride: usize| -> Vec<Blocks> {
        let is_needed = if stride == 4 { &apart } else { &near };
        let of = |(base, field): &(u8, Field)| {
            Blocks::of(field, stride, is_needed, if *base == 0 { 18.0 * THRESHOLD } else { THRESHOLD })
        };
        fields.bases.par_iter().map(of).collect()
    };
    let [with, without] = [3, 4].map(code);
    let time = |bases: &[Blocks]| {
        let mut texels = [0.0; block::TEXELS * BANDS];
        let mut best = f64::INFINITY;
        for _ in 0..3 {
            let (_, seconds) = timed(|| {
                for site in &sites {
                    let n = n as usize;
                    let low = [site % n, site / n % n, site / (n * n)].map(|c| c.min(n - 2));
                    // Four bases: three suns and the sky.
                    for base in &bases[..4] {
                        black_box(base.sample(low, &mut texels));
                    }
                }
            });
            best = best.min(1e9 * seconds / sites.len() as f64);
        }
        best
    };
    println!(
        "Forward neighbours, `haar-paper` at T {THRESHOLD} near geometry, one thread, four bases a sample:\n"
    );
    println!("| blocks | MB | share | ns a sample | times |\n|---|---:|---:|---:|---:|");
    let [whole, small] = [&with, &without].map(|bases| bases.iter().map(Blocks::bytes).sum::<usize>() as f64);
    let [one, many] = [&with, &without].map(|bases| time(bases));
    println!("| with | {:.1} | 1 | {one:.0} | 1 |", whole / 1e6);
    println!("| without | {:.1} | {:.2} | {many:.0} | {:.1} |", small / 1e6, small / whole, many / one);
    println!("| theirs, without | - | 0.42 | - | over 6 |\n");
}

/// Whether each block of 4^3 texels at stride 4 holds a texel that a sample in one of the sites reads.
fn texels_near(n: usize, sites: &[usize]) -> Vec<bool> {
    let per_axis = n / 4;
    let mut near = vec![false; per_axis * per_axis * per_axis];
    for site in sites {
        let at = [site % n, site / n % n, site / (n * n)];
        for corner in 0..27 {
            let step = [corner % 3, corner / 3 % 3, corner / 9];
            let [x, y, z] = [0, 1, 2].map(|a: usize| (at[a] + step[a]).saturating_sub(1).min(n - 1) / 4);
            near[(z * per_axis + y) * per_axis + x] = true;
        }
    }
    near
}

//! One pass over blocks: every base coded at its step, and the error measured at surfaces.

use flb_format::blocks::classes::DETAILS;
use flb_format::blocks::head::Head;
use flb_format::blocks::{CodedBlock, MAX_HALVINGS, TEXELS, transform};
use rayon::prelude::*;

use super::choose::{self, Chooser, Details};
use super::geometry::Geometry;
use super::quantise::{self, Grid};
use super::ready::{Filled, Ready};

/// A component is kept if its mean square is above this share of a square step.
const WORTH: f64 = 0.025;

/// Everything that a pass reads.
#[derive(Clone, Copy)]
pub struct Pass<'a> {
    /// Shared by all bases.
    pub geometry: &'a Geometry,
    /// `[base]`
    pub ready: &'a [Ready<'a>],
    /// Of all bases.
    pub filled: &'a Filled,
    /// For the first component and the others; none for `haar`.
    pub choosers: Option<&'a [Chooser; 2]>,
    /// Weighted square error, in steps, that a bit is worth.
    pub lambda: f32,
    /// Steps are halved until at most this share of a block's average.
    pub relative: Option<f32>,
}

/// What a base is coded with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Try {
    /// Index of the base in the pass.
    pub base: usize,
    /// Step of an orthonormal coefficient, relative to the peak.
    pub step: f32,
    /// Components kept.
    pub components: usize,
}

/// A coded base.
pub struct Coded {
    /// What it was coded with.
    pub tried: Try,
    /// `[block][component]`
    pub blocks: Vec<CodedBlock>,
    /// Sum over blocks of the square error that `G` expects, relative to the peak.
    pub expected: f64,
}

/// Error at surfaces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// Root of the mean square over points and bands, relative to the peak.
    pub rms: f64,
    /// 99th percentile over the darkest tenth of points of the norm of the error relative to that of the light.
    pub dark: f64,
}

/// Averages, in steps, below which a block's steps are halved, so that a step is at most `relative` of its average.
pub fn thresholds(relative: Option<f32>) -> [i32; MAX_HALVINGS as usize] {
    std::array::from_fn(|k| match relative {
        // The mean of a block is an eighth of its average.
        Some(share) => (libm::ceilf(8.0 / (share * (1u32 << k) as f32)) as i32).clamp(0, 32768),
        None => 0,
    })
}

/// Halvings of a block with this average.
pub fn halvings(average: i32, thresholds: &[i32; MAX_HALVINGS as usize]) -> u32 {
    thresholds.iter().map(|t| u32::from(average.abs() < *t)).sum()
}

impl Pass<'_> {
    /// Components of a base that are worth coding at a step.
    pub fn kept(&self, base: usize, step: f32) -> usize {
        let limit = f64::from(step) * f64::from(step) * WORTH;
        let moments = &self.ready[base].moment;
        1 + moments[1..].iter().take_while(|moment| **moment > limit).count()
    }

    /// Order of the coefficients of a base.
    pub fn order(&self, base: usize) -> [u8; TEXELS] {
        let axes = self.ready[base].axes;
        Head {
            bands: 1,
            axes,
            unit: 1.0,
            thresholds: [0; 3],
            peak: 0.0,
            rms_error: 0.0,
            dark_error: 0.0,
            rotation: vec![1.0],
        }
        .order()
    }

    /// Codes every `stride`-th block of the bases tried.
    pub fn code(&self, tries: &[Try], stride: usize) -> Vec<Coded> {
        let orders: Vec<[u8; TEXELS]> = tries.iter().map(|t| self.order(t.base)).collect();
        let limits = thresholds(self.relative);
        let ranks: Vec<usize> = (0..self.geometry.map.len()).step_by(stride).collect();
        let blocks: Vec<(Vec<CodedBlock>, Vec<f32>)> = ranks
            .par_iter()
            .map(|rank| {
                let gram = self.geometry.gram(*rank);
                let (mut coded, mut errors) = (Vec::new(), Vec::new());
                for (tried, order) in tries.iter().zip(&orders) {
                    let mut exact = vec![[0.0; TEXELS]; self.ready[tried.base].bands()];
                    self.ready[tried.base].texels(self.geometry, *rank, &mut exact);
                    let average = self.filled.get(*rank, tried.base, 0)[0];
                    let fine = halvings(libm::roundf(average / tried.step) as i32, &limits);
                    let mut error = 0.0;
                    for (c, exact) in exact.iter_mut().enumerate().take(tried.components) {
                        transform::forward(self.geometry.rows, exact);
                        let filled = self.filled.get(*rank, tried.base, c);
                        let (block, e) = self.block(c, exact, filled, &gram, order, tried.step, fine);
                        coded.push(block);
                        error += e;
                    }
                    errors.push(error);
                }
                (coded, errors)
            })
            .collect();
        let mut out: Vec<Coded> = tries
            .iter()
            .map(|t| Coded {
                tried: *t,
                blocks: Vec::with_capacity(ranks.len() * t.components),
                expected: 0.0,
            })
            .collect();
        for (blocks, errors) in blocks {
            let mut blocks = &blocks[..];
            for (coded, error) in out.iter_mut().zip(errors) {
                let (own, rest) = blocks.split_at(coded.tried.components);
                coded.blocks.extend(own);
                coded.expected += f64::from(error);
                blocks = rest;
            }
        }
        out
    }

    /// One component of one block.
    #[allow(clippy::too_many_arguments)] // all of them differ from block to block
    fn block(
        &self,
        component: usize,
        exact: &[f32; TEXELS],
        filled: &[f32; TEXELS],
        gram: &[f32; super::geometry::GRAM],
        order: &[u8; TEXELS],
        step: f32,
        fine: u32,
    ) -> (CodedBlock, f32) {
        let per_step = (1u32 << fine) as f32 / step;
        let details = details(filled, gram, order, per_step);
        let (class, grid) = match self.choosers {
            Some(choosers) => {
                let chooser = &choosers[component.min(1)];
                let class = chooser.choose(&choose::costs(&details, self.lambda));
                (class, Grid::Widths(choose::by_index(&chooser.widths[usize::from(class)], order)))
            }
            None => {
                let (width, mask) = choose::choose_mask(&details, self.lambda);
                let mut kept = [false; TEXELS];
                (1..TEXELS).for_each(|place| kept[usize::from(order[place])] = mask >> place & 1 == 1);
                (u16::from(width), Grid::Mask(width, kept))
            }
        };
        let (exact, start) = (exact.map(|v| v * per_step), filled.map(|v| v * per_step));
        let keep_average = self.relative.is_some();
        let (values, error) = quantise::descend(&exact, &start, gram, &grid, fine, keep_average);
        let mut block = CodedBlock { class, values: values.map(|v| v as i16) };
        block.values[0] = (values[0] >> (1 + fine)) as i16;
        if self.choosers.is_none() {
            // The descent may have left a width that is more than the values need.
            let largest = block.values[1..].iter().map(|v| v.unsigned_abs() / 2).max().unwrap_or(0);
            block.class = if largest == 0 { 0 } else { 1 + largest.next_power_of_two().ilog2() as u16 };
        }
        (block, error / (per_step * per_step))
    }

    /// Samples to train classes of a component by.
    pub fn training(&self, tried: &Try, component: usize, stride: usize) -> Vec<Details> {
        let limits = thresholds(self.relative);
        let order = self.order(tried.base);
        let ranks: Vec<usize> = (tried.base % stride..self.geometry.map.len()).step_by(stride).collect();
        let sample = |rank: &usize| {
            let average = self.filled.get(*rank, tried.base, 0)[0];
            let fine = halvings(libm::roundf(average / tried.step) as i32, &limits);
            let filled = self.filled.get(*rank, tried.base, component);
            details(filled, &self.geometry.gram(*rank), &order, (1u32 << fine) as f32 / tried.step)
        };
        ranks.par_iter().map(sample).collect()
    }

    /// Mean square error over points and bands that `G` expects of blocks coded at a stride, relative to the peak.
    pub fn expected(&self, coded: &Coded, stride: usize) -> f64 {
        let ready = &self.ready[coded.tried.base];
        let sites = self.geometry.counted_sites().max(1) as f64;
        let dropped: f64 = ready.sampled[coded.tried.components..].iter().sum();
        (coded.expected * stride as f64 / sites + dropped) / ready.bands() as f64
    }

    /// The error of a coded base at surfaces. The rotation is orthonormal, so it is measured across components.
    pub fn measure(&self, coded: &Coded) -> Quality {
        let (ready, geometry) = (&self.ready[coded.tried.base], self.geometry);
        let (n, bands, step) = (ready.field.lattice as usize, ready.bands(), coded.tried.step);
        let limits = thresholds(self.relative);
        let mut errors = vec![vec![0.0f32; n * n * n]; bands];
        let mut texels = vec![[0.0; TEXELS]; bands];
        for rank in 0..geometry.map.len() {
            ready.texels(geometry, rank, &mut texels);
            let blocks = &coded.blocks[rank * coded.tried.components..][..coded.tried.components];
            let scale = MAX_HALVINGS - halvings(i32::from(blocks[0].values[0]), &limits);
            for (texels, block) in texels.iter_mut().zip(blocks) {
                let mut values = block.values.map(|v| i32::from(v) << scale);
                values[0] = i32::from(block.values[0]) * transform::AVERAGE_COEFFICIENT;
                transform::inverse(geometry.rows, &mut values);
                (0..TEXELS).for_each(|t| texels[t] -= step / 16.0 * values[t] as f32);
            }
            let [x, y, z] = geometry.map.first_texel(rank);
            for (errors, texels) in errors.iter_mut().zip(&texels) {
                for (i, row) in texels.as_chunks::<4>().0.iter().enumerate() {
                    let first = ((z + i / 4) * n + y + i % 4) * n + x;
                    errors[first..][..4].copy_from_slice(row);
                }
            }
        }
        let square = |point: usize| -> f64 {
            let errors = errors.iter().map(|e| f64::from(geometry.points.sample(point, n, e)) / 216.0);
            errors.map(|e| e * e).sum()
        };
        let mut relative = Vec::with_capacity(ready.dark.len());
        let mut dark = ready.dark.iter().peekable();
        let mut sum = 0.0;
        for point in 0..geometry.points.len() {
            let square = square(point);
            sum += square;
            if let Some((_, light)) = dark.next_if(|(dark, _)| *dark as usize == point) {
                relative.push(libm::sqrt(square) / f64::from(*light).max(1e-12));
            }
        }
        relative.sort_unstable_by(f64::total_cmp);
        let dark = relative.get((relative.len().max(1) - 1) * 99 / 100).copied().unwrap_or(0.0);
        Quality { rms: libm::sqrt(sum / (geometry.points.len() * bands).max(1) as f64), dark }
    }
}

fn details(
    filled: &[f32; TEXELS],
    gram: &[f32; super::geometry::GRAM],
    order: &[u8; TEXELS],
    per_step: f32,
) -> Details {
    let mut details = Details { value: [0.0; DETAILS], weight: [0.0; DETAILS] };
    for i in 0..DETAILS {
        let index = usize::from(order[i + 1]);
        details.value[i] = filled[index] * per_step;
        details.weight[i] = gram[index * (TEXELS + 1)];
    }
    details
}

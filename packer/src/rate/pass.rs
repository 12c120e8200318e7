//! One pass over blocks: every base coded at its step, and the error measured at surfaces.

use flb_format::blocks::classes::DETAILS;
use flb_format::blocks::head::Head;
use flb_format::blocks::{CodedBlock, MAX_HALVINGS, TEXELS, transform};
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

use super::choose::{self, Chooser, Details};
use super::geometry::{Geometry, Gram};
use super::light::Light;
use super::quantise::{self, Grid};
use super::ready::{Filled, Ready};
use super::target::DARKEST;

/// A component is kept if its mean square is above this share of a square step.
const WORTH: f64 = 0.025;
/// Times the light of the darkest tenth of points that the mean of a block with halved steps may have.
const FAR_BRIGHTER: f32 = 3.0;

/// Everything that a pass reads.
#[derive(Clone, Copy)]
pub(super) struct Pass<'a> {
    /// Geometry that all bases share.
    pub geometry: &'a Geometry,
    /// `[base]`
    pub ready: &'a [Ready<'a>],
    /// Filled coefficients of all bases.
    pub filled: &'a Filled,
    /// Choosers of the first component and of the others; none for `haar`.
    pub choosers: Option<&'a [Chooser; 2]>,
    /// Weighted square error, in steps, that a bit is worth.
    pub lambda: f32,
    /// Whether errors in dark places count more.
    pub weighted: bool,
}

/// What a base is coded with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Try {
    /// Index of the base in the pass.
    pub base: usize,
    /// Step of an orthonormal coefficient, relative to the peak.
    pub step: f32,
    /// Components kept.
    pub components: usize,
    /// Averages, in steps, below which a block's steps are halved.
    pub thresholds: [i32; MAX_HALVINGS as usize],
}

/// A coded base.
pub(super) struct Coded {
    /// Settings that the base was coded with.
    pub tried: Try,
    /// `[block][component]`
    pub blocks: Vec<CodedBlock>,
    /// Sum over blocks of the square error that `G` expects, relative to the peak.
    pub expected: f64,
}

/// Error at surfaces of bases that are judged together.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Quality {
    /// Root of the mean square over points and bands, relative to the peak.
    pub rms: f64,
    /// Part of each base in it, in quadrature.
    pub of_bases: Vec<f64>,
    /// 99th percentile over the darkest tenth of points of the norm of the error relative to that of the light.
    pub dark: f64,
}

impl Try {
    /// Halvings of a block with this average.
    fn halvings(&self, average: i32) -> u32 {
        self.thresholds.iter().map(|t| u32::from(average.abs() < *t)).sum()
    }
}

/// Averages, in steps, below which a block's steps are halved, so that a step is at most `share` of its average, if the
/// block is not far brighter than the darkest tenth of points.
pub(super) fn thresholds(share: f32, step: f32, light: &Light) -> [i32; MAX_HALVINGS as usize] {
    // The mean of a block is an eighth of its average.
    let most = 8.0 * FAR_BRIGHTER * light.darkest_tenth / step;
    std::array::from_fn(|k| libm::ceilf((8.0 / (share * (1u32 << k) as f32)).min(most)).min(32768.0) as i32)
}

impl Pass<'_> {
    /// Components of a base that are worth coding at a step.
    pub(super) fn kept(&self, base: usize, step: f32) -> usize {
        let limit = f64::from(step) * f64::from(step) * WORTH;
        let moments = &self.ready[base].moment;
        1 + moments[1..].iter().take_while(|moment| **moment > limit).count()
    }

    /// How much errors count, `[site with points]`.
    #[inline(always)]
    fn weights(&self, base: usize) -> Option<&[f32]> {
        self.weighted.then_some(&self.ready[base].light.weights)
    }

    /// Order of the coefficients of a base.
    pub(super) fn order(&self, base: usize) -> [u8; TEXELS] {
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
    pub(super) fn code(&self, tries: &[Try], stride: usize) -> Vec<Coded> {
        let orders: Vec<[u8; TEXELS]> = tries.iter().map(|t| self.order(t.base)).collect();
        let ranks: Vec<usize> = (0..self.geometry.map.len()).step_by(stride).collect();
        let job = |rank: &usize| BlockJob { pass: self, tries, orders: &orders, rank: *rank };
        let blocks: Vec<(Vec<CodedBlock>, Vec<f32>)> =
            ranks.par_iter().map(|rank| Arch::new().dispatch(job(rank))).collect();
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
    #[inline(always)]
    fn block(
        &self,
        component: usize,
        filled: &[f32; TEXELS],
        gram: &Gram,
        scale: &Scale,
    ) -> (CodedBlock, f32) {
        let per_step = scale.per_step;
        let details = details(filled, gram, scale.order, per_step);
        let (class, grid) = match self.choosers {
            Some(choosers) => {
                let chooser = &choosers[component.min(1)];
                let class = chooser.choose(&choose::costs(&details, self.lambda));
                (class, Grid::Widths(choose::by_index(&chooser.widths[usize::from(class)], scale.order)))
            }
            None => {
                let (width, mask) = choose::choose_mask(&details, self.lambda);
                let mut kept = [false; TEXELS];
                (1..TEXELS).for_each(|place| {
                    kept[usize::from(scale.order[place]) % TEXELS] = mask >> place & 1 == 1
                });
                (u16::from(width), Grid::Mask(width, kept))
            }
        };
        let filled = filled.map(|v| v * per_step);
        let keep_average = scale.keep_average;
        let (values, error) = quantise::descend(&filled, gram, &grid, scale.steps_per_average, keep_average);
        let mut block = CodedBlock { class, values };
        if self.choosers.is_none() {
            // The descent may have left a width that is more than the values need.
            let largest = block.values[1..].iter().map(|v| v.unsigned_abs() / 2).max().unwrap_or(0);
            block.class = if largest == 0 { 0 } else { 1 + largest.next_power_of_two().ilog2() as u16 };
        }
        (block, error / (per_step * per_step))
    }

    /// Samples to train classes of a component by.
    pub(super) fn training(&self, tried: &Try, component: usize, stride: usize) -> Vec<Details> {
        let order = self.order(tried.base);
        let ranks: Vec<usize> = (tried.base % stride..self.geometry.map.len()).step_by(stride).collect();
        let sample = |rank: &usize| {
            let scale = self.scale(*rank, tried, &order);
            let filled = self.filled.get(*rank, tried.base, component);
            TrainingJob {
                geometry: self.geometry,
                weights: self.weights(tried.base),
                rank: *rank,
                filled,
                scale,
            }
        };
        ranks.par_iter().map(|rank| Arch::new().dispatch(sample(rank))).collect()
    }

    /// Mean square error over points and bands that `G` expects of blocks coded at a stride, relative to the peak.
    pub(super) fn expected(&self, coded: &Coded, stride: usize) -> f64 {
        let ready = &self.ready[coded.tried.base];
        let sites = self.geometry.counted_sites().max(1) as f64;
        let dropped = ready.dropped(coded.tried.components);
        (coded.expected * stride as f64 / sites + dropped) / ready.bands() as f64
    }

    /// The scale of a block whose steps are halved as its average says.
    #[inline(always)]
    fn scale<'o>(&self, rank: usize, tried: &Try, order: &'o [u8; TEXELS]) -> Scale<'o> {
        let average = quantise::whole(self.filled.get(rank, tried.base, 0)[0] / tried.step);
        let steps_per_average = (1u32 << tried.halvings(average as i32)) as f32;
        Scale {
            order,
            per_step: steps_per_average / tried.step,
            steps_per_average,
            keep_average: tried.thresholds[0] > 0,
        }
    }

    /// The error at surfaces of what coded bases make together. Rotations are orthonormal, so it is measured across
    /// components; harmonics have a mean square of 1 over all suns and near beams at most that, so squares add up.
    pub(super) fn measure(&self, coded: &[&Coded]) -> Quality {
        let squares: Vec<Vec<f32>> = coded
            .par_iter()
            .map_init(Vec::new, |texels, coded| {
                texels.resize(self.ready[coded.tried.base].field.lattice.pow(3) as usize, 0.0);
                Arch::new().dispatch(MeasureJob { pass: self, coded, texels })
            })
            .collect();
        let ready = &self.ready[coded[0].tried.base];
        let relative = |(point, light): &(u32, f32)| {
            let square: f32 = squares.iter().map(|squares| squares[*point as usize]).sum();
            square.sqrt() / light.max(DARKEST)
        };
        let mut relative: Vec<f32> = ready.light.dark.iter().map(relative).collect();
        let at = (relative.len().max(1) - 1) * 99 / 100;
        let dark =
            if relative.is_empty() { 0.0 } else { *relative.select_nth_unstable_by(at, f32::total_cmp).1 };
        let count = (self.geometry.points.len() * ready.bands()).max(1);
        let mean = |squares: &Vec<f32>| {
            squares.iter().fold(0.0, |sum, square| sum + f64::from(*square)) / count as f64 // a sum of nothing is -0
        };
        let means: Vec<f64> = squares.iter().map(mean).collect();
        Quality {
            rms: libm::sqrt(means.iter().fold(0.0, |sum, mean| sum + mean)),
            of_bases: means.into_iter().map(libm::sqrt).collect(),
            dark: f64::from(dark),
        }
    }
}

/// What differs from block to block.
struct Scale<'a> {
    /// Order of the coefficients.
    order: &'a [u8; TEXELS],
    /// Steps of the block in a unit.
    per_step: f32,
    /// Steps of the block in an average of 1.
    steps_per_average: f32,
    /// Whether the average must stay, since halvings depend on it.
    keep_average: bool,
}

/// A block of all bases that are tried.
struct BlockJob<'a> {
    pass: &'a Pass<'a>,
    tries: &'a [Try],
    orders: &'a [[u8; TEXELS]],
    rank: usize,
}

impl NullaryFnOnce for BlockJob<'_> {
    /// `[base][component]`, and the error of each base.
    type Output = (Vec<CodedBlock>, Vec<f32>);

    #[inline(always)]
    fn call(self) -> Self::Output {
        let even = self.pass.geometry.gram(self.rank, None);
        let (mut coded, mut errors) = (Vec::with_capacity(2 * self.tries.len()), Vec::new());
        for (tried, order) in self.tries.iter().zip(self.orders) {
            let scale = self.pass.scale(self.rank, tried, order);
            let mut error = 0.0;
            let own = self.pass.weights(tried.base).map(|w| self.pass.geometry.gram(self.rank, Some(w)));
            let gram = own.as_ref().unwrap_or(&even);
            for c in 0..tried.components {
                let filled = self.pass.filled.get(self.rank, tried.base, c);
                let (block, e) = self.pass.block(c, filled, gram, &scale);
                coded.push(block);
                error += e;
            }
            errors.push(error);
        }
        (coded, errors)
    }
}

/// A block of one base to train classes by.
struct TrainingJob<'a> {
    geometry: &'a Geometry,
    weights: Option<&'a [f32]>,
    rank: usize,
    filled: &'a [f32; TEXELS],
    scale: Scale<'a>,
}

impl NullaryFnOnce for TrainingJob<'_> {
    type Output = Details;

    #[inline(always)]
    fn call(self) -> Details {
        details(
            self.filled,
            &self.geometry.gram(self.rank, self.weights),
            self.scale.order,
            self.scale.per_step,
        )
    }
}

/// The samples of a coded base against those of its field. `texels` is `[z][y][x]`; of blocks that are not stored none
/// is read.
struct MeasureJob<'a> {
    pass: &'a Pass<'a>,
    coded: &'a Coded,
    texels: &'a mut [f32],
}

impl NullaryFnOnce for MeasureJob<'_> {
    /// `[point]` square of the norm of the error, relative to the peak.
    type Output = Vec<f32>;

    #[inline(always)]
    fn call(self) -> Vec<f32> {
        let MeasureJob { pass, coded, texels } = self;
        let Try { base, step, components, .. } = coded.tried;
        let (ready, geometry) = (&pass.ready[base], pass.geometry);
        let n = ready.field.lattice as usize;
        let mut squares = ready.rest.clone();
        squares.resize(geometry.points.len(), 0.0);
        for (c, samples) in ready.samples.iter().enumerate() {
            if c >= components {
                squares.iter_mut().zip(samples).for_each(|(square, v)| *square += v * v);
                continue;
            }
            for (rank, blocks) in coded.blocks.chunks_exact(components).enumerate() {
                let scale = MAX_HALVINGS - coded.tried.halvings(i32::from(blocks[0].values[0]));
                let mut values = blocks[c].values.map(|v| i32::from(v) << scale);
                values[0] = i32::from(blocks[c].values[0]) * transform::AVERAGE_COEFFICIENT;
                transform::inverse(geometry.rows, &mut values);
                let [x, y, z] = geometry.map.first_texel(rank);
                for (i, row) in values.as_chunks::<4>().0.iter().enumerate() {
                    let first = ((z + i / 4) * n + y + i % 4) * n + x;
                    texels[first..][..4].copy_from_slice(&row.map(|v| v as f32));
                }
            }
            let unit = step / 16.0 / 216.0;
            for (point, (square, sample)) in squares.iter_mut().zip(samples).enumerate() {
                let error = sample - unit * geometry.points.sample(point, n, texels);
                *square += error * error;
            }
        }
        squares
    }
}

#[inline(always)]
fn details(filled: &[f32; TEXELS], gram: &Gram, order: &[u8; TEXELS], per_step: f32) -> Details {
    let mut details = Details { value: [0.0; DETAILS], weight: [0.0; DETAILS] };
    for i in 0..DETAILS {
        let index = usize::from(order[i + 1]) % TEXELS;
        details.value[i] = filled[index] * per_step;
        details.weight[i] = gram.row(index)[index];
    }
    details
}

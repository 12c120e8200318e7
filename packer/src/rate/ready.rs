//! A base made ready for coding: rotated across its bands, transformed and filled, in units of its peak.

use flb_format::Field;
use flb_format::blocks::coarse::{self, COARSE_EDGE};
use flb_format::blocks::{TEXELS, map, transform};

use std::sync::Arc;

use super::fill;
use super::geometry::Geometry;
use super::light::Light;
use super::rotate::{Principal, principal};
use super::target::Target;
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

/// Coefficient 0 of a block of the value 1, where a step is 1: norm of row 0 to the third.
const SCALE: f32 = 216.0;
/// Every so many points are taken for the second moments of bands.
const MOMENT_STRIDE: usize = 3;
/// Share of the square error that is asked for below which components are not looked at: no step keeps them.
const NEGLIGIBLE: f64 = 1e-4;

/// What is known of a base before a step is chosen.
pub(super) struct Ready<'a> {
    /// Index of the base.
    pub base: u8,
    /// The field.
    pub field: &'a Field,
    /// Light that errors are measured against.
    pub light: Arc<Light>,
    /// `[component][band]` of the components that may be worth coding.
    pub rotation: Vec<f32>,
    /// `[component][point]` samples at surfaces, relative to the peak.
    pub samples: Vec<Vec<f32>>,
    /// `[component]` mean square of the samples.
    pub sampled: Vec<f64>,
    /// `[point]` sum of the squares of the components that are left out; empty where there are none.
    pub rest: Vec<f32>,
    /// `[component]` mean square of the filled texels, relative to the peak.
    pub moment: Vec<f64>,
    /// Finest step at which averages fit.
    pub finest: f32,
    /// Axes, strongest first.
    pub axes: [u8; 3],
    /// `[component][Morton code]` coarse averages where a step is 1.
    pub coarse: Vec<Vec<f32>>,
}

/// Filled coefficients where a step is 1, `[block][base][component]`.
pub(super) struct Filled {
    /// `[block][item]`
    blocks: Vec<Vec<[f32; TEXELS]>>,
    /// First item of each base.
    first: Vec<usize>,
}

impl Filled {
    /// Coefficients of a component of a base in a block.
    #[inline]
    pub(super) fn get(&self, rank: usize, base: usize, component: usize) -> &[f32; TEXELS] {
        &self.blocks[rank][self.first[base] + component]
    }
}

impl Ready<'_> {
    /// Number of bands.
    pub(super) fn bands(&self) -> usize {
        self.field.bands as usize
    }

    /// Number of components that may be worth coding.
    pub(super) fn components(&self) -> usize {
        self.samples.len()
    }

    /// Mean square over points of what is lost where so many components are kept, relative to the peak.
    pub(super) fn dropped(&self, components: usize) -> f64 {
        let rest = self.rest.iter().fold(0.0, |sum, square| sum + f64::from(*square));
        self.sampled[components..].iter().sum::<f64>() + rest / self.rest.len().max(1) as f64
    }

    /// Texels of all components of a block, where a step is 1.
    #[inline(always)]
    pub(super) fn texels(&self, geometry: &Geometry, rank: usize, out: &mut [[f32; TEXELS]]) {
        let n = self.field.lattice as usize;
        let bands = self.bands();
        let scale = SCALE / self.light.peak;
        let [x, y, z] = geometry.map.first_texel(rank);
        out.iter_mut().for_each(|o| *o = [0.0; TEXELS]);
        for band in 0..bands {
            let mut texels = [0.0; TEXELS];
            for (i, row) in texels.as_chunks_mut::<4>().0.iter_mut().enumerate() {
                let first = ((z + i / 4) * n + y + i % 4) * n + x;
                *row = self.field.row(band as u32, first).map(|value: f32| value * scale);
            }
            for (c, out) in out.iter_mut().enumerate() {
                let factor = self.rotation[c * bands + band];
                (0..TEXELS).for_each(|t| out[t] += factor * texels[t]);
            }
        }
    }
}

/// All bases made ready. With `harmonics` all but base 0 are judged together: so many harmonics of the sun's direction,
/// then terms of the near beam.
pub(super) fn ready<'a>(
    bases: &[(u8, &'a Field)],
    geometry: &Geometry,
    harmonics: Option<usize>,
    target: Target,
) -> (Vec<Ready<'a>>, Filled) {
    let samples: Vec<Vec<Vec<f32>>> = bases.par_iter().map(|(_, field)| samples(field, geometry)).collect();
    let alone = harmonics.map_or(bases.len(), |_| bases.iter().take_while(|(base, _)| *base == 0).count());
    let mut lights: Vec<Arc<Light>> = samples[..alone]
        .par_iter()
        .map(|samples| Arc::new(Light::new(samples, &geometry.points.on_leaves)))
        .collect();
    if let Some(harmonics) = harmonics.filter(|_| alone < bases.len()) {
        lights.resize(
            bases.len(),
            Arc::new(Light::of_suns(&samples[alone..], harmonics, &geometry.points.on_leaves)),
        );
    }
    let mut ready: Vec<Ready> = (bases, samples, lights)
        .into_par_iter()
        .map(|((base, field), samples, light)| survey(*base, field, geometry, samples, light, target))
        .collect();
    let filled = fill_all(&ready, geometry);
    ready.par_iter_mut().enumerate().for_each(|(i, ready)| measure(ready, i, &filled, geometry));
    (ready, filled)
}

/// `[band][point]`
fn samples(field: &Field, geometry: &Geometry) -> Vec<Vec<f32>> {
    let (n, points) = (field.lattice as usize, &geometry.points);
    let band = |b: u32| {
        let values = field.band(b);
        (0..points.len()).map(|p| points.sample(p, n, &values)).collect()
    };
    (0..field.bands).map(band).collect()
}

/// Everything but what needs the filled blocks.
fn survey<'a>(
    base: u8,
    field: &'a Field,
    geometry: &Geometry,
    samples: Vec<Vec<f32>>,
    light: Arc<Light>,
    target: Target,
) -> Ready<'a> {
    let (bands, points, peak) = (field.bands as usize, geometry.points.len(), light.peak);
    let mut moments = vec![0.0f64; bands * bands];
    let mut of_point = vec![0.0f64; bands];
    for p in (0..points).step_by(MOMENT_STRIDE) {
        of_point.iter_mut().zip(&samples).for_each(|(value, of_band)| *value = f64::from(of_band[p] / peak));
        for (i, row) in moments.chunks_exact_mut(bands).enumerate() {
            row.iter_mut().zip(&of_point).for_each(|(sum, value)| *sum += of_point[i] * value);
        }
    }
    let principal = principal(&moments, bands);
    let components = worthwhile(&principal, points.div_ceil(MOMENT_STRIDE), target.most_pursued(bands));
    // Within -1..=1 whatever was rounded, and no -0.
    let rows = principal.into_iter().take(components).flat_map(|principal| principal.row);
    let rotation: Vec<f32> = rows.map(|v| (v as f32).clamp(-1.0, 1.0) + 0.0).collect();
    let (samples, rest) = rotated(&samples, &rotation, peak);
    let mean = |v: &Vec<f32>| v.iter().map(|v| f64::from(v * v)).sum::<f64>() / points.max(1) as f64;
    let sampled = samples.iter().map(mean).collect();
    let coarse = coarse_means(field, geometry, &rotation, peak);
    Ready {
        base,
        field,
        light,
        rotation,
        samples,
        rest,
        sampled,
        moment: Vec::new(),
        finest: 0.0,
        axes: [0, 1, 2],
        coarse,
    }
}

/// Components, at least one, that may be worth coding where the square error of a point, summed over bands, is never to
/// be less than `pursued`: all others together are below [`NEGLIGIBLE`] of that.
fn worthwhile(principal: &[Principal], points: usize, pursued: f64) -> usize {
    let most = NEGLIGIBLE * pursued * points as f64;
    let mut left = 0.0;
    let negligible = principal.iter().rev().take_while(|principal| {
        left += principal.moment;
        left <= most
    });
    (principal.len() - negligible.count()).max(1)
}

/// Points that are rotated at once.
const ROTATED: usize = 512;

/// Samples `[component][point]` of samples `[band][point]`, relative to the peak, and what they do not hold: the square
/// at each point, summed over bands. That is empty where all components are wanted.
fn rotated(samples: &[Vec<f32>], rotation: &[f32], peak: f32) -> (Vec<Vec<f32>>, Vec<f32>) {
    let (bands, points) = (samples.len(), samples.first().map_or(0, Vec::len));
    let components = rotation.len() / bands;
    let mut of_components = vec![Vec::with_capacity(points); components];
    let mut rest = Vec::new();
    for first in (0..points).step_by(ROTATED) {
        let count = ROTATED.min(points - first);
        let relative = |of_band: &Vec<f32>| of_band[first..][..count].iter().map(|v| v / peak).collect();
        let mut relative: Vec<Vec<f32>> = samples.iter().map(relative).collect();
        for (row, of_component) in rotation.chunks_exact(bands).zip(&mut of_components) {
            let mut sum = vec![-0.0f32; count];
            for (factor, relative) in row.iter().zip(&relative) {
                sum.iter_mut().zip(relative).for_each(|(sum, value)| *sum += factor * value);
            }
            of_component.extend(sum);
        }
        if components == bands {
            continue;
        }
        for (row, of_component) in rotation.chunks_exact(bands).zip(&of_components) {
            for (factor, relative) in row.iter().zip(&mut relative) {
                relative
                    .iter_mut()
                    .zip(&of_component[first..])
                    .for_each(|(left, value)| *left -= factor * value);
            }
        }
        let squares = |i: usize| relative.iter().map(|left| left[i] * left[i]).sum::<f32>();
        rest.extend((0..count).map(squares));
    }
    (of_components, rest)
}

/// Means over 16^3 texels of the components: of the texels in blocks that are not stored, of all where there are none.
fn coarse_means(field: &Field, geometry: &Geometry, rotation: &[f32], peak: f32) -> Vec<Vec<f32>> {
    let bands = field.bands as usize;
    let edge = coarse::edge(&geometry.map);
    if edge == 0 {
        return Vec::new();
    }
    let mean = |code: u32, band: u32| -> f64 {
        let first = map::decode(code).map(|c| c * COARSE_EDGE);
        let (mut sums, mut counts) = ([0.0f64; 2], [0u32; 2]);
        for row in 0..COARSE_EDGE * COARSE_EDGE {
            let [x, y, z] = [first[0], first[1] + row % COARSE_EDGE, first[2] + row / COARSE_EDGE];
            let start = ((z * field.lattice + y) * field.lattice + x) as usize;
            let texels: [f32; COARSE_EDGE as usize] = field.row(band, start);
            for (i, texels) in texels.chunks_exact(4).enumerate() {
                let stored = geometry.map.rank([x / 4 + i as u32, y / 4, z / 4]).is_some();
                sums[usize::from(stored)] += texels.iter().map(|v| f64::from(*v)).sum::<f64>();
                counts[usize::from(stored)] += 4;
            }
        }
        let which = usize::from(counts[0] == 0);
        sums[which] / f64::from(counts[which])
    };
    let means: Vec<Vec<f64>> =
        (0..bands).map(|b| (0..edge.pow(3)).map(|code| mean(code, b as u32)).collect()).collect();
    let scale = f64::from(SCALE / 27.0 / peak);
    rotation
        .chunks_exact(bands)
        .map(|row| {
            let value = |i: usize| -> f64 {
                row.iter().zip(&means).map(|(factor, means)| f64::from(*factor) * means[i]).sum::<f64>()
                    * scale
            };
            (0..means[0].len()).map(|i| value(i) as f32).collect()
        })
        .collect()
}

fn fill_all(ready: &[Ready], geometry: &Geometry) -> Filled {
    let mut first = vec![0];
    ready.iter().for_each(|r| first.push(first.last().expect("one at least") + r.components()));
    let items = *first.last().expect("one at least");
    let blocks = (0..geometry.map.len())
        .into_par_iter()
        .map(|rank| Arch::new().dispatch(FillJob { ready, geometry, first: &first, rank, items }))
        .collect();
    Filled { blocks, first }
}

/// A block of all bases.
struct FillJob<'a> {
    ready: &'a [Ready<'a>],
    geometry: &'a Geometry,
    first: &'a [usize],
    rank: usize,
    items: usize,
}

impl NullaryFnOnce for FillJob<'_> {
    /// `[item]`
    type Output = Vec<[f32; TEXELS]>;

    #[inline(always)]
    fn call(self) -> Vec<[f32; TEXELS]> {
        let mut block = vec![[0.0; TEXELS]; self.items];
        for (ready, ends) in self.ready.iter().zip(self.first.windows(2)) {
            ready.texels(self.geometry, self.rank, &mut block[ends[0]..ends[1]]);
        }
        block.iter_mut().for_each(|texels| transform::forward(self.geometry.rows, texels));
        fill::fill(&self.geometry.gram(self.rank, None), &mut block);
        block
    }
}

/// Largest magnitude of a coefficient of the detail, in steps: what the widest field holds.
const MAX_DETAIL: f32 = 1023.0;
/// Largest magnitude of an average: less than an `i16` holds, as descent may move it.
const MAX_AVERAGE: f32 = 32_000.0;

fn measure(ready: &mut Ready, base: usize, filled: &Filled, geometry: &Geometry) {
    let mut energy = [0.0f64; 3];
    let (mut largest, mut steepest) = (0.0f32, 0.0f32);
    let square = |v: f32| f64::from(v) * f64::from(v);
    for c in 0..ready.components() {
        let mut sum = 0.0;
        for rank in 0..geometry.map.len() {
            let block = filled.get(rank, base, c);
            sum += block.iter().map(|v| square(*v)).sum::<f64>();
            steepest = block[1..].iter().fold(steepest, |most, v| most.max(v.abs()));
            // A number that is none is larger than all.
            let average = block[0].abs();
            largest = if average.is_finite() { largest.max(average) } else { f32::INFINITY };
            if c == 0 {
                [1, 4, 16].iter().zip(&mut energy).for_each(|(i, e)| *e += square(block[*i]));
            }
        }
        ready.moment.push(sum / (TEXELS * geometry.map.len()) as f64);
    }
    // A finer step would clip the steepest block, and be worse.
    ready.finest = (largest.max(1e-3) / MAX_AVERAGE).max(steepest / MAX_DETAIL);
    ready.axes.sort_by(|a, b| energy[usize::from(*b)].total_cmp(&energy[usize::from(*a)]).then(a.cmp(b)));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples `[band][point]` of 24 bands: two functions of the point in different shares, and very little beside.
    fn samples(beside: f32) -> Vec<Vec<f32>> {
        let value = |band: usize, p: usize| {
            let (x, b) = (p as f32 * 0.37, band as f32 * 0.1);
            (2.0 + libm::sinf(x)) * (1.0 + b) + libm::cosf(3.0 * x) * (1.0 - b) + beside * libm::sinf(x * b)
        };
        (0..24).map(|band| (0..1500).map(|p| value(band, p)).collect()).collect()
    }

    fn principal_of(samples: &[Vec<f32>]) -> Vec<Principal> {
        let product = |a: &Vec<f32>, b: &Vec<f32>| -> f64 {
            a.iter().zip(b).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum()
        };
        let moments: Vec<f64> = samples.iter().flat_map(|a| samples.iter().map(|b| product(a, b))).collect();
        principal(&moments, samples.len())
    }

    #[test]
    fn components_below_what_is_asked_for_are_left_out_and_more_are_kept_for_a_finer_target() {
        let principal = principal_of(&samples(1e-5));
        let kept = |db: f64| worthwhile(&principal, 1500, Target::Psnr(db).most_pursued(24));
        assert_eq!(kept(45.0), 2);
        assert!(kept(80.0) > 2);
        assert_eq!(worthwhile(&principal, 1500, 0.0), 24);
        assert_eq!(worthwhile(&principal, 1500, f64::INFINITY), 1);
    }

    #[test]
    fn what_components_left_out_hold_is_counted_as_error() {
        let samples = samples(0.1);
        let row = |principal: Principal| principal.row.into_iter().map(|v| v as f32);
        let rotation: Vec<f32> = principal_of(&samples).into_iter().flat_map(row).collect();
        let (all, rest) = rotated(&samples, &rotation, 2.0);
        assert_eq!((all.len(), rest.len()), (24, 0));
        let (some, rest) = rotated(&samples, &rotation[..2 * 24], 2.0);
        assert_eq!(some, all[..2]);
        for (p, rest) in rest.iter().enumerate() {
            let expected: f32 = all[2..].iter().map(|component| component[p] * component[p]).sum();
            assert!((rest - expected).abs() <= 1e-3 * expected + 1e-9, "point {p}: {rest} for {expected}");
        }
    }
}

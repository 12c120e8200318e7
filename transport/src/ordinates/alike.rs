//! The light of many bands from that of a few.
//!
//! From band to band only the albedos change, and what leaves let through. So the light of one band is nearly a
//! weighted sum of the light of some others. In every band the sky is solved, and the suns that are held out. Bands are
//! picked until the light of each other band is a weighted sum of theirs, to [`MAX_ERROR`] under these suns and the
//! sky. The picked ones are solved for every sun, and the same weights make the light of the others under all other
//! suns of a fit.
//!
//! The picks are the pivots of a Cholesky decomposition of the bands' scalar products. What an error of the weights
//! does to a file is in its stated error: the suns that are held out are solved in every band.

use flb_format::progress::Progress;
use rayon::prelude::*;

use super::band::Band;
use super::error::OrdinatesError;
use super::scatter::{Lit, Scattering};
use super::suns::SolvePlan;

/// Fewest bands of which some are made from others: fewer are nearly all picked.
pub(super) const MIN_BANDS: usize = 13;

/// Largest error of light that is made from that of other bands, rms over the sites, the suns that are held out and the
/// sky, relative to the mean total fluence. A fit over the suns is off by 5 to 10 times as much.
const MAX_ERROR: f64 = 3e-4;

/// Sites that scalar products count, about.
const COUNTED_SITES: usize = 16_384;

/// Light of all bands.
pub(super) struct AlikeBands {
    /// Suns that fields are made from.
    fitted: usize,
    /// `[band]`: the suns that are held out, and the sky.
    seen: Vec<Lit>,
    /// Bands that are solved for every sun, as they were picked.
    picked: Vec<(usize, Lit)>,
    /// `[band][pick]`
    weights: Vec<Vec<f64>>,
}

/// Solves some bands.
pub(super) type Solve<'a> =
    dyn Fn(&Scattering, &[Band], &Progress<'_>) -> Result<Vec<Lit>, OrdinatesError> + 'a;

impl AlikeBands {
    /// Solves what is needed of so many bands, `at_once` at a time. `direct` are the beams of the suns that are held
    /// out and the open sky, where that is wanted, as `solve` gives light.
    pub(super) fn solve(
        whole: &Scattering,
        direct: &[&[f32]],
        band: &(impl Fn(usize) -> Band + Sync),
        [count, at_once]: [usize; 2],
        solve: &Solve,
        progress: &Progress<'_>,
    ) -> Result<AlikeBands, OrdinatesError> {
        let fitted = whole.plan.fitted();
        let plan = SolvePlan::held_out_of(whole.plan);
        let beams = &whole.beams[fitted..];
        let held_out = Scattering { plan: &plan, beams, may_be_smooth: false, ..*whole };
        let in_parts = |scattering: &Scattering, some: &[usize], from: f64| -> Result<_, OrdinatesError> {
            let mut lit = Vec::with_capacity(some.len());
            for (at, part) in some.chunks(at_once).enumerate() {
                let made = |share: f64| {
                    let done = (at * at_once) as f64 + share * part.len() as f64;
                    progress(from + 0.5 * done / some.len() as f64)
                };
                let bands: Vec<Band> = part.iter().map(|&number| band(number)).collect();
                lit.extend(solve(scattering, &bands, &made)?);
            }
            Ok(lit)
        };
        let all: Vec<usize> = (0..count).collect();
        let seen: Vec<Lit> = in_parts(&held_out, &all, 0.0)?;
        let (picks, weights) = pick(&seen, direct);
        let lit = in_parts(whole, &picks, 0.5)?;
        Ok(AlikeBands { fitted, seen, picked: picks.into_iter().zip(lit).collect(), weights })
    }

    /// Light of a band; it is asked for once.
    pub(super) fn take(&mut self, band: usize) -> Lit {
        let Lit { light: of_seen, passes, error_estimate, .. } = std::mem::take(&mut self.seen[band]);
        if let Some((_, lit)) = self.picked.iter().find(|(number, _)| *number == band) {
            return lit.clone();
        }
        let weights: Vec<f32> = self.weights[band].iter().map(|weight| *weight as f32).collect();
        let of_sun = |sun: usize| -> Vec<f32> {
            let mut light = vec![0.0; of_seen[0].len()];
            for ((_, picked), weight) in self.picked.iter().zip(&weights) {
                light.iter_mut().zip(&picked.light[sun]).for_each(|(sum, light)| *sum += weight * light);
            }
            light
        };
        let light = (0..self.fitted).into_par_iter().map(of_sun).collect::<Vec<_>>();
        let solved = of_seen.len() as u32;
        Lit { light: light.into_iter().chain(of_seen).collect(), solved, passes, error_estimate }
    }
}

/// Numbers of the bands to solve, and the weights that make each band of them, `[band][pick]`.
fn pick(seen: &[Lit], direct: &[&[f32]]) -> (Vec<usize>, Vec<Vec<f64>>) {
    let sites = direct.first().map_or(0, |direct| direct.len());
    let stride = sites.div_ceil(COUNTED_SITES).max(1);
    let counted =
        |light: &[f32]| -> Vec<f64> { light.iter().step_by(stride).map(|l| f64::from(*l)).collect() };
    let direct: f64 = direct.iter().flat_map(|direct| counted(direct)).sum();
    // Light of a band over its mean total fluence, and what it was divided by.
    let scaled = |lit: &Lit| -> (Vec<f64>, f64) {
        let mut light: Vec<f64> = lit.light.iter().flat_map(|light| counted(light)).collect();
        let mean = (light.iter().sum::<f64>() + direct) / light.len().max(1) as f64;
        let unit = if mean > 0.0 { mean } else { 1.0 };
        light.iter_mut().for_each(|light| *light /= unit);
        (light, unit)
    };
    let (lights, units): (Vec<Vec<f64>>, Vec<f64>) = seen.par_iter().map(scaled).unzip();
    let product =
        |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / a.len().max(1) as f64;
    let products: Vec<Vec<f64>> =
        lights.par_iter().map(|a| lights.iter().map(|b| product(a, b)).collect()).collect();
    let (picks, factors) = pivots(&products);
    let of_band = |band: usize| {
        let weights = back_substituted(&picks, &factors, &factors[band]);
        weights.into_iter().zip(&picks).map(|(weight, &pick)| weight * units[band] / units[pick]).collect()
    };
    let weights = (0..seen.len()).map(of_band).collect();
    (picks, weights)
}

/// Pivots of a matrix of scalar products until nothing is left of any vector that is longer than [`MAX_ERROR`], and the
/// rows of its Cholesky factor, `[vector][pivot]`.
fn pivots(products: &[Vec<f64>]) -> (Vec<usize>, Vec<Vec<f64>>) {
    let mut left: Vec<f64> = (0..products.len()).map(|i| products[i][i]).collect();
    let mut factors: Vec<Vec<f64>> = vec![Vec::new(); products.len()];
    let mut picks = Vec::new();
    while picks.len() < products.len() {
        // The first of equals.
        let longest = (0..left.len()).rev().max_by(|a, b| left[*a].total_cmp(&left[*b]));
        let Some(pivot) = longest.filter(|&pivot| left[pivot] > MAX_ERROR * MAX_ERROR) else { break };
        let length = libm::sqrt(left[pivot]);
        let of_pivot = factors[pivot].clone();
        for (i, row) in factors.iter_mut().enumerate() {
            let known: f64 = row.iter().zip(&of_pivot).map(|(a, b)| a * b).sum();
            let along = if picks.contains(&i) { 0.0 } else { (products[i][pivot] - known) / length };
            row.push(along);
            left[i] -= along * along;
        }
        left[pivot] = 0.0;
        picks.push(pivot);
    }
    (picks, factors)
}

/// Weights of the pivots that make a vector, of which `factors` has the row.
fn back_substituted(picks: &[usize], factors: &[Vec<f64>], row: &[f64]) -> Vec<f64> {
    let mut weights = row.to_vec();
    for k in (0..picks.len()).rev() {
        let later: f64 = (k + 1..picks.len()).map(|i| factors[picks[i]][k] * weights[i]).sum();
        weights[k] = (weights[k] - later) / factors[picks[k]][k];
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_of_three_dimensions_are_made_of_three_of_them() {
        let made = |i: usize| {
            let x = i as f64 / 10.0;
            let of = |j: usize| 1.0 + x * (j % 7) as f64 + libm::sin(x) * (j % 5) as f64;
            (0..40).map(of).collect::<Vec<f64>>()
        };
        let vectors: Vec<Vec<f64>> = (0..12).map(made).collect();
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let products: Vec<Vec<f64>> =
            vectors.iter().map(|a| vectors.iter().map(|b| product(a, b)).collect()).collect();
        let (picks, factors) = pivots(&products);
        assert_eq!(picks.len(), 3, "{picks:?}");
        for (vector, row) in vectors.iter().zip(&factors) {
            let weights = back_substituted(&picks, &factors, row);
            for (j, value) in vector.iter().enumerate() {
                let sum: f64 =
                    picks.iter().zip(&weights).map(|(&pick, weight)| weight * vectors[pick][j]).sum();
                assert!((sum - value).abs() < 1e-3, "{sum} for {value}");
            }
        }
        // A picked vector is made of itself.
        let weights = back_substituted(&picks, &factors, &factors[picks[1]]);
        assert!(weights.iter().zip([0.0, 1.0, 0.0]).all(|(a, b)| (a - b).abs() < 1e-9), "{weights:?}");
    }

    #[test]
    fn vectors_that_have_nothing_in_common_are_all_picked() {
        let products: Vec<Vec<f64>> =
            (0..5).map(|i| (0..5).map(|j| f64::from(u8::from(i == j))).collect()).collect();
        assert_eq!(pivots(&products).0, [0, 1, 2, 3, 4]);
        assert!(pivots(&[]).0.is_empty());
    }
}

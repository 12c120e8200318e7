//! The light of many bands from that of a few.
//!
//! From band to band only the albedos change, and what leaves let through. So the light of one band is nearly a
//! weighted sum of the light of some others.
//!
//! 1. What sites scatter, to several powers, says which bands are unlike ([`gains_of`]). These are picked first, and
//!    solved for every sun.
//! 2. The light of every other band is guessed from theirs, and from that of all others that are solved by then, for
//!    the suns that are held out and for the sky. It is solved from there, in one to three passes for three to seven.
//! 3. Bands whose light is not a weighted sum of that of the picked ones, to [`MAX_ERROR`] under these suns and the
//!    sky, are picked and solved for every sun, too. The same weights make the light of the others under all other suns
//!    of a fit.
//!
//! The picks are the pivots of a Cholesky decomposition of the bands' scalar products. What an error of the weights
//! does to a file is in its stated error: the suns that are held out are solved in every band.

mod pivots;

use flb_format::progress::Progress;
use rayon::prelude::*;

use super::band::Band;
use super::error::OrdinatesError;
use super::fields::{BandLight, Making, add_weighted, weighted};
use super::scatter::{Lit, Scattering};
use super::suns::SolvePlan;
use pivots::{back_substituted, pivots};

/// Fewest bands of which some are made from others: fewer are nearly all picked.
pub(super) const MIN_BANDS: usize = 13;

/// Largest error of light that is made from that of other bands, rms over the sites, the suns that are held out and the
/// sky, relative to the mean total fluence. A fit over the suns is off by 5 to 10 times as much.
const MAX_ERROR: f64 = 3e-4;

/// Largest difference, rms over the sites, of what a band scatters from a sum of what picked bands do.
const MAX_UNLIKE: f64 = 3e-3;

/// Difference of that kind up to which a band tells nothing that is not known of others.
const SAME_GAINS: f64 = 1e-5;

/// Powers of the albedo that are compared: light that was scattered more often is guessed less well.
const POWERS: i32 = 5;

/// Sites that scalar products count, about.
const COUNTED_SITES: usize = 16_384;

/// Light of all bands.
pub(super) struct AlikeBands {
    /// `[band]`: the suns that are held out, and the sky.
    seen: Vec<Lit>,
    /// Bands that are solved for every sun.
    solved: Vec<(usize, BandLight)>,
    /// Those of them that others are made from.
    picks: Picks,
    /// Light where nothing is scattered.
    dark: BandLight,
}

/// Solves some bands.
pub(super) type Solve<'a> =
    dyn Fn(&Scattering, &[Band], &Progress<'_>) -> Result<Vec<Lit>, OrdinatesError> + 'a;

/// All bands.
pub(super) struct Bands<'a> {
    pub count: usize,
    /// Bands that are solved at once.
    pub at_once: usize,
    /// Makes a band.
    pub band: &'a (dyn Fn(usize) -> Band + Sync),
    /// Gives values of sites to the parts that they are marched in.
    pub parted: &'a (dyn Fn(&[f32]) -> Vec<f32> + Sync),
}

impl Bands<'_> {
    /// Some of them, with guesses of their light where `guess` has any.
    fn made(&self, some: &[usize], guess: impl Fn(usize) -> Option<Vec<Vec<f32>>>) -> Vec<Band> {
        let band = |&number: &usize| {
            let guess = guess(number);
            let guess = guess.map(|light| light.iter().map(|light| (self.parted)(light)).collect());
            Band { guess, ..(self.band)(number) }
        };
        some.iter().map(band).collect()
    }
}

impl AlikeBands {
    /// Solves what is needed of all bands.
    pub(super) fn solve(
        whole: &Scattering,
        making: &Making,
        bands: &Bands,
        solve: &Solve,
        progress: &Progress<'_>,
    ) -> Result<AlikeBands, OrdinatesError> {
        let fitted = whole.plan.fitted();
        let plan = SolvePlan::held_out_of(whole.plan);
        let beams = &whole.beams[fitted..];
        let held_out = Scattering { plan: &plan, beams, may_be_smooth: false, ..*whole };
        let light_of = |some: &[usize], progress: &Progress<'_>| -> Result<Vec<BandLight>, OrdinatesError> {
            let mut light = Vec::new();
            for part in some.chunks(bands.at_once) {
                let done = light.len() as f64;
                let made = |share: f64| progress((done + share * part.len() as f64) / some.len() as f64);
                light.extend(making.light(solve(whole, &bands.made(part, |_| None), &made)?));
            }
            Ok(light)
        };
        let unlike = Picks::of(gains_of(bands), &[], SAME_GAINS);
        let first = unlike.longer_than(MAX_UNLIKE);
        let light = light_of(first, &|share| progress(0.4 * share))?;
        let mut solved: Vec<(usize, BandLight)> = first.iter().copied().zip(light).collect();
        let mut seen: Vec<Lit> = (0..bands.count).map(|_| Lit::default()).collect();
        solved.iter().for_each(|(band, light)| seen[*band] = light.seen.clone());
        // Those that are least like others come first, so that the others are guessed from many.
        let rest = (0..bands.count).filter(|band| !unlike.bands.contains(band));
        let order: Vec<usize> =
            unlike.bands.iter().copied().chain(rest).filter(|band| !first.contains(band)).collect();
        for (at, some) in order.chunks(bands.at_once).enumerate() {
            let done = at * bands.at_once;
            let known = (first.len() + done).min(unlike.bands.len());
            let guess = |band: usize| {
                (known > 0).then(|| guessed(&seen, &unlike.bands[..known], &unlike.weights_of(band, known)))
            };
            let made = |share: f64| {
                progress(0.4 + 0.3 * (done as f64 + share * some.len() as f64) / order.len() as f64)
            };
            let lit = solve(&held_out, &bands.made(some, guess), &made)?;
            some.iter().zip(lit).for_each(|(band, lit)| seen[*band] = lit);
        }
        let direct = making.beams[fitted..].iter().map(|near| near.beam.mean.as_slice()).chain(making.sky);
        let picks = Picks::of(relative(&seen, &direct.collect::<Vec<_>>()), first, MAX_ERROR);
        let more: Vec<usize> = picks.bands.iter().copied().filter(|band| !first.contains(band)).collect();
        let light = light_of(&more, &|share| progress(0.7 + 0.3 * share))?;
        solved.extend(more.into_iter().zip(light));
        Ok(AlikeBands { seen, solved, picks, dark: making.dark() })
    }

    /// Light of a band; it is asked for once.
    pub(super) fn take(&mut self, band: usize) -> BandLight {
        let solved =
            |band: usize| self.solved.iter().find(|(solved, _)| *solved == band).map(|(_, light)| light);
        if let Some(light) = solved(band) {
            return light.clone();
        }
        let of_pick = |pick: &usize| solved(*pick).expect("picks are solved");
        let picked: Vec<&BandLight> = self.picks.bands.iter().map(of_pick).collect();
        let weights = self.picks.weights_of(band, picked.len());
        weighted(&picked, &weights, &self.dark, std::mem::take(&mut self.seen[band]))
    }
}

/// Weighted sums of the light of some bands, `[light][site]`.
fn guessed(seen: &[Lit], some: &[usize], weights: &[f64]) -> Vec<Vec<f32>> {
    let of = |at: usize| {
        let mut sum = vec![0.0_f32; seen[some[0]].light[at].len()];
        add_weighted(&mut sum, some.iter().map(|&band| seen[band].light[at].as_slice()), weights);
        sum
    };
    let lights = some.first().map_or(0, |first| seen[*first].light.len());
    (0..lights).into_par_iter().map(of).collect()
}

/// A vector of each band, and what it was divided by.
type Vectors = (Vec<Vec<f64>>, Vec<f64>);

/// What the sites of each band scatter: by moments, and by powers of the albedo as light does that is scattered often.
fn gains_of(bands: &Bands) -> Vectors {
    let of_band = |number: usize| {
        let gains = (bands.band)(number).gains.gains;
        let stride = gains.len().div_ceil(COUNTED_SITES).max(1);
        let of_site = |gains: &[f32; 3]| {
            let [albedo, first, second] = gains.map(f64::from);
            let powers = (0..POWERS).scan(1.0, move |power, _| {
                *power *= albedo;
                Some(*power)
            });
            powers.chain([first, second, albedo * first])
        };
        gains.iter().step_by(stride).flat_map(of_site).collect()
    };
    ((0..bands.count).into_par_iter().map(of_band).collect(), vec![1.0; bands.count])
}

/// Light of each band relative to its mean total fluence. `direct` has met nothing, light for light.
fn relative(seen: &[Lit], direct: &[&[f32]]) -> Vectors {
    let sites = direct.first().map_or(0, |direct| direct.len());
    let stride = sites.div_ceil(COUNTED_SITES).max(1);
    let counted =
        |light: &[f32]| -> Vec<f64> { light.iter().step_by(stride).map(|l| f64::from(*l)).collect() };
    let direct: f64 = direct.iter().flat_map(|direct| counted(direct)).sum();
    let relative = |lit: &Lit| -> (Vec<f64>, f64) {
        let mut light: Vec<f64> = lit.light.iter().flat_map(|light| counted(light)).collect();
        let mean = (light.iter().sum::<f64>() + direct) / light.len().max(1) as f64;
        let unit = if mean > 0.0 { mean } else { 1.0 };
        light.iter_mut().for_each(|light| *light /= unit);
        (light, unit)
    };
    seen.par_iter().map(relative).unzip()
}

/// Bands that others are made from.
struct Picks {
    bands: Vec<usize>,
    /// `[band][pick]`: rows of a Cholesky factor.
    factors: Vec<Vec<f64>>,
    /// What the vector of each band was divided by.
    units: Vec<f64>,
}

impl Picks {
    /// Those that make all others to an error, first the ones that are `given` and needed.
    fn of((vectors, units): Vectors, given: &[usize], max_error: f64) -> Picks {
        let product =
            |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / a.len().max(1) as f64;
        let products: Vec<Vec<f64>> =
            vectors.par_iter().map(|a| vectors.iter().map(|b| product(a, b)).collect()).collect();
        let (bands, factors) = pivots(&products, given, max_error);
        Picks { bands, factors, units }
    }

    /// The first of them, that were farther than an error from sums of those before.
    fn longer_than(&self, max_error: f64) -> &[usize] {
        let far = |(at, band): &(usize, &usize)| self.factors[**band][*at] > max_error;
        &self.bands[..self.bands.iter().enumerate().take_while(far).count()]
    }

    /// Weights of the first `count` that make a band.
    fn weights_of(&self, band: usize, count: usize) -> Vec<f64> {
        let picks = &self.bands[..count];
        let weights = back_substituted(picks, &self.factors, &self.factors[band][..count]);
        let of_pick = |(weight, pick): (f64, &usize)| weight * self.units[band] / self.units[*pick];
        weights.into_iter().zip(picks).map(of_pick).collect()
    }
}

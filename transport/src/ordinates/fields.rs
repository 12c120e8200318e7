//! The fields of a band: what is fitted, or the light of the suns of a list, with what they are off.

use flb_format::beam::NearBeam;
use flb_format::light::{FieldKind, SunBasis};
use flb_format::sun::{SunBlend, harmonics};
use rayon::prelude::*;

use super::fit::{self, Terms, evaluate};
use super::scatter::Lit;
use super::suns::SolvePlan;
use super::{BandReport, OrdinatesSettings, total};

/// Light of a band as it is kept: linear in the light of the suns.
#[derive(Clone)]
pub(super) struct BandLight {
    /// Scattered light, `[field][site]`: what is fitted, or that of each sun that fields are made from.
    pub of_suns: Vec<Vec<f32>>,
    /// All light, beams with it, `[field][site]`: see [`total::TotalLight`].
    pub total: Vec<Vec<f32>>,
    /// Scattered light of the suns that are held out, and of the sky where that is wanted, with how it was reached.
    pub seen: Lit,
}

/// What fields are made with.
#[derive(Clone, Copy)]
pub(super) struct Making<'a> {
    pub plan: &'a SolvePlan,
    /// One per sun of the plan.
    pub beams: &'a [NearBeam],
    /// Light of the sky that has met nothing, where that is wanted.
    pub sky: Option<&'a [f32]>,
    pub settings: &'a OrdinatesSettings,
}

impl Making<'_> {
    /// Light of up to [`fit::MAX_BANDS`] bands that were solved for every sun.
    pub(super) fn light(&self, lit: Vec<Lit>) -> Vec<BandLight> {
        let Making { plan, beams, settings, .. } = *self;
        let fitted = plan.fitted();
        let totals = lit.iter().map(|lit| total::of_suns(&lit.light[..fitted], plan, beams, settings));
        let totals: Vec<_> = totals.collect();
        let mut fits = match settings.suns {
            SunBasis::Harmonics { degree, single, leaning } => {
                let terms = Terms { degree, single, leaning };
                let lights: Vec<&[Vec<f32>]> = lit.iter().map(|lit| &lit.light[..fitted]).collect();
                fit::fit(&plan.suns[..fitted], terms, &beams[..fitted], &lights)
            }
            SunBasis::Lattice18 | SunBasis::Directions(_) => Vec::new(),
        }
        .into_iter();
        let light = |(mut lit, total): (Lit, Vec<Vec<f32>>)| {
            let seen = lit.light.split_off(fitted);
            let of_suns = fits.next().unwrap_or(std::mem::take(&mut lit.light));
            BandLight { of_suns, total, seen: Lit { light: seen, ..lit } }
        };
        lit.into_iter().zip(totals).map(light).collect()
    }

    /// Light of a band in which nothing is scattered.
    pub(super) fn dark(&self) -> BandLight {
        let zero = || vec![0.0; self.beams[0].beam.mean.len()];
        let of_suns = (1..self.settings.suns.items()).map(|_| zero()).collect();
        let suns: Vec<Vec<f32>> = (0..self.plan.fitted()).map(|_| zero()).collect();
        let total = total::of_suns(&suns, self.plan, self.beams, self.settings);
        BandLight { of_suns, total, seen: Lit::default() }
    }

    /// The fields of a band, `[field][site]`, and its total light.
    pub(super) fn fields(&self, band: u32, light: BandLight) -> (Vec<Vec<f32>>, Vec<Vec<f32>>, BandReport) {
        let Making { plan, beams, sky, settings } = *self;
        let BandLight { mut of_suns, mut total, seen } = light;
        let Lit { light: mut held_out, solved: solves, passes, error_estimate } = seen;
        let mut fields = Vec::new();
        if let Some(sky) = sky {
            let scattered = held_out.pop().expect("the sky is solved last");
            let all: Vec<f32> =
                scattered.iter().zip(sky).map(|(scattered, direct)| scattered + direct).collect();
            total.insert(0, all.clone());
            fields.push(all);
        }
        let judges = plan.fitted()..plan.suns.len();
        let judged_by = |light_of: &dyn Fn(usize) -> Vec<f32>| {
            let errors = judges.clone().zip(&held_out);
            let errors = errors.map(|(i, truth)| relative_rms(&light_of(i), truth, &beams[i].beam.mean));
            errors.sum::<f64>() / plan.held_out() as f64
        };
        let suns_rms = match &settings.suns {
            SunBasis::Lattice18 => None,
            SunBasis::Directions(list) => Some(judged_by(&|i| {
                let blend = list.blend(plan.suns[i].towards).expect("a unit vector has a blend");
                blended(&blend, blend.bases.map(|base| of_suns[usize::from(base) - 1].as_slice()))
            })),
            &SunBasis::Harmonics { degree, single, leaning } => {
                let terms = Terms { degree, single, leaning };
                Some(judged_by(&|i| evaluate(&of_suns, terms, plan.suns[i].towards, &beams[i])))
            }
        };
        if settings.field == FieldKind::Total {
            match settings.suns {
                SunBasis::Harmonics { degree, .. } => {
                    of_suns[harmonics::count(degree)].iter_mut().for_each(|of_beam| *of_beam += 1.0);
                }
                SunBasis::Lattice18 | SunBasis::Directions(_) => {
                    for (light, beam) in of_suns.iter_mut().zip(beams) {
                        light.iter_mut().zip(&beam.beam.mean).for_each(|(light, direct)| *light += direct);
                    }
                }
            }
        }
        fields.extend(of_suns);
        let converged = error_estimate <= settings.tolerance;
        (fields, total, BandReport { band, solves, passes, error_estimate, converged, suns_rms })
    }
}

/// Sums of the light of some bands, by weights: `seen` is solved by itself. `dark` is light where nothing is scattered.
pub(super) fn weighted(picked: &[&BandLight], weights: &[f64], dark: &BandLight, seen: Lit) -> BandLight {
    // Beams are in the total light of each band, and in their weighted sum as often as the weights say.
    let rest = (1.0 - weights.iter().sum::<f64>()) as f32;
    let sums = |of: &(dyn Fn(&BandLight) -> &[Vec<f32>] + Sync)| {
        let sum = |(at, dark): (usize, &Vec<f32>)| -> Vec<f32> {
            let mut sum: Vec<f32> = dark.iter().map(|dark| rest * dark).collect();
            add_weighted(&mut sum, picked.iter().map(|picked| of(picked)[at].as_slice()), weights);
            sum
        };
        of(dark).par_iter().enumerate().map(sum).collect()
    };
    BandLight { of_suns: sums(&|light| &light.of_suns), total: sums(&|light| &light.total), seen }
}

/// Adds the light of some bands, `[site]` each, by weights.
pub(super) fn add_weighted<'a>(sum: &mut [f32], lights: impl Iterator<Item = &'a [f32]>, weights: &[f64]) {
    for (light, weight) in lights.zip(weights) {
        let weight = *weight as f32;
        sum.iter_mut().zip(light).for_each(|(sum, light)| *sum += weight * light);
    }
}

/// The weighted sum of three bases, site by site.
pub(super) fn blended(blend: &SunBlend, bases: [&[f32]; 3]) -> Vec<f32> {
    let of = |site: usize| (0..3).map(|k| blend.weights[k] * bases[k][site]).sum();
    (0..bases[0].len()).map(of).collect()
}

/// Rms of the difference of two scattered fluences, relative to the mean total fluence. 0 without sites.
pub(super) fn relative_rms(found: &[f32], truth: &[f32], direct: &[f32]) -> f64 {
    let (mut square, mut total) = (0.0, 0.0);
    for ((found, truth), direct) in found.iter().zip(truth).zip(direct) {
        let difference = f64::from(*found) - f64::from(*truth);
        square += difference * difference;
        total += f64::from(*truth) + f64::from(*direct);
    }
    let count = truth.len() as f64;
    if total > 0.0 { libm::sqrt(square / count) / (total / count) } else { 0.0 }
}

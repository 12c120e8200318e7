//! The light of many suns that was scattered three times or more, as harmonics of the sun's direction.
//!
//! Light that was scattered twice is known for each sun. It is projected on the harmonics; what the projections scatter
//! further is solved, and added to the light of each sun. The projection is by the weights of the suns, which make a
//! quadrature of the sphere that is exact for products of these harmonics.

use flb_format::sun::harmonics;
use rayon::prelude::*;

use super::band::Band;
use super::halves::add_each;
use super::moments::Moments;
use super::suns::SolvePlan;
use super::{OrdinatesSettings, SunBasis};

/// Largest albedo, as the root of the mean square over the sites, up to which the rest is taken for smooth. Above it,
/// light that is scattered often is too large a share.
const MAX_ALBEDO: f64 = 0.27;

/// Harmonics of the sun, and how much of each the suns of a fit count for.
pub(super) struct Smooth {
    /// `[sun][function]`
    values: Vec<Vec<f64>>,
    /// One per sun.
    weights: Vec<f64>,
}

impl Smooth {
    /// Harmonics of a degree more than those of the fit; `None` where every sun is to be solved to the end.
    pub(super) fn of(plan: &SolvePlan, settings: &OrdinatesSettings, band: &Band) -> Option<Smooth> {
        let SunBasis::Harmonics { degree, .. } = settings.suns else { return None };
        if band.gains.rms_albedo() > MAX_ALBEDO {
            return None;
        }
        let count = harmonics::count((degree + 1).min(harmonics::MAX_DEGREE));
        let suns = &plan.suns[..plan.fitted()];
        Some(Smooth {
            values: suns.iter().map(|sun| harmonics::evaluate(sun.towards)[..count].to_vec()).collect(),
            weights: suns.iter().map(|sun| sun.weight).collect(),
        })
    }

    /// Projections of the light of a few suns, `[function][site]`.
    pub(super) fn project<const M: usize>(
        &self,
        light: &Moments<M>,
        first_sun: usize,
        suns: usize,
    ) -> Vec<Vec<[f32; M]>> {
        if suns == 0 {
            return Vec::new();
        }
        let projected = |function: usize| {
            let factors: Vec<f32> = (first_sun..first_sun + suns)
                .map(|sun| (self.weights[sun] * self.values[sun][function]) as f32)
                .collect();
            let of_site = |moments: &[super::lanes::Lanes; M]| {
                moments.map(|lanes| factors.iter().zip(lanes.0).map(|(factor, light)| factor * light).sum())
            };
            light.iter().map(of_site).collect()
        };
        (0..self.values[0].len()).map(projected).collect()
    }

    /// Adds projections of other suns.
    pub(super) fn add<const M: usize>(sums: &mut Vec<Vec<[f32; M]>>, other: Vec<Vec<[f32; M]>>) {
        if sums.is_empty() {
            *sums = other;
            return;
        }
        // Groups of suns that are held out have none.
        sums.par_iter_mut().zip(other).for_each(|(sums, other)| {
            add_each(sums.as_flattened_mut(), other.as_flattened());
        });
    }

    /// Sum over the sites of the square of the light in the mean over all suns.
    pub(super) fn mean_square(&self, light: &[Vec<f32>]) -> f64 {
        let of_site = |site: usize| -> f64 {
            let mean: f64 =
                light.iter().zip(&self.weights).map(|(light, weight)| weight * f64::from(light[site])).sum();
            mean * mean
        };
        (0..light[0].len()).map(of_site).sum()
    }

    /// Adds to the light of each sun what `rest`, `[function][site]`, is under it.
    pub(super) fn add_to_suns(&self, rest: &[Vec<f32>], light: &mut [Vec<f32>]) {
        light.par_iter_mut().zip(&self.values).for_each(|(light, values)| {
            for (rest, value) in rest.iter().zip(values) {
                light.iter_mut().zip(rest).for_each(|(light, rest)| *light += *value as f32 * rest);
            }
        });
    }
}

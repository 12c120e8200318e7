//! The near beam at solids.
//!
//! A solid is lit by the leaves around it, and what those send on depends on the sun's direction by the near beam as
//! much as by the harmonics (`flb_transport::ordinates`). So a solid takes the coefficients of the near beam from the
//! leaves around, as far as its own light goes with them: a twig among leaves all of them, a wall in the open none. The
//! harmonics hold the rest. Fields that are near to those of the leaves also code well: a solid whose harmonics held
//! all of its light stood out of them at every edge.

use flb_format::Field;
use flb_transport::ordinates::Spread;
use rayon::prelude::*;

use super::fit::Fit;
use super::gather::Gathered;
use super::{Places, Solids};

/// Most of the coefficients around that a solid takes.
const MAX_SHARE: f32 = 1.5;

/// What the near beam adds to the light of solids.
pub(super) struct NearOnSolids {
    /// Per side: the projection of each mean on each harmonic where readers sample, `[side][harmonic][mean]`.
    projected: Vec<f32>,
    harmonics: usize,
    means: usize,
    /// Column of the first harmonic in what was gathered.
    first: usize,
}

impl NearOnSolids {
    /// `None` where fields have no near beam.
    pub(super) fn new(
        solids: &Solids,
        places: &Places,
        fit: &Fit,
        gathered: &Gathered,
    ) -> Option<NearOnSolids> {
        let near = &solids.total.near;
        let (harmonics, means) = (near.len(), near.first()?.len());
        let width = harmonics * means;
        let mut projected = vec![0.0_f32; fit.sides() * width];
        projected.par_chunks_mut(width).enumerate().for_each(|(side, out)| {
            // As readers do: the mean over the corners that hold matter, else over those of the surface itself.
            let of_corners =
                fit.corner_sites(side).filter_map(|(site, weight)| Some((places.of(site)?, weight)));
            let mut met: Vec<(usize, f32)> = of_corners.filter(|(_, weight)| *weight > 0.0).collect();
            if met.is_empty() {
                met.extend(gathered.sides[side].place.map(|place| (place, 1.0)));
            }
            let all: f32 = met.iter().map(|(_, weight)| weight).sum();
            for (out, values) in out.iter_mut().zip(near.iter().flatten()) {
                *out = met.iter().map(|&(place, weight)| weight * values[place]).sum::<f32>()
                    / all.max(f32::MIN_POSITIVE);
            }
        });
        let first = solids.total.items.iter().position(|item| *item != 0).unwrap_or(0);
        Some(NearOnSolids { projected, harmonics, means, first })
    }

    /// Carries the coefficients of leaves on to solids, in the fields of the means, and takes what they give from what
    /// was gathered. `of_all` spreads values at the sites of `fit`; `kept` is what leaves of a site take back of the
    /// beam that they scatter themselves, by site and band: a solid takes back none.
    pub(super) fn carry_on(
        &self,
        fit: &Fit,
        of_all: &Spread,
        near: &mut [&mut Field],
        kept: &(dyn Fn(usize, u32) -> f32 + Sync),
        gathered: &mut Gathered,
    ) {
        let Some(lattice) = near.first().map(|field| field.lattice) else { return };
        let sites = fit.leaf_sites();
        let of_leaves = Spread::new(&sites, lattice);
        let kept =
            |mean: usize, site: u32, band: u32| if mean == 0 { kept(site as usize, band) } else { 0.0 };
        // Where no leaf has light of its own, what was there stays.
        near.par_iter_mut().enumerate().filter(|_| !sites.is_empty()).for_each(|(mean, field)| {
            for band in 0..field.bands {
                let value = |&site: &u32| field.value(band, site as usize) + kept(mean, site, band);
                let values: Vec<f32> = sites.iter().map(value).collect();
                field.set_band(band, of_leaves.band(&values));
            }
        });
        let shares = self.shares(fit, near, gathered);
        near.par_iter_mut().enumerate().for_each(|(mean, field)| {
            for band in 0..field.bands {
                let share = |((&site, &is_leaf), share): ((&u32, &bool), &f32)| {
                    let kept = if is_leaf { kept(mean, site, band) } else { 0.0 };
                    share * field.value(band, site as usize) - kept
                };
                let known = fit.sites().iter().zip(fit.leaves());
                let values: Vec<f32> = known.zip(&shares).map(share).collect();
                field.set_band(band, of_all.band(&values));
            }
        });
        self.take_from(fit, near, gathered);
    }

    /// Shares of the coefficients around that the sites of `fit` take, 0..=[`MAX_SHARE`]: 1 where leaves have their
    /// own, elsewhere those at which the near beam takes most of the light of the sides. `coefficients` are the fields
    /// of the means, of leaves alone and spread.
    fn shares(&self, fit: &Fit, coefficients: &[&mut Field], gathered: &Gathered) -> Vec<f32> {
        let of_side = |side: usize| {
            let (mut along, mut square) = (0.0, 0.0);
            for band in 0..gathered.bands {
                let around = self.sampled(fit, coefficients, side, band as u32);
                for harmonic in 0..self.harmonics {
                    let near = self.light(side, harmonic, &around);
                    along += near * gathered.of(side, self.first + harmonic, band);
                    square += near * near;
                }
            }
            (along, square)
        };
        let (along, square): (Vec<f32>, Vec<f32>) = (0..fit.sides()).into_par_iter().map(of_side).unzip();
        let sums = fit.start(|_| 1.0, &along).into_iter().zip(fit.start(|_| 1.0, &square));
        sums.map(|(along, square)| if square > 0.0 { (along / square).clamp(0.0, MAX_SHARE) } else { 0.0 })
            .collect()
    }

    /// Takes what the near beam gives from what was gathered.
    fn take_from(&self, fit: &Fit, coefficients: &[&mut Field], gathered: &mut Gathered) {
        let (width, bands) = (gathered.width, gathered.bands);
        gathered.light.par_chunks_mut(width).enumerate().for_each(|(side, light)| {
            for band in 0..bands {
                let around = self.sampled(fit, coefficients, side, band as u32);
                for harmonic in 0..self.harmonics {
                    light[(self.first + harmonic) * bands + band] -= self.light(side, harmonic, &around);
                }
            }
        });
    }

    fn sampled(&self, fit: &Fit, coefficients: &[&mut Field], side: usize, band: u32) -> Vec<f32> {
        let of_mean = |field: &&mut Field| {
            fit.corner_sites(side).map(|(site, weight)| weight * field.value(band, site)).sum()
        };
        coefficients.iter().map(of_mean).collect()
    }

    fn light(&self, side: usize, harmonic: usize, coefficients: &[f32]) -> f32 {
        let of_harmonic = &self.projected[(side * self.harmonics + harmonic) * self.means..][..self.means];
        of_harmonic.iter().zip(coefficients).map(|(near, coefficient)| near * coefficient).sum()
    }
}

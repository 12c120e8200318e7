//! From the light of many suns to few fields: least squares, site by site.
//!
//! The scattered fluence of a site under the sun s is fitted by `sum over k of c_k Y_k(s) + sum over j of b_j
//! near_j(s)`, with the harmonics of the sun's direction and the means of [`flb_format::beam`], which count as often as
//! leaves meet the beam where fields lean. c_k and b_j are the fields that a file stores. The suns stand at the points
//! of a quadrature of the sphere, and count by its weights.

use flb_format::beam::{MAX_MEANS, NearBeam, means};
use flb_format::sun::harmonics;
use rayon::prelude::*;

use crate::cholesky;

/// Added to the squares of the near beam's coefficients: where all suns are blocked alike, they stay small. Deep in a
/// crown the means themselves are a hundredth, their squares 1e-4; a ridge of that size would hide what they tell.
const RIDGE: f64 = 5e-6;

/// Most unknowns of a site.
const MAX_VALUES: usize = harmonics::count(harmonics::MAX_DEGREE) + MAX_MEANS;

/// A sun to fit to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sun {
    /// Unit vector, model space.
    pub towards: [f64; 3],
    /// Share of the sphere.
    pub weight: f64,
}

/// Functions of the sun that are fitted: harmonics up to a degree, and the near beam's means with or without the light
/// scattered once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Terms {
    /// Highest degree.
    pub degree: u8,
    /// Whether the light scattered once is fitted as a fifth mean.
    pub single: bool,
    /// Whether the near beam counts as often as leaves meet it.
    pub leaning: bool,
}

impl Terms {
    /// What each mean of a near beam is multiplied by.
    pub(super) fn near_factor(self, near: &NearBeam) -> f32 {
        if self.leaning { near.relative } else { 1.0 }
    }
}

/// Most bands that are fitted at once.
pub(super) const MAX_BANDS: usize = 4;

/// Fits the fields of up to [`MAX_BANDS`] bands, which share what is to be inverted. `near` has one entry per sun,
/// `light` one per band and sun. Gives `[band][field][site]`: harmonics, then the near beam's.
pub(super) fn fit(
    suns: &[Sun],
    terms: Terms,
    near: &[NearBeam],
    light: &[&[Vec<f32>]],
) -> Vec<Vec<Vec<f32>>> {
    let (harmonics_count, sites) = (harmonics::count(terms.degree), near[0].beam.mean.len());
    let unknowns = harmonics_count + means(terms.single);
    let values: Vec<_> = suns.iter().map(|sun| harmonics::evaluate(sun.towards)).collect();
    let solved: Vec<[[f32; MAX_VALUES]; MAX_BANDS]> = (0..sites)
        .into_par_iter()
        .map(|site| {
            let mut normal = [[0.0_f64; MAX_VALUES]; MAX_VALUES];
            let mut right = [[0.0_f64; MAX_VALUES]; MAX_BANDS];
            for (i, sun) in suns.iter().enumerate() {
                let mut row = [0.0_f64; MAX_VALUES];
                row[..harmonics_count].copy_from_slice(&values[i][..harmonics_count]);
                let factor = terms.near_factor(&near[i]);
                for j in 0..means(terms.single) {
                    row[harmonics_count + j] = f64::from(factor * near[i].mean(j, site));
                }
                for a in 0..unknowns {
                    let weighted = sun.weight * row[a];
                    for b in 0..=a {
                        normal[a][b] += weighted * row[b];
                    }
                    for (right, light) in right.iter_mut().zip(light) {
                        right[a] += weighted * f64::from(light[i][site]);
                    }
                }
            }
            for (a, row) in normal.iter_mut().enumerate().take(unknowns).skip(harmonics_count) {
                row[a] += RIDGE;
            }
            cholesky::factor(&mut normal, unknowns);
            right[..light.len()].iter_mut().for_each(|right| cholesky::substitute(&normal, right, unknowns));
            right.map(|right| right.map(|value| value as f32))
        })
        .collect();
    let field = |band: usize, field: usize| solved.iter().map(|fields| fields[band][field]).collect();
    (0..light.len()).map(|band| (0..unknowns).map(|of| field(band, of)).collect()).collect()
}

/// Scattered fluence under a sun, per site, from fitted fields.
pub fn evaluate(fields: &[Vec<f32>], terms: Terms, towards_sun: [f64; 3], near: &NearBeam) -> Vec<f32> {
    let y = harmonics::evaluate(towards_sun);
    let (count, factor) = (harmonics::count(terms.degree), terms.near_factor(near));
    (0..near.beam.mean.len())
        .map(|site| {
            let smooth: f32 = (0..count).map(|k| y[k] as f32 * fields[k][site]).sum();
            let sharp: f32 =
                (0..means(terms.single)).map(|j| factor * near.mean(j, site) * fields[count + j][site]).sum();
            smooth + sharp
        })
        .collect()
}

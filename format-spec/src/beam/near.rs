//! The near beam: what of a sun's light is not smooth in the sun's direction, because it was scattered nearby.
//!
//! Four numbers per site and sun carry it, each a mean of the uncollided fluence phi_0: over the site, and over the cubes that
//! reach 1, 3 and 8 sites further on every side. The cubes weigh each site by its extinction, as sources of scattered light
//! do: sum of sigma phi_0 / sum of sigma.

use crate::turbid::Turbid;

use super::tracks::Sites;
use super::uncollided::{Beam, uncollided};

/// How far the cubes reach around a site, in sites.
pub const REACHES: [u32; 3] = [1, 3, 8];

/// Means of phi_0 per site: over itself and over the cubes.
pub const MEANS: usize = 1 + REACHES.len();

/// The beam of one sun and its means around each site.
#[derive(Debug, Clone, PartialEq)]
pub struct NearBeam {
    /// Within the sites.
    pub beam: Beam,
    /// `[reach][site]`.
    pub around: [Vec<f32>; REACHES.len()],
}

impl NearBeam {
    /// Mean number `j` at a site, 0..[`MEANS`].
    pub fn mean(&self, j: usize, site: usize) -> f32 {
        if j == 0 { self.beam.mean[site] } else { self.around[j - 1][site] }
    }
}

/// Makes the near beam of any sun.
pub struct Near<'m> {
    medium: &'m Turbid,
    sites: &'m [u32],
    places: Sites,
    /// 1 / sum of the extinction over the cube, `[reach][site]`.
    inverse: [Vec<f64>; REACHES.len()],
}

impl<'m> Near<'m> {
    /// For the medium's non-empty sites.
    pub fn new(medium: &'m Turbid, sites: &'m [u32]) -> Near<'m> {
        let places = Sites::new(&medium.grid, sites);
        let ones = vec![1.0; sites.len()];
        let inverse = REACHES
            .map(|reach| cube_sums(medium, sites, &ones, reach).into_iter().map(|sum| 1.0 / sum).collect());
        Near { medium, sites, places, inverse }
    }

    /// The near beam of a sun along the unit vector `towards_sun`; `rays` per site edge find phi_0.
    pub fn beam(&self, towards_sun: [f64; 3], rays: u32) -> NearBeam {
        let beam = uncollided(self.medium, &self.places, self.sites, towards_sun, rays);
        let around: [Vec<f32>; REACHES.len()] = std::array::from_fn(|i| {
            let sums = cube_sums(self.medium, self.sites, &beam.mean, REACHES[i]);
            sums.iter().zip(&self.inverse[i]).map(|(sum, inverse)| (sum * inverse) as f32).collect()
        });
        NearBeam { beam, around }
    }
}

/// Sums of extinction x value over the cube around each non-empty site; the order of additions is fixed by the lattice.
fn cube_sums(medium: &Turbid, sites: &[u32], values: &[f32], reach: u32) -> Vec<f64> {
    let n = medium.grid.lattice as usize;
    let mut cube = vec![0.0_f64; n * n * n];
    for (&site, &value) in sites.iter().zip(values) {
        cube[site as usize] = f64::from(medium.extinction(site as usize)) * f64::from(value);
    }
    let mut line = vec![0.0_f64; n + 1];
    for stride in [1, n, n * n] {
        for a in 0..n {
            for b in 0..n {
                let start = match stride {
                    1 => (a * n + b) * n,
                    s if s == n => a * n * n + b,
                    _ => a * n + b,
                };
                let mut any = false;
                for i in 0..n {
                    let value = cube[start + i * stride];
                    any |= value != 0.0;
                    line[i + 1] = line[i] + value;
                }
                if any {
                    for i in 0..n {
                        let (low, high) = (i.saturating_sub(reach as usize), (i + reach as usize + 1).min(n));
                        cube[start + i * stride] = line[high] - line[low];
                    }
                }
            }
        }
    }
    sites.iter().map(|&site| cube[site as usize]).collect()
}

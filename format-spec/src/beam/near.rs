//! The near beam: what of a sun's light is not smooth in the sun's direction, because it was scattered nearby.
//!
//! A few numbers per site and sun carry it, each a mean of the uncollided fluence phi_0: over the site, and over cubes
//! that reach further on every side. The cubes weigh each site by its extinction, as sources of scattered light do: sum
//! of sigma phi_0 / sum of sigma. Where the fields ask for it the last is what comes in after one even scattering
//! ([`super::single`]), and one cube is enough.

use std::sync::Arc;

use crate::turbid::TurbidMedium;

use super::single::{self, OrdinateTracks, scattered_once};
use super::sites::Sites;
use super::uncollided::{Beam, uncollided};
use crate::ordinates::Ordinate;

/// How far the cubes reach around a site, in sites. Beside the light scattered once, small cubes bring nothing but
/// coefficients that are large, rough and cancel: files a fourth longer.
pub const fn reaches(single: bool) -> &'static [u32] {
    if single { &[8] } else { &[1, 3, 8] }
}

/// Means of phi_0 per site: over itself and over the cubes, and with `single` what is scattered once.
pub const fn means(single: bool) -> usize {
    1 + reaches(single).len() + single as usize
}

/// Largest number of means that fields ask for.
pub const MAX_MEANS: usize = if means(true) > means(false) { means(true) } else { means(false) };

/// Rays per site edge that follow a sun's beam, in the fit of the fields as where they are read. With 2, the noise of
/// the beam alone is 2 to 3 % of the light of a dense plant at lattice 64.
pub const BEAM_RAYS: u32 = 4;

/// The beam of one sun and its means around each site.
#[derive(Debug, Clone, PartialEq)]
pub struct NearBeam {
    /// Beam within the sites.
    pub beam: Beam,
    /// Means of the beam around each site, `[mean - 1][site]`: over the cubes, then the light scattered once if
    /// `single`.
    pub around: Vec<Vec<f32>>,
    /// Whether `around` holds the light scattered once.
    pub single: bool,
    /// Extinction of leaves along the beam, relative to its mean over all directions.
    pub relative: f32,
}

impl NearBeam {
    /// Mean number `j` at a site, 0..[`means`].
    ///
    /// # Panics
    /// If there is no such mean.
    pub fn mean(&self, j: usize, site: usize) -> f32 {
        if j == 0 { self.beam.mean[site] } else { self.around[j - 1][site] }
    }
}

/// Makes the near beam of any sun.
pub struct Near<'m> {
    medium: &'m TurbidMedium,
    sites: &'m [u32],
    places: Sites,
    /// How far each cube reaches, and 1 / sum of the extinction over it, `[site]`.
    cubes: Vec<(u32, Vec<f64>)>,
    /// For light scattered once.
    axes: Option<Vec<Arc<OrdinateTracks>>>,
}

impl<'m> Near<'m> {
    /// Prepares the near beam of the medium's non-empty sites. With `single` the rays of the light scattered once are
    /// laid: 12 bytes for each crossing of a site, and some 60 for each of one axis while it is laid.
    pub fn new(medium: &'m TurbidMedium, sites: &'m [u32], single: bool) -> Near<'m> {
        let near = Near::of_cubes(medium, sites, reaches(single));
        if !single {
            return near;
        }
        let axes = single::axes().iter().map(|ordinate| Arc::new(near.lay(ordinate))).collect();
        Near { axes: Some(axes), ..near }
    }

    /// Prepares the near beam with the light scattered once, along rays that are there: those of each of
    /// [`single::axes`], in their order, [`single::rays`] to a site edge.
    pub fn along(medium: &'m TurbidMedium, sites: &'m [u32], axes: Vec<Arc<OrdinateTracks>>) -> Near<'m> {
        Near { axes: Some(axes), ..Near::of_cubes(medium, sites, reaches(true)) }
    }

    fn of_cubes(medium: &'m TurbidMedium, sites: &'m [u32], reaches: &[u32]) -> Near<'m> {
        let ones = vec![1.0; sites.len()];
        let inverse =
            |reach| cube_sums(medium, sites, &ones, reach).into_iter().map(|sum| 1.0 / sum).collect();
        let cubes = reaches.iter().map(|&reach| (reach, inverse(reach))).collect();
        Near { medium, sites, places: Sites::new(&medium.grid, sites), cubes, axes: None }
    }

    fn lay(&self, ordinate: &Ordinate) -> OrdinateTracks {
        OrdinateTracks::lay(self.medium, &self.places, self.sites, ordinate)
    }

    /// The near beam of a sun along the unit vector `towards_sun`; `rays` per site edge find phi_0.
    pub fn beam(&self, towards_sun: [f64; 3], rays: u32) -> NearBeam {
        let beam = self.uncollided(towards_sun, rays);
        let around = self.around(&beam.mean);
        self.with_means(beam, around)
    }

    /// The near beam of a beam whose means [`Near::around`] or [`Near::around_each`] gave.
    pub fn with_means(&self, beam: Beam, around: Vec<Vec<f32>>) -> NearBeam {
        let relative = self.medium.angles.relative(beam.towards_sun[1]) as f32;
        NearBeam { beam, around, single: self.axes.is_some(), relative }
    }

    /// The beam alone.
    pub fn uncollided(&self, towards_sun: [f64; 3], rays: u32) -> Beam {
        uncollided(self.medium, &self.places, self.sites, towards_sun, rays)
    }

    /// Returns the means of a beam around each site, from its mean within each site, in the order of
    /// [`NearBeam::around`]. They are linear in the beam: those of a sum of beams are the sums of theirs.
    pub fn around(&self, mean: &[f32]) -> Vec<Vec<f32>> {
        self.around_each(&[mean]).remove(0)
    }

    /// Returns the means of several beams, as [`Near::around`] gives those of one. Up to [`single::BESIDE`] together
    /// take little more than one alone.
    pub fn around_each(&self, beams: &[&[f32]]) -> Vec<Vec<Vec<f32>>> {
        let over_cube = |mean: &[f32], (reach, inverse): &(u32, Vec<f64>)| -> Vec<f32> {
            let sums = cube_sums(self.medium, self.sites, mean, *reach);
            sums.iter().zip(inverse).map(|(sum, inverse)| (sum * inverse) as f32).collect()
        };
        let over_cubes = |mean: &&[f32]| self.cubes.iter().map(|cube| over_cube(mean, cube)).collect();
        let mut around: Vec<Vec<Vec<f32>>> = beams.iter().map(over_cubes).collect();
        if let Some(axes) = &self.axes {
            around.iter_mut().zip(scattered_once(axes, beams)).for_each(|(around, once)| around.push(once));
        }
        around
    }
}

/// Sums of extinction x value over the cube around each non-empty site; the order of additions is fixed by the lattice.
fn cube_sums(medium: &TurbidMedium, sites: &[u32], values: &[f32], reach: u32) -> Vec<f64> {
    let n = medium.grid.lattice as usize;
    let mut cube = vec![0.0_f64; n * n * n];
    for (&site, &value) in sites.iter().zip(values) {
        cube[site as usize] = f64::from(medium.extinction(site as usize)) * f64::from(value);
    }
    let around = |i: usize| (i.saturating_sub(reach as usize), (i + reach as usize + 1).min(n));
    let mut line = vec![0.0_f64; n + 1];
    for values in cube.chunks_exact_mut(n) {
        for i in 0..n {
            line[i + 1] = line[i] + values[i];
        }
        for (i, value) in values.iter_mut().enumerate() {
            let (low, high) = around(i);
            *value = line[high] - line[low];
        }
    }
    // Along the other axes, all lines of a plane side by side: memory is read as it lies.
    let mut lines = vec![0.0_f64; (n + 1) * n];
    for (stride, planes) in [(n, n * n), (n * n, n)] {
        for plane in 0..n {
            let row = |i: usize| plane * planes + i * stride;
            for i in 0..n {
                let (before, after) = lines.split_at_mut((i + 1) * n);
                let values = before[i * n..].iter().zip(&cube[row(i)..]);
                after.iter_mut().zip(values).for_each(|(sum, (before, value))| *sum = before + value);
            }
            for i in 0..n {
                let (low, high) = around(i);
                let sums = lines[high * n..].iter().zip(&lines[low * n..]);
                cube[row(i)..][..n].iter_mut().zip(sums).for_each(|(value, (high, low))| *value = high - low);
            }
        }
    }
    sites.iter().map(|&site| cube[site as usize]).collect()
}

//! Light that was scattered exactly once, near by or far off, as if every site scattered all light evenly: the mean
//! over all directions of travel of the integral of extinction x phi_0 x what is left on the way (SPEC.md, section
//! 10.4, near_2 with `single`).
//!
//! It is marched along the 110 ordinates; 18 tell nothing, 50 a little less.

use crate::ordinates::{Ordinate, Ordinates, rays_for};
use crate::turbid::TurbidMedium;

use super::crossings::{Crossing, crossings};
use super::passing::Passing;
use super::sites::Sites;
use super::uncollided::depth_per_edge;

/// A ray crosses a site.
#[derive(Debug, Clone, Copy)]
struct Segment {
    /// Place in the list of sites; [`LAST`] is set where the ray ends.
    place: u32,
    /// exp(-s).
    transmittance: f32,
    /// What a unit of light beyond the source function adds to the mean over the site and all directions.
    adds: f32,
}

const LAST: u32 = 1 << 31;

/// Rays per site edge along each ordinate: with four, a mean over so many directions gains nothing.
pub const fn rays(lattice: u32) -> u32 {
    if rays_for(lattice, 1) > 2 { 2 } else { rays_for(lattice, 1) }
}

/// The rays along one ordinate, for both ways.
pub struct OrdinateTracks {
    segments: Vec<Segment>,
}

/// One ordinate of each pair of opposites that singly scattered light is marched along.
pub fn axes() -> Vec<Ordinate> {
    Ordinates::Lebedev110.axes()
}

impl OrdinateTracks {
    /// Lays rays along an ordinate of [`axes`].
    pub fn lay(medium: &TurbidMedium, places: &Sites, sites: &[u32], ordinate: &Ordinate) -> OrdinateTracks {
        let depth = depth_per_edge(medium, sites, ordinate.direction);
        let found = crossings(places, ordinate.direction, rays(medium.grid.lattice));
        let mut lengths = vec![0.0_f32; sites.len()];
        found.iter().for_each(|crossing| lengths[crossing.place as usize] += crossing.length);
        let segment = |&Crossing { place, is_last, length, .. }: &Crossing| {
            let passing = Passing::new(depth[place as usize] * length);
            let adds = ordinate.weight as f32 * passing.mean * length / lengths[place as usize];
            let place = if is_last { place | LAST } else { place };
            Segment { place, transmittance: passing.transmittance, adds }
        };
        let segments = found.iter().map(segment).collect();
        OrdinateTracks { segments }
    }

    /// Adds to `excess` what arrives beyond phi_0 itself, from both ends.
    fn march(&self, source: &[f32], excess: &mut [f32]) {
        let mut light = 0.0;
        for segment in &self.segments {
            cross(segment, source, excess, &mut light);
            if segment.place & LAST != 0 {
                light = 0.0;
            }
        }
        for segment in self.segments.iter().rev() {
            if segment.place & LAST != 0 {
                light = 0.0;
            }
            cross(segment, source, excess, &mut light);
        }
    }
}

#[inline(always)]
fn cross(segment: &Segment, source: &[f32], excess: &mut [f32], light: &mut f32) {
    let place = (segment.place & !LAST) as usize;
    let beyond = *light - source[place];
    *light = source[place] + beyond * segment.transmittance;
    excess[place] += beyond * segment.adds;
}

/// Returns the light scattered once at each non-empty site, from the mean of the beam in each.
pub fn scattered_once(axes: &[OrdinateTracks], beam: &[f32]) -> Vec<f32> {
    // The weights of a site's segments sum to 1, so that the source function itself needs no march.
    let mut excess = vec![0.0; beam.len()];
    axes.iter().for_each(|axis| axis.march(beam, &mut excess));
    excess.iter().zip(beam).map(|(excess, beam)| (excess + beam).max(0.0)).collect()
}

//! Light that was scattered exactly once, near by or far off, as if every site scattered all light evenly: the mean
//! over all directions of travel of the integral of extinction x phi_0 x what is left on the way (SPEC.md, section
//! 10.4, near_2 with `single`).
//!
//! It is marched along the 110 ordinates; 18 tell nothing, 50 a little less.

use std::sync::Arc;

use prefetch_index::prefetch_index;
use pulp::{Arch, NullaryFnOnce};

use crate::ordinates::{Ordinate, Ordinates, rays_for};
use crate::turbid::TurbidMedium;

use super::crossings::{Crossing, crossings};
use super::passing::Passing;
use super::sites::Sites;
use super::uncollided::depth_per_edge;

/// A ray crosses a site.
#[derive(Debug, Clone, Copy)]
pub struct Segment {
    /// Place in the list of sites; [`LAST`] is set where the ray ends.
    place: u32,
    /// exp(-s) of the optical depth s of the segment.
    pub transmittance: f32,
    /// Share of a unit of light beyond the source function that is added to the mean over the site and all directions:
    /// weight of the ordinate x share of the site's segments x (1 - exp(-s)) / s.
    pub adds: f32,
}

const LAST: u32 = 1 << 31;

impl Segment {
    /// Place of the site in the list of non-empty sites.
    #[inline(always)]
    pub fn place(&self) -> usize {
        (self.place & !LAST) as usize
    }

    /// Whether the ray leaves the medium here.
    #[inline(always)]
    pub fn is_last(&self) -> bool {
        self.place & LAST != 0
    }
}

/// Visits between the fetching of a place and its own.
const AHEAD: usize = 16;

/// Rays per site edge along each ordinate: with four, a mean over so many directions gains nothing.
pub const fn rays(lattice: u32) -> u32 {
    if rays_for(lattice, 1) > 2 { 2 } else { rays_for(lattice, 1) }
}

/// The rays along one ordinate, for both ways.
#[derive(Debug)]
pub struct OrdinateTracks {
    segments: Vec<Segment>,
}

/// Ordinates that singly scattered light is marched along.
pub const ORDINATES: Ordinates = Ordinates::Lebedev110;

/// One of each pair of opposites of [`ORDINATES`].
pub fn axes() -> Vec<Ordinate> {
    ORDINATES.axes()
}

impl OrdinateTracks {
    /// Lays rays along an ordinate of [`axes`].
    pub fn lay(medium: &TurbidMedium, places: &Sites, sites: &[u32], ordinate: &Ordinate) -> OrdinateTracks {
        let depth = depth_per_edge(medium, sites, ordinate.direction);
        let found = crossings(places, ordinate.direction, rays(medium.grid.lattice));
        let mut lengths = vec![0.0_f32; sites.len()];
        found.iter().for_each(|crossing| lengths[crossing.place as usize] += crossing.length);
        OrdinateTracks::of_crossings(&found, &depth, |place| lengths[place], ordinate.weight)
    }

    /// Makes the rays of crossings that were found: `depth` is the optical depth of a site edge at each place,
    /// `length_at` that of all crossings of the site at a place, site edges, and `weight` the ordinate's.
    pub fn of_crossings(
        found: &[Crossing],
        depth: &[f32],
        length_at: impl Fn(usize) -> f32,
        weight: f64,
    ) -> OrdinateTracks {
        let segment = |&Crossing { place, is_last, length, .. }: &Crossing| {
            let passing = Passing::new(depth[place as usize] * length);
            let adds = weight as f32 * passing.mean * length / length_at(place as usize);
            let place = if is_last { place | LAST } else { place };
            Segment { place, transmittance: passing.transmittance, adds }
        };
        OrdinateTracks { segments: found.iter().map(segment).collect() }
    }

    /// The rays one after the other, each a segment per site that it crosses.
    #[inline(always)]
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// Adds to `excess` what arrives beyond phi_0 itself, from both ends.
    #[inline(always)]
    fn march<const L: usize>(&self, source: &[[f32; L]], excess: &mut [[f32; L]]) {
        let mut light = [0.0; L];
        let place = |at: usize| self.segments.get(at).map_or(0, Segment::place);
        for (at, segment) in self.segments.iter().enumerate() {
            prefetch_index(source, place(at + AHEAD));
            prefetch_index(&*excess, place(at + AHEAD));
            cross(segment, source, excess, &mut light);
            if segment.is_last() {
                light = [0.0; L];
            }
        }
        for (at, segment) in self.segments.iter().enumerate().rev() {
            prefetch_index(source, place(at.wrapping_sub(AHEAD)));
            prefetch_index(&*excess, place(at.wrapping_sub(AHEAD)));
            if segment.is_last() {
                light = [0.0; L];
            }
            cross(segment, source, excess, &mut light);
        }
    }
}

#[inline(always)]
fn cross<const L: usize>(
    segment: &Segment,
    source: &[[f32; L]],
    excess: &mut [[f32; L]],
    light: &mut [f32; L],
) {
    let (source, excess) = (&source[segment.place()], &mut excess[segment.place()]);
    for lane in 0..L {
        let beyond = light[lane] - source[lane];
        light[lane] = source[lane] + beyond * segment.transmittance;
        excess[lane] += beyond * segment.adds;
    }
}

/// Beams that are marched side by side.
pub const BESIDE: usize = 8;

/// Returns the light scattered once at each non-empty site, from the mean of the beam in each; of several beams,
/// [`BESIDE`] at a time. The bits of a beam's do not depend on the others.
pub fn scattered_once(axes: &[Arc<OrdinateTracks>], beams: &[&[f32]]) -> Vec<Vec<f32>> {
    let of_some = |some: &[&[f32]]| match some.len() {
        1 => beside::<1>(axes, some),
        _ => beside::<BESIDE>(axes, some),
    };
    beams.chunks(BESIDE).flat_map(of_some).collect()
}

/// Up to `L` beams side by side.
fn beside<const L: usize>(axes: &[Arc<OrdinateTracks>], beams: &[&[f32]]) -> Vec<Vec<f32>> {
    let sites = beams[0].len();
    let source: Vec<[f32; L]> = (0..sites)
        .map(|site| std::array::from_fn(|lane| beams.get(lane).map_or(0.0, |beam| beam[site])))
        .collect();
    // The weights of a site's segments sum to 1, so that the source function itself needs no march.
    let mut excess = vec![[0.0; L]; sites];
    axes.iter()
        .for_each(|axis| Arch::new().dispatch(MarchJob { axis, source: &source, excess: &mut excess }));
    let of_lane = |lane: usize| {
        excess.iter().zip(&source).map(|(excess, beam)| (excess[lane] + beam[lane]).max(0.0)).collect()
    };
    (0..beams.len()).map(of_lane).collect()
}

/// [`OrdinateTracks::march`], compiled for the SIMD of this machine.
struct MarchJob<'a, const L: usize> {
    axis: &'a OrdinateTracks,
    source: &'a [[f32; L]],
    excess: &'a mut [[f32; L]],
}

impl<const L: usize> NullaryFnOnce for MarchJob<'_, L> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.axis.march(self.source, self.excess);
    }
}

#[cfg(test)]
mod tests {
    use super::super::near::Near;
    use super::super::uncollided::tests::{DIRECTIONS, media, unit};
    use super::*;

    #[test]
    fn beams_side_by_side_have_the_bits_of_each_alone_and_of_any_simd() {
        for medium in media() {
            let sites = medium.sites();
            let near = Near::new(&medium, &sites, true);
            let beams: Vec<Vec<f32>> =
                DIRECTIONS.iter().map(|sun| near.uncollided(unit(*sun), 1).mean).collect();
            let all: Vec<&[f32]> = beams.iter().map(Vec::as_slice).collect();
            let together = near.around_each(&all);
            assert_eq!(together.len(), beams.len());
            for (beam, together) in beams.iter().zip(together) {
                assert!(near.around(beam) == together);
            }
            let places = Sites::new(&medium.grid, &sites);
            let axis = OrdinateTracks::lay(&medium, &places, &sites, &axes()[7]);
            let source: Vec<[f32; 2]> = beams[0].iter().zip(&beams[1]).map(|(a, b)| [*a, *b]).collect();
            let (mut plain, mut wide) = (vec![[0.0; 2]; sites.len()], vec![[0.0; 2]; sites.len()]);
            axis.march(&source, &mut plain);
            Arch::new().dispatch(MarchJob { axis: &axis, source: &source, excess: &mut wide });
            assert!(plain == wide);
        }
    }
}

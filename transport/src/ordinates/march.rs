//! One pass of light through the plant: what each site sends out -> what arrives everywhere, along every ordinate.
//!
//! Light is marched along the rays of [`crossings`]. Within a site the source is constant, so the light that leaves
//! it and the mean along the segment are exact (lighting model, section 9): with `d = psi - q` the excess of the
//! arriving light over the source function, the segment leaves `q + d exp(-s)` and its mean is `q + d (1 - exp(-s)) /
//! s`.
//!
//! Radiance is relative to an even sky of fluence 1, whose moments are 1, 0, 0, ... The moments are those of the real
//! [`harmonics`] of the direction of travel: `sum over directions of weight Y_a psi`.

use std::ops::Range;
use std::sync::Arc;

use flb_format::beam::single::{OrdinateTracks, Segment};
use flb_format::beam::{Crossing, Sites, crossings, depth_per_edge};
use flb_format::sun::harmonics;
use prefetch_index::prefetch_index;
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

use super::halves::{HALVINGS, add_each, by_halves};
use super::lanes::Lanes;
use super::leaves::Leaves;
use crate::turbid::TurbidMedium;

use super::moments::{Exchange, degree};
use flb_format::ordinates::{Ordinate, Ordinates};

/// Moments that an axis knows.
const MOMENTS: usize = 9;

/// How a ray crosses a site.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slant {
    /// Optical depth s of the segment.
    pub depth: f32,
    /// Site edges.
    pub length: f32,
    /// Middle of the segment from where the axis's segments of the site have theirs in the mean, in 1/[`FINE`] of an
    /// edge.
    pub offset: [i8; 3],
}

/// Steps of [`Slant::offset`] per site edge.
pub(super) const FINE: f32 = 127.0;

/// The rays along one ordinate, for both ways.
pub(super) struct SlantedTracks {
    pub direction: [f32; 3],
    /// Weight of either way; all ways together have 1.
    pub weight: f32,
    moments: [f32; MOMENTS],
    tracks: Arc<OrdinateTracks>,
    /// One per segment of the tracks.
    slants: Vec<Slant>,
    /// Number of the last segment of each ray, plus 1.
    ends: Vec<u32>,
}

impl SlantedTracks {
    /// The rays one by one: the segments of each, and those that are visited [`AHEAD`] later, for what lies there to be
    /// fetched, as nearly all the time would go by waiting for memory. A ray goes there and back before the next one,
    /// while its sites are in a cache.
    #[inline(always)]
    fn rays(&self) -> impl Iterator<Item = (&[Segment], &[Segment])> {
        let segments = self.tracks.segments();
        self.ranges().map(|ray| {
            let later = (ray.start + AHEAD).min(segments.len());
            (&segments[ray], &segments[later..])
        })
    }

    /// [`rays`](Self::rays), and how the segments of each cross their sites.
    #[inline(always)]
    pub(super) fn slanted_rays(&self) -> impl Iterator<Item = (&[Segment], &[Slant], &[Segment])> {
        let slants = self.ranges().map(|ray| &self.slants[ray]);
        self.rays().zip(slants).map(|((ray, later), slants)| (ray, slants, later))
    }

    /// The numbers of each ray's segments.
    #[inline(always)]
    fn ranges(&self) -> impl Iterator<Item = Range<usize>> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, &end)| start as usize..end as usize)
    }

    /// The direction of travel there or back.
    pub(super) fn direction(&self, way: f32) -> [f32; 3] {
        self.direction.map(|c| way * c)
    }

    /// Moments of the direction of travel.
    pub(super) fn moments<const M: usize>(&self, way: f32) -> [f32; M] {
        std::array::from_fn(|a| if degree(a) == 1 { way * self.moments[a] } else { self.moments[a] })
    }

    /// See [`March::pass`].
    #[inline(always)]
    fn pass<const M: usize>(&self, sites: &mut [Exchange<M>]) {
        let [there, back]: [[f32; M]; 2] = WAYS.map(|way| self.moments(way));
        for (ray, later) in self.rays() {
            let mut light = Lanes::default();
            for (at, segment) in ray.iter().enumerate() {
                prefetch_index(&*sites, later.get(at).map_or(0, Segment::place));
                cross(segment, &there, &mut sites[segment.place()], &mut light);
            }
            light = Lanes::default();
            for segment in ray.iter().rev() {
                cross(segment, &back, &mut sites[segment.place()], &mut light);
            }
        }
    }

    /// See [`March::sky`].
    fn sky<const M: usize>(&self, below: f32, sky: &mut [[f32; M]]) {
        let comes = |way: f32| match self.direction(way)[1] {
            up if up > 0.0 => below,
            up if up < 0.0 => 1.0,
            _ => (1.0 + below) / 2.0,
        };
        let ([there, back], comes): ([[f32; M]; 2], _) = (WAYS.map(|way| self.moments(way)), WAYS.map(comes));
        let mut cross = |segment: &Segment, y: &[f32; M], light: &mut f32| {
            sky[segment.place()].iter_mut().zip(y).for_each(|(sum, y)| *sum += y * *light * segment.adds);
            *light *= segment.transmittance;
        };
        for (ray, _) in self.rays() {
            let mut light = comes;
            ray.iter().for_each(|segment| cross(segment, &there, &mut light[0]));
            ray.iter().rev().for_each(|segment| cross(segment, &back, &mut light[1]));
        }
    }
}

/// [`SlantedTracks::pass`] there and back, compiled for the SIMD of this machine.
struct PassJob<'a, const M: usize> {
    axis: &'a SlantedTracks,
    sites: &'a mut [Exchange<M>],
}

impl<const M: usize> NullaryFnOnce for PassJob<'_, M> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.axis.pass(self.sites);
    }
}

/// Visits between the fetching of a place and its own.
const AHEAD: usize = 48;

/// There, and back.
pub(super) const WAYS: [f32; 2] = [1.0, -1.0];

/// All rays, ready to march.
pub(super) struct March {
    pub axes: Vec<SlantedTracks>,
    /// Share of the light sent out in a site that leaves it uncollided, in the mean over its volume and all directions.
    pub escape: Vec<f32>,
    pub leaves: Leaves,
}

impl March {
    /// Lays `rays` per site edge along every ordinate. `sites` are the medium's non-empty ones.
    pub(super) fn new(medium: &TurbidMedium, sites: &[u32], ordinates: Ordinates, rays: u32) -> March {
        let places = Sites::new(&medium.grid, sites);
        let axes: Vec<SlantedTracks> =
            ordinates.axes().par_iter().map(|ordinate| lay(medium, &places, sites, ordinate, rays)).collect();
        let escape_along = |axes: &[SlantedTracks]| {
            let mut escape = vec![0.0_f32; sites.len()];
            for segment in axes.iter().flat_map(|axis| axis.tracks.segments()) {
                escape[segment.place()] += 2.0 * segment.adds;
            }
            escape
        };
        let add = |escape: &mut Vec<f32>, other: Vec<f32>| add_each(escape, &other);
        let escape = by_halves(&axes, HALVINGS, &escape_along, &add);
        March { axes, escape, leaves: Leaves::new(&medium.angles) }
    }

    /// The rays without how they cross sites.
    pub(super) fn tracks(&self) -> Vec<Arc<OrdinateTracks>> {
        self.axes.iter().map(|axis| axis.tracks.clone()).collect()
    }

    /// Adds to the excess of each site the moments of what arrives beyond the source function.
    pub(super) fn pass<const M: usize>(&self, sites: &mut [Exchange<M>]) {
        for axis in &self.axes {
            Arch::new().dispatch(PassJob { axis, sites });
        }
    }

    /// Moments of an even sky of fluence 1 before any scattering; from below the horizon comes `below` times its light.
    pub(super) fn sky<const M: usize>(&self, below: f32) -> Vec<[f32; M]> {
        let along = |axes: &[SlantedTracks]| {
            let mut sky = vec![[0.0_f32; M]; self.escape.len()];
            axes.iter().for_each(|axis| axis.sky(below, &mut sky));
            sky
        };
        let add = |sky: &mut Vec<[f32; M]>, other: Vec<[f32; M]>| {
            add_each(sky.as_flattened_mut(), other.as_flattened());
        };
        by_halves(&self.axes, HALVINGS, &along, &add)
    }
}

#[inline(always)]
fn cross<const M: usize>(segment: &Segment, y: &[f32; M], site: &mut Exchange<M>, light: &mut Lanes) {
    let mut q = Lanes::default();
    for (y, source) in y.iter().zip(site.source) {
        q += *y * source;
    }
    let beyond = *light - q;
    *light = q + segment.transmittance * beyond;
    let adds = segment.adds * beyond;
    for (y, excess) in y.iter().zip(&mut site.excess) {
        *excess += *y * adds;
    }
}

fn lay(
    medium: &TurbidMedium,
    places: &Sites,
    sites: &[u32],
    ordinate: &Ordinate,
    rays: u32,
) -> SlantedTracks {
    let depth = depth_per_edge(medium, sites, ordinate.direction);
    let found = crossings(places, ordinate.direction, rays);
    // Per site: sums of length, and of length x middle.
    let mut sums = vec![[0.0_f32; 4]; sites.len()];
    for Crossing { place, length, middle, .. } in &found {
        let [lengths, middles @ ..] = &mut sums[*place as usize];
        *lengths += length;
        middles.iter_mut().zip(middle).for_each(|(sum, middle)| *sum += length * middle);
    }
    let slant = |&Crossing { place, length, middle, .. }: &Crossing| {
        let [lengths, middles @ ..] = sums[place as usize];
        let from_mean = |axis: usize| middle[axis] - middles[axis] / lengths;
        let offset = std::array::from_fn(|axis| (from_mean(axis) * FINE).clamp(-127.0, 127.0) as i8);
        Slant { depth: depth[place as usize] * length, length, offset }
    };
    let tracks = OrdinateTracks::of_crossings(&found, &depth, |place| sums[place][0], ordinate.weight);
    let y = harmonics::evaluate(ordinate.direction);
    SlantedTracks {
        direction: ordinate.direction.map(|c| c as f32),
        weight: ordinate.weight as f32,
        moments: std::array::from_fn(|a| y[a] as f32),
        tracks: Arc::new(tracks),
        slants: found.iter().map(slant).collect(),
        ends: (1..).zip(&found).filter(|(_, crossing)| crossing.is_last).map(|(end, _)| end).collect(),
    }
}

#[cfg(test)]
pub(super) mod tests;

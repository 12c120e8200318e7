//! The first scattering of beams: what the sites scatter of them by their phase functions -> what arrives everywhere.
//!
//! A beam's fluence changes along straight lines within a site, and so does what it scatters. A ray goes there and back
//! before the next one; geometry and light of its crossings are made once for both ways.

use flb_format::beam::Beam;
use flb_format::beam::single::Segment;
use prefetch_index::prefetch_index;
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

use super::halves::{HALVINGS, add_each, by_halves};
use super::lanes::{LANES, Lanes};
use super::march::{FINE, March, Slant, SlantedTracks, WAYS};
use super::moments::{Moments, none_below_0};
use crate::turbid::Phase;

impl March {
    /// Moments of the light of up to [`LANES`] beams after one scattering, by the phase functions themselves,
    /// `[band][site]`. A beam's fluence changes along straight lines within a site, and so does what it scatters: taken
    /// constant, sites that are dense and lit from one side would be several per cent off.
    pub(super) fn first_scattering<const M: usize, const B: usize>(
        &self,
        matter: [&SiteScattering; B],
        beams: &[&Beam],
    ) -> [Moments<M>; B] {
        let lanes = |of: &dyn Fn(&Beam) -> f32| lanes_of(beams, of);
        let lights: Vec<SiteLight> = (0..self.escape.len())
            .map(|site| {
                let slope = |i: usize| lanes(&|beam| beam.slope[site][i]);
                [LanePair([lanes(&|beam| beam.mean[site]), slope(0)]), LanePair([slope(1), slope(2)])]
            })
            .collect();
        let albedos: Vec<Albedos<B>> =
            (0..self.escape.len()).map(|site| Albedos(matter.map(|matter| matter.albedos[site]))).collect();
        let turned = turned(self, matter, beams);
        let axes: Vec<(&SlantedTracks, &Turned<B>)> = self.axes.iter().zip(&turned).collect();
        let of_axes = |axes: &[(&SlantedTracks, &Turned<B>)]| {
            let mut first = vec![[[Lanes::default(); M]; B]; self.escape.len()];
            let (mut crossed, albedos, lights) = (Vec::new(), &albedos, &lights);
            for &(axis, turned) in axes {
                let (first, crossed) = (&mut first, &mut crossed);
                Arch::new().dispatch(FirstJob { axis, albedos, turned, lights, first, crossed });
            }
            first
        };
        let add = |first: &mut Vec<[[Lanes; M]; B]>, other: Vec<[[Lanes; M]; B]>| {
            add_each(first.as_flattened_mut().as_flattened_mut(), other.as_flattened().as_flattened());
        };
        let first = by_halves(&axes, HALVINGS, &of_axes, &add);
        std::array::from_fn(|band| none_below_0(first.iter().map(|first| first[band]).collect()))
    }
}

/// One number for each of up to [`LANES`] beams. An idle lane has 0.
fn lanes_of(beams: &[&Beam], of: &dyn Fn(&Beam) -> f32) -> Lanes {
    Lanes(std::array::from_fn(|lane| beams.get(lane).map_or(0.0, |beam| of(beam))))
}

/// What leaf and wood of albedo 1 scatter of each beam into the direction of an axis, and into the opposite one,
/// relative to their extinction along it: `[way][band][leaf, wood]`.
pub(super) type Turned<const B: usize> = [[[Lanes; 2]; B]; 2];

/// Finds what is scattered into each axis of a march, in each band.
pub(super) fn turned<const B: usize>(
    march: &March,
    matter: [&SiteScattering; B],
    beams: &[&Beam],
) -> Vec<Turned<B>> {
    let from: Vec<[f64; 3]> = beams.iter().map(|beam| beam.towards_sun.map(|c| -c)).collect();
    let scattered = |axis: &SlantedTracks| -> Turned<B> {
        let there = axis.direction(WAYS[0]).map(f64::from);
        // Of all bands alike; on the way back they change places.
        let of_facets: Vec<Option<[f64; 2]>> =
            from.iter().map(|from| march.leaves.of_facets(*from, there)).collect();
        WAYS.map(|way| {
            let to = axis.direction(way).map(f64::from);
            let of_beam = |matter: &SiteScattering, i: usize, lane: usize| {
                let of_facets = of_facets[lane].map(|[a, b]| if way == WAYS[0] { [a, b] } else { [b, a] });
                let of_facets = of_facets.filter(|_| matter.are_leaves[i]);
                march.leaves.scattered(matter.phases[i], of_facets, from[lane], to) as f32
            };
            let lanes = |matter, i| {
                Lanes(std::array::from_fn(
                    |lane| if lane < from.len() { of_beam(matter, i, lane) } else { 0.0 },
                ))
            };
            matter.map(|matter| std::array::from_fn(|i| lanes(matter, i)))
        })
    };
    let mut turned: Vec<Turned<B>> = march.axes.par_iter().map(scattered).collect();
    // All directions together have what is met of the beam.
    for band in 0..B {
        for i in 0..2 {
            let leaning = matter[band].are_leaves[i];
            let relative =
                |direction: [f64; 3]| if leaning { march.leaves.relative(direction) as f32 } else { 1.0 };
            let mut whole = Lanes::default();
            for (axis, turned) in march.axes.iter().zip(&turned) {
                let ways = turned[0][band][i] + turned[1][band][i];
                whole += axis.weight * (relative(axis.direction.map(f64::from)) * ways);
            }
            let met = lanes_of(beams, &|beam| relative(beam.towards_sun));
            // An idle lane has no light: 0 of 0.
            let factor: [f32; LANES] = std::array::from_fn(|lane| whole.0[lane].max(f32::MIN_POSITIVE));
            for turned in turned.iter_mut().flatten() {
                let values = &mut turned[band][i].0;
                (0..LANES).for_each(|lane| values[lane] = met.0[lane] * values[lane] / factor[lane]);
            }
        }
    }
    turned
}

impl SlantedTracks {
    /// See [`March::first_scattering`]: `turned` is what leaf and wood of albedo 1 scatter of each beam into this
    /// direction and into the opposite one, in each band; `albedos` are those of each site, in each band.
    #[inline(always)]
    fn scatter_first<const M: usize, const B: usize>(
        &self,
        albedos: &[Albedos<B>],
        turned: &Turned<B>,
        lights: &[SiteLight],
        first: &mut [[[Lanes; M]; B]],
        crossed: &mut Vec<Crossed<B>>,
    ) {
        let [there, back]: [[f32; M]; 2] = WAYS.map(|way| self.moments(way));
        for (ray, slants, later) in self.slanted_rays() {
            crossed.clear();
            let mut rays = [Lanes::default(); B];
            for (at, (segment, slant)) in ray.iter().zip(slants).enumerate() {
                // Two lines of a cache each.
                let later = later.get(at).map_or(0, Segment::place);
                prefetch_index(lights.as_flattened(), 2 * later);
                prefetch_index(lights.as_flattened(), 2 * later + 1);
                prefetch_index(first.as_flattened(), B * later);
                prefetch_index(first.as_flattened(), B * later + B - 1);
                prefetch_index(albedos, later);
                let place = segment.place();
                let slanted = Slanted::new(segment, slant);
                let light = SlantedLight::new(slant, self.direction, &lights[place]);
                let mut adds = [Lanes::default(); B];
                for band in 0..B {
                    let (albedos, turned) = (albedos[place].0[band], &turned[0][band]);
                    adds[band] = slanted.cross(albedos, turned, &light, segment, &mut rays[band]);
                }
                crossed.push(Crossed { slanted, light: light.reversed(), adds });
            }
            rays = [Lanes::default(); B];
            for (segment, crossed) in ray.iter().zip(&*crossed).rev() {
                let Crossed { slanted, light, adds } = crossed;
                let place = segment.place();
                let first = &mut first[place];
                for band in 0..B {
                    let (albedos, turned) = (albedos[place].0[band], &turned[1][band]);
                    let adds_back = slanted.cross(albedos, turned, light, segment, &mut rays[band]);
                    for ((first, there), back) in first[band].iter_mut().zip(there).zip(back) {
                        *first += there * adds[band] + back * adds_back;
                    }
                }
            }
        }
    }
}

/// A segment that light has crossed on its way there, for the way back.
struct Crossed<const B: usize> {
    slanted: Slanted,
    /// Of the way back.
    light: SlantedLight,
    /// What the way there adds to the mean of the site, in each band.
    adds: [Lanes; B],
}

/// [`SlantedTracks::scatter_first`], compiled for the SIMD of this machine.
struct FirstJob<'a, const M: usize, const B: usize> {
    axis: &'a SlantedTracks,
    albedos: &'a [Albedos<B>],
    turned: &'a Turned<B>,
    lights: &'a [SiteLight],
    first: &'a mut [[[Lanes; M]; B]],
    crossed: &'a mut Vec<Crossed<B>>,
}

impl<const M: usize, const B: usize> NullaryFnOnce for FirstJob<'_, M, B> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let FirstJob { axis, albedos, turned, lights, first, crossed } = self;
        axis.scatter_first(albedos, turned, lights, first, crossed);
    }
}

/// What leaf and wood scatter, in one band.
pub(super) struct SiteScattering {
    /// `[site][leaf, wood]`: albedo x share of the site's extinction.
    pub albedos: Vec<[f32; 2]>,
    /// Phase functions of leaf and of wood.
    pub phases: [Phase; 2],
    /// Whether each of the two scatters as leaves do, that may favour an inclination.
    pub are_leaves: [bool; 2],
}

/// A segment through a source that changes along it.
#[derive(Clone, Copy)]
struct Slanted {
    /// Of the ordinate, times the share of the site's segments.
    weight: f32,
    /// What a source that rises by 1 along the segment, 0 in the middle, adds to the light that leaves.
    leaves: f32,
    /// ... and to the mean along the segment: what left was not added there.
    stays: f32,
}

impl Slanted {
    #[inline(always)]
    fn new(segment: &Segment, slant: &Slant) -> Slanted {
        let s = slant.depth;
        let gone = 1.0 - segment.transmittance;
        // Series where the closed forms cancel.
        let (mean, leaves, stays) = if s < 0.03 {
            let stays = -s / 12.0 * (1.0 - 0.5 * s);
            (1.0 - 0.5 * s, -stays * s, stays)
        } else {
            let mean = gone / s;
            let leaves = 1.0 - mean - 0.5 * gone;
            (mean, leaves, -leaves / s)
        };
        Slanted { weight: segment.adds / mean, leaves, stays }
    }

    /// Carries the ray across, and gives what the segment adds to the mean of the site over all directions.
    #[inline(always)]
    fn cross(
        &self,
        [leaf, wood]: [f32; 2],
        [of_leaf, of_wood]: &[Lanes; 2],
        light: &SlantedLight,
        segment: &Segment,
        ray: &mut Lanes,
    ) -> Lanes {
        let share = leaf * *of_leaf + wood * *of_wood;
        let (aside, along, even) = (share * light.aside, share * light.along, share * light.mean);
        let source = even + aside;
        let beyond = *ray - source;
        *ray = source + segment.transmittance * beyond + self.leaves * along;
        // The even part is the same for all segments of the site, whose weights sum to the ordinate's.
        segment.adds * beyond + self.weight * (source + self.stays * along)
    }
}

/// Light of beams within a site: mean, and slope along x, y and z.
type SiteLight = [LanePair; 2];

/// Fills a line of a cache.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct LanePair([Lanes; 2]);

/// Albedos of a site, `[band][leaf, wood]`, within a line of a cache.
#[repr(align(32))]
struct Albedos<const B: usize>([[f32; 2]; B]);

/// Light of beams along a segment.
#[derive(Clone, Copy)]
struct SlantedLight {
    /// Mean over the site.
    mean: Lanes,
    /// What its middle has beyond the mean.
    aside: Lanes,
    /// By how much it rises from where the ray enters to where it leaves.
    along: Lanes,
}

impl SlantedLight {
    /// The beams' light along a segment, from that of its site.
    #[inline(always)]
    fn new(
        slant: &Slant,
        direction: [f32; 3],
        [LanePair([mean, x]), LanePair([y, z])]: &SiteLight,
    ) -> SlantedLight {
        let light = |along: [f32; 3]| along[0] * *x + along[1] * *y + along[2] * *z;
        // From the mean place of the axis's segments of the site to the middle of this one, in site edges.
        let aside = light(slant.offset.map(|c| f32::from(c) * (1.0 / FINE)));
        SlantedLight { mean: *mean, aside, along: light(direction.map(|c| c * slant.length)) }
    }

    /// Of a ray that goes the other way.
    #[inline(always)]
    fn reversed(&self) -> SlantedLight {
        SlantedLight { along: -self.along, ..*self }
    }
}

#[cfg(test)]
mod tests;

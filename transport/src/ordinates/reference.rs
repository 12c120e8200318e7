//! The same light in f64, by the plainest code: what the errors of the fast solver in f32 are measured against.
//!
//! It shares with that solver where rays cross sites and the beam of a sun. Every ordinate is marched by itself, there
//! and back; plain fixed-point steps go on until nothing changes; every sun is solved to its end.

use flb_format::beam::{Beam, Sites, crossings, depth_per_edge};
use flb_format::matter::TurbidMedium;
use flb_format::ordinates::Ordinates;
use flb_format::sun::harmonics;
use rayon::prelude::*;

use super::leaves::Leaves;
use super::moments::degree;
use crate::turbid::{BandScatter, extinction_moment};

/// Moments that are known of the light.
const MOMENTS: usize = 9;

/// Power below which nothing is asked of a balance, W at a fluence of 1 W/m^2.
const MIN_POWER: f64 = 1e-30;

/// Light that enters.
#[derive(Clone, Copy)]
pub(super) enum Entering<'a> {
    /// The even sky of fluence 1.
    Sky,
    /// A beam whose light at the sites is known.
    Beam(&'a Beam),
}

/// A ray crosses a site.
struct Segment {
    place: usize,
    is_last: bool,
    /// What it does to light.
    crossed: Crossed,
    /// Site edges.
    length: f64,
    /// Share of the lengths of all rays of the ordinate in the site.
    share: f64,
    /// Middle, from the mean middle of the ordinate's segments of the site, in site edges.
    offset: [f64; 3],
}

/// The rays along one ordinate, one way.
struct Rays {
    direction: [f64; 3],
    weight: f64,
    /// Cross-section that a ray stands for, m^2: rays stand evenly across the main axis.
    ray_m2: f64,
    moments: [f64; MOMENTS],
    /// In the order of travel, ray after ray.
    segments: Vec<Segment>,
}

/// A band of a medium, ready to be solved.
pub(super) struct Reference<'a> {
    medium: &'a TurbidMedium,
    sites: &'a [u32],
    rays: Vec<Rays>,
    /// Albedo x share of the extinction, `[site][leaf, wood]`.
    albedos: Vec<[f64; 2]>,
    scatter: &'a BandScatter,
    /// Legendre moments of the phase functions of leaf and of wood.
    phase_moments: [[f64; 3]; 2],
    leaves: Leaves,
    /// Degree of the moments up to which scattered light is scattered again.
    degree: usize,
    /// Second moment of the leaf extinction where it counts, else 0.
    leaning: f64,
}

/// Light of one sun, or of the sky, solved to the end.
pub(super) struct ExactLight {
    /// Scattered fluence of each site; of the sky what has met nothing, too.
    pub fluence: Vec<f64>,
    /// Whether nothing changed any more.
    pub ended: bool,
    /// Power that matter meets, W at a fluence of 1 W/m^2 where nothing is in the way.
    met: f64,
    /// Power that leaves; of a beam what is absorbed at once, too.
    gone: f64,
    /// Power that is absorbed at each site where its fluence is 1, by leaf and by wood.
    absorbs: Vec<[f64; 2]>,
    /// What leaves meet beyond the fluence, as they lean.
    beyond: Vec<f64>,
}

impl ExactLight {
    /// What neither leaves nor is absorbed, as a share of what is met, where the sites have these fluences.
    pub(super) fn imbalance(&self, fluence: &[f64]) -> f64 {
        let of_site = |((fluence, [leaf, wood]), beyond): ((&f64, &[f64; 2]), &f64)| {
            (leaf + wood) * fluence + leaf * beyond
        };
        let absorbed: f64 = fluence.iter().zip(&self.absorbs).zip(&self.beyond).map(of_site).sum();
        (self.met - absorbed - self.gone) / self.met.max(MIN_POWER)
    }
}

/// Moments of the light of each site.
type Light = Vec<[f64; MOMENTS]>;

impl<'a> Reference<'a> {
    /// For a medium's non-empty sites; moments are those that the fast solver takes: 1, 4 or 9.
    pub(super) fn new(
        medium: &'a TurbidMedium,
        sites: &'a [u32],
        scatter: &'a BandScatter,
        ordinates: Ordinates,
        rays: u32,
        moments: usize,
    ) -> Reference<'a> {
        let (places, ray_m) = (Sites::new(&medium.grid, sites), medium.grid.spacing_m / f64::from(rays));
        let both_ways = ordinates.axes().into_par_iter().flat_map_iter(|ordinate| {
            let across = ordinate.direction.iter().fold(0.0_f64, |most, c| most.max(c.abs()));
            let depth = depth_per_edge(medium, sites, ordinate.direction);
            let found = crossings(&places, ordinate.direction, rays);
            // Sums of length, and of length x middle.
            let mut sums = vec![[0.0_f64; 4]; sites.len()];
            for crossing in &found {
                let [lengths, middles @ ..] = &mut sums[crossing.place as usize];
                let length = f64::from(crossing.length);
                *lengths += length;
                middles.iter_mut().zip(crossing.middle).for_each(|(sum, c)| *sum += length * f64::from(c));
            }
            let segment = |crossing: &flb_format::beam::Crossing| {
                let place = crossing.place as usize;
                let ([lengths, middles @ ..], length) = (sums[place], f64::from(crossing.length));
                Segment {
                    place,
                    is_last: crossing.is_last,
                    crossed: Crossed::new(f64::from(depth[place]) * length),
                    length,
                    share: length / lengths,
                    offset: std::array::from_fn(|i| f64::from(crossing.middle[i]) - middles[i] / lengths),
                }
            };
            [false, true].map(|back| {
                let direction = ordinate.direction.map(|c| if back { -c } else { c });
                let y = harmonics::evaluate(direction);
                let mut segments: Vec<Segment> = found.iter().map(segment).collect();
                if back {
                    // What was the first of its ray is the last.
                    let starts: Vec<bool> = std::iter::once(true)
                        .chain(segments.iter().map(|segment| segment.is_last))
                        .take(segments.len())
                        .collect();
                    segments.iter_mut().zip(starts).for_each(|(segment, start)| segment.is_last = start);
                    segments.reverse();
                }
                let moments = std::array::from_fn(|a| y[a]);
                Rays { direction, weight: ordinate.weight, ray_m2: ray_m * ray_m * across, moments, segments }
            })
        });
        let both = [&scatter.leaf, &scatter.wood];
        let albedos = sites.iter().map(|&site| {
            let wood = f64::from(medium.wood_per_m[site as usize]);
            let leaf = f64::from(medium.leaf_per_m[site as usize]);
            [leaf / (leaf + wood) * both[0].albedo, wood / (leaf + wood) * both[1].albedo]
        });
        let degree = [1, 4, 9].iter().position(|&count| count == moments).expect("1, 4 or 9 moments");
        Reference {
            rays: both_ways.collect(),
            albedos: albedos.collect(),
            phase_moments: both.map(|matter| std::array::from_fn(|l| matter.phase.moment(l))),
            leaves: Leaves::new(&medium.angles),
            leaning: if degree == 2 { extinction_moment(&medium.angles) } else { 0.0 },
            degree,
            medium,
            sites,
            scatter,
        }
    }

    /// Solves until the steps are below `tolerance` of the light, or `most` are done.
    pub(super) fn solve(&self, entering: Entering, tolerance: f64, most: u32) -> ExactLight {
        // What is met, and what of it leaves or is absorbed at its first scattering.
        let (direct, first, met, gone_at_once) = match entering {
            Entering::Sky => {
                let (direct, passes) = self.march(&|_, _, _| [0.0; 2], 1.0);
                let all: f64 = self.rays.iter().map(|rays| rays.weight * rays.ray_m2 * rays.count()).sum();
                let first = self.arrives(&direct).0;
                // What is scattered of it leaves with the rest.
                (direct, first, all - passes, 0.0)
            }
            Entering::Beam(beam) => {
                let met = self.met_of(beam, |_| 1.0);
                let none = vec![[0.0; MOMENTS]; self.sites.len()];
                let (first, leaves) = self.first(beam);
                (none, first, met, leaves + self.met_of(beam, |albedo| 1.0 - albedo))
            }
        };
        let own = self.own();
        let mut light = first.clone();
        let (mut ended, mut steps) = (false, 0);
        while !ended && steps < most {
            let (arrives, _) = self.arrives(&light);
            let (mut change, mut norm) = (0.0, 0.0);
            for (site, light) in light.iter_mut().enumerate() {
                for a in 0..self.moments() {
                    let whole = 1.0 / (1.0 - self.gain(site, degree(a)) * own[site]);
                    let step = whole * (first[site][a] + arrives[site][a] - light[a]);
                    if a == 0 {
                        change += step * step;
                        norm += light[0] * light[0];
                    }
                    light[a] += step;
                }
            }
            ended = change <= tolerance * tolerance * norm;
            steps += 1;
        }
        let all: Light = light
            .iter()
            .zip(&direct)
            .map(|(light, direct)| std::array::from_fn(|a| light[a] + direct[a]))
            .collect();
        let moment = extinction_moment(&self.medium.angles);
        ExactLight {
            fluence: all.iter().map(|light| light[0]).collect(),
            ended,
            met,
            gone: gone_at_once + self.arrives(&all).1,
            absorbs: self.sites.iter().map(|&site| self.absorbs(site as usize)).collect(),
            beyond: all.iter().map(|light| moment * up_moment(light)).collect(),
        }
    }

    fn moments(&self) -> usize {
        (self.degree + 1) * (self.degree + 1)
    }

    /// Albedo x Legendre moment of the phase function.
    fn gain(&self, site: usize, degree: usize) -> f64 {
        (0..2).map(|i| self.albedos[site][i] * self.phase_moments[i][degree]).sum()
    }

    /// Share of what a site sends out that it takes back.
    fn own(&self) -> Vec<f64> {
        let mut escape = vec![0.0; self.sites.len()];
        for rays in &self.rays {
            for segment in &rays.segments {
                escape[segment.place] += rays.weight * segment.share * segment.crossed.mean;
            }
        }
        escape.iter().map(|escape| 1.0 - escape).collect()
    }

    fn site_m3(&self) -> f64 {
        let edge_m = self.medium.grid.spacing_m;
        edge_m * edge_m * edge_m
    }

    /// Power that is absorbed at a site where its fluence is 1, by leaf and by wood.
    fn absorbs(&self, site: usize) -> [f64; 2] {
        let both =
            [(&self.medium.leaf_per_m, self.scatter.leaf), (&self.medium.wood_per_m, self.scatter.wood)];
        let volume = self.site_m3();
        both.map(|(per_m, scatter)| f64::from(per_m[site]) * (1.0 - scatter.albedo) * volume)
    }

    /// Power of a beam that is met, times a function of the albedo of what meets it.
    fn met_of(&self, beam: &Beam, share: impl Fn(f64) -> f64) -> f64 {
        let volume = self.site_m3();
        let more = self.leaves.relative(beam.towards_sun);
        let of_site = |(&site, light): (&u32, &f32)| {
            let leaf =
                f64::from(self.medium.leaf_per_m[site as usize]) * more * share(self.scatter.leaf.albedo);
            let wood = f64::from(self.medium.wood_per_m[site as usize]) * share(self.scatter.wood.albedo);
            (leaf + wood) * f64::from(*light)
        };
        self.sites.iter().zip(&beam.mean).map(of_site).sum::<f64>() * volume
    }

    /// Light that a beam's first scattering sends everywhere, and how much of it leaves.
    fn first(&self, beam: &Beam) -> (Light, f64) {
        let phases = [self.scatter.leaf.phase, self.scatter.wood.phase];
        let from = beam.towards_sun.map(|c| -c);
        let leans = |i: usize, direction| if i == 0 { self.leaves.relative(direction) } else { 1.0 };
        let into = |i: usize, to| {
            self.leaves.scattered(phases[i], self.leaves.of_facets(from, to).filter(|_| i == 0), from, to)
        };
        let factor: [f64; 2] = std::array::from_fn(|i| {
            let of = |rays: &Rays| rays.weight * leans(i, rays.direction) * into(i, rays.direction);
            leans(i, beam.towards_sun) / self.rays.iter().map(of).sum::<f64>()
        });
        let turned: Vec<[f64; 2]> = self
            .rays
            .iter()
            .map(|rays| std::array::from_fn(|i| factor[i] * into(i, rays.direction)))
            .collect();
        let source = |at: usize, rays: &Rays, segment: &Segment| {
            let albedos = self.albedos[segment.place];
            let share = albedos[0] * turned[at][0] + albedos[1] * turned[at][1];
            let along = |v: [f64; 3]| -> f64 {
                beam.slope[segment.place].iter().zip(v).map(|(slope, c)| f64::from(*slope) * c).sum()
            };
            let middle = f64::from(beam.mean[segment.place]) + along(segment.offset);
            [share * middle, share * along(rays.direction) * segment.length]
        };
        let (mut first, leaves) = self.march(&source, 0.0);
        first.iter_mut().for_each(|light| light[0] = light[0].max(0.0));
        (first, leaves)
    }

    /// What arrives of light, scattered once more, and how much of it leaves.
    fn arrives(&self, light: &Light) -> (Light, f64) {
        let sources = light.iter().enumerate().map(|(site, light)| {
            let mut source: [f64; MOMENTS] = std::array::from_fn(|a| {
                if degree(a) <= self.degree { self.gain(site, degree(a)) * light[a] } else { 0.0 }
            });
            source[0] += self.leaning * self.albedos[site][0] * up_moment(light);
            source
        });
        let sources: Light = sources.collect();
        let source = |_, rays: &Rays, segment: &Segment| {
            let of_site = &sources[segment.place][..self.moments()];
            [rays.moments.iter().zip(of_site).map(|(y, source)| y * source).sum(), 0.0]
        };
        self.march(&source, 0.0)
    }

    /// Light that `source`, at the middle of a segment and by how much it rises along it, sends everywhere, with that
    /// which enters; and the power that leaves.
    fn march(
        &self,
        source: &(impl Fn(usize, &Rays, &Segment) -> [f64; 2] + Sync),
        enters: f64,
    ) -> (Light, f64) {
        let of_rays = |(at, rays): (usize, &Rays)| {
            let mut means = vec![0.0; self.sites.len()];
            let (mut light, mut leaves) = (enters, 0.0);
            for segment in &rays.segments {
                let ([even, rise], crossed) = (source(at, rays, segment), &segment.crossed);
                let mean = even + (light - even) * crossed.mean + crossed.stays * rise;
                means[segment.place] += segment.share * mean;
                light = even + (light - even) * (1.0 - crossed.gone) + crossed.leaves * rise;
                if segment.is_last {
                    leaves += light;
                    light = enters;
                }
            }
            (means, leaves)
        };
        let each: Vec<(Vec<f64>, f64)> = self.rays.par_iter().enumerate().map(of_rays).collect();
        let (mut sums, mut leaves) = (vec![[0.0; MOMENTS]; self.sites.len()], 0.0);
        for (rays, (means, of_rays)) in self.rays.iter().zip(each) {
            leaves += rays.weight * rays.ray_m2 * of_rays;
            for (sums, mean) in sums.iter_mut().zip(means) {
                sums.iter_mut().zip(rays.moments).for_each(|(sum, y)| *sum += rays.weight * y * mean);
            }
        }
        (sums, leaves)
    }
}

impl Rays {
    fn count(&self) -> f64 {
        self.segments.iter().filter(|segment| segment.is_last).count() as f64
    }
}

/// Second moment of the light about the vertical.
fn up_moment(light: &[f64; MOMENTS]) -> f64 {
    -0.5 * light[6] - libm::sqrt(3.0) / 2.0 * light[8]
}

/// What a segment does to light.
struct Crossed {
    /// Share that is lost.
    gone: f64,
    /// Share of what enters that is there in the mean.
    mean: f64,
    /// What a source that rises by 1 along the segment, 0 in the middle, adds to what leaves ...
    leaves: f64,
    /// ... and to the mean.
    stays: f64,
}

impl Crossed {
    fn new(depth: f64) -> Crossed {
        let gone = -libm::expm1(-depth);
        if depth == 0.0 {
            return Crossed { gone, mean: 1.0, leaves: 0.0, stays: 0.0 };
        }
        let mean = gone / depth;
        // The closed form cancels.
        let leaves = match depth < 0.03 {
            true => depth * depth * (1.0 / 12.0 - depth * (1.0 / 24.0 - depth / 80.0)),
            false => 1.0 - mean - gone / 2.0,
        };
        Crossed { gone, mean, leaves, stays: -leaves / depth }
    }
}

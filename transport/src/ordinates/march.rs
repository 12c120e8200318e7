//! One pass of light through the plant: what each site sends out -> what arrives everywhere, along every ordinate.
//!
//! Light is marched along the rays of [`crossings`]. Within a site the source is constant, so the light that leaves
//! it and the mean along the segment are exact (lighting model, section 9): with `d = psi - q` the excess of the
//! arriving light over the source function, the segment leaves `q + d exp(-s)` and its mean is `q + d (1 - exp(-s)) /
//! s`.
//!
//! Radiance is relative to an even sky of fluence 1, whose moments are 1, 0, 0, ... The moments are those of the real
//! [`harmonics`] of the direction of travel: `sum over directions of weight Y_a psi`.

use flb_format::beam::{Beam, Crossing, Passing, Sites, crossings, depth_per_edge};
use flb_format::sun::harmonics;
use prefetch_index::prefetch_index;
use rayon::prelude::*;

use super::lanes::{LANES, Lanes};
use crate::turbid::{Phase, TurbidMedium};

use super::moments::{Moments, ScatteringMoments, degree};
use flb_format::ordinates::{Ordinate, Ordinates};

/// Moments that an axis knows.
const MOMENTS: usize = 9;

/// A ray crosses a site.
#[derive(Debug, Clone, Copy)]
struct Segment {
    /// Place in the list of sites; [`LAST`] is set where the ray ends.
    place: u32,
    /// exp(-s).
    transmittance: f32,
    /// What a unit of excess adds to the mean over the site and all directions: weight of the ordinate x share of the
    /// site's segments x (1 - exp(-s)) / s.
    adds: f32,
    /// Optical depth s.
    depth: f32,
    /// Middle of the segment from where the axis's segments of the site have theirs in the mean, in 1/[`FINE`] of an
    /// edge.
    offset: [i8; 3],
}

/// Steps of [`Segment::offset`] per site edge.
const FINE: f32 = 127.0;

const LAST: u32 = 1 << 31;

impl Segment {
    fn place(&self) -> usize {
        (self.place & !LAST) as usize
    }

    fn is_last(&self) -> bool {
        self.place & LAST != 0
    }
}

/// The rays along one ordinate, for both ways.
struct OrdinateTracks {
    direction: [f32; 3],
    /// Of either way; all ways together have 1.
    weight: f32,
    moments: [f32; MOMENTS],
    /// Optical depth of each site per edge.
    depth: Vec<f32>,
    segments: Vec<Segment>,
}

impl OrdinateTracks {
    /// Visits the segments there or back, with whether a ray begins, and a place that is visited some visits later, for
    /// what lies there to be fetched: nearly all the time would go by waiting for memory. Each way has code of its own:
    /// a visit that is called from one place becomes part of the loop, and keeps the ray's light in registers.
    #[inline(always)]
    fn walk<const BACK: bool>(&self, mut visit: impl FnMut(&Segment, bool, usize)) {
        let count = self.segments.len();
        let number = |at: usize| if BACK { count - 1 - at } else { at };
        let mut begins = true;
        let mut at = 0;
        while at < count {
            let segment = &self.segments[number(at)];
            let later = if at + AHEAD < count { self.segments[number(at + AHEAD)].place() } else { 0 };
            visit(segment, if BACK { segment.is_last() } else { begins }, later);
            begins = segment.is_last();
            at += 1;
        }
    }

    /// The direction of travel there or back.
    fn direction(&self, way: f32) -> [f32; 3] {
        self.direction.map(|c| way * c)
    }

    /// Moments of the direction of travel.
    fn moments<const M: usize>(&self, way: f32) -> [f32; M] {
        std::array::from_fn(|a| if degree(a) == 1 { way * self.moments[a] } else { self.moments[a] })
    }

    /// See [`March::pass`].
    #[inline(never)]
    fn pass<const M: usize, const BACK: bool>(&self, source: &Moments<M>, excess: &mut Moments<M>) {
        let y: [f32; M] = self.moments(WAYS[usize::from(BACK)]);
        let mut light = Lanes::default();
        self.walk::<BACK>(|segment, begins, later| {
            prefetch_index(&**source, later);
            prefetch_index(&**excess, later);
            if begins {
                light = Lanes::default();
            }
            let place = segment.place();
            cross(segment, &y, &source[place], &mut excess[place], &mut light);
        });
    }

    /// See [`March::sky`].
    fn sky<const M: usize, const BACK: bool>(&self, below: f32, sky: &mut [[f32; M]]) {
        let way = WAYS[usize::from(BACK)];
        let y: [f32; M] = self.moments(way);
        let comes = match self.direction(way)[1] {
            up if up > 0.0 => below,
            up if up < 0.0 => 1.0,
            _ => (1.0 + below) / 2.0,
        };
        let mut light = comes;
        self.walk::<BACK>(|segment, begins, _| {
            if begins {
                light = comes;
            }
            sky[segment.place()].iter_mut().zip(&y).for_each(|(sum, y)| *sum += y * light * segment.adds);
            light *= segment.transmittance;
        });
    }

    /// See [`March::first_scattering`]: `turned` is what leaf and wood of albedo 1 scatter of each beam into this
    /// direction, in each band; `albedos` are those of each site, in each band.
    #[inline(never)]
    fn scatter_first<const M: usize, const B: usize, const BACK: bool>(
        &self,
        albedos: &[[[f32; 2]; B]],
        turned: &[[Lanes; 2]; B],
        lights: &[[Lanes; 4]],
        first: &mut [[[Lanes; M]; B]],
    ) {
        let way = WAYS[usize::from(BACK)];
        let (y, direction): ([f32; M], _) = (self.moments(way), self.direction(way));
        let mut rays = [Lanes::default(); B];
        self.walk::<BACK>(|segment, begins, later| {
            // Two lines of a cache each.
            prefetch_index(lights.as_flattened(), 4 * later);
            prefetch_index(lights.as_flattened(), 4 * later + 2);
            prefetch_index(first.as_flattened(), B * later);
            prefetch_index(first.as_flattened(), B * later + B - 1);
            if begins {
                rays = [Lanes::default(); B];
            }
            let place = segment.place();
            let slanted = Slanted::new(segment, self.depth[place]);
            let light = slanted.light(&lights[place], direction);
            let (albedos, first) = (&albedos[place], &mut first[place]);
            for band in 0..B {
                let adds = slanted.cross(albedos[band], &turned[band], &light, segment, &mut rays[band]);
                for (first, y) in first[band].iter_mut().zip(y) {
                    for (first, adds) in first.0.iter_mut().zip(adds.0) {
                        *first += y * adds;
                    }
                }
            }
        });
    }
}

/// Visits between the fetching of a place and its own.
const AHEAD: usize = 16;

/// There, and back.
const WAYS: [f32; 2] = [1.0, -1.0];

/// All rays, ready to march.
pub(super) struct March {
    axes: Vec<OrdinateTracks>,
    /// Share of the light sent out in a site that leaves it uncollided, in the mean over its volume and all directions.
    pub escape: Vec<f32>,
}

impl March {
    /// Lays `rays` per site edge along every ordinate. `sites` are the medium's non-empty ones.
    pub(super) fn new(medium: &TurbidMedium, sites: &[u32], ordinates: Ordinates, rays: u32) -> March {
        let places = Sites::new(&medium.grid, sites);
        let axes: Vec<OrdinateTracks> =
            ordinates.axes().par_iter().map(|ordinate| lay(medium, &places, sites, ordinate, rays)).collect();
        let mut escape = vec![0.0_f32; sites.len()];
        for segment in axes.iter().flat_map(|axis| &axis.segments) {
            escape[segment.place()] += 2.0 * segment.adds;
        }
        March { axes, escape }
    }

    /// Adds to `excess` the moments of what arrives beyond the source function `source`.
    pub(super) fn pass<const M: usize>(&self, source: &Moments<M>, excess: &mut Moments<M>) {
        for axis in &self.axes {
            axis.pass::<M, false>(source, excess);
            axis.pass::<M, true>(source, excess);
        }
    }

    /// Moments of an even sky of fluence 1 before any scattering; from below the horizon comes `below` times its light.
    pub(super) fn sky<const M: usize>(&self, below: f32) -> Vec<[f32; M]> {
        let mut sky = vec![[0.0_f32; M]; self.escape.len()];
        for axis in &self.axes {
            axis.sky::<M, false>(below, &mut sky);
            axis.sky::<M, true>(below, &mut sky);
        }
        sky
    }

    /// Moments of the light of up to [`LANES`] beams after one scattering, by the phase functions themselves,
    /// `[band][site]`. A beam's fluence changes along straight lines within a site, and so does what it scatters: taken
    /// constant, sites that are dense and lit from one side would be several per cent off.
    pub(super) fn first_scattering<const M: usize, const B: usize>(
        &self,
        matter: [&SiteScattering; B],
        beams: &[&Beam],
    ) -> [Moments<M>; B] {
        let lanes = |of: &dyn Fn(&Beam) -> f32| {
            Lanes(std::array::from_fn(|lane| beams.get(lane).map_or(0.0, |beam| of(beam))))
        };
        // Mean, and slope along x, y and z.
        let lights: Vec<[Lanes; 4]> = (0..self.escape.len())
            .map(|site| {
                std::array::from_fn(|i| match i {
                    0 => lanes(&|beam| beam.mean[site]),
                    _ => lanes(&|beam| beam.slope[site][i - 1]),
                })
            })
            .collect();
        let albedos: Vec<[[f32; 2]; B]> =
            (0..self.escape.len()).map(|site| matter.map(|matter| matter.albedos[site])).collect();
        // What leaf and wood of albedo 1 scatter of a beam into a direction, and what that is in all.
        let phase_of = |phase: Phase, beam: &Beam, direction: [f32; 3]| {
            let along = |i: usize| -beam.towards_sun[i] * f64::from(direction[i]);
            phase.at(along(0) + along(1) + along(2)) as f32
        };
        let whole = matter.map(|matter| {
            matter.phases.map(|phase| {
                let ways = |axis: &OrdinateTracks, beam: &Beam| {
                    WAYS.map(|way| phase_of(phase, beam, axis.direction(way)))
                };
                let of = |beam: &Beam| {
                    self.axes
                        .iter()
                        .map(|axis| axis.weight * ways(axis, beam).iter().sum::<f32>())
                        .sum::<f32>()
                };
                lanes(&of)
            })
        });
        let mut first = vec![[[Lanes::default(); M]; B]; self.escape.len()];
        for axis in &self.axes {
            for way in WAYS {
                let direction = axis.direction(way);
                let turned: [[Lanes; 2]; B] = std::array::from_fn(|band| {
                    std::array::from_fn(|i| {
                        let scattered = lanes(&|beam| phase_of(matter[band].phases[i], beam, direction));
                        // An idle lane has no light: 0 of 0.
                        Lanes(std::array::from_fn(|lane| {
                            scattered.0[lane] / whole[band][i].0[lane].max(f32::MIN_POSITIVE)
                        }))
                    })
                });
                if way > 0.0 {
                    axis.scatter_first::<M, B, false>(&albedos, &turned, &lights, &mut first);
                } else {
                    axis.scatter_first::<M, B, true>(&albedos, &turned, &lights, &mut first);
                }
            }
        }
        std::array::from_fn(|band| first.iter().map(|first| first[band]).collect())
    }

    /// Adds the once scattered light of such a sky as lane `lane` of `first`.
    pub(super) fn add_first_of_sky<const M: usize>(
        &self,
        gains: &ScatteringMoments,
        below: f32,
        lane: usize,
        first: &mut Moments<M>,
    ) {
        let sky = self.sky::<M>(below);
        let mut source = vec![[Lanes::default(); M]; sky.len()];
        for ((source, sky), gain) in source.iter_mut().zip(&sky).zip(&gains.0) {
            for a in 0..M {
                source[a].0[lane] = gain[degree(a)] * sky[a];
            }
        }
        let mut arrives = source.clone();
        self.pass(&source, &mut arrives);
        for (first, arrives) in first.iter_mut().zip(&arrives) {
            for a in 0..M {
                first[a].0[lane] += arrives[a].0[lane];
            }
        }
    }
}

/// What leaf and wood scatter, in one band.
pub(super) struct SiteScattering {
    /// `[site][leaf, wood]`: albedo x share of the site's extinction.
    pub albedos: Vec<[f32; 2]>,
    /// Phase functions of leaf and of wood.
    pub phases: [Phase; 2],
}

/// A segment through a source that changes along it.
struct Slanted {
    /// Site edges.
    length: f32,
    /// Of the ordinate, times the share of the site's segments.
    weight: f32,
    /// From the mean place of the axis's segments of the site to the middle of this one, in site edges.
    offset: [f32; 3],
    /// What a source that rises by 1 along the segment, 0 in the middle, adds to the light that leaves.
    leaves: f32,
    /// ... and to the mean along the segment: what left was not added there.
    stays: f32,
}

impl Slanted {
    fn new(segment: &Segment, depth: f32) -> Slanted {
        let s = segment.depth;
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
        let offset = segment.offset.map(|c| f32::from(c) * (1.0 / FINE));
        Slanted { length: s / depth, weight: segment.adds / mean, offset, leaves, stays }
    }

    /// The beams' light along the segment, that of the site given as mean and slopes.
    #[inline(always)]
    fn light(&self, [mean, x, y, z]: &[Lanes; 4], direction: [f32; 3]) -> SlantedLight {
        let [dx, dy, dz] = direction.map(|c| c * self.length);
        let [ox, oy, oz] = self.offset;
        let mut light = SlantedLight { mean: *mean, aside: Lanes::default(), along: Lanes::default() };
        for lane in 0..LANES {
            light.aside.0[lane] = ox * x.0[lane] + oy * y.0[lane] + oz * z.0[lane];
            light.along.0[lane] = dx * x.0[lane] + dy * y.0[lane] + dz * z.0[lane];
        }
        light
    }

    /// Carries the ray across, and gives what the segment adds to the mean of the site over all directions. Each loop
    /// over the lanes is plain, so that it becomes one vector operation after the other.
    #[inline(always)]
    fn cross(
        &self,
        [leaf, wood]: [f32; 2],
        [of_leaf, of_wood]: &[Lanes; 2],
        light: &SlantedLight,
        segment: &Segment,
        ray: &mut Lanes,
    ) -> Lanes {
        let mut adds = Lanes::default();
        for lane in 0..LANES {
            let share = leaf * of_leaf.0[lane] + wood * of_wood.0[lane];
            let aside = share * light.aside.0[lane];
            let along = share * light.along.0[lane];
            let even = share * light.mean.0[lane];
            let beyond = ray.0[lane] - (even + aside);
            ray.0[lane] = even + aside + beyond * segment.transmittance + along * self.leaves;
            // The even part is the same for all segments of the site, whose weights sum to the ordinate's.
            adds.0[lane] = beyond * segment.adds + self.weight * (even + aside + along * self.stays);
        }
        adds
    }
}

/// Light of beams along a segment.
struct SlantedLight {
    /// Mean over the site.
    mean: Lanes,
    /// What its middle has beyond the mean.
    aside: Lanes,
    /// By how much it rises from where the ray enters to where it leaves.
    along: Lanes,
}

#[inline(always)]
fn cross<const M: usize>(
    c: &Segment,
    y: &[f32; M],
    source: &[Lanes; M],
    excess: &mut [Lanes; M],
    light: &mut Lanes,
) {
    for lane in 0..LANES {
        let mut q = 0.0;
        for a in 0..M {
            q += y[a] * source[a].0[lane];
        }
        let beyond = light.0[lane] - q;
        light.0[lane] = q + beyond * c.transmittance;
        let adds = beyond * c.adds;
        for a in 0..M {
            excess[a].0[lane] += y[a] * adds;
        }
    }
}

fn lay(
    medium: &TurbidMedium,
    places: &Sites,
    sites: &[u32],
    ordinate: &Ordinate,
    rays: u32,
) -> OrdinateTracks {
    let depth = depth_per_edge(medium, sites, ordinate.direction);
    let found = crossings(places, ordinate.direction, rays);
    // Per site: sums of length, and of length x middle.
    let mut sums = vec![[0.0_f32; 4]; sites.len()];
    for Crossing { place, length, middle, .. } in &found {
        let [lengths, middles @ ..] = &mut sums[*place as usize];
        *lengths += length;
        middles.iter_mut().zip(middle).for_each(|(sum, middle)| *sum += length * middle);
    }
    let segment = |&Crossing { place, is_last, length, middle }: &Crossing| {
        let s = depth[place as usize] * length;
        let passing = Passing::new(s);
        let [lengths, middles @ ..] = sums[place as usize];
        let from_mean = |axis: usize| middle[axis] - middles[axis] / lengths;
        let offset = std::array::from_fn(|axis| (from_mean(axis) * FINE).clamp(-127.0, 127.0) as i8);
        let adds = ordinate.weight as f32 * (length / lengths) * passing.mean;
        let place = if is_last { place | LAST } else { place };
        Segment { place, transmittance: passing.transmittance, adds, depth: s, offset }
    };
    let segments = found.iter().map(segment).collect();
    let y = harmonics::evaluate(ordinate.direction);
    OrdinateTracks {
        direction: ordinate.direction.map(|c| c as f32),
        weight: ordinate.weight as f32,
        moments: std::array::from_fn(|a| y[a] as f32),
        depth,
        segments,
    }
}

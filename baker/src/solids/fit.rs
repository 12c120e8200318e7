//! From light at points to values of sites: least squares through the readers' own interpolation.
//!
//! Sought are the values v that minimise
//!
//! ```text
//! sum over sides of a (sum over corners of w v - light)^2 + sum over sites of b (v - v0)^2
//! ```
//!
//! with a the area of a side, w the trilinear weights where a reader samples it, and b the area of the leaves of a
//! site, whose light v0 has to stay. Sites that no leaf holds are tied to the mean of what their sides received, as
//! loosely as keeps them from running away. Conjugate gradients, each field by itself and in one order: the same on any
//! machine.

use super::gather::Gathered;
use super::{Places, Solids};

/// How much a site without leaves is tied to its mean, in faces of a site.
const LOOSE: f32 = 0.02;

/// Steps of a descent.
const STEPS: usize = 12;

/// Descents for plants with walls: after each, values that would leave their range are held at its end, and the others
/// go on. A clamp alone made enclosed leaves 14 % too bright.
const ROUNDS: usize = 4;

/// Corners of a sample.
const CORNERS: usize = 8;

/// What is sought, for all fields.
pub(super) struct Fit {
    /// Sites with known values, ascending: those that hold leaves, and those that solids sample.
    sites: Vec<u32>,
    /// Per side: the place in `sites` and the weight of each corner.
    corners: Vec<[(u32, f32); CORNERS]>,
    /// Per side: how much it counts.
    counts: Vec<f32>,
    /// Per site: how much v0 counts.
    ties: Vec<f32>,
    /// Per site: whether v0 is what its leaves receive.
    leaves: Vec<bool>,
    /// Descents at most.
    pub(super) rounds: usize,
}

impl Fit {
    pub(super) fn new(solids: &Solids, places: &Places, gathered: &Gathered) -> Fit {
        let lattice = solids.turbid.grid.lattice;
        let n = lattice as usize;
        let holds_leaf = |site: usize| {
            let has_light = |place| !places.is_enclosed(place);
            places.of(site).is_some_and(has_light) && solids.turbid.leaf_per_m[site] > 0.0
        };
        let mut is_known: Vec<bool> = (0..n * n * n).map(holds_leaf).collect();
        let found: Vec<[(u32, f32); CORNERS]> =
            gathered.sides.iter().map(|side| corners(lattice, side.sample)).collect();
        for &(site, weight) in found.iter().flatten() {
            is_known[site as usize] |= weight > 0.0;
        }
        let sites: Vec<u32> = (0u32..).zip(&is_known).filter(|(_, is)| **is).map(|(site, _)| site).collect();
        let mut place = vec![0u32; n * n * n];
        (0u32..).zip(&sites).for_each(|(i, &site)| place[site as usize] = i);
        let corners =
            found.into_iter().map(|of| of.map(|(site, weight)| (place[site as usize], weight))).collect();
        let leaves: Vec<bool> = sites.iter().map(|&site| holds_leaf(site as usize)).collect();
        let face = solids.turbid.grid.spacing_m;
        // Two sides of each leaf, in faces of a site.
        let area =
            |site: u32| (2.0 * face * f64::from(solids.medium.leaf_area_density[site as usize])) as f32;
        let ties =
            sites.iter().zip(&leaves).map(|(&site, &leaf)| LOOSE + if leaf { area(site) } else { 0.0 });
        let counts = gathered.sides.iter().map(|side| side.weight).collect();
        // Without walls light and dark lie nowhere so near to each other that a clamp would matter.
        let rounds = if places.enclosed.is_empty() { 1 } else { ROUNDS };
        Fit { ties: ties.collect(), sites, corners, counts, leaves, rounds }
    }

    /// Sites with known values, ascending.
    pub(super) fn sites(&self) -> &[u32] {
        &self.sites
    }

    /// Whether each of them holds leaves.
    pub(super) fn leaves(&self) -> &[bool] {
        &self.leaves
    }

    /// Sides that solids are seen from.
    pub(super) fn sides(&self) -> usize {
        self.corners.len()
    }

    /// The sites whose values a side samples, with their weights.
    pub(super) fn corner_sites(&self, side: usize) -> impl Iterator<Item = (usize, f32)> {
        self.corners[side].iter().map(|&(place, weight)| (self.sites[place as usize] as usize, weight))
    }

    /// Those of the known sites that hold leaves.
    pub(super) fn leaf_sites(&self) -> Vec<u32> {
        self.sites.iter().zip(&self.leaves).filter(|(_, leaf)| **leaf).map(|(&site, _)| site).collect()
    }

    /// Their values in one band of a field: `received` by the leaves of every site, and at solids the `column` of what
    /// was gathered.
    pub(super) fn values(
        &self,
        received: impl Fn(usize) -> f32,
        column: usize,
        band: usize,
        gathered: &Gathered,
    ) -> Vec<f32> {
        let light: Vec<f32> = (0..self.sides()).map(|side| gathered.of(side, column, band)).collect();
        let start = self.start(|site| received(site as usize), &light);
        let ends = self.ends(&light, &start);
        let mut found = start.clone();
        let mut held = vec![false; found.len()];
        for round in 0..self.rounds {
            if round > 0 {
                let lacks = self.lacks(&light, &start, &found).into_iter();
                let at_ends = lacks.zip(found.iter().zip(&ends));
                held = at_ends.map(|(lacks, (value, ends))| is_held(lacks, *value, *ends)).collect();
            }
            self.descend(&light, &start, &held, &mut found);
            let mut is_within = true;
            for (value, [low, high]) in found.iter_mut().zip(&ends) {
                is_within &= (*low..=*high).contains(value);
                *value = value.clamp(*low, *high);
            }
            if is_within {
                break;
            }
        }
        found
    }

    /// v0 per known site: what its leaves have, else the mean of what the sides that sample it have.
    pub(super) fn start(&self, of_leaves: impl Fn(u32) -> f32, of_sides: &[f32]) -> Vec<f32> {
        let mut sums = vec![(0.0f32, 0.0f32); self.sites.len()];
        for ((corners, count), light) in self.corners.iter().zip(&self.counts).zip(of_sides) {
            for &(place, weight) in corners {
                let (sum, all) = &mut sums[place as usize];
                *sum += count * weight * light;
                *all += count * weight;
            }
        }
        let of_site = |((&site, &leaf), (sum, all)): ((&u32, &bool), (f32, f32))| match leaf {
            true => of_leaves(site),
            false if all > 0.0 => sum / all,
            false => 0.0,
        };
        self.sites.iter().zip(&self.leaves).zip(sums).map(of_site).collect()
    }

    /// Least and most of v0 and of what the sides that sample a site received, per known site.
    fn ends(&self, light: &[f32], start: &[f32]) -> Vec<[f32; 2]> {
        let mut ends: Vec<[f32; 2]> = start.iter().map(|start| [*start; 2]).collect();
        for (corners, light) in self.corners.iter().zip(light) {
            for &(place, weight) in corners {
                if weight > 0.0 {
                    let [low, high] = &mut ends[place as usize];
                    (*low, *high) = (low.min(*light), high.max(*light));
                }
            }
        }
        ends
    }

    /// Descent of the sum at values, per known site: what the sides lack, and what the ties pull.
    fn lacks(&self, light: &[f32], start: &[f32], values: &[f32]) -> Vec<f32> {
        let mut lacks: Vec<f32> =
            start.iter().zip(values).zip(&self.ties).map(|((start, v), tie)| tie * (start - v)).collect();
        for ((corners, count), light) in self.corners.iter().zip(&self.counts).zip(light) {
            let sampled: f32 = corners.iter().map(|&(place, weight)| weight * values[place as usize]).sum();
            for &(place, weight) in corners {
                lacks[place as usize] += count * weight * (light - sampled);
            }
        }
        lacks
    }

    /// Moves the values that are not held towards the least sum.
    fn descend(&self, light: &[f32], start: &[f32], held: &[bool], v: &mut [f32]) {
        let apply = |v: &[f32]| -> Vec<f32> {
            let mut out: Vec<f32> = v.iter().zip(&self.ties).map(|(v, tie)| v * tie).collect();
            for (corners, count) in self.corners.iter().zip(&self.counts) {
                let sampled: f32 = corners.iter().map(|&(place, weight)| weight * v[place as usize]).sum();
                for &(place, weight) in corners {
                    out[place as usize] += count * weight * sampled;
                }
            }
            out
        };
        let mut diagonal = self.ties.clone();
        for (corners, count) in self.corners.iter().zip(&self.counts) {
            for &(place, weight) in corners {
                diagonal[place as usize] += count * weight * weight;
            }
        }
        let scaled = |r: &[f32]| -> Vec<f32> {
            let of = |((r, d), held): ((&f32, &f32), &bool)| if *held { 0.0 } else { r / d };
            r.iter().zip(&diagonal).zip(held).map(of).collect()
        };
        let mut residual = self.lacks(light, start, v);
        let mut z = scaled(&residual);
        let mut direction = z.clone();
        let mut energy = dot(&residual, &z);
        for _ in 0..STEPS {
            if energy <= 0.0 {
                break;
            }
            let image = apply(&direction);
            let along = dot(&direction, &image);
            if along <= 0.0 {
                break;
            }
            let step = (energy / along) as f32;
            v.iter_mut().zip(&direction).for_each(|(v, d)| *v += step * d);
            residual.iter_mut().zip(&image).for_each(|(r, i)| *r -= step * i);
            z = scaled(&residual);
            let next = dot(&residual, &z);
            let turn = (next / energy) as f32;
            direction.iter_mut().zip(&z).for_each(|(d, z)| *d = z + turn * *d);
            energy = next;
        }
    }
}

/// Whether a value stands at an end of its range and would leave it.
fn is_held(lacks: f32, value: f32, [low, high]: [f32; 2]) -> bool {
    (value <= low && lacks <= 0.0) || (value >= high && lacks >= 0.0)
}

fn dot(a: &[f32], b: &[f32]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum()
}

/// The texels around a point in lattice coordinates, with the weights of [`flb_format::sample::trilinear`].
fn corners(lattice: u32, point: [f64; 3]) -> [(u32, f32); CORNERS] {
    let part: [(u32, f64); 3] = std::array::from_fn(|axis| {
        let x = (point[axis] - 0.5).clamp(0.0, f64::from(lattice - 1));
        let texel = (x as u32).min(lattice - 2);
        (texel, x - f64::from(texel))
    });
    std::array::from_fn(|corner| {
        let at: [u32; 3] = std::array::from_fn(|axis| part[axis].0 + (corner as u32 >> axis & 1));
        let weight = |axis: usize| if corner >> axis & 1 == 1 { part[axis].1 } else { 1.0 - part[axis].1 };
        ((at[2] * lattice + at[1]) * lattice + at[0], (weight(0) * weight(1) * weight(2)) as f32)
    })
}

//! Oracle of [`uncollided`](super::uncollided) and [`crossings`](super::crossings): parallel rays through the lattice,
//! one after the other.
//!
//! Rays start on a square grid across the direction's largest component, a whole number per site, so that every
//! site is crossed by the same number of rays at its middle, and by some more at its corners. Where a ray crosses no
//! matter nothing happens to it, so only non-empty sites appear.

use super::passing::Passing;
use super::sites::Sites;
use super::sweep::SHORTEST;
use super::uncollided::{Beam, depth_per_edge};
use crate::Grid;
use crate::turbid::TurbidMedium;

/// No site: the place is empty.
const EMPTY: u32 = u32::MAX;

/// The non-empty sites of a lattice by their places.
pub(super) struct Walker {
    lattice: usize,
    /// `[z][y][x]`: place in the list of non-empty sites, or [`EMPTY`].
    place: Vec<u32>,
    bounds: [[usize; 2]; 3],
}

impl Walker {
    pub(super) fn new(grid: &Grid, sites: &[u32]) -> Walker {
        let mut place = vec![EMPTY; grid.sites()];
        for (at, &site) in (0u32..).zip(sites) {
            place[site as usize] = at;
        }
        Walker { lattice: grid.lattice as usize, place, bounds: *Sites::new(grid, sites).bounds() }
    }

    /// Walks every ray along `direction` (a unit vector), `rays` of them per site edge. Tells of each crossed site its
    /// place in the list and the length of the crossing in site edges, in the order of travel, and [`Step::End`] after
    /// each ray that crossed any.
    pub(super) fn walk(&self, direction: [f64; 3], rays: u32, mut tell: impl FnMut(Step)) {
        let magnitude = direction.map(f64::abs);
        let main = (0..3).fold(0, |main, axis| if magnitude[axis] > magnitude[main] { axis } else { main });
        let [first, last] = self.bounds[main];
        if first > last {
            return;
        }
        let across = [(main + 1) % 3, (main + 2) % 3];
        let stride = [1, self.lattice, self.lattice * self.lattice];
        let layer = Layer {
            sites: self,
            slope: across.map(|axis| direction[axis] / magnitude[main]),
            bounds: across.map(|axis| self.bounds[axis]),
            strides: across.map(|axis| stride[axis]),
            axes: [main, across[0], across[1]],
            way: direction[main].signum(),
            length: 1.0 / magnitude[main],
        };
        let layers = last - first + 1;
        // A ray is named by where it is in the middle of the layer that it crosses first.
        let range = [0, 1].map(|i| {
            let ends = [-0.5 * layer.slope[i], (layers as f64 - 0.5) * layer.slope[i]];
            let [low, high] = layer.bounds[i].map(|c| c as f64);
            let n = f64::from(rays);
            let first = libm::floor((low - ends[0].max(ends[1])) * n) as i64;
            first..libm::ceil((high + 1.0 - ends[0].min(ends[1])) * n) as i64
        });
        for i in range[0].clone() {
            for j in range[1].clone() {
                let middle = [i, j].map(|k| (k as f64 + 0.5) / f64::from(rays));
                let mut crossed = false;
                for step in 0..layers {
                    let at = if direction[main] < 0.0 { last - step } else { first + step };
                    let enter = [0, 1].map(|i| middle[i] + layer.slope[i] * (step as f64 - 0.5));
                    crossed |= layer.cross(at * stride[main], enter, &mut tell);
                }
                if crossed {
                    tell(Step::End);
                }
            }
        }
    }
}

/// One step of a ray through the lattice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Step {
    /// The ray crosses a site.
    Cross {
        /// Place of the site in the list of non-empty sites.
        place: u32,
        /// Length of the crossing, in site edges.
        length: f64,
        /// Middle of the crossing, in site edges from the middle of the site.
        middle: [f64; 3],
    },
    /// The ray has left the lattice.
    End,
}

/// How a ray crosses a layer of sites.
struct Layer<'s> {
    sites: &'s Walker,
    /// Shift across the layer along the two other axes, at most 1.
    slope: [f64; 2],
    bounds: [[usize; 2]; 2],
    strides: [usize; 2],
    /// The axes: the layer's own and the two across.
    axes: [usize; 3],
    /// -1 where the ray crosses the layer from its upper face, else 1.
    way: f64,
    /// Of the whole crossing.
    length: f64,
}

impl Layer<'_> {
    /// Up to three sites. `start` is the index of the layer's first site, `enter` where the ray enters. Whether any of
    /// them holds matter.
    fn cross(&self, start: usize, enter: [f64; 2], tell: &mut impl FnMut(Step)) -> bool {
        let leave = [0, 1].map(|i| enter[i] + self.slope[i]);
        let outside = |i: usize| {
            let [low, high] = self.bounds[i].map(|c| c as f64);
            enter[i].max(leave[i]) < low || enter[i].min(leave[i]) > high + 1.0
        };
        if outside(0) || outside(1) {
            return false;
        }
        let mut at = enter.map(|c| libm::floor(c) as i64);
        let to = leave.map(|c| libm::floor(c) as i64);
        // When the ray leaves the site along an axis, 0..=1; above 1 if it does not.
        let turns: [f64; 2] = std::array::from_fn(|i| match to[i] - at[i] {
            0 => 2.0,
            _ => ((at[i].max(to[i]) as f64 - enter[i]) / self.slope[i]).clamp(0.0, 1.0),
        });
        let mut done = 0.0;
        let mut crossed = false;
        for i in if turns[0] <= turns[1] { [0, 1] } else { [1, 0] } {
            if turns[i] <= 1.0 {
                crossed |= self.tell_of(start, at, enter, [done, turns[i]], tell);
                done = turns[i];
                at[i] = to[i];
            }
        }
        crossed | self.tell_of(start, at, enter, [done, 1.0], tell)
    }

    /// The part `from..to` of the crossing of the layer lies in the site `at`.
    fn tell_of(
        &self,
        start: usize,
        at: [i64; 2],
        enter: [f64; 2],
        [from, to]: [f64; 2],
        tell: &mut impl FnMut(Step),
    ) -> bool {
        let length = (to - from) * self.length;
        let within = |i: usize| (self.bounds[i][0] as i64..=self.bounds[i][1] as i64).contains(&at[i]);
        if length < SHORTEST || !within(0) || !within(1) {
            return false;
        }
        let index = start + at[0] as usize * self.strides[0] + at[1] as usize * self.strides[1];
        let place = self.sites.place[index];
        if place == EMPTY {
            return false;
        }
        let half = (from + to) / 2.0;
        let mut middle = [0.0; 3];
        middle[self.axes[0]] = self.way * (half - 0.5);
        for i in 0..2 {
            middle[self.axes[i + 1]] = enter[i] + self.slope[i] * half - at[i] as f64 - 0.5;
        }
        tell(Step::Cross { place, length, middle });
        true
    }
}

/// Computes [`uncollided`](super::uncollided) ray by ray.
pub fn uncollided_ray_by_ray(medium: &TurbidMedium, sites: &[u32], towards_sun: [f64; 3], rays: u32) -> Beam {
    let depth = depth_per_edge(medium, sites, towards_sun);
    let travel = towards_sun.map(|c| -c as f32);
    // Sums over the crossings: length, light, light x offset from the site's centre.
    let mut sums = vec![[0.0_f32; 5]; sites.len()];
    let mut light = 1.0_f32;
    Walker::new(&medium.grid, sites).walk(towards_sun.map(|c| -c), rays, |step| match step {
        Step::Cross { place, length, middle } => {
            let length = length as f32;
            let passing = Passing::new(depth[place as usize] * length);
            let [lengths, mean, offset @ ..] = &mut sums[place as usize];
            *lengths += length;
            *mean += light * passing.mean * length;
            for axis in 0..3 {
                let along = passing.lean * length * travel[axis];
                offset[axis] += light * length * (passing.mean * middle[axis] as f32 + along);
            }
            light *= passing.transmittance;
        }
        Step::End => light = 1.0,
    });
    // Over a unit cube, offsets have a variance of 1/12 along each axis. Every site is crossed in its middle layer.
    let slope_of = |[length, _, offset @ ..]: &[f32; 5]| offset.map(|sum| 12.0 * sum / length);
    let mean_of = |[length, mean, ..]: &[f32; 5]| mean / length;
    Beam { towards_sun, mean: sums.iter().map(mean_of).collect(), slope: sums.iter().map(slope_of).collect() }
}

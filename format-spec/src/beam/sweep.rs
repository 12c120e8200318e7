//! Parallel rays through the lattice, layer by layer: every non-empty site is visited once, in the order of travel,
//! with all rays that cross it. What becomes of the rays is kept in a picture across the direction of travel, so that
//! empty space costs nothing.
//!
//! Rays start on a square grid across the direction's largest component, a whole number per site, so that every
//! site is crossed by the same number of rays at its middle, and by some more at its corners. Where a ray crosses no
//! matter nothing happens to it, so only non-empty sites appear.

use super::passing::LANES;
use super::sites::Sites;

/// Shorter pieces of a ray, in site edges, are left out: rounding at corners.
pub(super) const SHORTEST: f64 = 1e-6;

/// A slope below this is none: the ray stays in its line of sites.
const MIN_SLOPE: f64 = 1e-12;

/// Rays along a direction, and how they cross a layer of sites.
pub(super) struct Sweep<'s> {
    sites: &'s Sites,
    /// Axes: that of the largest component, and the two across it: the one of the larger stride, the other.
    pub axes: [usize; 3],
    /// -1 where rays go down along the first axis, else 1.
    sign: f64,
    /// Length of a ray within a layer, in site edges.
    length: f64,
    /// Shift across a layer along the two axes across, at most 1.
    slope: [f64; 2],
    /// First and last coordinate of non-empty sites along the axes across.
    bounds: [[usize; 2]; 2],
    /// First layer and last.
    layers: [usize; 2],
    rays: f64,
    /// Numbers of the first ray along the axes across, and counts.
    first: [i64; 2],
    counts: [usize; 2],
}

/// Rays of one line of the picture that cross a slab of sites, and where: one after the other from `first` on.
#[derive(Default, Clone)]
pub(super) struct Span {
    /// Place of the first ray along its axis of the picture.
    pub first: usize,
    /// Share of the way through the layer at which each ray enters the slab. Padded to whole [`LANES`] by rays that
    /// enter behind where they leave.
    pub enter: Vec<f32>,
    /// Share of the way at which it leaves.
    pub leave: Vec<f32>,
    /// Position that each ray would have at the beginning of the layer, in site edges from the middle of the slab.
    pub start: Vec<f32>,
}

impl Span {
    /// The rays without padding: place along the axis of the picture, then enter, leave and start.
    pub(super) fn rays(&self) -> impl Iterator<Item = (usize, [f32; 3])> {
        let rays = self.enter.iter().zip(&self.leave).zip(&self.start);
        (self.first..)
            .zip(rays.map(|((&enter, &leave), &start)| [enter, leave, start]))
            .filter(|(_, [enter, leave, _])| leave > enter)
    }
}

/// How rays cross the sites of a layer: in f32, as what they carry.
#[derive(Clone, Copy)]
pub(super) struct Way {
    /// -1 where rays go down along the first axis, else 1.
    sign: f32,
    /// Length of a ray within a layer, in site edges.
    edge: f32,
    slope: [f32; 2],
}

impl Way {
    /// Length of the part `from..to` of the way through the layer, in site edges; 0 where that is next to nothing.
    #[inline(always)]
    pub(super) fn length(&self, from: f32, to: f32) -> f32 {
        let length = (to - from) * self.edge;
        if length < SHORTEST as f32 { 0.0 } else { length }
    }

    /// Offset from the middle of a site, along [`Sweep::axes`], in the middle of such a part, of a ray that starts at
    /// `start` along the axes across.
    #[inline(always)]
    pub(super) fn middle(&self, from: f32, to: f32, start: [f32; 2]) -> [f32; 3] {
        let half = 0.5 * (from + to);
        [self.sign * (half - 0.5), start[0] + self.slope[0] * half, start[1] + self.slope[1] * half]
    }
}

impl<'s> Sweep<'s> {
    /// `None` where there are no sites.
    pub(super) fn new(sites: &'s Sites, direction: [f64; 3], rays: u32) -> Option<Sweep<'s>> {
        let magnitude = direction.map(f64::abs);
        let main = (0..3).fold(0, |main, axis| if magnitude[axis] > magnitude[main] { axis } else { main });
        let [first, last] = sites.bounds()[main];
        if first > last {
            return None;
        }
        let across = [[2, 1], [2, 0], [1, 0]][main];
        let slope = across.map(|axis| direction[axis] / magnitude[main]);
        let slope = slope.map(|slope| if slope.abs() < MIN_SLOPE { 0.0 } else { slope });
        let bounds = across.map(|axis| sites.bounds()[axis]);
        let (n, layers) = (f64::from(rays), last - first + 1);
        // A ray is named by where it is in the middle of the layer that it crosses first.
        let range = [0, 1].map(|i| {
            let ends = [-0.5 * slope[i], (layers as f64 - 0.5) * slope[i]];
            let [low, high] = bounds[i].map(|c| c as f64);
            let from = libm::floor((low - ends[0].max(ends[1])) * n) as i64;
            from..libm::ceil((high + 1.0 - ends[0].min(ends[1])) * n) as i64
        });
        Some(Sweep {
            sites,
            axes: [main, across[0], across[1]],
            sign: direction[main].signum(),
            length: 1.0 / magnitude[main],
            slope,
            bounds,
            layers: [first, last],
            rays: n,
            first: [range[0].start, range[1].start],
            counts: [0, 1].map(|i| (range[i].end - range[i].start) as usize),
        })
    }

    /// How rays cross the sites of a layer.
    pub(super) fn way(&self) -> Way {
        Way { sign: self.sign as f32, edge: self.length as f32, slope: self.slope.map(|slope| slope as f32) }
    }

    /// Size of the picture: rows, and rays of a row with room for whole [`LANES`] behind the last.
    pub(super) fn picture(&self) -> [usize; 2] {
        [self.counts[0], self.counts[1] + LANES]
    }

    /// Visits every non-empty site in the order of travel: its place in the list, the rows of the picture that cross
    /// it, and the rays of a row.
    pub(super) fn visit(&self, mut visit: impl FnMut(u32, &Span, &Span)) {
        let [first, last] = self.layers;
        let order = self.sites.by_layer(self.axes[0]);
        let mut rows = Span::default();
        let mut columns = vec![Span::default(); self.bounds[1][1] + 1];
        for step in 0..=last - first {
            let layer = if self.sign < 0.0 { last - step } else { first + step };
            for (at, span) in columns.iter_mut().enumerate().skip(self.bounds[1][0]) {
                self.span(1, step, at, span);
            }
            let mut visit_row = |row: usize| {
                let (outer, members) = order.row(row);
                self.span(0, step, outer, &mut rows);
                let mut visit = |&(inner, place): &(u32, u32)| visit(place, &rows, &columns[inner as usize]);
                match self.slope[1] < 0.0 {
                    true => members.iter().rev().for_each(&mut visit),
                    false => members.iter().for_each(&mut visit),
                }
            };
            match self.slope[0] < 0.0 {
                true => order.rows_of(layer).rev().for_each(&mut visit_row),
                false => order.rows_of(layer).for_each(&mut visit_row),
            }
        }
    }

    /// The rays that cross the slab `at` of an axis across, in the layer of a step.
    fn span(&self, axis: usize, step: usize, at: usize, span: &mut Span) {
        let (slope, at) = (self.slope[axis], at as f64);
        let shift = slope * (step as f64 - 0.5);
        // Where rays enter the layer that are in the slab at some time.
        let [low, high] = [at - slope.max(0.0), at + 1.0 - slope.min(0.0)];
        let from = libm::floor((low - shift) * self.rays - 0.5) as i64;
        let to = libm::ceil((high - shift) * self.rays - 0.5) as i64;
        let (first, end) = (self.first[axis], self.first[axis] + self.counts[axis] as i64);
        let Span { first: place, enter, leave, start } = span;
        [&mut *enter, leave, start].into_iter().for_each(Vec::clear);
        for ray in from.max(first)..=to.min(end - 1) {
            let begins = (ray as f64 + 0.5) / self.rays + shift;
            let [enters, leaves] = match slope == 0.0 {
                true if begins >= at && begins < at + 1.0 => [0.0, 1.0],
                true => continue,
                false => {
                    let turns = [(at - begins) / slope, (at + 1.0 - begins) / slope];
                    [turns[0].min(turns[1]).max(0.0), turns[0].max(turns[1]).min(1.0)]
                }
            };
            if (leaves - enters) * self.length >= SHORTEST {
                if enter.is_empty() {
                    *place = (ray - first) as usize;
                }
                enter.push(enters as f32);
                leave.push(leaves as f32);
                start.push((begins - at - 0.5) as f32);
            }
        }
        let whole = enter.len().next_multiple_of(LANES);
        enter.resize(whole, 1.0);
        leave.resize(whole, 0.0);
        start.resize(whole, 0.0);
    }
}

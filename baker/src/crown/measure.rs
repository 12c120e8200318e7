//! What happens to parallel light in every site: how much of it arrives, how far it gets, and what stops it.

use std::ops::Range;

use flb_format::progress::{Cancelled, Progress};
use rayon::prelude::*;

use super::directions::Axis;
use super::facets::{Facets, Hit};
use super::gap::{bounds_of, low_of};
use super::view::View;
use flb_transport::turbid::TurbidMedium;

/// Sums over all rays of all axes, each weighted by its axis (mean weight 1).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct SiteLight {
    /// Rays that pass the site's cube.
    pub rays: f64,
    /// Rays that meet matter inside the site's cube, whatever they met before.
    pub blocked: f64,
    /// Rays that come to the site's cube, from either end, without having met matter.
    pub arrived: f64,
    /// Sum over `arrived` of the relative projection of leaves for each ray's direction.
    pub arrived_leaf: f64,
    /// Rays that arrived and meet matter inside: leaf, wood.
    pub first: [f64; 2],
    /// Sides of leaves inside that rays meet, from either end, whatever they met before: those that the sky lights,
    /// all, and those before which they met wood last.
    pub leaf_sides: [f64; 3],
}

/// How far below its low faces a site still owns what lies there, in edges. A sheet in a face between two sites, as a
/// card in the middle of a plant often is, belongs to the upper one: there the voxels have its area, too.
const OWN: f64 = 1.0 / 8192.0;

/// Triangles whose hits are collected by one thread at a time.
const SHARE: usize = 2048;

/// Bits of a hit's code: what was met below, the depth above.
const DEPTH_SHIFT: u32 = 2;
const DEPTH_BITS: u32 = 32 - DEPTH_SHIFT;
const DEEPEST: f64 = ((1u32 << DEPTH_BITS) - 1) as f64;

/// Hits of a view, grouped by ray and sorted along it.
struct Hits {
    /// Per ray: depth of the first and the last hit, metres; (inf, -inf) where there is none.
    ends_m: Vec<[f64; 2]>,
    /// Where a ray's hits start, and the end of the last.
    starts: Vec<u32>,
    /// Depth in units of `unit_m` above `-reach_m`, and what was met ([`code`]).
    codes: Vec<u32>,
    unit_m: f64,
    reach_m: f64,
}

impl Hits {
    /// All hits of a view; depths are from `-reach_m` to `reach_m`.
    fn of(facets: &Facets, view: &View, reach_m: f64) -> Hits {
        let unit_m = 2.0 * reach_m / f64::from(1u32 << DEPTH_BITS);
        let keys = |share: &[u32]| {
            let mut keys = Vec::new();
            for &triangle in share {
                facets.for_each_hit(view, triangle, |hit| {
                    let depth = ((hit.depth_m + reach_m) / unit_m).clamp(0.0, DEEPEST);
                    keys.push((hit.ray as u64) << 32 | u64::from(code(depth as u32, &hit)));
                });
            }
            keys
        };
        let mut keys: Vec<u64> = facets.triangles().par_chunks(SHARE).flat_map_iter(keys).collect();
        keys.par_sort_unstable();
        let mut starts = vec![0u32; view.rays() + 1];
        keys.iter().for_each(|key| starts[(key >> 32) as usize + 1] += 1);
        for ray in 0..view.rays() {
            starts[ray + 1] += starts[ray];
        }
        let codes: Vec<u32> = keys.iter().map(|&key| key as u32).collect();
        let mut hits = Hits { ends_m: Vec::new(), starts, codes, unit_m, reach_m };
        let ends = |ray: usize| match hits.along(ray) {
            [] => [f64::INFINITY, f64::NEG_INFINITY],
            [first, .., last] => [hits.depth_m(*first), hits.depth_m(*last)],
            [only] => [hits.depth_m(*only); 2],
        };
        hits.ends_m = (0..view.rays()).map(ends).collect();
        hits
    }

    /// Codes along a ray, by rising depth.
    fn along(&self, ray: usize) -> &[u32] {
        &self.codes[self.starts[ray] as usize..self.starts[ray + 1] as usize]
    }

    fn depth_m(&self, code: u32) -> f64 {
        (f64::from(code >> DEPTH_SHIFT) + 0.5) * self.unit_m - self.reach_m
    }

    /// Which of a ray's hits are from `enter` to `leave`, metres.
    fn within(&self, ray: usize, enter: f64, leave: f64) -> Range<usize> {
        let codes = self.along(ray);
        let from = codes.partition_point(|&code| self.depth_m(code) < enter);
        let count = codes[from..].partition_point(|&code| self.depth_m(code) < leave);
        from..from + count
    }
}

/// A code of a hit, from its depth in units.
fn code(depth: u32, hit: &Hit) -> u32 {
    depth << DEPTH_SHIFT | u32::from(hit.one_sided) << 1 | u32::from(hit.wood)
}

fn is_wood(code: u32) -> bool {
    code & 1 == 1
}

/// Sides of a leaf that a ray meets: one of a triangle that stands for one side, else two. None of wood.
fn leaf_sides(code: u32) -> u32 {
    if is_wood(code) { 0 } else { 2 - (code >> 1 & 1) }
}

/// Light in each of `sites` of a medium along `axes`, with `pixel_m` between rays; of the medium, only the grid and the
/// leaf angles count. The same for any number of threads.
pub(super) fn measure(
    facets: &Facets,
    turbid: &TurbidMedium,
    sites: &[u32],
    axes: &[Axis],
    pixel_m: f64,
    progress: &Progress<'_>,
) -> Result<Vec<SiteLight>, Cancelled> {
    let grid = &turbid.grid;
    let mut light = vec![SiteLight::default(); sites.len()];
    let (low, high) = bounds_of(grid, sites);
    let center: [f64; 3] = std::array::from_fn(|k| low[k].midpoint(high[k]));
    let half: [f64; 3] = std::array::from_fn(|k| (high[k] - low[k]) / 2.0);
    let reach_m = half.iter().sum();
    let own = OWN * grid.spacing_m;
    for (done, axis) in axes.iter().enumerate() {
        let view = View::new(*axis, center, half, pixel_m);
        let hits = Hits::of(facets, &view, reach_m);
        let weight = axis.weight * axes.len() as f64;
        let relative = turbid.angles.relative(axis.along[1]);
        sites.par_iter().zip(&mut light).with_min_len(256).for_each(|(&site, light)| {
            let one = along(&view, &hits, low_of(grid, site).map(|c| c - own), grid.spacing_m);
            light.rays += weight * one.rays;
            light.blocked += weight * one.blocked;
            light.arrived += weight * one.arrived;
            light.arrived_leaf += weight * relative * one.arrived_leaf;
            light.first[0] += weight * one.first[0];
            light.first[1] += weight * one.first[1];
            for (sum, sides) in light.leaf_sides.iter_mut().zip(one.leaf_sides) {
                *sum += weight * sides;
            }
        });
        progress((done + 1) as f64 / axes.len() as f64)?;
    }
    Ok(light)
}

/// Light in one site along one axis.
fn along(view: &View, hits: &Hits, low: [f64; 3], edge: f64) -> SiteLight {
    let [mut rays, mut blocked, mut arrived] = [0u32; 3];
    let mut first = [0u32; 2];
    let mut sides = [0u32; 3];
    view.for_each_ray(low, edge, |ray, enter, leave| {
        rays += 1;
        let [start, end] = hits.ends_m[ray];
        let arrives = [start >= enter, end < leave];
        arrived += arrives.iter().map(|&arrives| u32::from(arrives)).sum::<u32>();
        if start >= leave || end < enter {
            return;
        }
        let codes = hits.along(ray);
        let range = hits.within(ray, enter, leave);
        let inside = &codes[range.clone()];
        let [Some(&low), Some(&high)] = [inside.first(), inside.last()] else { return };
        blocked += 1;
        let mut of_ray = [0u32; 2];
        for (arrives, code) in arrives.into_iter().zip([low, high]) {
            of_ray[usize::from(is_wood(code))] += u32::from(arrives);
        }
        (0..2).for_each(|kind| first[kind] += of_ray[kind]);
        let all = inside.iter().map(|&code| leaf_sides(code)).sum::<u32>();
        sides[0] += of_ray[0].min(all);
        sides[1] += all;
        for at in range {
            let walls =
                [at.checked_sub(1), Some(at + 1)].into_iter().flatten().filter_map(|at| codes.get(at));
            sides[2] += leaf_sides(codes[at]).min(walls.filter(|&&code| is_wood(code)).count() as u32);
        }
    });
    let [rays, blocked, arrived] = [rays, blocked, arrived].map(f64::from);
    let first = first.map(f64::from);
    let leaf_sides = sides.map(f64::from);
    SiteLight { rays, blocked, arrived, arrived_leaf: arrived, first, leaf_sides }
}

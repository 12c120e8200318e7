//! The gap fraction: which share of the light that meets a crown's outline passes the crown.

use flb_format::Grid;
use rayon::prelude::*;

use super::directions::{Axis, judged_axes};
use super::facets::Facets;
use super::view::View;
use crate::voxelise::{CLUSTER_EDGE, VoxelError, VoxelSettings, voxelise};
use flb_scene::{MaterialClass, Mesh};
use flb_transport::turbid::TurbidMedium;

/// The lattice whose non-empty sites make a crown's outline, whatever lattice the crown is baked at.
pub const OUTLINE_LATTICE: u32 = 32;

/// Light that passes a crown along one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisGap {
    /// The axis, and its weight in the mean.
    pub axis: Axis,
    /// Rays through the outline.
    pub rays: u64,
    /// Share of them that passes, 0..=1.
    pub passing: f64,
}

/// Light that passes a crown along all axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Gap {
    /// Gap fractions in the order of [`judged_axes`].
    pub axes: Vec<AxisGap>,
}

impl Gap {
    /// Share of an even sky's light that passes, of what meets the outline: an axis counts by its weight and by its
    /// rays, as a flat plant shows little of itself from the side.
    pub fn mean(&self) -> f64 {
        mean(self.axes.iter().map(|gap| (gap.axis.weight * gap.rays as f64, gap.passing)))
    }

    /// Error of the mean against the mean of `truth`, relative to it.
    pub fn error(&self, truth: &Gap) -> f64 {
        self.mean() / truth.mean() - 1.0
    }

    /// The error of the axis that is furthest off, relative to `truth` along that axis.
    pub fn worst_error(&self, truth: &Gap) -> f64 {
        let errors = self.axes.iter().zip(&truth.axes).map(|(gap, truth)| gap.passing / truth.passing - 1.0);
        errors.fold(0.0, |worst: f64, error| if error.abs() > worst.abs() { error } else { worst })
    }
}

/// The rays along which mesh and medium are compared: parallel rays on a square grid, those that pass a non-empty site
/// of the plant at [`OUTLINE_LATTICE`].
pub struct GapRays<'a> {
    facets: Facets<'a>,
    views: Vec<(View, Vec<bool>)>,
}

impl<'a> GapRays<'a> {
    /// Rays along the judged axes, `pixels` of them over the plant's longest extent.
    ///
    /// # Errors
    /// As of [`voxelise`].
    pub fn new(
        mesh: &'a Mesh,
        classes: &[MaterialClass],
        ignore_alpha: bool,
        pixels: u32,
    ) -> Result<GapRays<'a>, VoxelError> {
        GapRays::along(&judged_axes(), mesh, classes, ignore_alpha, pixels)
    }

    /// Lays rays along given axes.
    ///
    /// # Errors
    /// As of [`voxelise`].
    pub fn along(
        axes: &[Axis],
        mesh: &'a Mesh,
        classes: &[MaterialClass],
        ignore_alpha: bool,
        pixels: u32,
    ) -> Result<GapRays<'a>, VoxelError> {
        let facets = Facets::new(mesh, classes, ignore_alpha)?;
        GapRays::of(facets, axes, (mesh, classes), ignore_alpha, pixels)
    }

    /// The same with facets that are known.
    pub(super) fn of(
        facets: Facets<'a>,
        axes: &[Axis],
        (mesh, classes): (&Mesh, &[MaterialClass]),
        ignore_alpha: bool,
        pixels: u32,
    ) -> Result<GapRays<'a>, VoxelError> {
        let (grid, sites) = outline(mesh, classes, ignore_alpha)?;
        let (low, high) = bounds_of(&grid, &sites);
        let center: [f64; 3] = std::array::from_fn(|k| low[k].midpoint(high[k]));
        let half: [f64; 3] = std::array::from_fn(|k| (high[k] - low[k]) / 2.0);
        let pixel_m = grid.spacing_m * f64::from(OUTLINE_LATTICE - 4) / f64::from(pixels);
        let view = |axis: &Axis| {
            let view = View::new(*axis, center, half, pixel_m);
            let mut inside = vec![false; view.rays()];
            for &site in &sites {
                view.for_each_ray(low_of(&grid, site), grid.spacing_m, |ray, _, _| inside[ray] = true);
            }
            (view, inside)
        };
        Ok(GapRays { facets, views: axes.par_iter().map(view).collect() })
    }

    /// The mesh's own gap fraction: the truth.
    pub fn of_mesh(&self) -> Gap {
        let along = |(view, inside): &(View, Vec<bool>)| {
            let count = |rays: &[bool]| rays.iter().filter(|&&ray| ray).count() as u64;
            let mut open = inside.clone();
            for &triangle in self.facets.triangles() {
                self.facets.for_each_hit(view, triangle, |hit| open[hit.ray] = false);
            }
            let rays = count(inside);
            AxisGap { axis: view.axis, rays, passing: count(&open) as f64 / rays as f64 }
        };
        Gap { axes: self.views.par_iter().map(along).collect() }
    }

    /// The gap fraction of a medium: the mean of exp(-optical depth) over the same rays.
    pub fn of_turbid(&self, turbid: &TurbidMedium) -> Gap {
        let depths = self.depths(turbid);
        let along = |((view, _), depths): (&(View, Vec<bool>), &Vec<f32>)| AxisGap {
            axis: view.axis,
            rays: depths.len() as u64,
            passing: passing(depths, 1.0),
        };
        Gap { axes: self.views.par_iter().zip(&depths.along).map(along).collect() }
    }

    /// Optical depths of a medium along the same rays.
    pub(super) fn depths(&self, turbid: &TurbidMedium) -> Depths {
        let sites = turbid.sites();
        let along = |(view, inside): &(View, Vec<bool>)| depths_along(turbid, &sites, view, inside);
        let weights = self.views.iter().map(|(view, _)| view.axis.weight).collect();
        Depths { weights, along: self.views.par_iter().map(along).collect() }
    }
}

/// Optical depths of a medium along rays.
pub(super) struct Depths {
    /// Weight of each axis.
    pub weights: Vec<f64>,
    /// Optical depth of each ray through the outline, `[axis][ray]`.
    pub along: Vec<Vec<f32>>,
}

/// Optical depths of a medium's non-empty `sites` along those rays of a view that are `inside`.
pub(super) fn depths_along(turbid: &TurbidMedium, sites: &[u32], view: &View, inside: &[bool]) -> Vec<f32> {
    let mut depths = vec![0.0f32; view.rays()];
    let up = view.axis.along[1];
    for &site in sites {
        let extinction = turbid.extinction_along(site as usize, up);
        view.for_each_ray(low_of(&turbid.grid, site), turbid.grid.spacing_m, |ray, enter, leave| {
            depths[ray] += (extinction * (leave - enter)) as f32;
        });
    }
    depths.into_iter().zip(inside).filter(|(_, inside)| **inside).map(|(depth, _)| depth).collect()
}

impl Depths {
    /// [`Gap::mean`] with every extinction times `factor`.
    pub(super) fn passing(&self, factor: f64) -> f64 {
        let along: Vec<f64> = self.along.par_iter().map(|depths| passing(depths, factor)).collect();
        let weights =
            self.along.iter().zip(&self.weights).map(|(depths, weight)| weight * depths.len() as f64);
        mean(weights.zip(along))
    }
}

/// Mean of (weight, value).
fn mean(shares: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (weights, sum) =
        shares.fold((0.0, 0.0), |(weights, sum), (weight, value)| (weights + weight, sum + weight * value));
    sum / weights
}

fn passing(depths: &[f32], factor: f64) -> f64 {
    depths.iter().map(|&depth| libm::exp(-factor * f64::from(depth))).sum::<f64>() / depths.len() as f64
}

/// Sites of the lattice of the outline that a plant touches.
fn outline(
    mesh: &Mesh,
    classes: &[MaterialClass],
    ignore_alpha: bool,
) -> Result<(Grid, Vec<u32>), VoxelError> {
    // One voxel per site: a voxel that is occupied is a site that is not empty.
    let settings = VoxelSettings { voxels: OUTLINE_LATTICE, lattice: OUTLINE_LATTICE, ignore_alpha };
    let occupancy = voxelise(mesh, classes, &settings, &|_| Ok(()))?;
    let grid = *occupancy.grid();
    let mut sites = Vec::new();
    for cluster in occupancy.clusters() {
        let first = cluster.position.map(|c| u32::from(c) * CLUSTER_EDGE);
        for z in 0..CLUSTER_EDGE {
            let words = cluster.leaf[z as usize] | cluster.wood[z as usize];
            for bit in (0..64).filter(|bit| words >> bit & 1 == 1) {
                sites.push(grid.index(first[0] + bit % 8, first[1] + bit / 8, first[2] + z) as u32);
            }
        }
    }
    sites.sort_unstable();
    Ok((grid, sites))
}

/// Lowest corner of a site, metres.
pub(super) fn low_of(grid: &Grid, site: u32) -> [f64; 3] {
    grid.low_m(grid.site(site as usize))
}

/// Box around sites, metres.
pub(super) fn bounds_of(grid: &Grid, sites: &[u32]) -> ([f64; 3], [f64; 3]) {
    grid.extent_m(sites).map_or(([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]), |[low, high]| (low, high))
}

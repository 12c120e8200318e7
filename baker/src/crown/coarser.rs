//! A plant's medium on larger sites, made as open as it is on its own.
//!
//! Merged into large sites a crown has fewer gaps, and its matter reaches further out. So one factor is calibrated as
//! for a mesh: in the mean over the measured axes, the same share of the light that meets the fine medium's outline
//! passes. (As large a shadow in all would be another aim. But three trees are half as far off again with it.) It is no
//! more than 1: a plant smaller than a site is spread far over its outline, which then tells nothing, and no matter is
//! to be made.

use flb_format::matter::TurbidMedium;
use rayon::prelude::*;

use super::directions::measured_axes;
use super::estimate;
use super::gap::{Depths, OUTLINE_LATTICE, bounds_of, depths_along, low_of};
use super::view::View;
use super::{CALIBRATION_RAYS, Crown, SeenSky};

/// `coarse` times the factor that makes it as open as `fine`, both in the same frame and not empty. Of the crown, the
/// mesh is the fine medium.
pub(crate) fn as_open_as(fine: &TurbidMedium, coarse: TurbidMedium) -> Crown {
    let sites = fine.sites();
    let (low, high) = bounds_of(&fine.grid, &sites);
    let center: [f64; 3] = std::array::from_fn(|k| low[k].midpoint(high[k]));
    let half: [f64; 3] = std::array::from_fn(|k| (high[k] - low[k]) / 2.0);
    let longest_m = half.iter().fold(0.0, |longest: f64, half| longest.max(2.0 * half));
    // The outline is as coarse for every fine lattice.
    let block = (fine.grid.lattice / OUTLINE_LATTICE).max(1);
    let corner = |site: u32| {
        let [x, y, z] = fine.grid.site(site as usize).map(|c| c / block * block);
        fine.grid.index(x, y, z) as u32
    };
    let mut blocks: Vec<u32> = sites.iter().map(|&site| corner(site)).collect();
    blocks.sort_unstable();
    blocks.dedup();
    let edge_m = fine.grid.spacing_m * f64::from(block);
    let axes = measured_axes();
    let coarse_sites = coarse.sites();
    let along = axes.par_iter().map(|axis| {
        let view = View::new(*axis, center, half, longest_m / f64::from(CALIBRATION_RAYS));
        let mut inside = vec![false; view.rays()];
        for &block in &blocks {
            view.for_each_ray(low_of(&fine.grid, block), edge_m, |ray, _, _| inside[ray] = true);
        }
        [(fine, &sites), (&coarse, &coarse_sites)]
            .map(|(turbid, sites)| depths_along(turbid, sites, &view, &inside))
    });
    let (of_fine, of_coarse): (Vec<Vec<f32>>, Vec<Vec<f32>>) =
        along.map(|[fine, coarse]| (fine, coarse)).unzip();
    let weights: Vec<f64> = axes.iter().map(|axis| axis.weight).collect();
    let mesh_gap = Depths { weights: weights.clone(), along: of_fine }.passing(1.0);
    let depths = Depths { weights, along: of_coarse };
    let factor = estimate::factor(mesh_gap, |factor| depths.passing(factor)).min(1.0);
    let (measured_gap, gap) = (depths.passing(1.0), depths.passing(factor));
    let mut turbid = coarse;
    for per_m in turbid.leaf_per_m.iter_mut().chain(&mut turbid.wood_per_m) {
        *per_m = (f64::from(*per_m) * factor) as f32;
    }
    Crown { turbid, seen_sky: SeenSky::default(), factor, mesh_gap, measured_gap, gap }
}

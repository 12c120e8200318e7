//! Grains to sites: every grain's area goes to the eight sites around it, by the weights with which light is read back
//! at its place.
//!
//! As the weights of a point are those of a sample at the point, light at a grain is read from sites that hold some of
//! it, and never from empty ones. They sum to 1: area is neither lost nor made.

use flb_format::matter::{LeafAngles, TurbidMedium};
use flb_format::{Grid, Placement};

use super::grains::Grain;

/// Sites of matter on a lattice's border are never filled (SPEC.md): so many on each side.
pub(super) const BORDER: u32 = 2;

/// Area of matter per site, and what it scatters.
pub(super) struct Sums {
    grid: Grid,
    /// `[site][leaf, wood]`, m^2.
    area_m2: Vec<[f64; 2]>,
    /// The same, each times its albedo.
    bright_m2: Vec<[f64; 2]>,
    /// `[z][x]`: the lowest site above the ground; matter does not go below.
    pub tops: Option<Vec<u32>>,
}

impl Sums {
    pub(super) fn new(grid: Grid, tops: Option<Vec<u32>>) -> Sums {
        let zeros = || vec![[0.0; 2]; grid.sites()];
        Sums { grid, area_m2: zeros(), bright_m2: zeros(), tops }
    }

    /// Adds an instance, its extinction times `factor`; area grows with the square of its scale.
    pub(super) fn add(&mut self, instance: &Placement, grains: &[Grain], factor: f64, albedo: [f64; 2]) {
        let (stands, larger) =
            (instance.transform, instance.transform.scale * instance.transform.scale * factor);
        let most = f64::from(self.grid.lattice - 1 - BORDER);
        for grain in grains {
            let area = grain.area_m2.map(|area| area * larger);
            let at = self.grid.lattice_from_model(stands.world_from_model_point(grain.at_m));
            // Per axis the lower and the upper of two sites, and their weights.
            let (mut sites, mut weights) = ([[0; 2]; 3], [[0.0; 2]; 3]);
            for axis in 0..3 {
                let low = libm::floor(at[axis] - 0.5);
                let t = at[axis] - 0.5 - low;
                weights[axis] = [1.0 - t, t];
                sites[axis] = [low, low + 1.0].map(|c| c.clamp(f64::from(BORDER), most) as u32);
            }
            for corner in 0..8 {
                let upper = [corner & 1, corner >> 1 & 1, corner >> 2];
                let [x, mut y, z] = std::array::from_fn(|axis| sites[axis][upper[axis]]);
                let weight = weights[0][upper[0]] * weights[1][upper[1]] * weights[2][upper[2]];
                if let Some(tops) = &self.tops {
                    y = y.max(tops[(z * self.grid.lattice + x) as usize]);
                }
                let index = self.grid.index(x, y, z);
                for kind in 0..2 {
                    let area = area[kind] * weight;
                    self.area_m2[index][kind] += area;
                    self.bright_m2[index][kind] += area * albedo[kind];
                }
            }
        }
    }

    /// The medium, and the albedos of its sites in their order. `soil` is wood of an albedo of its own, in the `layers`
    /// below each top.
    pub(super) fn finish(
        self,
        angles: LeafAngles,
        soil: Option<GroundLayers>,
    ) -> (TurbidMedium, Vec<[f32; 2]>, Vec<bool>) {
        let Sums { grid, area_m2, bright_m2, tops } = self;
        let volume_m3 = grid.spacing_m * grid.spacing_m * grid.spacing_m;
        let per_m =
            |kind: usize| area_m2.iter().map(|area| (area[kind] / volume_m3) as f32).collect::<Vec<_>>();
        let (leaf_per_m, mut wood_per_m) = (per_m(0), per_m(1));
        let mut is_soil = vec![false; grid.sites()];
        if let Some((soil, tops)) = soil.as_ref().zip(tops) {
            for (index, depth) in soil.sites(&grid, &tops) {
                wood_per_m[index] = (depth / grid.spacing_m) as f32;
                is_soil[index] = true;
            }
        }
        let turbid = TurbidMedium { grid, leaf_per_m, wood_per_m, angles };
        let albedo = |site: u32, kind: usize| {
            let site = site as usize;
            let [area, bright] = [area_m2[site][kind], bright_m2[site][kind]];
            match &soil {
                Some(soil) if is_soil[site] => soil.albedo as f32,
                _ if area > 0.0 => (bright / area).clamp(0.0, 1.0) as f32,
                _ => 0.0,
            }
        };
        let albedos = turbid.sites().into_iter().map(|site| [albedo(site, 0), albedo(site, 1)]).collect();
        (turbid, albedos, is_soil)
    }
}

/// What lies below the tops.
pub(super) struct GroundLayers {
    /// Albedo of a single scattering.
    pub albedo: f64,
    /// Optical depth of a site.
    pub depth: f64,
    /// Sites on top of each other.
    pub layers: u32,
}

impl GroundLayers {
    /// Every site of the soil with its depth. Where a neighbouring column is lower, the soil reaches down to it.
    fn sites(&self, grid: &Grid, tops: &[u32]) -> Vec<(usize, f64)> {
        let n = grid.lattice;
        let top = |x: u32, z: u32| tops[(z * n + x) as usize];
        let mut sites = Vec::new();
        for z in BORDER..n - BORDER {
            for x in BORDER..n - BORDER {
                let here = top(x, z);
                let around = [top(x - 1, z), top(x + 1, z), top(x, z - 1), top(x, z + 1)];
                let lowest = around.into_iter().min().map_or(here, |lowest| lowest.min(here));
                for y in lowest.saturating_sub(self.layers).max(BORDER)..here {
                    sites.push((grid.index(x, y, z), self.depth));
                }
            }
        }
        sites
    }
}

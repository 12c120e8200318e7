//! The ground below a scene's plants, as matter of its lattice.
//!
//! It is two layers of sites that next to no light passes, of the albedo at which such layers throw back what the
//! ground's reflectance says. A plane lies between two layers of sites exactly, so that no plant's site holds any of
//! it.

use flb_format::Grid;

use super::deposit::{BORDER, GroundLayers};
use flb_scene::scene::{self, Heights, Terrain};

use super::SceneLightError;

/// Optical depth of a site of ground: more, and light would be scattered too deep in it; less would let light through.
const DEPTH: f64 = 1.5;
/// Layers of it.
const LAYERS: u32 = 2;
/// Places along x and z at which the lowest and highest point of a map under the plants are sought.
const PROBES: u32 = 65;
/// Ground is laid around the plants as far as the tallest is high, but no further than this share of the scene.
const APRON: f64 = 0.125;

/// A scene's ground in luminance, its height map read.
#[derive(Debug)]
pub struct Ground {
    /// Reflectance of the ground as a Lambertian surface.
    pub reflectance: f64,
    shape: Shape,
}

#[derive(Debug)]
enum Shape {
    Plane { height_m: f64 },
    Map(Heights),
}

impl Ground {
    /// Reads the ground of a scene.
    ///
    /// # Errors
    /// [`SceneLightError::Ground`] for a height map that cannot be read.
    pub fn of(ground: &scene::Ground) -> Result<Ground, SceneLightError> {
        let shape = match &ground.terrain {
            Terrain::Plane { height_m } => Shape::Plane { height_m: *height_m },
            Terrain::Map(map) => Shape::Map(map.read()?),
        };
        let reflectance =
            ground.color.iter().zip(super::LUMINANCE).map(|(share, weight)| share * weight).sum();
        Ok(Ground { reflectance, shape })
    }

    fn height_m(&self, x_m: f64, z_m: f64) -> f64 {
        match &self.shape {
            Shape::Plane { height_m } => *height_m,
            Shape::Map(heights) => heights.at_m(x_m, z_m),
        }
    }

    /// `[z][x]`: the lowest site above the ground.
    pub(super) fn tops(&self, grid: &Grid) -> Vec<u32> {
        let n = grid.lattice;
        let top = |z: u32, x: u32| {
            let [x_m, _, z_m] = grid.middle_m([x, 0, z]);
            let height = (self.height_m(x_m, z_m) - grid.origin_m[1]) / grid.spacing_m;
            (libm::round(height).max(0.0) as u32).clamp(BORDER + LAYERS, n - BORDER - 1)
        };
        (0..n).flat_map(|z| (0..n).map(move |x| (z, x))).map(|(z, x)| top(z, x)).collect()
    }

    pub(super) fn soil(&self) -> GroundLayers {
        GroundLayers { albedo: albedo(self.reflectance), depth: DEPTH, layers: LAYERS }
    }
}

/// The albedo of a single scattering at which the layers reflect so much.
fn albedo(reflectance: f64) -> f64 {
    let root = (1.0 - reflectance) / (1.0 + reflectance);
    (1.0 - root * root).clamp(0.0, 1.0)
}

/// The lattice over plants in a box: as fine as holds it, with an apron of ground and room for its layers, if there is
/// any.
pub(super) fn grid_over(
    [low, high]: [[f64; 3]; 2],
    tallest_m: f64,
    ground: Option<&Ground>,
    lattice: u32,
) -> Grid {
    // Matter reaches a site further than its grains.
    let free = f64::from(lattice - 2 * (BORDER + 1));
    let size = |axis: usize| high[axis] - low[axis];
    let middle = |axis: usize| f64::midpoint(low[axis], high[axis]);
    let Some(ground) = ground else {
        let spacing_m = at_least_some((0..3).map(size).fold(0.0, f64::max) / free);
        let origin = |axis: usize| middle(axis) - spacing_m * f64::from(lattice) / 2.0;
        return Grid { lattice, origin_m: std::array::from_fn(origin), spacing_m };
    };
    let apron_m = tallest_m.min(APRON * size(0).max(size(2)));
    let [lowest, highest] = ground.range_m([low, high], apron_m);
    let tall = high[1].max(highest) - lowest;
    let wide = size(0).max(size(2)) + 2.0 * apron_m;
    let spacing_m = at_least_some((wide / free).max(tall / (free - f64::from(LAYERS))));
    let origin = |axis: usize| match axis {
        1 => lowest - spacing_m * f64::from(BORDER + LAYERS),
        _ => middle(axis) - spacing_m * f64::from(lattice) / 2.0,
    };
    Grid { lattice, origin_m: std::array::from_fn(origin), spacing_m }
}

/// The smallest sites that a file holds.
fn at_least_some(spacing_m: f64) -> f64 {
    spacing_m.max(1e-9)
}

impl Ground {
    /// Lowest and highest point under the plants and around them.
    fn range_m(&self, [low, high]: [[f64; 3]; 2], apron_m: f64) -> [f64; 2] {
        let along = |axis: usize, probe: u32| {
            let (from, to) = (low[axis] - apron_m, high[axis] + apron_m);
            from + (to - from) * f64::from(probe) / f64::from(PROBES - 1)
        };
        let heights = (0..PROBES).flat_map(|z| (0..PROBES).map(move |x| (x, z)));
        heights
            .map(|(x, z)| self.height_m(along(0, x), along(2, z)))
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[lowest, highest], height| {
                [lowest.min(height), highest.max(height)]
            })
    }
}

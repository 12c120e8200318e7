//! From a mesh to sparse occupancy: which voxels of a fine grid leaf and wood touch, and how much surface
//! lies in each site of the lattice.
//!
//! - Placement: the box around all leaf and wood triangles (others do not count) is centred in the cubic
//!   lattice; its longest edge spans `N - 4` sites less a hair, so the outer two layers stay empty.
//! - Vertices are rounded to 1/65536 voxel, finer than the f32 positions of a plant. From there on the test
//!   of triangle against voxel is exact integer arithmetic. Voxels and triangles are closed sets: a
//!   triangle that lies in the face between two voxels occupies both. So neither the order of vertices nor
//!   that of triangles matters, and a mirrored plant gives a mirrored grid.
//! - Where alpha cuts, a voxel is occupied only if the triangle clipped to it touches a present texel (`touches` in
//!   [`flb_scene::alpha`] states which). The clip is in f64, to the voxel grown by 2^-20, so that rounding never loses
//!   a touching triangle.
//! - Area is summed in whole units, so the order of summation cannot matter either. Sites are half-open
//!   for area: a triangle in the face between two sites counts once, for the upper one.
//!
//! Work is shared out by horizontal layers along z; a layer's result is written by one thread, in order.

use flb_format::Grid;
use flb_format::progress::Progress;

use flb_scene::alpha::Coverage;
use flb_scene::plant::plant_bounds;
use flb_scene::{MaterialClass, Mesh};

mod area;
mod clips;
mod cutter;
mod error;
mod occupancy;
mod occupy;
pub mod oracle;
mod overlap;
mod piece;
#[cfg(test)]
pub(crate) mod tests;
mod triangle;

pub use error::VoxelError;
pub use occupancy::{AREA_UNITS_PER_SITE_FACE, CLUSTER_EDGE, Cluster, Occupancy, SiteArea};

/// Largest number of voxels per edge.
pub const MAX_VOXELS: u32 = 4096;

/// Smallest and largest lattice.
pub const LATTICES: [u32; 2] = [16, 256];

/// Resolution of the voxels, and the lattice that they are for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VoxelSettings {
    /// Voxels per edge: a multiple of `lattice` and of 8, at most [`MAX_VOXELS`].
    pub voxels: u32,
    /// Sites per edge: a power of two, 16..=256.
    pub lattice: u32,
    /// Take every texel for present, as the papers do.
    pub ignore_alpha: bool,
}

impl Default for VoxelSettings {
    fn default() -> VoxelSettings {
        VoxelSettings { voxels: 1024, lattice: 128, ignore_alpha: false }
    }
}

/// Voxelises the leaf and wood triangles of a mesh. `classes` has one entry per material. The result is the
/// same for any number of threads and any order of triangles and of their vertices. `progress` is called
/// with shares from 0 to 1, from any thread.
///
/// # Errors
/// Settings out of range; a class list of another length than the material list; no leaf or wood
/// triangle; bounds without extent or not finite; broken images; [`VoxelError::Cancelled`].
pub fn voxelise(
    mesh: &Mesh,
    classes: &[MaterialClass],
    settings: &VoxelSettings,
    progress: &Progress<'_>,
) -> Result<Occupancy, VoxelError> {
    let scene = Scene::new(mesh, classes, settings)?;
    let clusters = occupy::occupy(&scene, &|share| progress(share * 0.7))?;
    let areas = area::measure(&scene, &|share| progress(0.7 + share * 0.3))?;
    progress(1.0)?;
    Ok(Occupancy::from_stages(scene.grid, settings.voxels, clusters, areas))
}

/// What every pass over the triangles needs.
struct Scene<'a> {
    mesh: &'a Mesh,
    /// Per material.
    surfaces: Vec<Option<Surface>>,
    grid: Grid,
    voxels: u32,
    /// Vertices in units of 1/65536 voxel.
    snapped: Vec<[i32; 3]>,
}

/// A material that counts.
struct Surface {
    wood: bool,
    coverage: Coverage,
}

impl<'a> Scene<'a> {
    fn new(
        mesh: &'a Mesh,
        classes: &[MaterialClass],
        settings: &VoxelSettings,
    ) -> Result<Scene<'a>, VoxelError> {
        check(settings)?;
        if classes.len() != mesh.materials.len() {
            return Err(VoxelError::Classes { found: classes.len(), expected: mesh.materials.len() });
        }
        if let Some(vertex) = mesh.positions.iter().position(|at| !at.iter().all(|c| c.is_finite())) {
            return Err(VoxelError::NotFinite { vertex, position: mesh.positions[vertex] });
        }
        let surface_of = |(material, class): (usize, &MaterialClass)| {
            let wood = match class {
                MaterialClass::Neither => return Ok(None),
                MaterialClass::Leaf => false,
                MaterialClass::Wood => true,
            };
            let coverage = if settings.ignore_alpha { Coverage::Full } else { Coverage::of(mesh, material)? };
            Ok(Some(Surface { wood, coverage }))
        };
        let surfaces = classes.iter().enumerate().map(surface_of).collect::<Result<Vec<_>, VoxelError>>()?;
        let grid = place(mesh, classes, settings.lattice)?;
        let snapped = triangle::snapped(mesh, &grid, settings.voxels);
        Ok(Scene { mesh, surfaces, grid, voxels: settings.voxels, snapped })
    }

    /// Voxels along an edge of a site.
    fn voxels_per_site(&self) -> u32 {
        self.voxels / self.grid.lattice
    }
}

fn check(settings: &VoxelSettings) -> Result<(), VoxelError> {
    let &VoxelSettings { voxels, lattice, .. } = settings;
    if !lattice.is_power_of_two() || !(LATTICES[0]..=LATTICES[1]).contains(&lattice) {
        return Err(VoxelError::Lattice { found: lattice });
    }
    if voxels == 0
        || voxels > MAX_VOXELS
        || !voxels.is_multiple_of(lattice)
        || !voxels.is_multiple_of(CLUSTER_EDGE)
    {
        return Err(VoxelError::Voxels { found: voxels, lattice, limit: MAX_VOXELS });
    }
    Ok(())
}

/// The lattice around the plant: centred, two layers of sites free on every side.
fn place(mesh: &Mesh, classes: &[MaterialClass], lattice: u32) -> Result<Grid, VoxelError> {
    /// The hair by which the plant stays clear of the outer layers, as a share of its longest extent.
    const HAIR: f64 = 1.0 / 1024.0;
    let bounds = plant_bounds(mesh, classes).ok_or(VoxelError::NothingToVoxelise)?;
    let extents: [f64; 3] = std::array::from_fn(|axis| bounds.max[axis] - bounds.min[axis]);
    let longest = extents[0].max(extents[1]).max(extents[2]);
    let spacing_m = longest / f64::from(lattice - 4) * (1.0 + HAIR);
    let center: [f64; 3] = std::array::from_fn(|axis| bounds.min[axis] + extents[axis] / 2.0);
    // A plant so far from the origin that f64 cannot tell its sites apart has no usable extent either.
    let resolved = center.iter().all(|c| c.abs() * f64::EPSILON * 1e6 < spacing_m);
    if spacing_m <= 0.0 || !resolved {
        return Err(VoxelError::Extent { min: bounds.min, max: bounds.max });
    }
    let origin_m = center.map(|c| c - spacing_m * f64::from(lattice) / 2.0);
    Ok(Grid { lattice, origin_m, spacing_m })
}

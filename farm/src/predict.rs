//! How much memory and time a bake will take, before it begins.

use flb_baker::bake::BakeSettings;
use flb_scene::extents::Walls;

/// Everything that does not grow with the lattice: the mesh, voxels of the fine grid, textures.
const BASE_BYTES: u64 = 200_000_000;
/// Of a site: density, class, areas, extinction, and what stages keep beside them for a moment.
const SITE_BYTES: u64 = 40;
/// Share of sites with matter that few plants have more of.
const MATTER_SHARE: f64 = 0.15;
/// Of a site with matter, while it is solved.
const SOLVE_BYTES: u64 = 1_800;

/// Bytes that the bake of a species with so many bands takes, as is expected from its lattice alone.
pub(crate) fn memory_bytes(settings: &BakeSettings, bands: usize) -> u64 {
    let sites = u64::from(settings.lattice).pow(3);
    let fields = sites * settings.items(Walls::None) as u64 * bands as u64 * 4;
    let matter = (sites as f64 * MATTER_SHARE) as u64;
    BASE_BYTES + sites * SITE_BYTES + fields + matter * SOLVE_BYTES
}

/// Seconds of a bake beside its solves.
const BASE_S: f64 = 0.5;
/// Of a site, a band and a field that the light is fitted by, on one core.
const ITEM_S: f64 = 4e-7;

/// Seconds that the bake of a species with so many bands takes on one core of a present machine, roughly.
pub(crate) fn seconds(settings: &BakeSettings, bands: usize) -> f64 {
    let sites = (u64::from(settings.lattice).pow(3)) as f64;
    BASE_S + sites * f64::from(settings.items(Walls::None)) * bands as f64 * ITEM_S
}

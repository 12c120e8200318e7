//! How much memory and time a bake will take, before it begins.

use flb_baker::bake::BakeSettings;
use flb_scene::extents::Walls;

/// Everything that does not grow with the lattice: the program, the mesh, voxels of the fine grid, textures.
const BASE_BYTES: u64 = 40_000_000;
/// Of a site: density, class, areas, extinction, what stages keep beside them for a moment, and what the allocator
/// keeps of the stages before.
const SITE_BYTES: u64 = 100;
/// Of a site with matter and of a ray through it, while light is solved.
const RAY_BYTES: u64 = 2_900;
/// Share of sites with matter on a lattice of 32^3. A finer lattice has matter at a smaller share.
const MATTER_SHARE: f64 = 0.15;
/// Power of the site's edge that the share goes by.
const MATTER_POWER: f64 = 0.8;

/// Sites with matter, or what plants have of them on such a lattice.
fn sites_with_matter(settings: &BakeSettings, known: Option<u64>) -> u64 {
    let sites = u64::from(settings.lattice).pow(3) as f64;
    let share = || MATTER_SHARE * libm::pow(32.0 / f64::from(settings.lattice), MATTER_POWER);
    known.unwrap_or_else(|| (sites * share()) as u64)
}

/// Bytes that the bake of a species with so many bands takes, resident: by the number of sites with matter, where that
/// is known.
pub(crate) fn memory_bytes(settings: &BakeSettings, bands: usize, matter: Option<u64>) -> u64 {
    let sites = u64::from(settings.lattice).pow(3);
    let fields = sites * u64::from(settings.items(Walls::None)) * bands as u64 * 4;
    let lit = u64::from(settings.rays()) * RAY_BYTES;
    BASE_BYTES + sites * SITE_BYTES + fields + sites_with_matter(settings, matter) * lit
}

/// Seconds of a bake that do not grow with the lattice.
const BASE_S: f64 = 2.5;
/// Of a site and a band.
const SITE_S: f64 = 1.4e-6;
/// Of a site with matter, a band, a direction, and a ray along it.
const RAY_S: f64 = 1.4e-7;

/// Seconds that the bake of a species with so many bands takes on one core of a present machine, roughly.
pub(crate) fn seconds(settings: &BakeSettings, bands: usize, matter: Option<u64>) -> f64 {
    let sites = u64::from(settings.lattice).pow(3) as f64;
    let rays = f64::from(settings.ordinates()) * f64::from(settings.rays());
    let lit = sites_with_matter(settings, matter) as f64 * rays * RAY_S;
    BASE_S + (sites * SITE_S + lit) * bands as f64
}

//! From a plant's triangles to a turbid medium that lets as much light through, in all directions together.
//!
//! ```text
//! Mesh -rays-> light per site -estimate-> TurbidMedium -one factor-> TurbidMedium
//! ```
//!
//! Half of the leaf area density is the extinction of leaves that are spread evenly. Real leaves clump, and a site
//! filled by that formula stops too much light, the more so the larger it is. So extinction is *measured*: parallel
//! rays go through the mesh along 13 axes, from both ends, and of the rays that come to a site without having met
//! matter, a share meets its first matter inside. The site gets the extinction at which an even cube stops the
//! same share in the mean over these rays (Beer and Lambert over the chords of a cube). Leaf and wood divide it as they
//! divide those first hits. As only light that arrives counts, what neighbouring sites have in common (a card
//! that both share, a shaft between twigs) is in the number; the share of all rays that a site blocks leaves it
//! out. Sites that little light reaches lean on that share, and where it tells nothing, on the formula
//! (`estimate.rs`).
//!
//! Independent even cubes still are no mesh, so one factor per species is *calibrated*: all extinctions are multiplied
//! by it, so that the crown's gap fraction, in the mean over the same 13 axes, is the mesh's. It is recorded: below 1
//! where sites are coarse (their gaps line up), above 1 where they are finer than cards and walls (a cube cannot be
//! opaque along one direction and open along another). [`GapRays`] judges the result along 25 axes.
//!
//! Extinction depends on direction through [`LeafAngles`] alone, so along a single direction a crown may be further off
//! than in the mean, above all where its wood faces one way.

mod angles;
mod coarser;
pub mod directions;
mod error;
mod estimate;
mod facets;
mod gap;
mod measure;
mod recollision;
mod seen_sky;
#[cfg(test)]
mod tests;
mod view;

pub use angles::{LeafAngleChoice, measured_angles};
pub(crate) use coarser::as_open_as;
pub use error::CrownError;
pub use gap::{AxisGap, Gap, GapRays, OUTLINE_LATTICE};
pub use recollision::{Received, Recollision};
pub use seen_sky::SeenSky;

use flb_format::Medium;
use flb_format::matter::rounded;
use flb_format::progress::Progress;

use directions::measured_axes;
use facets::Facets;
use flb_scene::plant::plant_bounds;
use flb_scene::{MaterialClass, Mesh};
use flb_transport::turbid::{LeafAngles, TurbidMedium};

/// Rays over the plant's longest extent, at least; and rays over a site, at least.
const RAYS: [u32; 2] = [384, 3];

/// Rays over the plant's longest extent by which the factor is calibrated.
const CALIBRATION_RAYS: u32 = 192;

/// Most hits of all rays along one axis that are expected: the grid of rays becomes coarser to keep below.
const MAX_HITS: f64 = (1u64 << 25) as f64;

/// Settings of the measurement of a crown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CrownSettings {
    /// Take every texel for present; as the medium was voxelised.
    pub ignore_alpha: bool,
    /// Assumed distribution of leaf inclinations.
    pub angles: LeafAngleChoice,
}

/// A crown as a turbid medium, and what was calibrated.
#[derive(Debug, Clone, PartialEq)]
pub struct Crown {
    /// The medium, the factor applied, rounded ([`flb_format::matter::rounded`]).
    pub turbid: TurbidMedium,
    /// Share of the sky that the leaves see; of no site where there is no mesh.
    pub seen_sky: SeenSky,
    /// The factor of all extinctions, from 1/8 to 8.
    pub factor: f64,
    /// Gap fraction of the mesh along the 13 measured axes ([`Gap::mean`]).
    pub mesh_gap: f64,
    /// Gap fraction of the medium before the factor.
    pub measured_gap: f64,
    /// Gap fraction of `turbid` before its rounding: `mesh_gap`, unless the factor came to an end of its range.
    pub gap: f64,
}

/// The medium by the formula: half of the leaf area density, a quarter of the wood area density.
///
/// # Errors
/// Arrays of another length than the grid's, or area densities that are negative or not finite.
pub fn unclumped(medium: &Medium, angles: LeafAngles) -> Result<TurbidMedium, CrownError> {
    let scaled = |array: &'static str, densities: &[f32], factor: f32| {
        error::check_densities(array, densities, medium.grid.sites())?;
        Ok::<_, CrownError>(densities.iter().map(|density| factor * density).collect())
    };
    Ok(TurbidMedium {
        grid: medium.grid,
        leaf_per_m: scaled("leaf area density", &medium.leaf_area_density, 0.5)?,
        wood_per_m: scaled("wood area density", &medium.wood_area_density, 0.25)?,
        angles,
    })
}

/// Measures and calibrates the extinction of a plant on the grid of `medium`, which was made of the same mesh and
/// classes. The result is the same for any number of threads. `progress` is called with shares from 0 to 1.
///
/// # Errors
/// As of [`unclumped`] and [`crate::voxelise()`]; a plant that is not inside of the medium's grid; a medium without
/// area; [`CrownError::Cancelled`].
pub fn measure_crown(
    mesh: &Mesh,
    classes: &[MaterialClass],
    medium: &Medium,
    settings: &CrownSettings,
    progress: &Progress<'_>,
) -> Result<Crown, CrownError> {
    let facets = Facets::new(mesh, classes, settings.ignore_alpha)?;
    let angles = settings.angles.of(&facets);
    let unclumped = unclumped(medium, angles)?;
    let sites = unclumped.sites();
    if sites.is_empty() {
        return Err(CrownError::NoArea);
    }
    error::check_place(&medium.grid, plant_bounds(mesh, classes))?;
    let axes = measured_axes();
    let pixel_m = pixel_m(&facets, unclumped.grid.spacing_m, medium.grid.lattice);
    let measured = |share: f64| progress(share * 0.8);
    let light = measure::measure(&facets, &unclumped, &sites, &axes, pixel_m, &measured)?;
    let mut turbid = estimate::estimate(unclumped, &sites, &light, &axes);
    let rays = GapRays::of(facets, &axes, (mesh, classes), settings.ignore_alpha, CALIBRATION_RAYS)?;
    let (mesh_gap, depths) = (rays.of_mesh().mean(), rays.depths(&turbid));
    let factor = estimate::factor(mesh_gap, |factor| depths.passing(factor));
    for extinction in turbid.leaf_per_m.iter_mut().chain(&mut turbid.wood_per_m) {
        *extinction = rounded(*extinction * factor as f32);
    }
    let seen_sky = SeenSky::of(&turbid, &sites, &light);
    progress(1.0)?;
    Ok(Crown {
        turbid,
        seen_sky,
        factor,
        mesh_gap,
        measured_gap: depths.passing(1.0),
        gap: depths.passing(factor),
    })
}

/// Rays that a site of a lattice meets along all measured axes, in the mean.
fn rays_per_site(lattice: u32) -> f64 {
    let along_edge = f64::from(RAYS[0].max(RAYS[1] * lattice)) / f64::from(lattice);
    // A cube shows three halves of a face in the mean.
    1.5 * along_edge * along_edge * measured_axes().len() as f64
}

/// Distance between rays, metres.
fn pixel_m(facets: &Facets, spacing_m: f64, lattice: u32) -> f64 {
    let rays = RAYS[0].max(RAYS[1] * lattice);
    let fine = spacing_m * f64::from(lattice) / f64::from(rays);
    // A facet covers half of its area in the mean over all directions.
    let covered_m2: f64 =
        facets.triangles().iter().map(|&t| facets.area_m2(t) * facets.counted(t) / 2.0).sum();
    fine.max(libm::sqrt(covered_m2 / MAX_HITS))
}

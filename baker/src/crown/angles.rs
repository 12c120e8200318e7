//! Which leaf angles a crown is given, and those of its mesh.

use super::facets::Facets;
use crate::voxelise::VoxelError;
use flb_scene::{MaterialClass, Mesh};
use flb_transport::turbid::{INCLINATIONS, LeafAngles};

/// Distribution of leaf inclinations that is assumed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum LeafAngleChoice {
    /// Inclinations of the leaf triangles of the mesh; spherical where it has none.
    #[default]
    Measured,
    /// Random; extinction is the same in all directions.
    Spherical,
    /// Mostly flat.
    Planophile,
    /// Mostly upright.
    Erectophile,
}

impl LeafAngleChoice {
    /// Name of the choice on the command line and in keys of kept stages.
    pub fn name(self) -> &'static str {
        match self {
            LeafAngleChoice::Measured => "measured",
            LeafAngleChoice::Spherical => "spherical",
            LeafAngleChoice::Planophile => "planophile",
            LeafAngleChoice::Erectophile => "erectophile",
        }
    }

    pub(super) fn of(self, facets: &Facets) -> LeafAngles {
        match self {
            LeafAngleChoice::Spherical => LeafAngles::spherical(),
            LeafAngleChoice::Planophile => LeafAngles::planophile(),
            LeafAngleChoice::Erectophile => LeafAngles::erectophile(),
            LeafAngleChoice::Measured => of_facets(facets).unwrap_or_else(LeafAngles::spherical),
        }
    }
}

/// The inclinations of a mesh's leaf triangles, weighted by the area that alpha leaves. `None` where no leaf has area.
///
/// # Errors
/// A class list of another length than the material list; vertices that are not finite; broken images.
pub fn measured_angles(
    mesh: &Mesh,
    classes: &[MaterialClass],
    ignore_alpha: bool,
) -> Result<Option<LeafAngles>, VoxelError> {
    Ok(of_facets(&Facets::new(mesh, classes, ignore_alpha)?))
}

fn of_facets(facets: &Facets) -> Option<LeafAngles> {
    let mut areas = [0.0; INCLINATIONS];
    for &triangle in facets.triangles() {
        let (normal, area) = (facets.normal_m2(triangle), facets.area_m2(triangle));
        let (wood, present) = facets.kind(triangle);
        if !wood && area > 0.0 {
            let up = normal[1].abs() / 2.0 / area;
            areas[((up * INCLINATIONS as f64) as usize).min(INCLINATIONS - 1)] +=
                area * present * facets.counted(triangle);
        }
    }
    LeafAngles::from_areas(areas)
}

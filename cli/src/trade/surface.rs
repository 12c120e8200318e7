//! Where light is compared: points of the plant's surface.

use flb_baker::voxelise::VoxelError;
use flb_scene::{ClassedMesh, SurfacePoint, surface_points};

use crate::exit::{Failure, VERDICT};

/// Up to `count` points on leaf and wood, even by area.
pub(super) fn points(
    classed: &ClassedMesh,
    count: u32,
    ignore_alpha: bool,
) -> Result<Vec<SurfacePoint>, Failure> {
    let found = surface_points(classed, count, ignore_alpha).map_err(VoxelError::Alpha)?;
    match found.is_empty() {
        true => Err(Failure::new(
            VERDICT,
            "found no point of leaf or wood to measure light at, expected some surface",
        )),
        false => Ok(found),
    }
}

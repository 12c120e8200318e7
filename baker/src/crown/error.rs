//! What can be wrong with a mesh and a medium that are to make a crown.

use flb_format::Grid;
use flb_format::meta::Bounds;
use flb_format::progress::Cancelled;

use crate::voxelise::VoxelError;

/// A mesh or medium of which no crown can be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CrownError {
    /// The mesh, its classes or its images.
    #[error(transparent)]
    Mesh(#[from] VoxelError),
    /// An array of the medium does not match its grid.
    #[error("{array}: {found} values, expected {expected}, one per site")]
    Length {
        /// Name of the array.
        array: &'static str,
        /// Values found.
        found: usize,
        /// Sites of the grid.
        expected: usize,
    },
    /// Area density that is negative or not finite.
    #[error("{array} of site {site}: {found} 1/m, expected a finite number, not negative")]
    Density {
        /// Name of the array.
        array: &'static str,
        /// Index of the site.
        site: usize,
        /// The value.
        found: f32,
    },
    /// Medium without area.
    #[error("no site of the medium has leaf or wood area: there is no crown")]
    NoArea,
    /// Mesh and medium are not of the same plant.
    #[error(
        "the plant spans {min:?} to {max:?} m, outside of the medium's grid from {low:?} to {high:?} m: expected the medium of this mesh"
    )]
    Place {
        /// Smallest coordinates of the plant, metres.
        min: [f64; 3],
        /// Largest.
        max: [f64; 3],
        /// Smallest coordinates of the grid, metres.
        low: [f64; 3],
        /// Largest.
        high: [f64; 3],
    },
    /// The caller stopped the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// One density per site, each finite and not negative.
pub(super) fn check_densities(
    array: &'static str,
    densities: &[f32],
    sites: usize,
) -> Result<(), CrownError> {
    if densities.len() != sites {
        return Err(CrownError::Length { array, found: densities.len(), expected: sites });
    }
    match densities.iter().position(|density| !(*density >= 0.0 && density.is_finite())) {
        Some(site) => Err(CrownError::Density { array, site, found: densities[site] }),
        None => Ok(()),
    }
}

/// The plant lies inside the grid.
pub(super) fn check_place(grid: &Grid, plant: Option<Bounds>) -> Result<(), CrownError> {
    let Bounds { min, max } = plant.ok_or(VoxelError::NothingToVoxelise)?;
    let low = grid.origin_m;
    let high = low.map(|c| c + f64::from(grid.lattice) * grid.spacing_m);
    if (0..3).all(|axis| low[axis] <= min[axis] && max[axis] <= high[axis]) {
        return Ok(());
    }
    Err(CrownError::Place { min, max, low, high })
}

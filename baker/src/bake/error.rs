//! Why a plant cannot be baked.

use flb_format::FormatError;
use flb_transport::lattice::SolveError;
use flb_transport::monte_carlo::MonteCarloError;
use flb_transport::ordinates::OrdinatesError;

use crate::artefact::ArtefactError;
use crate::crown::CrownError;
use flb_scene::rays::RayMeshError;

use crate::plan::PlanError;
use crate::scene_light::SceneLightError;
use crate::voxelise::VoxelError;

/// A bake that ended without fields.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BakeError {
    /// Mesh, classes, voxels or lattice.
    #[error(transparent)]
    Voxels(#[from] VoxelError),
    /// The crown cannot be measured.
    #[error(transparent)]
    Crown(#[from] CrownError),
    /// Surfaces or settings of the `physical` model.
    #[error(transparent)]
    Ordinates(#[from] OrdinatesError),
    /// Optics or settings of the `paper` model.
    #[error(transparent)]
    Solve(#[from] SolveError),
    /// The light at solids cannot be traced.
    #[error(transparent)]
    Solids(#[from] RayMeshError),
    /// The light cannot be judged.
    #[error(transparent)]
    MonteCarlo(#[from] MonteCarloError),
    /// A band that the plant does not have.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The plants of a scene, or the lattice over them.
    #[error(transparent)]
    Scene(#[from] SceneLightError),
    /// A result that cannot be turned into bytes for the store.
    #[error(transparent)]
    Artefact(#[from] ArtefactError),
    /// Metadata that no file can hold.
    #[error("the species cannot be stored: {0}")]
    Metadata(FormatError),
    /// A plant too small or too large: a wrong unit, for the most part.
    #[error("the plant is {found_m} m long, expected {low_m} to {high_m} m")]
    Extent {
        /// Along its longest axis.
        found_m: f64,
        /// Shortest.
        low_m: f64,
        /// Longest.
        high_m: f64,
    },
    /// The observer said so.
    #[error("the bake was stopped")]
    Cancelled,
}

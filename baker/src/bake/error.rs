//! Why a plant cannot be baked.

use flb_format::FormatError;
use flb_scene::rays::RayMeshError;
use flb_transport::lattice::SolveError;
use flb_transport::monte_carlo::MonteCarloError;
use flb_transport::ordinates::OrdinatesError;

use crate::artefact::ArtefactError;
use crate::crown::CrownError;
use crate::plan::PlanError;
use crate::scene_light::SceneLightError;
use crate::solids::SolidsError;
use crate::voxelise::VoxelError;

/// A bake that ended without fields.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BakeError {
    /// Mesh, classes, voxels or lattice.
    #[error(transparent)]
    Voxels(VoxelError),
    /// The crown cannot be measured.
    #[error(transparent)]
    Crown(CrownError),
    /// Surfaces or settings of the `physical` model.
    #[error(transparent)]
    Ordinates(OrdinatesError),
    /// Optics or settings of the `paper` model.
    #[error(transparent)]
    Solve(SolveError),
    /// The light at solids cannot be traced.
    #[error(transparent)]
    Solids(#[from] RayMeshError),
    /// The light cannot be judged.
    #[error(transparent)]
    MonteCarlo(MonteCarloError),
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

/// A stage that was stopped is a bake that was stopped, whatever the stage.
macro_rules! from_stage {
    ($($stage:ident as $of_bake:ident),* $(,)?) => {$(
        impl From<$stage> for BakeError {
            fn from(error: $stage) -> BakeError {
                match error {
                    $stage::Cancelled(_) => BakeError::Cancelled,
                    error => BakeError::$of_bake(error),
                }
            }
        }
    )*};
}

from_stage! {
    VoxelError as Voxels,
    CrownError as Crown,
    OrdinatesError as Ordinates,
    SolveError as Solve,
    MonteCarloError as MonteCarlo,
}

impl From<SolidsError> for BakeError {
    fn from(error: SolidsError) -> BakeError {
        match error {
            SolidsError::Cancelled(_) => BakeError::Cancelled,
            SolidsError::Mesh(error) => BakeError::Solids(error),
        }
    }
}

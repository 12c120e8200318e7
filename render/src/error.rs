//! Why a picture could not be made.

use flb_scene::rays::RayMeshError;
use thiserror::Error;

/// Everything that this crate refuses, and what it read when it did.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RenderError {
    /// A setting lies outside its limits.
    #[error("render setting `{name}` is {found}, expected {expected}")]
    Setting {
        /// Name of the field.
        name: &'static str,
        /// Its value.
        found: String,
        /// What is allowed.
        expected: String,
    },
    /// There is nothing to look at.
    #[error("the mesh has no triangles, so there is nothing to render")]
    NoTriangles,
    /// Classes do not belong to this mesh.
    #[error("{found} material classes for a mesh with {expected} materials")]
    Classes {
        /// Classes given.
        found: usize,
        /// Materials of the mesh.
        expected: usize,
    },
    /// A mesh whose indices or coordinates cannot be used.
    #[error("triangle {triangle}: {what}")]
    Triangle {
        /// Its index.
        triangle: usize,
        /// What is wrong with it, and what was expected.
        what: String,
    },
    /// Nothing stands in the scene.
    #[error("the scene has no instances, so there is nothing to render")]
    NoInstances,
    /// An instance that cannot stand in a scene.
    #[error("instance {instance}: {what}")]
    Instance {
        /// Its index.
        instance: usize,
        /// What is wrong with it, and what was expected.
        what: String,
    },
    /// A camera in the water, which nothing is seen through.
    #[error("the camera stands at a height of {eye_m} m, expected above the water at {water_m} m")]
    Underwater {
        /// Of the camera.
        eye_m: f64,
        /// Of the water.
        water_m: f64,
    },
    /// Light of one species is in other units than that of the first.
    #[error(
        "species {species} is shaded by another model than species 0, expected `paper` for all or `physical` for all: their light is in \
         different units"
    )]
    Shadings {
        /// Its index.
        species: usize,
    },
    /// The light closure or a texture gave a value that is no number.
    #[error(
        "pixel ({x}, {y}) band {band} is {found}, expected a finite value: the light sampled there is not finite"
    )]
    NotFinite {
        /// Column.
        x: u32,
        /// Row.
        y: u32,
        /// R, G or B.
        band: &'static str,
        /// The value.
        found: f32,
    },
    /// A material's alpha cannot be read.
    #[error(transparent)]
    Alpha(#[from] flb_scene::alpha::AlphaError),
    /// Pictures that do not fit side by side.
    #[error("contact sheet: {0}")]
    Sheet(String),
    /// The PNG encoder failed.
    #[error("png: {0}")]
    Png(#[from] png::EncodingError),
    /// The EXR encoder failed.
    #[error("exr: {0}")]
    Exr(#[from] exr::error::Error),
}

impl From<RayMeshError> for RenderError {
    fn from(error: RayMeshError) -> RenderError {
        match error {
            RayMeshError::NoTriangles => RenderError::NoTriangles,
            RayMeshError::Triangle { triangle, what } => RenderError::Triangle { triangle, what },
            RayMeshError::Alpha(error) => RenderError::Alpha(error),
        }
    }
}

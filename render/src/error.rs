//! Why a picture could not be made.

use flb_format::progress::Cancelled;
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
        /// Value of the field.
        found: String,
        /// Values that are allowed.
        expected: String,
    },
    /// Mesh without triangles.
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
        /// Index of the triangle.
        triangle: usize,
        /// Fault of the triangle, and what was expected.
        what: String,
    },
    /// Scene without instances.
    #[error("the scene has no instances, so there is nothing to render")]
    NoInstances,
    /// An instance that cannot stand in a scene.
    #[error("instance {instance}: {what}")]
    Instance {
        /// Index of the instance.
        instance: usize,
        /// Fault of the instance, and what was expected.
        what: String,
    },
    /// A camera in the water, which nothing is seen through.
    #[error("the camera stands at a height of {eye_m} m, expected above the water at {water_m} m")]
    Underwater {
        /// Height of the camera, metres.
        eye_m: f64,
        /// Height of the water, metres.
        water_m: f64,
    },
    /// Light of one species is in other units than that of the first.
    #[error(
        "species {species} is shaded by another model than species 0, expected `paper` for all or `physical` for all: their light is in \
         different units"
    )]
    Shadings {
        /// Index of the species.
        species: usize,
    },
    /// The light closure or a texture gave a value that is no number.
    #[error(
        "pixel ({x}, {y}) band {band} is {found}, expected a finite value: the light sampled there is not finite"
    )]
    NotFinite {
        /// Column of the pixel.
        x: u32,
        /// Row of the pixel.
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
    /// The caller stopped the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
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

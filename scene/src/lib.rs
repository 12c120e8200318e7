//! What a renderer and a bake read: plant meshes with their materials, leaf optics, species files and scenes.
//!
//! ```text
//! glTF/OBJ -import-> Mesh -classify-> leaf or wood, per material
//! ClassedMesh -color-> what its texels mean, and what it reflects in the mean
//! ClassedMesh -extents-> its size, and doubts about it
//! species file -> SpeciesFile (classes, units, optics)
//! scene file, or glTF -> scene::Scene (where plants stand, camera, suns)
//! sun and turbidity, or an image -> sky::Sky (radiance from every side)
//! ```
//!
//! Model space is right-handed, +Y up, in metres. Nothing here solves light.
#![forbid(unsafe_code)]
#![deny(clippy::print_stdout, clippy::print_stderr)] // cli/src/print.rs alone prints

pub mod alpha;
pub mod class;
pub mod classify;
pub mod color;
pub mod extents;
pub mod import;
pub mod leaf;
pub mod mesh;
mod name_pattern;
pub mod observer;
pub mod plant;
pub mod rays;
pub mod sampling;
pub mod scene;
pub mod sheets;
pub mod sky;
pub mod solar;
pub mod species;
pub mod surface_points;
pub mod texture;
pub mod unit;

pub use class::MaterialClass;
pub use classify::{ClassRules, Classified, classify};
pub use color::{ColorRules, MaterialColor};
pub use extents::{Doubt, Extents, doubts};
pub use import::{ImportError, ImportSettings, Up, import};
pub use mesh::Mesh;
pub use observer::{Observer, Step, Unobserved};
pub use plant::{ClassedMesh, Plant, PlantReader};
pub use species::SpeciesFile;
pub use surface_points::{SurfacePoint, surface_points};
pub use unit::parse_unit;

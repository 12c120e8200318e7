//! From a plant mesh to the 19 base fields: import, voxelise, downsample, solve.
//!
//! ```text
//! glTF/OBJ -import-> Mesh -voxelise-> Occupancy -downsample-> Medium -solve-> Field x 19
//! ```
#![forbid(unsafe_code)]

pub mod class;
pub mod classify;
pub mod import;
pub mod materials;
pub mod mesh;
pub mod species;

pub use class::MaterialClass;
pub use classify::{ClassRules, Classified, classify};
pub use import::{ImportError, ImportSettings, Up, import};
pub use mesh::Mesh;
pub use species::SpeciesFile;

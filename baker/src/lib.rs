//! From a plant mesh to the 19 base fields: import, voxelise, downsample, solve.
//!
//! ```text
//! glTF/OBJ -import-> Mesh -voxelise-> Occupancy -downsample-> Medium -solve-> Field x 19
//! ```
#![forbid(unsafe_code)]
#![deny(clippy::print_stdout, clippy::print_stderr)] // cli/src/print.rs alone prints

pub mod alpha;
pub mod artefact;
pub mod class;
pub mod classify;
pub mod crown;
pub mod downsample;
pub mod import;
pub mod lattice;
pub mod leaf;
pub mod materials;
pub mod mesh;
pub mod monte_carlo;
pub mod ordinates;
pub mod plan;
pub mod scene;
pub mod scene_light;
pub mod solar;
pub mod species;
pub mod turbid;
pub mod voxelise;

pub use class::MaterialClass;
pub use classify::{ClassRules, Classified, classify};
pub use downsample::downsample;
pub use import::{ImportError, ImportSettings, Up, import};
pub use lattice::{BaseReport, Solution, SolveError, SolveSettings, SolverKind, solve};
pub use mesh::Mesh;
pub use species::SpeciesFile;
pub use voxelise::{Occupancy, VoxelSettings, voxelise};

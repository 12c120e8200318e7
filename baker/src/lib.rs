//! From a plant mesh to the 19 base fields: import, voxelise, downsample, solve.
//!
//! ```text
//! glTF/OBJ -import-> Mesh -voxelise-> Occupancy -downsample-> Medium -solve-> Field x 19
//! ```
#![forbid(unsafe_code)]

pub mod class;
pub mod lattice;
pub mod mesh;

pub use class::MaterialClass;
pub use lattice::{BaseReport, Solution, SolveError, SolveSettings, SolverKind, solve};
pub use mesh::Mesh;

//! From a plant mesh to the 19 base fields: import, voxelise, downsample, solve.
//!
//! ```text
//! glTF/OBJ -import-> Mesh -voxelise-> Occupancy -downsample-> Medium -solve-> Field x 19
//! ```
#![forbid(unsafe_code)]

pub mod alpha;
pub mod artefact;
pub mod class;
pub mod downsample;
pub mod mesh;
pub mod voxelise;

pub use class::MaterialClass;
pub use downsample::downsample;
pub use mesh::Mesh;
pub use voxelise::{Occupancy, VoxelSettings, voxelise};

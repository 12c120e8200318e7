//! From a plant mesh to the light fields of a species: voxelise, downsample, measure the crown, solve.
//!
//! ```text
//! Mesh -voxelise-> Occupancy -downsample-> Medium -measure_crown-> Turbid -ordinates-> Field per basis
//! ```
#![forbid(unsafe_code)]
#![deny(clippy::print_stdout, clippy::print_stderr)] // cli/src/print.rs alone prints

pub mod artefact;
pub mod crown;
pub mod downsample;
pub mod plan;
pub mod scene_light;
pub mod voxelise;

pub use downsample::downsample;
pub use voxelise::{Occupancy, VoxelSettings, voxelise};

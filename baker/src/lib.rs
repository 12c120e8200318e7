//! From a plant mesh to the light fields of a species: [`bake()`], and the stages that it runs.
//!
//! ```text
//! Mesh -voxelise-> Occupancy -downsample-> Medium -measure_crown-> TurbidMedium -ordinates-> Field per basis
//! ```
#![forbid(unsafe_code)]
#![deny(clippy::print_stdout, clippy::print_stderr)] // cli/src/print.rs alone prints

pub mod artefact;
pub mod bake;
pub mod crown;
pub mod downsample;
mod mean_light;
pub mod mixture;
pub mod plan;
pub mod scene_light;
pub mod solids;
pub mod voxelise;

pub use bake::{BakeError, BakeSettings, Baked, BakedScene, SceneSettings, bake, bake_scene};
pub use downsample::downsample;
pub use voxelise::{Occupancy, VoxelSettings, voxelise};

//! Inspect, validate, diff and extract .flb files
#![forbid(unsafe_code)]
<<<<<<< HEAD
pub mod extract;
#[derive(Debug, thiserror::Error)]
pub enum InspectError { #[error("PNG: {0}")] Png(String), #[error("EXR: {0}")] Exr(String), #[error("NPY: {0}")] Npy(String) }
=======

pub mod info;
pub mod validate;
pub use info::{Info, info};
pub use validate::{Issue, Level, Report, validate};
>>>>>>> container

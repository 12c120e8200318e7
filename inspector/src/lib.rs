//! Inspect, validate, diff and extract .flb files
#![forbid(unsafe_code)]
pub mod extract;
#[derive(Debug, thiserror::Error)]
pub enum InspectError { #[error("PNG: {0}")] Png(String), #[error("EXR: {0}")] Exr(String), #[error("NPY: {0}")] Npy(String) }

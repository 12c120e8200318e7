//! Inspect, validate, diff and extract .flb files
#![forbid(unsafe_code)]

pub mod info;
pub mod validate;
pub use info::{Info, info};
pub use validate::{Issue, Level, Report, validate};

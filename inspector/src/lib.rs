//! Look into `.flb` files: info, validate, diff, extract. Each computes a value; printing is the caller's.
#![forbid(unsafe_code)]
#![deny(clippy::print_stdout, clippy::print_stderr)] // cli/src/print.rs alone prints

pub mod diff;
mod error;
pub mod extract;
pub mod info;
pub mod validate;

pub use error::InspectError;
pub use info::{Info, info};
pub use validate::{Issue, Level, Report, validate};

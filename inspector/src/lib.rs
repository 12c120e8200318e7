//! Looks into `.flb` files: what one holds ([`info()`]), whether it keeps what SPEC.md promises
//! ([`validate()`]), what differs between two ([`diff`]), and one volume as a picture or as plain numbers
//! ([`extract`]). Every function computes a value or bytes; printing and writing are the caller's.
#![forbid(unsafe_code)]

pub mod diff;
mod error;
pub mod extract;
pub mod info;
pub mod validate;

pub use error::InspectError;
pub use info::{Info, info};
pub use validate::{Issue, Level, Report, validate};

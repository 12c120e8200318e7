//! Looks into `.flb` files: what differs between two ([`diff`]), and one volume as a picture or as plain
//! numbers ([`extract`]). Every function computes a value or bytes; printing and writing are the caller's.
#![forbid(unsafe_code)]

pub mod diff;
mod error;
pub mod extract;

pub use error::InspectError;

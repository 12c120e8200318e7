//! What tests and benchmarks of more than one crate need: plants in, files, scenes and answers of servers out.
//!
//! Only ever a dev-dependency (`tests/tests/it/imports.rs` holds that). The unit tests of a crate may use what is made
//! of types of the crates below it alone: of its own types this package knows another build.
#![forbid(unsafe_code)]

pub mod crown;
pub mod grown;
pub mod model;
pub mod plants;
pub mod psa;
#[cfg(feature = "scenes")]
pub mod scenes;
pub mod server;
pub mod solids;
#[cfg(feature = "screen")]
pub mod xvfb;

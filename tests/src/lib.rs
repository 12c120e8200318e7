//! Whole-pipeline tests of `flb`; see `tests/`. This crate's library holds what they share.
//!
//! ```text
//! (plant, settings) -bake-> Baked, every stage's result kept -describe-> text for the snapshots
//!                                                            -portrait-> pictures and their comparator
//! (plant, its file) -day-> frames of a day under a clear sky, baked and path traced
//! (plants, places) -stand-> light of a stand by one fine lattice, and by scene light
//! bytes -targets-> what a fuzz target does with them
//! ```
#![forbid(unsafe_code)]

/// Rust that documents show, compiled. A test finds documents with Rust that are not here.
#[cfg(doctest)]
mod documents {
    #[doc = include_str!("../../README.md")]
    struct Readme;

    #[doc = include_str!("../../docs/book/src/renderer.md")]
    struct Renderer;

    #[doc = include_str!("../../docs/book/src/bake.md")]
    struct Bake;
}

pub mod benched;
pub mod budget;
pub mod day;
pub mod default_bake;
pub mod describe;
pub mod mesh_light;
pub mod pipeline;
pub mod portrait;
pub mod stand;
pub mod targets;

//! Libraries of plant species: a manifest names them, a build bakes what changed and no more.
//!
//! ```text
//! library.toml -Manifest::read-> Manifest -Plan::of-> Plan -build-> a file a species, one of all, an index, a page
//! ```
//!
//! Each species is one task. Its [key](parts::Parts::key) is the digest of all that its file depends on, by name, so
//! that a build can say [why](plan::Why) it works. Results lie in a [cache](cache::Cache) under their keys, and so do
//! those of the stages of each bake. A build that is killed goes on where it was: nothing is written half, and nothing
//! that was finished is done again.
//!
//! ```
//! use flb_farm::build::{BuildObserver, BuildSettings, OnFailure, build};
//! use flb_farm::cache::{Cache, Place};
//! use flb_farm::{Manifest, digests::Trust};
//!
//! struct Quiet;
//! impl BuildObserver for Quiet {}
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let temporary = tempfile::tempdir()?;
//! # let folder = temporary.path();
//! # std::fs::write(folder.join("card.obj"), "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl leaf\nf 1 2 3 4\n")?;
//! # let small = "bake = { quality = 'draft', lattice = 16, voxels = 64 }";
//! # std::fs::write(folder.join("library.toml"), format!("[[species]]\nmesh = 'card.obj'\n{small}"))?;
//! let manifest = Manifest::read(&folder.join("library.toml"))?;
//! let tell = |told: &str| eprintln!("{told}");
//! let cache = Cache::open(Some(&Place::parse(folder.join("cache"))?), &tell)?;
//! let settings = BuildSettings {
//!     jobs: 2,
//!     threads: 2,
//!     memory_bytes: 4 << 30,
//!     only: Vec::new(),
//!     on_failure: OnFailure::KeepGoing,
//! };
//! let summary = build(&manifest, &settings, (&cache, Trust::SizeAndTime), &Quiet)?;
//! assert_eq!(summary.failed().count(), 0);
//! assert!(folder.join("library/species/card.flb").is_file());
//! # Ok(())
//! # }
//! ```
//!
//! [`Recipe`] is the list of a bake's settings, which manifests and command lines share.
#![forbid(unsafe_code)]
#![deny(clippy::print_stdout, clippy::print_stderr)] // cli/src/print.rs alone prints

pub mod build;
pub mod cache;
pub mod compare;
pub mod digests;
pub mod emit;
mod error;
pub mod index;
pub mod init;
pub mod job;
pub mod make;
pub mod manifest;
pub mod outcome;
pub mod output;
mod page;
pub mod parts;
pub mod pictures;
pub mod plan;
mod predict;
mod publish;
pub mod recipe;
pub mod record;
pub mod slurm;
pub mod tasks;

pub use error::FarmError;
pub use manifest::Manifest;
pub use plan::Plan;
pub use recipe::{Recipe, RecipeError};

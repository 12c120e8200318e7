//! From fields to a published `.flb` file: bases are coded into pages, species are laid out into one
//! file, and the file appears whole or not at all. Packing again never solves again: [`load_species`]
//! reads fields back, [`copy_species`] takes coded pages over as they are.
#![forbid(unsafe_code)]
#![deny(clippy::print_stdout, clippy::print_stderr)] // cli/src/print.rs alone prints

mod encode;
mod error;
pub mod leave_out;
mod load;
mod priority;
mod quality;
pub mod rate;
mod surface;
mod write;

pub use encode::{CodingPreset, EncodeSettings, EncodedPage, EncodedSection, EncodedSpecies, encode_species};
pub use error::PackError;
pub use flb_format::SpeciesFields;
pub use load::{Copier, copy_species, load_species};
pub use quality::{BaseReport, CodingReport};
pub use surface::{POINTS_PER_SITE, surface_point};
pub use write::{write_library, write_library_to};

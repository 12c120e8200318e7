//! From fields to a published `.flb` file: bases are coded into pages, species are laid out into one
//! file, and the file appears whole or not at all. Packing again never solves again: [`load_species`]
//! reads fields back, [`copy_species`] takes coded pages over as they are.
//!
//! ```
//! use flb_format::{Codec, Container, Quality};
//! use flb_packer::{EncodeSettings, encode_species, load_species, write_library_to};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let bytes = std::fs::read("../format-spec/golden/raw-f32.flb")?;
//! let fields = load_species(&Container::open(&bytes)?, &bytes, 0)?; // or those that a bake returned
//! let settings = EncodeSettings::of(Quality::Draft, Codec::Classed);
//! let coded = encode_species(&fields, &settings, &|_| Ok(()))?;
//! let mut packed = Vec::new();
//! write_library_to(&mut packed, &[&coded])?; // `write_library` makes a file
//! assert_eq!(Container::open(&packed)?.species().len(), 1);
//! # Ok(())
//! # }
//! ```
//!
//! [`rate`] codes to an error, [`quality`] has the report of it, [`leave_out`] drops bases, and [`surface`] says at
//! which points near geometry errors are counted.
#![forbid(unsafe_code)]
#![deny(clippy::print_stdout, clippy::print_stderr)] // cli/src/print.rs alone prints

mod encode;
mod error;
pub mod leave_out;
mod load;
mod priority;
pub mod quality;
pub mod rate;
pub mod surface;
mod write;

pub use encode::{CodingPreset, EncodeSettings, EncodedSpecies, StoredBlocks, encode_all, encode_species};
pub use error::PackError;
pub use flb_files::Existing;
pub use load::{Copier, copy_species, load_species};
pub use write::{write_library, write_library_to};

/// Parts of a coded species.
pub mod sections {
    pub use crate::encode::{EncodedPage, EncodedSection};
}

//! The `.flb` format: the types that every room shares, the block codec, and the checked parse of a
//! container. No files, no threads, no GPU, no unsafe: bytes come through [`Source`].
//!
//! ```
//! use flb_format::Container;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let bytes = std::fs::read("golden/haar.flb")?;
//! let container = Container::open(&bytes)?; // every promise about its tables is checked
//! let plant = &container.species()[0].meta;
//! let sky = container.read_field(&bytes, 0, 0)?; // of the first plant, under an even sky
//! assert_eq!(sky.lattice, plant.grid.lattice);
//! # Ok(())
//! # }
//! ```
//!
//! `SPEC.md` beside this crate is normative; this crate follows it. The root has what a reader or writer of a file
//! meets first. Below it, [`matter`], [`light`] and [`mesh`] say what a species holds, [`container`] and [`blocks`] how
//! that lies in bytes, [`beam`] and [`sun`] which formulas readers and writers share.
#![forbid(unsafe_code)]
#![deny(clippy::print_stdout, clippy::print_stderr)] // cli/src/print.rs alone prints

pub mod bases;
pub mod beam;
pub mod block;
pub mod blocks;
pub mod canonical;
pub mod colors;
pub mod container;
mod daylight;
pub mod direction;
pub mod error;
pub mod eye;
pub mod field;
mod haar;
pub mod light;
pub mod material_surface;
pub mod mean_light;
mod medium;
mod mesh_error;
mod mesh_mark;
pub mod meta;
pub mod model;
mod optics;
pub mod ordinates;
pub mod progress;
pub mod provenance;
mod quality;
pub mod room;
pub mod sample;
pub mod scene_light;
pub mod size_text;
pub mod sky_part;
mod source;
mod species;
pub mod sun;
pub mod surface;
mod surfaces;
#[cfg(feature = "testing")]
pub mod testing;
pub mod text;
mod transform;
mod turbid;

/// Matter of a plant, as solvers see it: classes of sites, optics and surfaces of each class, leaf area in each site.
pub mod matter {
    pub use crate::medium::{Class, rounded};
    pub use crate::optics::{BandOptics, ClassOptics, Optics};
    pub use crate::surfaces::{BandSurfaces, LeafSurface, Surfaces, WoodSurface};
    pub use crate::turbid::{INCLINATIONS, LeafAngles, TurbidMedium};
}

/// Words of a file about the mesh that its light was made on: a mark to know it by, and errors measured on it.
pub mod mesh {
    pub use crate::mesh_error::{ClassError, MESH_ERROR, MeshError, SourceError};
    pub use crate::mesh_mark::{FIT_SHARE, MeshFit, MeshMark, MeshMatch, digest};
}

pub use container::Container;
pub use container::records::Codec;
pub use daylight::Daylight;
pub use error::FormatError;
pub use field::{Field, Grid};
pub use medium::Medium;
pub use meta::SpeciesMeta;
pub use quality::{Purpose, Quality};
pub use source::Source;
pub use species::SpeciesFields;
pub use transform::{Placement, Transform};

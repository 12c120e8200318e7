//! The `.flb` format: the types that every room shares, the block codec, and the checked parse of a
//! container. No files, no threads, no GPU, no unsafe: bytes come through [`Source`].
//!
//! `SPEC.md` beside this crate is normative; this crate follows it.
#![forbid(unsafe_code)]
#![deny(clippy::print_stdout, clippy::print_stderr)] // cli/src/print.rs alone prints

pub mod bases;
pub mod beam;
pub mod block;
pub mod blocks;
pub mod canonical;
pub mod colors;
pub mod container;
pub mod daylight;
pub mod direction;
pub mod error;
pub mod eye;
pub mod field;
pub mod haar;
pub mod light;
pub mod material_surface;
pub mod mean_light;
pub mod medium;
pub mod mesh_error;
pub mod mesh_mark;
pub mod meta;
pub mod model;
pub mod optics;
pub mod ordinates;
pub mod progress;
pub mod provenance;
pub mod quality;
pub mod room;
pub mod sample;
pub mod scene_light;
pub mod size_text;
pub mod sky_part;
pub mod source;
pub mod species;
pub mod sun;
pub mod surfaces;
#[cfg(feature = "testing")]
pub mod testing;
pub mod text;
pub mod transform;
pub mod turbid;

pub use bases::BaseSet;
pub use container::records::{Codec, SectionEntry, SectionKey};
pub use container::{Container, payload, records};
pub use daylight::Daylight;
pub use error::{ErrorClass, FormatError, Place};
pub use eye::Eye;
pub use field::{Field, Grid, site_of};
pub use light::{FieldKind, Light, LightError, MonteCarloError, SunBasis};
pub use material_surface::{MaterialSurface, Texel};
pub use mean_light::MeanLight;
pub use medium::{Class, Medium};
pub use mesh_error::{ClassError, MESH_ERROR, MeshError, SourceError};
pub use mesh_mark::{MeshMark, MeshMatch};
pub use meta::SpeciesMeta;
pub use model::Model;
pub use optics::{BandOptics, ClassOptics, Optics};
pub use progress::{Cancelled, Progress};
pub use quality::Quality;
pub use sample::SOLID_OFFSET;
pub use sky_part::SkyPart;
pub use source::Source;
pub use species::SpeciesFields;
pub use surfaces::{BandSurfaces, LeafSurface, Surfaces, WoodSurface};
pub use transform::{Placement, Transform};
pub use turbid::{LeafAngles, TurbidMedium};

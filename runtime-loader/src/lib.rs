//! From a `.flb` file to light at a point: open it (by positioned reads, mapped, or behind a URL), load a species, ask.
//!
//! ```
//! # fn main() -> Result<(), flb_runtime::RuntimeError> {
//! use flb_format::sun::towards_sun;
//! use flb_runtime::{Daylight, Library, SpeciesLight, Transform};
//!
//! let library = Library::open("golden/shrub.flb")?;
//! let shrub = SpeciesLight::load(&library, 0)?;
//!
//! // Once for each plant, when the sun moves.
//! let afternoon = Daylight { towards_sun: towards_sun(240.0, 35.0), sun: 1.0, sky: 0.36 };
//! let stands = Transform { position_m: [12.0, 0.0, -3.0], ..Transform::IDENTITY };
//! let lit = shrub.lit_by(&afternoon, &stands)?;
//!
//! // For each point of its mesh at rest, in metres, from any thread.
//! let mut rgb = [0.0; 3];
//! lit.at([0.5, 3.0, -0.2], &mut rgb);
//! assert!(rgb.iter().all(|band| *band > 0.0));
//!
//! // Points that lie near one another cost less, one cursor for each thread.
//! let mut cursor = lit.cursor();
//! let mut near = [0.0; 3];
//! cursor.at([0.5, 3.0, -0.2], &mut near);
//! assert!(near.iter().zip(rgb).all(|(near, rgb)| (near - rgb).abs() < 1e-4));
//! # Ok(())
//! # }
//! ```
//!
//! [`SpeciesLight`] takes files of either model and of every codec, and what a [`stream::Streamer`] has loaded;
//! [`light`] says how wind, skinning and levels of detail ask. What it is made of is in modules:
//! [`samplers`] of one model each, [`resident::ResidentSpecies`], and with the feature `gpu` the terms and the shaders
//! of `gpu`. A [`source`] opens the bytes of a file or a URL.
#![deny(unsafe_code)] // `forbid` everywhere but here: `source/mapped.rs` maps memory.
#![deny(clippy::print_stdout, clippy::print_stderr)] // cli/src/print.rs alone prints

mod base;
mod entry;
mod error;
pub mod extinction;
mod file_light;
pub mod forest;
#[cfg(feature = "gpu")]
pub mod gpu;
mod library;
pub mod light;
mod location;
mod near_beam;
mod physical;
#[cfg(test)]
mod plants;
pub mod residency;
pub mod resident;
mod sampler;
pub mod scene_light;
pub mod source;
pub mod stream;
mod sun_terms;
pub mod view;

/// Samplers below [`SpeciesLight`], of one model each, the near beam in a medium, and what a sun gives each basis.
pub mod samplers {
    pub use crate::near_beam::{Marcher, PreparedSun, RayOffsets, SunRing, offset, seed_of};
    pub use crate::physical::PhysicalSampler;
    pub use crate::sampler::{SpeciesSampler, bases_needed};
    pub use crate::sun_terms::SunTerms;
}

pub use error::RuntimeError;
pub use flb_format::mesh::{MeshMark, MeshMatch};
pub use flb_format::surface;
pub use flb_format::{Daylight, Placement, Transform};
pub use forest::Forest;
pub use library::Library;
pub use light::SpeciesLight;
pub use light::cursor::LightCursor;
pub use light::instance::InstanceLight;
pub use location::{Location, LocationError};

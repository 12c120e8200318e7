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
//! [`light`] says how wind, skinning and levels of detail ask. Its parts are here for those who need them:
//! [`SpeciesSampler`], [`PhysicalSampler`], [`Marcher`], [`resident::ResidentSpecies`], and with the feature `gpu` the
//! terms and the shaders of `gpu`.
#![deny(unsafe_code)] // `forbid` everywhere but here: `source/mapped.rs` maps memory.
#![deny(clippy::print_stdout, clippy::print_stderr)] // cli/src/print.rs alone prints

mod base;
mod entry;
mod error;
pub mod extinction;
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

pub use error::RuntimeError;
pub use flb_format::{MeshMark, MeshMatch, Placement, Transform};
pub use library::{Library, Traffic};
pub use light::{
    Daylight, InstanceLight, KeptLight, LightCursor, LightCursors, SkyBeams, SkyLight, SkyPart, SpeciesLight,
};
#[cfg(feature = "remote")]
pub use location::RemoteUrl;
pub use location::{Location, LocationError};
pub use near_beam::{Marcher, PreparedSun, RayOffsets, offset, seed_of};
pub use physical::PhysicalSampler;
pub use sampler::{SpeciesSampler, bases_needed};
pub use scene_light::SceneLight;
#[cfg(feature = "remote")]
pub use source::{EnvironmentError, RemoteError, RemoteSettings, RemoteSource, is_private};
pub use source::{FileSource, MappedSource, Replaced, is_replaced, retry_replaced};
pub use sun_terms::SunTerms;

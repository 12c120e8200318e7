//! From a `.flb` file to light at a point: open it (mapped, by positioned reads, or behind a URL), load the bases that
//! a sun needs, sample them.
//!
//! ```no_run
//! # fn main() -> Result<(), flb_runtime::RuntimeError> {
//! let library = flb_runtime::Library::open("oak.flb")?;
//! let sun = flb_format::sun::blend(flb_format::sun::towards_sun(135.0, 40.0)).expect("a direction");
//! let sampler = flb_runtime::SpeciesSampler::load(&library, 0, &flb_runtime::bases_needed(&sun, true))?;
//! let mut light = [0.0; 3];
//! sampler.indirect(&sun, 1.0, 0.2, [0.5, 3.0, -0.2], &mut light);
//! # Ok(())
//! # }
//! ```
#![deny(unsafe_code)]
#![deny(clippy::print_stdout, clippy::print_stderr)] // cli/src/print.rs alone prints // `forbid` everywhere but here: `source/mapped.rs` maps memory.

mod error;
pub mod extinction;
#[cfg(feature = "gpu")]
pub mod gpu;
mod library;
mod location;
mod physical;
#[cfg(test)]
mod plants;
pub mod residency;
pub mod resident;
mod sampler;
pub mod scene_light;
pub mod source;
pub mod stream;
pub mod view;

pub use error::RuntimeError;
pub use library::{Library, Traffic};
#[cfg(feature = "remote")]
pub use location::RemoteUrl;
pub use location::{Location, LocationError};
pub use physical::{Marcher, PhysicalSampler, PreparedSun, RayOffsets, SunTerms, offset};
pub use sampler::{SpeciesSampler, bases_needed};
pub use scene_light::SceneLight;
#[cfg(feature = "remote")]
pub use source::{EnvironmentError, RemoteError, RemoteSettings, RemoteSource, is_private};
pub use source::{FileSource, MappedSource, Replaced, is_replaced, retry_replaced};

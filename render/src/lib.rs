//! A mesh and the light of an `.flb` file in, a relit picture out, on the CPU.
//!
//! ```text
//! Species, instances -prepare-> Forest -trace-> Fragments -relight-> Picture -tone map-> PNG, or linear EXR
//! ```
//!
//! Two shadings of docs/lighting-model.md, section 10. `paper`: direct Lambert light through a shadow ray, a
//! small highlight on leaves, and indirect light = texture colour x phi x scale. `physical`: leaves of
//! measured reflectance and transmittance in radiometric units, whose texture only says where they are
//! brighter or darker than the mean. Where phi comes from is the caller's: a closure from a point in model
//! space to phi per band ([`LightFn`]), with sun and ambient already blended in. So this crate ray traces and nothing
//! else, and tests need no file.
//!
//! There is one renderer, that of a [`forest`]. A plant alone is a forest of one ([`render_plant`]).
//!
//! [`render_reference`] makes the `physical` picture by paths traced on the mesh, without any phi: what baked
//! light is judged by.
//!
//! The same scene and settings give the same bytes for any number of threads: every pixel has its own
//! sequence of samples, summed in order by one thread.
#![forbid(unsafe_code)]
#![deny(clippy::print_stdout, clippy::print_stderr)] // cli/src/print.rs alone prints

mod backdrop;
pub mod classes;
pub mod error;
pub mod forest;
pub mod irradiance;
mod lens;
mod lighting;
mod paper;
mod paths;
mod physical;
pub mod picture;
mod portrait;
pub mod reference;
mod scene;
pub mod settings;
pub mod shading;
mod skylight;
mod sun;
pub mod surfaces;

pub use flb_format::Daylight;
pub use flb_scene::sampling::hash;
use flb_scene::sampling::r2_sequence;

pub use error::RenderError;
pub use forest::{LightFn, LightQuery, Species};
pub use irradiance::{PointIrradiance, irradiance};
pub use lighting::{Indirect, Lighting, Look};
pub use picture::{PHYSICAL_EXPOSURE, Picture, contact_sheet, png_of};
pub use portrait::{Portrait, render_plant};
pub use reference::{Reference, render_reference};
pub use shading::{PHYSICAL_SKY, Shading, Units};
pub use surfaces::Surfaces;

/// Where in its pixel a sample lies, 0..1 in x and y. A lone sample lies in the middle.
fn jitter(x: u32, y: u32, sample: u32, samples: u32) -> [f32; 2] {
    if samples == 1 { [0.5, 0.5] } else { r2_sequence(x ^ hash(y), sample) }
}

#[cfg(test)]
mod tests;

//! A mesh and the light of an `.flb` file in, a relit picture out, on the CPU.
//!
//! ```text
//! Species, instances -prepare-> Forest -trace-> Fragments -relight-> Picture -tone map-> PNG, or linear EXR
//! ```
//!
//! ```
//! use flb_render::{Lighting, Look, Portrait, Shading, Species, Surfaces, render_plant};
//! use flb_scene::mesh::Material;
//! use flb_scene::{MaterialClass, Mesh};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mesh = Mesh {
//!     positions: vec![[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]],
//!     normals: vec![[0.0, 0.0, 1.0]; 3],
//!     uvs: vec![[0.0; 2]; 3],
//!     triangles: vec![[0, 1, 2]],
//!     triangle_material: vec![0],
//!     materials: vec![Material::opaque("leaf")],
//!     ..Mesh::default()
//! };
//! let surfaces = Surfaces {
//!     leaf_reflectance: [0.05, 0.15, 0.02],
//!     leaf_transmittance: [0.07, 0.12, 0.04],
//!     wood_reflectance: [0.3, 0.25, 0.2],
//!     solid_offset_m: None,
//! };
//! let leaf = Species { mesh: &mesh, classes: &[MaterialClass::Leaf], shading: Shading::Physical(surfaces) };
//! let portrait = Portrait { width: 32, height: 32, samples: 1, ..Portrait::default() };
//! // Light at a point comes from a file (`flb_runtime::SpeciesLight`); here it is the same everywhere.
//! let light = |_query, rgb: &mut [f32; 3]| *rgb = [0.5; 3];
//! let picture =
//!     render_plant(&leaf, &portrait, &Lighting::default(), &Look::default(), &light, &|_| Ok(()))?;
//! assert_eq!(picture.rgb.len(), 32 * 32 * 3);
//! # Ok(())
//! # }
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
//! [`reference::render_reference`] makes the `physical` picture by paths traced on the mesh, without any phi: what
//! baked light is judged by.
//!
//! The same scene and settings give the same bytes for any number of threads: every pixel has its own
//! sequence of samples, summed in order by one thread.
#![forbid(unsafe_code)]
#![deny(clippy::print_stdout, clippy::print_stderr)] // cli/src/print.rs alone prints

mod backdrop;
pub mod classes;
mod error;
pub mod forest;
pub mod highlight;
pub mod irradiance;
mod lens;
mod lighting;
mod paper;
mod paths;
mod physical;
pub mod picture;
pub mod portrait;
pub mod reference;
mod scene;
pub mod settings;
pub mod shading;
mod skylight;
mod sun;
mod surfaces;

use flb_scene::sampling::{hash, r2_sequence};

pub use error::RenderError;
pub use forest::Species;
pub use forest::relight::{LightFn, LightQuery};
pub use lighting::{Indirect, Lighting, Look};
pub use picture::Picture;
pub use portrait::{Portrait, render_plant};
pub use shading::Shading;
pub use surfaces::Surfaces;

/// Where in its pixel a sample lies, 0..1 in x and y. A lone sample lies in the middle.
fn jitter(x: u32, y: u32, sample: u32, samples: u32) -> [f32; 2] {
    if samples == 1 { [0.5, 0.5] } else { r2_sequence(x ^ hash(y), sample) }
}

#[cfg(test)]
mod tests;

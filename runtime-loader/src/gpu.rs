//! Light of coded bases on a GPU: any renderer's shader samples it straight from the coefficients.
//!
//! ```text
//! CodedBase -pack-> records and nibbles -GpuLight-> buffers -light.wgsl: flb_sample-> light at a point
//! ```
//!
//! Where many fragments share a species and a sun, an [`Atlas`] of the blend is filtered by hardware instead, one fetch
//! a fragment.
//!
//! A renderer hands its device to [`GpuLight::new`], adds species and bases (or pages, as they are streamed), writes
//! the terms of its instances, and puts [`light_wgsl`] before its own shaders:
//!
//! ```no_run
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! use flb_runtime::gpu::{Gpu, GpuLight, GpuSpecies, LightSettings, light_wgsl};
//! let gpu = Gpu::open(wgpu::Features::empty())?; // a renderer has its own
//! let library = flb_runtime::Library::open("oak.flb")?;
//! let mut light = GpuLight::new(&gpu.device, &gpu.queue, LightSettings::default())?;
//! let oak = GpuSpecies::load(&mut light, &library, 0)?;
//! let mut terms = Vec::new();
//! let near_count = oak.terms([0.36, 0.8, 0.48], 1.0, 0.2, &mut terms)?; // for every instance
//! light.set_terms(0, &terms)?;
//! let shader = light_wgsl(3)
//!     + "/* flb_sample(oak.number(), 0u, terms.len(), point_model_m), or flb_near and flb_sample_near */";
//! # Ok(())
//! # }
//! ```
//!
//! Species of harmonics have a near beam, which `flb_near` marches through the extinction for each point
//! ([`GpuLight::set_extinction`]); `flb_sample_near` takes what it finds. Light of an uneven sky is `flb_sky`'s
//! ([`GpuLight::set_sky_beams`], [`GpuSpecies::sky_terms`]).
//!
//! It keeps to WebGPU's default limits: one bind group of a uniform buffer and three storage buffers, of which none is
//! over 128 MiB.

mod atlas;
mod bindings;
mod error;
mod follow;
mod id;
mod layout;
mod light;
mod pack;
mod pool;
mod sky;
mod species;

pub use atlas::{Atlas, AtlasDecoder, atlas_wgsl};
pub use bindings::{light_wgsl, light_wgsl_f16};
pub use error::GpuError;
pub use flb_gpu::{DeviceError, Gpu};
pub use follow::{Followed, Follower};
pub use id::GpuSpeciesId;
pub use layout::{MAX_SPECIES, MAX_TERMS, Term};
pub use light::{GpuLight, LightSettings};
pub use sky::SkyOnGpu;
pub use species::GpuSpecies;

#[cfg(test)]
mod tests;

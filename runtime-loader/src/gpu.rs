//! Light of coded bases on a GPU: any renderer's shader samples it straight from the coefficients.
//!
//! ```text
//! CodedBase -pack-> records and nibbles -GpuLight-> buffers -light.wgsl: flb_sample-> light at a point
//! ```
//!
//! Where many fragments share a species and a sun, an [`Atlas`] of the blend is filtered by hardware instead, one fetch a fragment.
//!
//! A renderer hands its device to [`GpuLight::new`], adds species and bases (or pages, as they are streamed), writes the terms of its
//! instances, and puts [`light_wgsl`] before its own shaders:
//!
//! ```no_run
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! use flb_runtime::gpu::{Gpu, GpuLight, LightSettings, Term, light_wgsl};
//! let gpu = Gpu::open(wgpu::Features::empty())?; // a renderer has its own
//! let library = flb_runtime::Library::open("oak.flb")?;
//! let (container, source) = (library.container(), library.source());
//! let shared = container.read_shared(source, 0)?;
//! let mut light = GpuLight::new(&gpu.device, &gpu.queue, LightSettings::default())?;
//! let oak = light.add_species(&container.species()[0].meta.grid, &shared)?;
//! let base = light.set_base(oak, 0, &container.read_coded_base(source, 0, 0, &shared)?)?;
//! light.set_terms(0, &[Term { base, factor: 0.2 }])?;
//! let shader = light_wgsl(3) + "/* flb_sample(oak, 0u, 1u, point_model_m) */";
//! # Ok(())
//! # }
//! ```
//!
//! Species of harmonics have a near beam, which `flb_near` marches through the extinction for each point ([`GpuLight::set_extinction`]);
//! `flb_sample_near` takes what it finds.
//!
//! It keeps to WebGPU's default limits: one bind group of a uniform buffer and three storage buffers, of which none is over 128 MiB.

mod atlas;
mod bindings;
mod error;
mod follow;
mod layout;
mod light;
mod pack;
mod pool;

pub use atlas::{Atlas, AtlasDecoder, atlas_wgsl};
pub use bindings::{light_wgsl, light_wgsl_f16};
pub use error::GpuError;
pub use flb_gpu::{DeviceError, Gpu};
pub use follow::{Followed, Follower};
pub use layout::{MOST_SPECIES, MOST_TERMS, Term};
pub use light::{GpuLight, LightSettings};

#[cfg(test)]
mod tests;

//! The forest renderer of `flb-render` on a GPU: plants of a few species, each in its own baked light, relit while the
//! sun moves.
//!
//! ```text
//! Forest -new-> buffers -trace(view)-> fragments -relight(light, look)-> picture -> a window, or the host
//! ```
//!
//! Compute shaders, one file a stage, whose twins are the files of `flb_render::forest`: `trace` finds what every ray
//! of the camera meets, `shade` casts shadow rays and adds what the sun does, `light` adds the light of fields
//! (`flb_sample` of `flb_runtime::gpu`), `resolve` takes the means of pixels. Fragments stay on the GPU, so that a sun
//! that moves pays for the last three alone. Where plants change each other's light ([`GpuForest::set_scene_light`]),
//! another `light` takes its place, which samples sun and sky apart; other scenes do not pay for that. Water sends rays
//! back, so that `trace` searches twice and a fragment tells what was met by way of it; shaders of a stand without
//! water have no such code.
//!
//! Hierarchies are those that the CPU built ([`flb_render::forest::export`]), walked by one stack for both levels; so
//! are the papers' grids, which [`ForestSettings::search`] puts in their places. It keeps to WebGPU's default limits:
//! buffers of 128 MiB, eight storage buffers a stage, four bind groups, workgroups of 64, no subgroups. No dispatch
//! serves more than [`ForestSettings::rays_per_dispatch`] rays, so that no driver's watchdog barks.
//!
//! A [`Fleet`] draws on several GPUs at once, tile by tile ([`GpuForest::trace_part`]).
//!
//! The CPU works in f64 where rays cross the world, a GPU has f32 only. So positions are sent as two floats and counted
//! from the camera, where they are finest: a ray's place on a plant is off by some ten-millionths of its distance. Rays
//! that graze an edge may fall on its other side; so pictures agree with the CPU's to a tolerance, not to the bit.
//!
//! ```no_run
//! # use flb_render::forest::{Forest, View};
//! # use flb_render::{Lighting, Look};
//! # use flb_render_gpu::{ForestSettings, GpuForest, LightSet, LightSource};
//! # fn draw(forest: &Forest, library: &flb_runtime::Library, view: &View) -> Result<(), Box<dyn std::error::Error>> {
//! let gpu = flb_gpu::Gpu::open(wgpu::Features::empty())?; // a window adopts its own
//! let mut lights = LightSet::load(&gpu, &[LightSource::Library { library, species: 0 }], 1000)?;
//! let mut on_gpu = GpuForest::new(&gpu, forest, &lights, ForestSettings::default())?;
//! on_gpu.trace(view)?;
//! on_gpu.relight(&mut lights, &Lighting::default(), &Look::default())?;
//! let picture = on_gpu.picture()?; // or bind on_gpu.picture_buffer()
//! # Ok(())
//! # }
//! ```
#![forbid(unsafe_code)]
#![deny(clippy::print_stdout, clippy::print_stderr)] // cli/src/print.rs alone prints

mod boxes;
mod buffers;
mod camera;
mod dome;
mod error;
mod fleet;
mod forest;
mod grids;
mod layout;
mod light_set;
mod light_words;
mod materials;
mod models;
mod neighbours;
mod part;
mod queue;
mod show;
mod skies;
mod stages;
mod stand;
mod statics;
mod streamed;
mod strips;
mod surroundings;

pub use error::ForestError;
pub use fleet::Fleet;
pub use forest::{ForestSettings, GpuForest};
pub use light_set::{LightSet, LightSource, can_light};
pub use part::PictureRect;
pub use show::Show;
pub use streamed::StreamedLights;
pub use strips::CameraHit;

/// Features of a device that are of use: none yet.
pub const FEATURES: wgpu::Features = wgpu::Features::empty();

#[cfg(test)]
mod tests;

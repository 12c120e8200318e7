//! Opens a scene of plants and makes its frames, each plant in the light of its file.
//!
//! ```text
//! Scene, plants, scene light -new-> Stage -renderer-> SceneRenderer -picture(frame)-> Picture
//!                                         └-Painter (streamed light) -paint(shot)-> Painted
//! ```
//!
//! A [`Stage`] is a scene with its meshes and its light. A [`SceneRenderer`] loads what the frames show of whole files,
//! and takes them on the CPU or on GPUs. A [`Painter`](stream::Painter) streams the light within a budget and draws
//! with what has come so far, as a viewer does. A [`PlantRenderer`] takes pictures of a plant alone. [`frames()`] says
//! where the camera and the sun of each frame are, [`StageSky`] which sky is over them.
//!
//! ```no_run
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! use flb_render::Look;
//! use flb_scene::Unobserved;
//! use flb_scene::scene::Scene;
//! use flb_stage::{
//!     Backend, FrameSettings, LookSettings, OpenSettings, SceneLook, SceneRenderer, Stage, StageSky, frames,
//! };
//!
//! let scene = Scene::read("forest.toml".as_ref())?;
//! let frames = frames(&scene, &FrameSettings { count: Some(24), needs_sun: true, ..FrameSettings::default() })?;
//! let stage = Stage::open(scene, &OpenSettings::default(), &Unobserved)?;
//! let settings = LookSettings { size: None, samples: 4, ambient: None, look: Look::default() };
//! let look = SceneLook::new(&stage, &settings, StageSky::clear(3.0)?)?;
//! let mut renderer = SceneRenderer::new(&stage, look, &frames, Backend::Cpu, &Unobserved)?;
//! for (number, frame) in frames.iter().enumerate() {
//!     let png = renderer.picture(frame, &Unobserved)?.to_png(stage.default_exposure())?;
//!     std::fs::write(format!("forest-{number:04}.png"), png)?;
//! }
//! # Ok(())
//! # }
//! ```
//!
//! The crate knows no window and no command line.
#![forbid(unsafe_code)]
#![deny(clippy::print_stdout, clippy::print_stderr)] // cli/src/print.rs alone prints

mod alone;
mod backend;
mod error;
#[cfg(feature = "gpu")]
mod fleet;
#[cfg(not(feature = "gpu"))]
#[path = "no_fleet.rs"]
mod fleet;
pub mod frames;
mod light;
mod look;
mod mesh_of_light;
mod neighbours;
pub mod open;
mod plant;
mod renderer;
mod sky;
mod stage;
pub mod stream;

pub use alone::{PlantLook, PlantRenderer};
pub use backend::{Backend, GpuCount};
pub use error::StageError;
pub use frames::{FramePath, FrameSettings, SceneFrame, frames};
pub use look::{LookSettings, SceneLook};
pub use mesh_of_light::MeshOfLight;
pub use open::OpenSettings;
pub use plant::{PlantLight, ScenePlant};
pub use renderer::SceneRenderer;
pub use sky::StageSky;
pub use stage::Stage;

#[cfg(test)]
mod tests;

//! Opens a scene of plants and makes its frames, each plant in the light of its file.
//!
//! ```text
//! Scene, plants, scene light -new-> Stage -renderer-> SceneRenderer -picture(frame)-> Picture
//!                                         └-Painter (streamed light) -paint(shot)-> Painted
//! ```
//!
//! A [`Stage`] is a scene with its meshes and its light. A [`SceneRenderer`] loads what the frames show of whole files,
//! and takes them on the CPU or on GPUs. A [`Painter`](stream::Painter) streams the light within a budget and draws
//! with what has come so far, as a viewer does. A [`PlantRenderer`](alone::PlantRenderer) takes pictures of a plant
//! alone. [`frames()`] says where the camera and the sun of each frame are, [`StageSky`] which sky is over them.
//!
//! ```
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! use flb_scene::Unobserved;
//! use flb_scene::scene::Scene;
//! use flb_stage::{
//!     Backend, FrameSettings, LookSettings, OpenSettings, SceneLook, SceneRenderer, Stage, StageSky, frames,
//! };
//!
//! # use flb_format::{Codec, light::SunBasis};
//! # use flb_testkit::plants;
//! # let temporary = tempfile::tempdir()?;
//! # let folder = temporary.path();
//! # let mut oak = plants::plant("oak", Some(&SunBasis::Lattice18), 16, 1);
//! # oak.meta.record(&flb_format::provenance::CLASSES, vec!["leaf".to_owned()]);
//! # std::fs::write(folder.join("oak.flb"), plants::bytes(&[oak], Codec::Classed))?;
//! # std::fs::write(folder.join("oak.obj"), "v -2 0 -2\nv 2 4 2\nv 2 0 -2\nusemtl leaf\nf 1 2 3\n")?;
//! # let camera = "camera = { position_m = [0, 2, 9], look_at_m = [0, 2, 0], height_px = 32, fov_deg = 40 }";
//! # let species = "[[species]]\nname = 'oak'\nfile = 'oak.obj'\nlight = 'oak.flb'";
//! # let instance = "[[instance]]\nspecies = 'oak'\nposition_m = [0, 0, 0]";
//! # let sun = "sun = { fixed = [[135, 40]] }";
//! # std::fs::write(folder.join("forest.toml"), [camera, sun, species, instance].join("\n"))?;
//! let scene = Scene::read(&folder.join("forest.toml"))?;
//! let frames = frames(&scene, &FrameSettings { count: Some(1), needs_sun: true, ..FrameSettings::default() })?;
//! let stage = Stage::open(scene, &OpenSettings::default(), &Unobserved)?;
//! let look = SceneLook::new(&stage, &LookSettings::default(), StageSky::clear(3.0)?)?;
//! let mut renderer = SceneRenderer::new(&stage, look, &frames, Backend::Cpu, &Unobserved)?;
//! for (number, frame) in frames.iter().enumerate() {
//!     let png = renderer.picture(frame, &Unobserved)?.to_png(stage.default_exposure())?;
//!     std::fs::write(folder.join(format!("forest-{number:04}.png")), png)?;
//! }
//! # Ok(())
//! # }
//! ```
//!
//! The crate knows no window and no command line.
#![forbid(unsafe_code)]
#![deny(clippy::print_stdout, clippy::print_stderr)] // cli/src/print.rs alone prints

pub mod alone;
pub mod backend;
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
mod parts;
pub mod plant;
pub mod read;
mod renderer;
mod show;
mod sky;
mod stage;
pub mod stream;
mod suns;

pub use backend::Backend;
pub use error::StageError;
pub use frames::{FrameSettings, SceneFrame, frames};
pub use look::{LookSettings, SceneLook};
pub use mesh_of_light::MeshOfLight;
pub use open::OpenSettings;
pub use renderer::SceneRenderer;
pub use show::SceneShow;
pub use sky::StageSky;
pub use stage::Stage;

#[cfg(test)]
mod tests;

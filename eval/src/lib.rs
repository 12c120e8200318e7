//! Judges baked light: a file against paths traced on the plant's mesh, and a grid of bakes against the finest of them.
//!
//! ```text
//! mesh -judged_points-> points ─┐
//! .flb -SpeciesLight-> light ───┴─MeshJudge-> MeshJudgement: figures of leaves and wood, under suns and sky
//! ```
//!
//! ```no_run
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! use flb_eval::{JudgeSettings, MeshJudge, judged_points, judged_surfaces};
//! use flb_runtime::{Library, SpeciesLight};
//! use flb_scene::import::import;
//! use flb_scene::{ClassRules, ImportSettings, PlantReader, Unobserved};
//! use flb_transport::monte_carlo::judge;
//!
//! let library = Library::open("oak.flb")?;
//! let reader = PlantReader::new(None, ImportSettings::default(), ClassRules::default());
//! let (mesh, _) = reader.class(import("oak.glb".as_ref(), &reader.settings)?)?;
//! let light = SpeciesLight::load(&library, 0)?;
//! let surfaces = judged_surfaces(&library.container().species()[0].meta)?;
//! let JudgeSettings { suns, points, samples } = JudgeSettings::default();
//! let points = judged_points(&mesh, points, false)?;
//! let judge = MeshJudge::new(&light, surfaces, points, judge::suns(suns as usize), &Unobserved)?;
//! let judged = judge.judge(&mesh, samples, "oak", &Unobserved)?;
//! if let Some(sky) = judged.leaf.and_then(|leaf| leaf.sky) {
//!     println!("leaves under the sky: {:.3} of the truth in green", sky.ratio[1]);
//! }
//! # Ok(())
//! # }
//! ```
//!
//! The crate prints nothing and writes no file.
#![forbid(unsafe_code)]
#![deny(clippy::print_stdout, clippy::print_stderr)] // cli/src/print.rs alone prints

mod coded;
mod error;
pub mod figures;
mod mesh;
mod pictures;
pub mod trade;

pub use coded::judge_coded;
pub use error::EvalError;
pub use figures::{ClassJudgement, Figures, MeshJudgement};
pub use mesh::{JudgeSettings, MeshJudge, MeshTruth, judged_points, judged_surfaces};
pub use pictures::JudgePicture;
pub use trade::{Trade, TradeSettings, trade};

#[cfg(test)]
mod tests;

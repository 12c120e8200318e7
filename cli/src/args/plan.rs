//! Arguments of `flb plan`.

use std::path::PathBuf;

use clap::{ArgAction, Args};
use flb_files::Existing;
use flb_scene::scene::SunPath;

use super::values::existing;

#[derive(Args)]
#[command(group(clap::ArgGroup::new("from").required(true).multiple(true).args(["scene", "sun_path", "upright"])))]
pub(crate) struct PlanArgs {
    /// Scene file (TOML): species, instances, sun, sky, camera; its keys are in docs/book/src/scenes.md. Without one
    /// the plan is for every plant that turns only about the vertical
    #[arg(value_name = "SCENE.toml")]
    pub scene: Option<PathBuf>,
    /// The suns of whole days (UTC, both included) at a place, degrees north and east; in place of the scene's.
    /// Refraction is ignored; a sun counts from elevation 0
    #[arg(long, value_name = "LAT,LON,DATE..DATE", allow_hyphen_values = true)]
    pub sun_path: Option<SunPath>,
    /// Plan for plants that turn freely about the vertical, whatever their yaw in the scene
    #[arg(long)]
    pub upright: bool,
    /// Plan without ambient light: base 0 is left out
    #[arg(long)]
    pub no_ambient: bool,
    /// The plan to write: .toml or .json
    #[arg(short, long, value_name = "PLAN.toml|.json")]
    pub output: PathBuf,
    /// Overwrite the output if it is there already
    #[arg(long = "force", action = ArgAction::SetTrue, value_parser = existing())]
    pub existing: Existing,
    /// Print what was found as JSON (schema: cli/schema/plan.json)
    #[arg(long)]
    pub json: bool,
}

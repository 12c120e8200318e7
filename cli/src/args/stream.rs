//! Arguments of `flb stream`.

use std::path::PathBuf;

use clap::{ArgAction, Args};
use flb_files::Existing;

use super::MemoryArgs;
use super::values::{above_0, at_least_0, existing};

#[derive(Args)]
pub(crate) struct StreamArgs {
    /// The .flb file, or its URL (http, https, s3), with the light of every species of the scene
    #[arg(value_name = "LIB.flb")]
    pub library: PathBuf,
    /// Scene file (TOML) with a camera that looks at something (look_at_m or look_at_path_m), and fixed suns or a path
    /// of the sun, which it moves along; its keys are in docs/book/src/scenes.md
    #[arg(value_name = "SCENE.toml")]
    pub scene: PathBuf,
    /// Also write what every frame asked for and saw, as JSON
    #[arg(long, value_name = "PATH.json")]
    pub trace: Option<PathBuf>,
    /// Time from a request to its first byte, milliseconds
    #[arg(long, default_value_t = 50.0, value_name = "MS", value_parser = at_least_0)]
    pub rtt: f64,
    /// Bandwidth of the link, 10^6 bytes a second
    #[arg(long, default_value_t = 10.0, value_name = "MB/S", value_parser = above_0)]
    pub bandwidth: f64,
    /// Requests at once
    #[arg(long, default_value_t = 6, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub connections: u16,
    /// Memory for the light, 10^6 bytes
    #[arg(long, default_value_t = 32.0, value_name = "MB", value_parser = above_0)]
    pub budget: f64,
    #[command(flatten)]
    pub memory: MemoryArgs,
    /// How long the camera and the sun take for their paths, seconds
    #[arg(long, default_value_t = 10.0, value_name = "S", value_parser = above_0)]
    pub seconds: f64,
    /// Frames a second
    #[arg(long, default_value_t = 60.0, value_name = "N", value_parser = above_0)]
    pub fps: f64,
    /// Overwrite the trace if it is there already
    #[arg(long = "force", action = ArgAction::SetTrue, value_parser = existing())]
    pub existing: Existing,
    /// Print as JSON (schema: cli/schema/stream.json)
    #[arg(long)]
    pub json: bool,
}

//! Arguments of `flb view`.

use std::path::PathBuf;

use clap::{ArgAction, Args};
use flb_files::Existing;
use flb_view::Show;

use super::values::{above_0, angle_pair, existing, exposure, size};
use super::{BandArgs, HighlightArgs, MemoryArgs, RenderBackendArg, SceneLightArgs, SkyArgs, SunlightArgs};

#[derive(Args)]
pub(crate) struct ViewArgs {
    /// Scene file (TOML), as `flb render` takes it; without a camera, it is looked at from outside
    #[arg(value_name = "SCENE.toml")]
    pub scene: PathBuf,
    /// Sun's azimuth (clockwise from north, -Z; east is +X) and elevation, degrees, to begin with [default: the scene's
    /// first fixed sun, else 135,40]
    #[arg(long, value_name = "AZIMUTH,ELEVATION", value_parser = angle_pair, allow_hyphen_values = true)]
    pub sun: Option<[f64; 2]>,
    #[command(flatten)]
    pub sunlight: SunlightArgs,
    #[command(flatten)]
    pub highlight: HighlightArgs,
    /// What is shown to begin with: `all`, `indirect`, `direct`, `base:N` (the light of one base), `level` (green: all
    /// there, yellow: averages, orange: other bases, red: nothing), `residency` (white: all detail is loaded), `error`
    /// (white: 10 % off what the whole file has)
    #[arg(long, value_name = "SHOW", value_parser = show, default_value = "all")]
    pub show: Show,
    /// Size of the window, or of the screenshot, in pixels
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "1280x720")]
    pub size: [u32; 2],
    /// Rays per pixel of a picture that has come to rest
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub samples: u32,
    /// Memory for the light, 10^6 bytes: more of it is streamed than this never. A GPU takes 128 at most
    #[arg(long, default_value_t = 64.0, value_name = "MB", value_parser = above_0)]
    pub budget: f64,
    /// Where pictures are painted, but for the false colours; a GPU takes scenes whose light is of one file (`flb
    /// pack`). `auto` passes over software
    #[arg(long, value_enum, default_value_t = RenderBackendArg::Auto)]
    pub backend: RenderBackendArg,
    /// Light of the sky, as for `flb render` [default: the scene's, else 0.02; `physical`: 0.36]
    #[arg(long, value_name = "A")]
    pub ambient: Option<f32>,
    #[command(flatten)]
    pub sky: SkyArgs,
    #[command(flatten)]
    pub bands: BandArgs,
    #[command(flatten)]
    pub scene_light: SceneLightArgs,
    /// Exposure to begin with, stops [default: 0; `physical`: 3]
    #[arg(long, allow_hyphen_values = true, value_name = "EV", value_parser = exposure)]
    pub exposure: Option<f32>,
    /// Show other meshes than the light was baked from, even where their size does not fit; without it, that is refused
    #[arg(long)]
    pub mesh_differs: bool,
    #[command(flatten)]
    pub memory: MemoryArgs,
    /// Open no window: write what it would show once all light is there that fits, panel and all
    #[arg(long, value_name = "OUT.png")]
    pub screenshot: Option<PathBuf>,
    /// Close the window by itself after so many seconds
    #[arg(long, value_name = "S", conflicts_with = "screenshot")]
    pub seconds: Option<f64>,
    /// Overwrite the screenshot if it is there already
    #[arg(long = "force", action = ArgAction::SetTrue, value_parser = existing())]
    pub existing: Existing,
    /// Print what was seen last as JSON (schema: cli/schema/view.json)
    #[arg(long)]
    pub json: bool,
}

fn show(text: &str) -> Result<Show, String> {
    Ok(match text {
        "all" => Show::Whole,
        "indirect" => Show::Indirect,
        "direct" => Show::Direct,
        "level" => Show::Level,
        "residency" => Show::Residency,
        "error" => Show::Error,
        _ => match text.strip_prefix("base:").map(str::parse) {
            Some(Ok(base)) => Show::Base(base),
            _ => return Err("expected all, indirect, direct, base:N, level, residency or error".to_owned()),
        },
    })
}

//! Arguments of `flb render`.

use std::path::PathBuf;

use clap::{ArgAction, Args, ValueEnum};
use flb_files::Existing;
use flb_scene::scene::SunHours;

use super::gpu_count::gpu_count;
use super::search::search;
use super::values::{angle_pair, existing, exposure, size};
use flb_render::forest::Search;
use flb_stage::SceneShow;
use flb_stage::backend::GpuCount;

use super::{BandArgs, HighlightArgs, MemoryArgs, SceneLightArgs, SkyArgs, SunlightArgs};

#[derive(Args)]
pub(crate) struct RenderArgs {
    /// A .flb file, or its URL (http, https, s3); or a scene (.toml)
    #[arg(value_name = "FILE.flb|SCENE.toml")]
    pub file: PathBuf,
    /// The mesh that the species was baked from; a scene names its own
    #[arg(long, value_name = "MESH")]
    pub mesh: Option<PathBuf>,
    /// The one mesh of a glTF to show, by its name or as #3 [default: as it was baked]
    #[arg(long, value_name = "NAME", requires = "mesh")]
    pub gltf_mesh: Option<String>,
    /// Sun's azimuth (clockwise from north, -Z; east is +X) and elevation, degrees; repeat it for a
    /// contact sheet of several suns side by side [default: a scene's first fixed sun]
    #[arg(long, value_name = "AZIMUTH,ELEVATION", value_parser = angle_pair, allow_hyphen_values = true)]
    pub sun: Vec<[f64; 2]>,
    #[command(flatten)]
    pub sunlight: SunlightArgs,
    #[command(flatten)]
    pub highlight: HighlightArgs,
    /// Take so many pictures of a scene while its sun goes along --sun-path, or from the first to the last of the suns
    /// (of --sun, else the scene's), and its camera along its path: OUT-0001.png and so on
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=9999))]
    pub frames: Option<u32>,
    /// The sun of a place (degrees north and east) for --frames, from one time to another, UTC unless they end in an
    /// offset: 52.5,13.4,2026-06-21T05:00..2026-06-21T19:00. A date alone: from sunrise to sunset. Refraction is
    /// ignored. While the sun is below the horizon, the sky alone lights a scene with ground [default: of a scene's
    /// `path` the first day]
    #[arg(
        long,
        value_name = "LAT,LON,FROM..TO",
        allow_hyphen_values = true,
        requires = "frames",
        conflicts_with = "sun"
    )]
    pub sun_path: Option<SunHours>,
    /// Show another mesh than the light was baked from, even where its size does not fit; without it, that is refused
    #[arg(long)]
    pub mesh_differs: bool,
    /// Name of the species [default: the only one, else the mesh file's name]
    #[arg(long, value_name = "S")]
    pub species: Option<String>,
    #[command(flatten)]
    pub scene_light: SceneLightArgs,
    /// Light of the sky: factor on the ambient base of a `paper` file, whose value is 18 outside the plant; fluence of
    /// an even sky, the sun's being 1, with a `physical` one; factor on a clear sky [default: 0.02; `physical`: 0.36;
    /// a clear sky: 1]
    #[arg(long, value_name = "A")]
    pub ambient: Option<f32>,
    #[command(flatten)]
    pub sky: SkyArgs,
    #[command(flatten)]
    pub bands: BandArgs,
    /// Factor on all indirect light [default: 0.5; 1, as in the papers, of files of `--quality papers`]; `paper` files
    /// only
    #[arg(long, value_name = "F")]
    pub indirect_scale: Option<f32>,
    /// Render with the light of this file too, and show both pictures and their difference, for each sun
    #[arg(long, value_name = "OTHER.flb", conflicts_with = "path_traced")]
    pub against: Option<PathBuf>,
    /// What the difference is multiplied by, with --against
    #[arg(long, value_name = "F", default_value_t = 10.0, requires = "against")]
    pub times: f32,
    /// Trace paths over the mesh itself instead of using the light of the file; a `physical` file says what leaves and
    /// wood reflect
    #[arg(long)]
    pub path_traced: bool,
    /// Size of a picture in pixels [default: 512x512; of a scene its camera's height, and 16:9]
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<[u32; 2]>,
    /// Rays per pixel [default: 16; of a scene 4]
    #[arg(long, value_name = "N")]
    pub samples: Option<u32>,
    /// What pictures show: `light`; `direct`, from the sun and the sky behind; `indirect`, the rest of it; `base:N`,
    /// the light of one base; `global`, of a scene, in grey how much of each plant's own light its neighbours leave and
    /// add; `alpha`, how much of a pixel plants and ground cover, beside which no sky is drawn behind. Several, as in
    /// `light,direct,indirect,alpha`, are layers of one .exr: channels R, G, B, A of the light, and direct.R and so on;
    /// a .png takes one, and `alpha` beside it
    #[arg(long, value_delimiter = ',', default_value = "light", value_name = "WHAT,...")]
    pub show: Vec<SceneShow>,
    /// Where the camera stands: azimuth and elevation seen from the plant, degrees [default: 180,8]; a scene has its
    /// own camera
    #[arg(long, value_name = "AZIMUTH,ELEVATION", value_parser = angle_pair, allow_hyphen_values = true)]
    pub view: Option<[f64; 2]>,
    /// Where a scene is drawn: `auto` takes a GPU that is no software and can light all its species, else the CPU, and
    /// says which. Pictures of a GPU differ from the CPU's by some thousandths, and from one GPU to another
    #[arg(long, value_enum, default_value_t = RenderBackendArg::Cpu)]
    pub backend: RenderBackendArg,
    /// GPUs that draw a scene together, with `--backend gpu` or `auto`: the best so many, or `all`. Each takes tile
    /// after tile; one that is lost leaves its tiles to the others [default: 1]
    #[arg(long, value_name = "N|all", value_parser = gpu_count)]
    pub gpus: Option<GpuCount>,
    /// How all rays find triangles in a scene's plants (`model`), and how rays of the camera and to the sun find
    /// plants: each `=grid`, as in the papers, or `=tree`. No pixel changes [default:
    /// model=tree,camera=grid,sun=tree]
    #[arg(long, value_name = "RAYS=grid|tree,...", value_parser = search)]
    pub find: Option<Search>,
    /// Exposure, stops [default: 0; `physical`: 3]
    #[arg(long, allow_hyphen_values = true, value_name = "EV", value_parser = exposure)]
    pub exposure: Option<f32>,
    #[command(flatten)]
    pub memory: MemoryArgs,
    /// Stand the plant on ground that catches its shadow and fades into the sky; a scene has its own
    #[arg(long)]
    pub ground: bool,
    /// The picture to write: .png (tone-mapped) or .exr (linear)
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// Overwrite the output if it is there already
    #[arg(long = "force", action = ArgAction::SetTrue, value_parser = existing())]
    pub existing: Existing,
    /// Print what was written as JSON (schema: cli/schema/render.json)
    #[arg(long)]
    pub json: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum RenderBackendArg {
    /// Every core; the same bytes everywhere
    Cpu,
    /// The GPU that the system ranks highest, through Vulkan, Metal, Direct3D 12 or OpenGL
    Gpu,
    /// A GPU where there is one for the scene
    Auto,
}

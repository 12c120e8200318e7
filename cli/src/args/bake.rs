//! Arguments of `flb bake`.

use std::path::PathBuf;

use clap::{ArgAction, Args, ValueEnum};
use flb_farm::cache::Place;
use flb_files::Existing;
use flb_stage::backend::GpuCount;

use super::gpu_count::gpu_count;
use super::values::{cache_place, existing};
use super::{CodingArgs, MeshArgs, ModelArgs};
use flb_format::{Purpose, Quality};

#[derive(Args)]
pub(crate) struct BakeArgs {
    /// glTF, GLB or OBJ files; each becomes a species named after its file
    #[arg(required = true, value_name = "MESH")]
    pub meshes: Vec<PathBuf>,
    /// The .flb file to write
    #[arg(short, long, value_name = "OUT.flb")]
    pub output: PathBuf,
    #[command(flatten)]
    pub mesh: MeshArgs,
    /// Name of the species [default: the species file's, else the mesh file's]; of several meshes once for each, in
    /// their order
    #[arg(long, value_name = "NAME")]
    pub name: Vec<String>,
    // The help comes from the table of presets.
    #[arg(long, value_enum, value_name = "PRESET", help = super::preset::help())]
    pub quality: Option<Quality>,
    // As above.
    #[arg(long = "for", value_enum, value_name = "PURPOSE", conflicts_with = "quality", help = super::preset::purposes())]
    pub purpose: Option<Purpose>,
    /// Sites along each edge of the lattice: a power of two, 16 to 256 [default: the plan's, else the preset's];
    /// refused where the plan chooses one
    #[arg(long, value_name = "N")]
    pub lattice: Option<u32>,
    /// Bake only what this plan needs (`flb plan` writes it): its bands and lattices, and its bases with
    /// --model paper or --suns lattice18
    #[arg(long, value_name = "PLAN.toml|.json")]
    pub plan: Option<PathBuf>,
    /// Voxels along each edge of the fine grid: a multiple of the lattice, up to 4096 [default: the preset's]
    #[arg(long, value_name = "N")]
    pub voxels: Option<u32>,
    /// Count leaf cards whole, ignoring the alpha of their textures, as the papers do
    #[arg(long)]
    pub ignore_alpha: bool,
    /// Estimated error (relative L2 over the plant) at which a solve has converged [default: the preset's]
    #[arg(long, value_name = "T")]
    pub tolerance: Option<f64>,
    /// Do N iterations of the papers whatever the error is by then, which is no loss; `paper` only, by the solvers
    /// explicit (the default here) and literal [default: none; twice the lattice's edge with --quality papers]
    #[arg(long, value_name = "N", conflicts_with = "tolerance")]
    pub steps: Option<u32>,
    /// Sweeps after which a solve gives up
    #[arg(long, default_value_t = flb_transport::lattice::DEFAULT_MAX_SWEEPS, value_name = "N")]
    pub max_sweeps: u32,
    /// Where to solve. The light of a GPU is that of the CPU but for its last digits; its bytes can differ from one GPU
    /// to another
    #[arg(long, value_enum, default_value_t = BackendArg::Cpu)]
    pub backend: BackendArg,
    /// GPUs of one kind that share the solves, with `--backend gpu` or `auto`: so many, or `all`. Each takes band after
    /// band, or with `paper` base after base; the bytes are those of one [default: 1]
    #[arg(long, value_name = "N|all", value_parser = gpu_count)]
    pub gpus: Option<GpuCount>,
    /// Solver of the transport on the CPU; `paper` only. `literal` is the papers' iteration in f64, slow, for comparing
    #[arg(long, value_enum, default_value_t = SolverArg::Auto)]
    pub solver: SolverArg,
    #[command(flatten)]
    pub model: ModelArgs,
    #[command(flatten)]
    pub coding: CodingArgs,
    /// Judge the light on the mesh, as `flb judge` does, and keep the figures in the file: `flb info` shows them first.
    /// `physical` with scattered light only
    #[arg(long)]
    pub judge: bool,
    /// Make every doubt and every warning about a mesh an error (exit 1), before the long work
    #[arg(long)]
    pub strict: bool,
    /// Also write the uncoded fields, for `flb pack`
    #[arg(long, value_name = "FILE.flb")]
    pub keep_fields: Option<PathBuf>,
    /// Folder that keeps stage results, or s3://BUCKET/PREFIX; a later bake with the same inputs and settings reuses
    /// them
    #[arg(long, value_name = "DIR", value_parser = cache_place())]
    pub cache: Option<Place>,
    /// Overwrite files that are there already
    #[arg(long = "force", action = ArgAction::SetTrue, value_parser = existing())]
    pub existing: Existing,
    /// Print the summary as JSON (schema: cli/schema/bake.json)
    #[arg(long)]
    pub json: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum SolverArg {
    /// The fastest one: `sweep`; with --steps `explicit`
    Auto,
    /// Gauss-Seidel sweeps over non-empty sites, f32
    Sweep,
    /// The papers' iteration over the whole lattice, f32, until it converges
    Explicit,
    /// The papers' iteration over the whole lattice, f64, 2N steps
    Literal,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum BackendArg {
    /// Every core
    Cpu,
    /// The GPU that the system ranks highest, through Vulkan, Metal, Direct3D 12 or OpenGL
    Gpu,
    /// That GPU if it is hardware, else the CPU
    Auto,
}

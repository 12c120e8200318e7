//! The words of the command line. What each flag means is written here once; `--help` prints it.

mod bake;
mod bake_scene;
mod bands;
mod cache;
mod coding;
mod farm;
mod gpu_count;
mod highlight;
mod judge;
mod library;
mod model;
mod plan;
mod preset;
mod render;
mod scatter;
mod scene;
mod scene_light;
mod search;
mod sky;
mod stream;
mod sunlight;
mod torture;
mod trade;
mod values;
#[cfg(feature = "view")]
mod view;

use std::path::PathBuf;

use clap::{ArgAction, Args, Parser, Subcommand, ValueEnum};
use flb_files::Existing;
use flb_fixtures::PlantKind;
use flb_format::Quality;
use flb_inspector::validate::Level;
use flb_scene::color::ColorSource;
use flb_scene::import::Up;

pub(crate) use bake::{BackendArg, BakeArgs, SolverArg};
pub(crate) use bake_scene::BakeSceneArgs;
pub(crate) use bands::BandArgs;
pub(crate) use cache::{CacheArgs, CacheCommand, CacheFolder, GcArgs, VerifyArgs};
pub(crate) use coding::CodingArgs;
pub(crate) use farm::{
    EmitArgs, EngineArg, FarmArgs, FarmCommand, LogsArgs, SubmitArgs, TaskArgs, TaskCommand, TaskRunArgs,
    WaitArgs, WorkArgs, WorkFolder,
};
pub(crate) use highlight::HighlightArgs;
pub(crate) use judge::JudgeArgs;
pub(crate) use library::{
    BuildArgs, InitArgs, LibraryArgs, LibraryCommand, LibraryDiffArgs, ManifestArgs, ProgressArg, WhyArgs,
};
pub(crate) use model::{ModelArg, ModelArgs};
pub(crate) use plan::PlanArgs;
pub(crate) use render::{RenderArgs, RenderBackendArg};
pub(crate) use scatter::{ScatterArgs, SpeciesArg};
pub(crate) use scene::SceneArgs;
pub(crate) use scene_light::SceneLightArgs;
pub(crate) use sky::SkyArgs;
pub(crate) use stream::StreamArgs;
pub(crate) use sunlight::SunlightArgs;
pub(crate) use torture::TortureArgs;
pub(crate) use trade::TradeArgs;
#[cfg(feature = "view")]
pub(crate) use view::ViewArgs;

use values::existing;

/// Precomputed plant lighting: bake a plant mesh, keep its light in a .flb file, relight it anywhere.
#[derive(Parser)]
#[command(name = "flb", bin_name = "flb", version, long_version = crate::version::LONG, max_term_width = 100, after_help = EXIT_CODES)]
pub(crate) struct Cli {
    /// Threads to work with; 0 or none: every core. The bytes written do not depend on it
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(0..=1024))]
    pub threads: Option<u16>,
    /// Let a public server that a URL names redirect to addresses of this machine and of private networks; without it,
    /// that is refused
    #[cfg(feature = "remote")]
    #[arg(long, global = true)]
    pub allow_private_redirects: bool,
    #[command(subcommand)]
    pub command: Command,
}

const EXIT_CODES: &str = "\
Exit codes:
  0   done
  1   negative verdict: the input is invalid, or the files differ
  2   usage: a flag, a pattern or a setting is wrong, or something must be decided
  3   finished, with loss: for example, a solve that did not converge
  4   input/output: a file cannot be read or written, or the output is there already
  5   unsupported version, feature or extension
  6   a limit was hit
  70  internal fault
  75  a task was stopped before its end: run it again
  130 interrupted";

#[derive(Subcommand)]
pub(crate) enum Command {
    /// Bake plant meshes: import, voxelise, downsample, solve the light of all suns and of the sky, encode, write
    Bake(BakeArgs),
    /// Bake what the plants of a scene leave of each other's light and add to it, on a coarse lattice over all of them
    BakeScene(BakeSceneArgs),
    /// Work out what a scene needs of its species, for `flb bake --plan`: lattices, bands, and the bases of bakes with
    /// --model paper or --suns lattice18 (harmonics, the default, need all of theirs for any sun)
    Plan(PlanArgs),
    /// List a mesh's materials and the class (leaf, wood, neither) that each would get
    Materials(MaterialsArgs),
    /// Encode kept fields again, or merge files into one library; never solves again
    Pack(PackArgs),
    /// Rewrite a file of an older version of the format as the present one; no light changes
    Migrate(MigrateArgs),
    /// Say what is in a file: species, grids, bases, sections, sizes
    Info(InfoArgs),
    /// Check everything that SPEC.md promises of a file
    Validate(ValidateArgs),
    /// Corrupt a good file in every way that is known, and check that validate finds each; exit 1 where it does not
    Torture(TortureArgs),
    /// Compare two files; exit 1 where they differ
    Diff(DiffArgs),
    /// Write a base, the density or the extinction as a slice sheet (png) or a volume (exr, npy)
    Extract(ExtractArgs),
    /// Ray trace a mesh with the light of a file, or a scene of many plants with the light of theirs
    Render(RenderArgs),
    /// Compare the light of a file with paths traced on the mesh, at points of leaves and wood
    Judge(JudgeArgs),
    /// Replay a camera's path through a scene against a link: requests, bytes, stalls, time to the first and to the
    /// final picture
    Stream(StreamArgs),
    /// Open a window on a scene: move the camera and the sun, watch the light come
    #[cfg(feature = "view")]
    View(ViewArgs),
    /// Grow one of the built-in plants and write it as GLB
    Grow(GrowArgs),
    /// Make a scene of many plants, evenly spread at random
    Scatter(ScatterArgs),
    /// Make a scene of a glTF that holds a forest: nodes that share meshes, or EXT_mesh_gpu_instancing
    Scene(SceneArgs),
    /// Bake a plant under a grid of choices, measure each, and say which to choose
    Trade(TradeArgs),
    /// Bake a library of species from a manifest: what changed and no more
    Library(LibraryArgs),
    /// Bake a library on many machines: its work as tasks for Slurm, for what reads Open Job Description, for any other
    Farm(FarmArgs),
    /// Do a part of a library's work, as engines of farms call it
    Task(TaskArgs),
    /// Look after a folder that `--cache` names: list, count, check and remove what it keeps
    Cache(CacheArgs),
    /// Say what this machine offers; `--extremes` tries the solvers at the ends of their range
    Doctor(DoctorArgs),
}

/// For commands that need whole fields.
#[derive(Args)]
pub(crate) struct MemoryArgs {
    /// Memory, 10^9 bytes, that the fields of a file may take where they are needed whole, and the plants of a scene
    #[arg(long, default_value_t = 8.0, value_name = "GB")]
    pub memory_limit: f64,
}

/// How a mesh file is read and its materials are classed.
#[derive(Args, Clone, Default)]
pub(crate) struct MeshArgs {
    /// Species file (TOML): material patterns, unit, up axis, optics
    #[arg(long, value_name = "FILE")]
    pub species: Option<PathBuf>,
    /// Materials whose name matches are leaf (glob, case ignored; may be repeated); MATERIAL@NODE means a material
    /// where that node or group uses it. Where patterns overlap, an exact name wins, then leaf, then wood
    #[arg(long, value_name = "PATTERN")]
    pub leaf: Vec<String>,
    /// Materials whose name matches are wood (glob, case ignored; may be repeated)
    #[arg(long, value_name = "PATTERN")]
    pub wood: Vec<String>,
    /// Materials whose name matches are left out, a pot for example (glob, case ignored; may be repeated)
    #[arg(long, value_name = "PATTERN")]
    pub ignore: Vec<String>,
    /// Axis that points up in the mesh file [default: the species file's, else y]
    #[arg(long, value_enum)]
    pub up: Option<Up>,
    /// Unit of the mesh file: m, cm, mm, in, ft, or metres as a number [default: the species file's, else m]
    #[arg(long, value_name = "UNIT", value_parser = flb_scene::unit::parse_unit)]
    pub unit: Option<f64>,
    /// The one mesh of a glTF file to read, in its own space, by its name or as #3; `*`: the whole file as one plant,
    /// which must be said where it holds instances (EXT_mesh_gpu_instancing) [default: the species file's]
    #[arg(long, value_name = "NAME")]
    pub gltf_mesh: Option<String>,
    /// Nodes of a glTF, or groups and objects of an OBJ, to read, each with all below it (glob, case ignored, or #3 for
    /// a node's number; may be repeated) [default: the species file's, else all that the file shows]
    #[arg(long, value_name = "PATTERN")]
    pub node: Vec<String>,
    /// Take all vertices for white and opaque. Without this flag, their colours (COLOR_0, `v x y z r g b`) multiply
    /// the material's. In many exports such colours are data, as of wind [default: the species file's]
    #[arg(long, visible_alias = "ignore-vertex-colors")]
    pub ignore_vertex_colours: bool,
    /// Where the colour of leaves comes from: their texture (or base colour), which is what they reflect, or measured
    /// leaves, of which the texture is a tint [default: the species file's, else measured where the two are near]
    #[arg(long, visible_alias = "leaf-color", value_enum, value_name = "SOURCE")]
    pub leaf_colour: Option<ColorSource>,
    /// Where the colour of wood and of pots comes from, in the same way; measured is the mean of three barks
    #[arg(long, visible_alias = "wood-color", value_enum, value_name = "SOURCE")]
    pub wood_colour: Option<ColorSource>,
}

#[derive(Args)]
pub(crate) struct MaterialsArgs {
    /// A glTF, GLB or OBJ file
    #[arg(value_name = "MESH")]
    pub mesh_file: PathBuf,
    #[command(flatten)]
    pub mesh: MeshArgs,
    /// Also draw the plant in four views (front, right, back, above) with a colour a class: leaf green, wood brown,
    /// neither grey, undecided purple, cut away pink
    #[arg(long, value_name = "FILE.png")]
    pub picture: Option<PathBuf>,
    /// Pixels along an edge of each view
    #[arg(long, default_value_t = 384, value_parser = clap::value_parser!(u32).range(16..=4096), value_name = "PIXELS")]
    pub view_size: u32,
    /// Units in which the size is told: m, cm, mm, in, ft
    #[arg(long, value_delimiter = ',', default_value = "m,cm,ft", value_parser = flb_scene::unit::parse_name, value_name = "UNIT,..")]
    pub units: Vec<&'static str>,
    /// Make every doubt and every warning about the mesh an error (exit 1)
    #[arg(long)]
    pub strict: bool,
    /// Overwrite the picture if it exists
    #[arg(long = "force", action = ArgAction::SetTrue, value_parser = existing())]
    pub existing: Existing,
    /// Print as JSON (schema: cli/schema/materials.json)
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
pub(crate) struct PackArgs {
    /// .flb files or their URLs (http, https, s3); with one, its fields are encoded again; with several, their species
    /// are merged, as they are unless a flag asks for another coding
    #[arg(required = true, value_name = "FILE.flb")]
    pub inputs: Vec<PathBuf>,
    /// The .flb file to write
    #[arg(short, long, value_name = "OUT.flb")]
    pub output: PathBuf,
    /// Error of a preset of `flb bake`: 38, 45, 52 or 60 dB; of haar-paper a threshold of 0.05, 0.02, 0.005 or 0
    /// [default: standard]
    #[arg(long, value_enum, value_name = "PRESET", conflicts_with_all = ["threshold", "target_psnr", "target_error"])]
    pub quality: Option<Quality>,
    #[command(flatten)]
    pub coding: CodingArgs,
    #[command(flatten)]
    pub memory: MemoryArgs,
    /// Drop the bases that this plan does not need, where each sun has its own and a file may lack some (not with
    /// harmonics and lists)
    #[arg(long, value_name = "PLAN.toml|.json")]
    pub plan: Option<PathBuf>,
    /// Overwrite the output if it is there already
    #[arg(long = "force", action = ArgAction::SetTrue, value_parser = existing())]
    pub existing: Existing,
    /// Print the summary as JSON (schema: cli/schema/pack.json)
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
pub(crate) struct InfoArgs {
    /// A .flb file, or its URL (http, https, s3)
    pub file: PathBuf,
    /// Print as JSON (schema: cli/schema/info.json)
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
pub(crate) struct MigrateArgs {
    /// A .flb file of any version, or its URL (http, https, s3)
    #[arg(value_name = "OLD.flb")]
    pub input: PathBuf,
    /// The .flb file to write
    #[arg(short, long, value_name = "NEW.flb")]
    pub output: PathBuf,
    /// Overwrite the output if it is there already
    #[arg(long = "force", action = ArgAction::SetTrue, value_parser = existing())]
    pub existing: Existing,
    /// Print the summary as JSON (schema: cli/schema/migrate.json)
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
pub(crate) struct ValidateArgs {
    /// .flb files, or their URLs (http, https, s3)
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// How deep to look; each level includes the ones before it
    #[arg(long, value_enum, default_value_t = Level::Decode)]
    pub level: Level,
    /// Print as JSON (schema: cli/schema/validate.json)
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
pub(crate) struct DiffArgs {
    /// The first .flb file, or its URL (http, https, s3)
    pub a: PathBuf,
    /// The second .flb file, or its URL
    pub b: PathBuf,
    /// Call arrays equal whose largest difference is at most T times the largest magnitude in A, and
    /// leave settings, sources, tool and the mesh's digest out of the verdict [default: everything must be the same]
    #[arg(long, value_name = "T")]
    pub tolerance: Option<f64>,
    #[command(flatten)]
    pub memory: MemoryArgs,
    /// Print as JSON (schema: cli/schema/diff.json)
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
#[command(group(clap::ArgGroup::new("what").required(true).args(["base", "density"])))]
pub(crate) struct ExtractArgs {
    /// A .flb file, or its URL (http, https, s3)
    pub file: PathBuf,
    /// Name of the species [default: the only one]
    #[arg(long, value_name = "S")]
    pub species: Option<String>,
    /// Base to extract, by its number (0 is ambient), or the word density, or extinction (`physical` files)
    #[arg(long, value_name = "J|density|extinction")]
    pub base: Option<String>,
    /// Extract the density of the medium; the same as --base density
    #[arg(long)]
    pub density: bool,
    #[command(flatten)]
    pub memory: MemoryArgs,
    #[command(flatten)]
    pub bands: BandArgs,
    /// What to write: slices side by side (png), or all values (exr: a layer per slice; npy)
    #[arg(long, value_enum)]
    pub format: VolumeFormat,
    /// The file to write
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// Overwrite the output if it is there already
    #[arg(long = "force", action = ArgAction::SetTrue, value_parser = existing())]
    pub existing: Existing,
    /// Print what was written as JSON (schema: cli/schema/extract.json)
    #[arg(long)]
    pub json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum VolumeFormat {
    Png,
    Exr,
    Npy,
}

#[derive(Args)]
pub(crate) struct GrowArgs {
    /// The plant to grow
    #[arg(value_enum, value_name = "SPECIES")]
    pub plant: PlantKind,
    /// Another seed grows another plant of the species
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub seed: u64,
    /// Triangles to aim at
    #[arg(long, value_name = "N")]
    pub triangles: Option<u32>,
    /// With red and orange leaves in place of green ones
    #[arg(long)]
    pub autumn: bool,
    /// In a clay pot a third as high as the plant
    #[arg(long)]
    pub potted: bool,
    /// The .glb file to write
    #[arg(short, long, value_name = "OUT.glb")]
    pub output: PathBuf,
    /// Overwrite the output if it is there already
    #[arg(long = "force", action = ArgAction::SetTrue, value_parser = existing())]
    pub existing: Existing,
    /// Print what was grown as JSON (schema: cli/schema/grow.json)
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
pub(crate) struct DoctorArgs {
    /// Solve tables of extreme media, optics and settings of both models, and hold each against a solution in f64 and
    /// its energy balance; exit 1 if one does not end as it must
    #[arg(long)]
    pub extremes: bool,
    /// Print the report as JSON (schema: cli/schema/doctor.json)
    #[arg(long)]
    pub json: bool,
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;
    use flb_baker::crown::LeafAngleChoice;
    use flb_format::light::FieldKind;
    use flb_format::{Codec, Purpose};
    use flb_transport::ordinates::NamedSuns;

    use super::*;

    #[test]
    fn command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn values_of_flags_are_the_names_that_libraries_give_them() {
        fn check<T: ValueEnum>(name: impl Fn(&T) -> &'static str) {
            for value in T::value_variants() {
                let word = value.to_possible_value().expect("none is hidden");
                assert_eq!(word.get_name(), name(value));
            }
        }
        check(|codec: &Codec| codec.name());
        check(|color: &ColorSource| color.name());
        check(|field: &FieldKind| field.name());
        check(|angles: &LeafAngleChoice| angles.name());
        check(|plant: &PlantKind| plant.name());
        check(|quality: &Quality| quality.name());
        check(|purpose: &Purpose| purpose.name());
        check(|suns: &NamedSuns| suns.name());
        check(|up: &Up| up.name());
        let named = |level: &Level| Level::ALL.into_iter().find(|(of, _)| of == level);
        check(|level: &Level| named(level).expect("all are listed").1);
    }
}

//! Arguments of `flb library`.

use std::path::PathBuf;

use clap::{ArgAction, Args, Subcommand, ValueEnum};
use flb_farm::cache::Place;
use flb_files::Existing;

use super::MemoryArgs;
use super::values::{cache_place, existing, share};

#[derive(Args)]
#[command(after_help = "Schema of what --json prints: cli/schema/library.json")]
pub(crate) struct LibraryArgs {
    #[command(subcommand)]
    pub command: LibraryCommand,
}

#[derive(Subcommand)]
pub(crate) enum LibraryCommand {
    /// Write a manifest of the meshes in a folder, and say which materials are undecided; exit 3 where a mesh is or
    /// cannot be read
    Init(InitArgs),
    /// Look for all that is wrong with a manifest, its species files and its meshes, before any work; exit 1 where
    /// something is
    Check(ManifestArgs),
    /// Bake what changed, take the rest from where it is, write one file of all, an index and a page
    Build(BuildArgs),
    /// Say why a species would be baked: which input or setting is another one than before
    Why(WhyArgs),
    /// Compare the light of two libraries, species by species, the worst first; with --fail-above exit 1 where it
    /// differs by more
    Diff(LibraryDiffArgs),
}

#[derive(Args)]
pub(crate) struct InitArgs {
    /// Folder of meshes; those in folders below are found, too
    #[arg(default_value = ".", value_name = "DIR")]
    pub folder: PathBuf,
    /// The manifest [default: library.toml in that folder]
    #[arg(short, long, value_name = "LIBRARY.toml")]
    pub output: Option<PathBuf>,
    /// Overwrite it if it exists
    #[arg(long = "force", action = ArgAction::SetTrue, value_parser = existing())]
    pub existing: Existing,
    /// Print what was found as JSON (schema: cli/schema/library.json)
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
pub(crate) struct ManifestArgs {
    /// The manifest
    #[arg(default_value = "library.toml", value_name = "LIBRARY.toml")]
    pub manifest: PathBuf,
    /// Folder that keeps results, or s3://BUCKET/PREFIX [default: .flb-cache beside the manifest]
    #[arg(long, value_name = "DIR", value_parser = cache_place())]
    pub cache: Option<Place>,
    /// Read every file, though its size and time are those of the last build
    #[arg(long)]
    pub paranoid: bool,
    /// Print what was found as JSON (schema: cli/schema/library.json)
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
pub(crate) struct BuildArgs {
    #[command(flatten)]
    pub manifest: ManifestArgs,
    /// Species that are baked at once, at most; they share the threads [default: one for each two threads]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub jobs: Option<u32>,
    /// Memory, 10^9 bytes, that species that are baked at once are expected to take together; one that needs more is
    /// baked alone
    #[arg(long, default_value_t = 8.0, value_name = "GB")]
    pub memory: f64,
    /// Build this species alone (may be repeated)
    #[arg(long, value_name = "NAME")]
    pub only: Vec<String>,
    /// Go on where a species fails; the end lists what failed, with exit code 3
    #[arg(long)]
    pub keep_going: bool,
    /// Say what would be done, and why, and do nothing
    #[arg(long)]
    pub dry_run: bool,
    /// Form of what is told on the way
    #[arg(long, default_value = "auto", value_name = "FORM")]
    pub progress: ProgressArg,
}

#[derive(ValueEnum, Clone, Copy, PartialEq)]
pub(crate) enum ProgressArg {
    /// Bars on a terminal, sentences elsewhere, on stderr
    Auto,
    /// Sentences on stderr
    Lines,
    /// Sentences, and on stdout a line of JSON for each stage and each species
    Json,
    /// Sentences, and on stdout what runners of Open Job Description read: openjd_progress, openjd_status
    Openjd,
}

#[derive(Args)]
pub(crate) struct WhyArgs {
    /// Name of the species
    #[arg(value_name = "SPECIES")]
    pub species: String,
    #[command(flatten)]
    pub manifest: ManifestArgs,
}

#[derive(Args)]
#[command(after_help = "Schema of what --json prints: cli/schema/library-diff.json")]
pub(crate) struct LibraryDiffArgs {
    /// The library before: a folder that `flb library build` wrote, or a .flb file
    pub old: PathBuf,
    /// The library now: a folder or a file
    pub new: PathBuf,
    /// Exit 1 where the light of a species differs by more, rms, as a share of its mean light: 1% or 0.01; where it
    /// cannot be compared; and where a species is gone
    #[arg(long, value_name = "SHARE", value_parser = share)]
    pub fail_above: Option<f64>,
    /// Folder for index.html, diff.json, junit.xml and pictures before, after and of the difference
    #[arg(short = 'o', long = "output", value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Overwrite files that are there already
    #[arg(long = "force", action = ArgAction::SetTrue, value_parser = existing())]
    pub existing: Existing,
    #[command(flatten)]
    pub memory: MemoryArgs,
    /// Print what was found as JSON (schema: cli/schema/library-diff.json)
    #[arg(long)]
    pub json: bool,
}

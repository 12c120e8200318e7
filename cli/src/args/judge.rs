//! Arguments of `flb judge`.

use std::path::PathBuf;

use clap::{ArgAction, Args};
use flb_eval::JudgeSettings;
use flb_files::Existing;

use super::values::{existing, size};
use super::{BandArgs, MemoryArgs};

#[derive(Args)]
pub(crate) struct JudgeArgs {
    /// A .flb file of the `physical` model with scattered light (`--field`), or its URL (http, https, s3)
    #[arg(value_name = "FILE.flb")]
    pub file: PathBuf,
    /// The mesh that the species was baked from
    #[arg(long, value_name = "MESH")]
    pub mesh: PathBuf,
    /// The one mesh of a glTF to judge on, by its name or as #3 [default: as it was baked]
    #[arg(long, value_name = "NAME")]
    pub gltf_mesh: Option<String>,
    /// Judge on a mesh whose bounds are not those of the mesh that was baked
    #[arg(long)]
    pub mesh_differs: bool,
    /// Name of the species [default: the only one, else the mesh file's name]
    #[arg(long, value_name = "S")]
    pub species: Option<String>,
    /// Suns to judge under, 1 to 22, besides the sky: straight above, along a diagonal, then spread over the sphere
    #[arg(long, default_value_t = JudgeSettings::default().suns, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=22))]
    pub suns: u32,
    /// Points of leaves and wood, even by area
    #[arg(long, default_value_t = JudgeSettings::default().points, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub points: u32,
    /// Paths traced from each side of each point; twice as many make the truth's noise smaller by a third
    #[arg(long, default_value_t = JudgeSettings::default().samples, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=65536))]
    pub samples: u32,
    #[command(flatten)]
    pub memory: MemoryArgs,
    #[command(flatten)]
    pub bands: BandArgs,
    /// Draw the plant, too, under the sky and under the first sun, into this folder: judge-sky.png and judge-sun.png.
    /// Each shows the light of the file, the light of traced paths, and their difference, red where the file is
    /// brighter and blue where it is darker
    #[arg(long, value_name = "DIR")]
    pub picture: Option<PathBuf>,
    /// Size of each of the three views of a picture, in pixels [default: 512x512]
    #[arg(long, value_name = "WxH", value_parser = size, requires = "picture")]
    pub size: Option<[u32; 2]>,
    /// Overwrite pictures that are there already
    #[arg(long = "force", requires = "picture", action = ArgAction::SetTrue, value_parser = existing())]
    pub existing: Existing,
    /// Print the figures as JSON (schema: cli/schema/judge.json)
    #[arg(long)]
    pub json: bool,
}

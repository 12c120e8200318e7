//! Arguments of `flb trade`.

use std::path::PathBuf;

use clap::{ArgAction, Args};
use flb_files::Existing;

use super::MeshArgs;
use super::values::existing;

#[derive(Args)]
pub(crate) struct TradeArgs {
    /// A glTF, GLB or OBJ file
    #[arg(value_name = "MESH")]
    pub mesh_file: PathBuf,
    /// Folder for trade.csv, trade.json, trade.html and the plots [default: the mesh file's name with -trade]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    pub mesh: MeshArgs,
    /// Lattices to try, each a power of two, 16 to 256 [default: 32,64,128,256; with --quick 32,64]
    #[arg(long, value_name = "N,N,...", value_delimiter = ',')]
    pub lattices: Vec<u32>,
    /// Try fewer choices
    #[arg(long)]
    pub quick: bool,
    /// Suns to measure the light under, 1 to 22: straight above, along a diagonal, then spread over the sphere
    #[arg(long, default_value_t = 5, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=22))]
    pub suns: u32,
    /// Points of the plant's surface to measure the light at
    #[arg(long, default_value_t = 4096, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub points: u32,
    /// Memory, 10^9 bytes, that no choice may need more of, as predicted; choices that would are listed as skipped
    /// [default: three quarters of what the system has available]
    #[arg(long, value_name = "GB")]
    pub memory_limit: Option<f64>,
    /// Voxels along each edge of the fine grid: a multiple of every lattice, up to 4096
    #[arg(long, default_value_t = 1024, value_name = "N")]
    pub voxels: u32,
    /// Count leaf cards whole, ignoring the alpha of their textures, as the papers do
    #[arg(long)]
    pub ignore_alpha: bool,
    /// Overwrite files that are there already
    #[arg(long = "force", action = ArgAction::SetTrue, value_parser = existing())]
    pub existing: Existing,
    /// Print what was measured as JSON, as in trade.json (schema: cli/schema/trade.json)
    #[arg(long)]
    pub json: bool,
}

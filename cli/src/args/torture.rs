//! Arguments of `flb torture`.

use std::path::PathBuf;

use clap::Args;

#[derive(Args)]
pub(crate) struct TortureArgs {
    /// A .flb file that keeps every promise, of 16 MiB at most
    #[arg(value_name = "GOOD.flb")]
    pub file: PathBuf,
    /// The folder to fill: new, or empty. It takes about 200 times the file's size
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Chooses where truncations and flipped bits lie
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub seed: u64,
    /// Print what was found as JSON, as in manifest.json (schema: cli/schema/torture.json)
    #[arg(long)]
    pub json: bool,
}

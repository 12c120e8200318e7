//! Arguments of `flb cache`.

use std::time::Duration;

use clap::{Args, Subcommand};
use flb_farm::cache::Place;

use super::values::{byte_count, cache_place, duration};

#[derive(Args)]
#[command(after_help = "Schema of what --json prints: cli/schema/cache.json")]
pub(crate) struct CacheArgs {
    #[command(subcommand)]
    pub command: CacheCommand,
}

#[derive(Subcommand)]
pub(crate) enum CacheCommand {
    /// List what is kept: bytes, days since the last use, the species of what is one
    List(CacheFolder),
    /// Say how many entries and bytes there are of each kind
    Stats(CacheFolder),
    /// Read every entry, and say which is not what was kept; exit 1 where one is not
    Verify(VerifyArgs),
    /// Remove what was not used for a time, and what was used longest ago until the rest is small enough
    Gc(GcArgs),
}

#[derive(Args)]
pub(crate) struct CacheFolder {
    /// Folder that keeps results, or s3://BUCKET/PREFIX
    #[arg(default_value = ".flb-cache", value_name = "DIR", value_parser = cache_place())]
    pub folder: Place,
    /// Print what was found as JSON (schema: cli/schema/cache.json)
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
pub(crate) struct VerifyArgs {
    #[command(flatten)]
    pub folder: CacheFolder,
    /// Remove what is damaged, and exit 0
    #[arg(long)]
    pub remove: bool,
}

#[derive(Args)]
pub(crate) struct GcArgs {
    #[command(flatten)]
    pub folder: CacheFolder,
    /// Bytes that stay at most: a number, with k, M, G or T behind it for 10^3, 10^6, 10^9 or 10^12
    #[arg(long, value_name = "BYTES", value_parser = byte_count)]
    pub max_size: Option<u64>,
    /// Time since the last use from which on an entry goes: a number with h, d or w behind it
    #[arg(long, value_name = "TIME", value_parser = duration)]
    pub older_than: Option<Duration>,
    /// Say what would be removed, and remove nothing
    #[arg(long)]
    pub dry_run: bool,
}

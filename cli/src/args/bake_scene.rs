//! The words of `flb bake-scene`.

use std::path::PathBuf;

use clap::{ArgAction, Args};
use flb_baker::SceneSettings;
use flb_farm::cache::Place;
use flb_files::Existing;
use flb_transport::ordinates::NamedSuns;

use super::MemoryArgs;
use super::values::{cache_place, existing};

#[derive(Args)]
pub(crate) struct BakeSceneArgs {
    /// The scene (.toml); every species that stands in it needs its `light`, all of one model
    #[arg(value_name = "SCENE.toml")]
    pub scene: PathBuf,
    /// The .flb file to write, for the scene's `light` or `flb render --scene-light`
    #[arg(short, long, value_name = "OUT.flb")]
    pub output: PathBuf,
    /// Sites along each edge of the lattice over the scene: a power of two, 16 to 256. Sites of a tenth of a crown's
    /// width are fine enough, of a third too coarse
    #[arg(long, default_value_t = SceneSettings::default().lattice, value_name = "N")]
    pub lattice: u32,
    /// How the stored light depends on the sun [default: sh1; of `paper` files always lattice18]
    #[arg(long, value_enum)]
    pub suns: Option<NamedSuns>,
    /// Directions that light is marched along: 18, 50 or 110 [default: 50; of `paper` files always the lattice's 18]
    #[arg(long, value_name = "N")]
    pub ordinates: Option<u32>,
    /// Estimated error (relative L2) at which a solve has converged
    #[arg(long, default_value_t = SceneSettings::default().tolerance, value_name = "T")]
    pub tolerance: f64,
    /// Passes, or sweeps of the papers' lattice, after which a solve gives up
    #[arg(long, default_value_t = SceneSettings::default().max_passes, value_name = "N")]
    pub max_sweeps: u32,
    /// Folder that keeps the light of species alone, or s3://BUCKET/PREFIX: when plants move in the box around all of
    /// them, only the scene's own is solved again
    #[arg(long, value_name = "DIR", value_parser = cache_place())]
    pub cache: Option<Place>,
    #[command(flatten)]
    pub memory: MemoryArgs,
    /// Overwrite the output if it is there already
    #[arg(long = "force", action = ArgAction::SetTrue, value_parser = existing())]
    pub existing: Existing,
    /// Print the summary as JSON (schema: cli/schema/bake-scene.json)
    #[arg(long)]
    pub json: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_help_calls_defaults_are_the_library_s() {
        let default = SceneSettings::default();
        assert!(NamedSuns::of(&default.suns) == Some(NamedSuns::Sh1));
        assert_eq!(default.ordinates.count(), 50);
    }
}

//! The sky that the flags ask for.

use std::path::Path;

use flb_scene::scene::SceneSky;
use flb_scene::sky::clear::CLEAR_TURBIDITY;
use flb_stage::StageSky;

use crate::args::SkyArgs;
use crate::exit::{Failure, USAGE};

/// Reads the sky that the flags name, else the scene's; without both it is even.
pub(crate) fn read_sky(args: &SkyArgs, scene: &SceneSky) -> Result<StageSky, Failure> {
    let of_scene = match scene {
        SceneSky::Clear { turbidity } => Some(*turbidity),
        _ => None,
    };
    let turbidity = args.turbidity.or(of_scene).unwrap_or(CLEAR_TURBIDITY);
    let sky = match (args.sky.as_deref().map(|word| (word, word.to_str())), scene) {
        (Some((_, Some("even"))), _) | (None, SceneSky::Even) => StageSky::Even,
        // Refused before anything is read.
        (Some((_, Some("clear"))), _) | (None, SceneSky::Clear { .. }) => StageSky::clear(turbidity)?,
        (Some((file, _)), _) => StageSky::image(file)?,
        (None, SceneSky::Image(file)) => StageSky::image(file)?,
    };
    if args.turbidity.is_some() && !matches!(sky, StageSky::Clear { .. }) {
        return Err(Failure::new(USAGE, "--turbidity is for --sky clear"));
    }
    Ok(sky)
}

/// The file of an image that the flags name.
pub(crate) fn sky_file(args: &SkyArgs) -> Option<&Path> {
    let is_word = |sky: &Path| ["even", "clear"].iter().any(|word| sky.as_os_str() == *word);
    args.sky.as_deref().filter(|sky| !is_word(sky))
}

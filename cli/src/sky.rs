//! The sky that the flags ask for.

use std::path::Path;

use flb_scene::scene::SceneSky;
use flb_scene::sky::Sky;
use flb_scene::sky::clear::CLEAR_TURBIDITY;
use flb_stage::StageSky;

use crate::args::SkyArgs;
use crate::exit::{Failure, USAGE};

/// Reads the sky that the flags name, else the scene's; without both it is even. The image that is drawn in its
/// place is the flag's, else the scene's, too.
pub(crate) fn read_sky(
    args: &SkyArgs,
    scene: &SceneSky,
    backdrop: Option<&Path>,
) -> Result<StageSky, Failure> {
    let of_scene = match scene {
        SceneSky::Clear { turbidity } => Some(*turbidity),
        _ => None,
    };
    let turbidity = args.turbidity.or(of_scene).unwrap_or(CLEAR_TURBIDITY);
    let sky = match (args.sky.as_deref().map(|word| (word, word.to_str())), scene) {
        (Some((_, Some("even"))), _) | (None, SceneSky::Even) => StageSky::EVEN,
        // Refused before anything is read.
        (Some((_, Some("clear"))), _) | (None, SceneSky::Clear { .. }) => StageSky::clear(turbidity)?,
        (Some((file, _)), _) => StageSky::image(file)?,
        (None, SceneSky::Image(file)) => StageSky::image(file)?,
    };
    if args.turbidity.is_some() && !sky.is_clear() {
        return Err(Failure::new(USAGE, "--turbidity is for --sky clear"));
    }
    let backdrop = args.backdrop.as_deref().or(backdrop);
    Ok(sky.with_backdrop(backdrop.map(Sky::read).transpose()?))
}

/// Files of images that the flags name.
pub(crate) fn sky_files(args: &SkyArgs) -> impl Iterator<Item = &Path> {
    sky_file(args).into_iter().chain(args.backdrop.as_deref())
}

/// The file of an image that the flags name, and that lights.
pub(crate) fn sky_file(args: &SkyArgs) -> Option<&Path> {
    let is_word = |sky: &Path| ["even", "clear"].iter().any(|word| sky.as_os_str() == *word);
    args.sky.as_deref().filter(|sky| !is_word(sky))
}

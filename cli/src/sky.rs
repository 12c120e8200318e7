//! The sky that the flags ask for, and its light on a plant.

use std::path::Path;
use std::sync::Arc;

use flb_runtime::{SkyLight, SpeciesLight, Transform};
use flb_scene::scene::SceneSky;
use flb_scene::sky::clear::CLEAR_TURBIDITY;
use flb_scene::sky::{Sky, SkyImage};

use crate::args::SkyArgs;
use crate::exit::{Failure, USAGE};
use crate::picture::PHYSICAL_SKY;

/// A sky before it is known where the sun stands.
pub(crate) enum SkyChoice {
    Even,
    Clear { turbidity: f64 },
    Image(Sky),
}

impl SkyChoice {
    /// Reads what the flags name, else what the scene does; without both it is even.
    pub(crate) fn read(args: &SkyArgs, scene: &SceneSky) -> Result<SkyChoice, Failure> {
        let of_scene = match scene {
            SceneSky::Clear { turbidity } => Some(*turbidity),
            _ => None,
        };
        let turbidity = args.turbidity.or(of_scene).unwrap_or(CLEAR_TURBIDITY);
        let choice = match (args.sky.as_deref().map(|word| (word, word.to_str())), scene) {
            (Some((_, Some("even"))), _) | (None, SceneSky::Even) => SkyChoice::Even,
            (Some((_, Some("clear"))), _) | (None, SceneSky::Clear { .. }) => {
                Sky::clear([0.0, 1.0, 0.0], turbidity)?; // refused before anything is read
                SkyChoice::Clear { turbidity }
            }
            (Some((file, _)), _) => SkyChoice::of_image(file)?,
            (None, SceneSky::Image(file)) => SkyChoice::of_image(file)?,
        };
        if args.turbidity.is_some() && !matches!(choice, SkyChoice::Clear { .. }) {
            return Err(Failure::new(USAGE, "--turbidity is for --sky clear"));
        }
        Ok(choice)
    }

    fn of_image(file: &Path) -> Result<SkyChoice, Failure> {
        Ok(SkyChoice::Image(Sky::of_image(Arc::new(SkyImage::read(file)?))))
    }

    /// The file of an image that the flags name.
    pub(crate) fn file(args: &SkyArgs) -> Option<&Path> {
        let is_word = |sky: &Path| ["even", "clear"].iter().any(|word| sky.as_os_str() == *word);
        args.sky.as_deref().filter(|sky| !is_word(sky))
    }

    pub(crate) fn is_even(&self) -> bool {
        matches!(self, SkyChoice::Even)
    }

    /// Whether it needs no sun.
    pub(crate) fn is_image(&self) -> bool {
        matches!(self, SkyChoice::Image(_))
    }

    /// The sky over a sun, and the colour of that; `None` where it is even. `ambient` is the flag: a factor on a clear
    /// sky, the fluence of an image.
    ///
    /// # Errors
    /// For plants of the model `paper`.
    pub(crate) fn over(
        &self,
        towards_sun: [f64; 3],
        ambient: Option<f32>,
        is_physical: bool,
    ) -> Result<Option<(Sky, [f32; 3])>, Failure> {
        if !self.is_even() && !is_physical {
            let message = "an uneven sky is for physical files: a paper file does not say what comes from the sky itself";
            return Err(Failure::new(USAGE, message));
        }
        Ok(match self {
            SkyChoice::Even => None,
            SkyChoice::Clear { turbidity } => {
                let sky = Sky::clear(towards_sun, *turbidity)?;
                let color = sky.sun().unwrap_or([1.0; 3]);
                Some((sky.times(ambient.unwrap_or(1.0)), color))
            }
            SkyChoice::Image(sky) => Some((sky.times(ambient.unwrap_or(PHYSICAL_SKY)), [1.0; 3])),
        })
    }
}

/// What a sky gives a plant that stands as its model does.
pub(crate) fn light_of<'l>(sky: &Sky, light: &'l SpeciesLight<'_>) -> Result<SkyLight<'l>, Failure> {
    Ok(light.sky(&sky.patches(), &Transform::IDENTITY)?)
}

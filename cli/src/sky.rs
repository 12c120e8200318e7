//! The sky that the flags ask for, and its light on a plant.

use std::path::Path;
use std::sync::Arc;

use flb_render::{RenderSettings, Shading};
use flb_runtime::{SkyLight, SpeciesLight, Transform};
use flb_scene::sky::clear::CLEAR_TURBIDITY;
use flb_scene::sky::{Sky, SkyImage};

use crate::args::SkyArgs;
use crate::exit::{Failure, USAGE};
use crate::picture::PHYSICAL_SKY;

/// A sky before it is known where the sun stands.
pub enum SkyChoice {
    Even,
    Clear { turbidity: f64 },
    Image(Sky),
}

impl SkyChoice {
    /// Reads what the flags name.
    pub fn read(args: &SkyArgs) -> Result<SkyChoice, Failure> {
        let choice = match args.sky.to_str() {
            Some("even") => SkyChoice::Even,
            Some("clear") => {
                let turbidity = args.turbidity.unwrap_or(CLEAR_TURBIDITY);
                Sky::clear([0.0, 1.0, 0.0], turbidity)?; // refused before anything is read
                SkyChoice::Clear { turbidity }
            }
            _ => SkyChoice::Image(Sky::of_image(Arc::new(SkyImage::read(&args.sky)?))),
        };
        if args.turbidity.is_some() && !matches!(choice, SkyChoice::Clear { .. }) {
            return Err(Failure::new(USAGE, "--turbidity is for --sky clear"));
        }
        Ok(choice)
    }

    /// The file of an image.
    pub fn file(args: &SkyArgs) -> Option<&Path> {
        let is_word = ["even", "clear"].iter().any(|word| args.sky.as_os_str() == *word);
        (!is_word).then_some(&args.sky)
    }

    pub fn is_even(&self) -> bool {
        matches!(self, SkyChoice::Even)
    }

    /// Settings under this sky and a sun. `ambient` is the flag: a factor on a clear sky, the fluence of an image.
    pub fn over(
        &self,
        settings: &RenderSettings,
        towards_sun: Option<[f64; 3]>,
        ambient: Option<f32>,
    ) -> Result<RenderSettings, Failure> {
        if !self.is_even() && settings.shading == Shading::Paper {
            let message =
                "--sky is for physical files: a paper file does not say what comes from the sky itself";
            return Err(Failure::new(USAGE, message));
        }
        let mut settings = settings.clone();
        match towards_sun {
            Some(towards) => settings.sun = towards,
            None => settings.sun_strength = 0.0,
        }
        match self {
            SkyChoice::Even => {}
            SkyChoice::Clear { turbidity } => {
                let sky = Sky::clear(settings.sun, *turbidity)?.times(ambient.unwrap_or(1.0));
                settings.sun_color = sky.sun().unwrap_or([1.0; 3]);
                settings.dome = Some(sky);
            }
            SkyChoice::Image(sky) => settings.dome = Some(sky.times(ambient.unwrap_or(PHYSICAL_SKY))),
        }
        Ok(settings)
    }
}

/// What a sky gives a plant that stands as its model does.
pub fn light_of<'l>(sky: &Sky, light: &'l SpeciesLight<'_>) -> Result<SkyLight<'l>, Failure> {
    Ok(light.sky(&sky.patches(), &Transform::IDENTITY)?)
}

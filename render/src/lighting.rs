//! What lights a scene, and which part of that light a picture shows.

use std::f32::consts::PI;

use flb_format::{Daylight, SpeciesMeta};
use flb_scene::sky::{Sky, luminance};
use glam::DVec3;

use crate::{RenderError, backdrop::SKY_LUMINANCE, highlight::Highlights, settings::range};

/// The light on a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Lighting {
    /// The sun and the even sky, in the frame of the world. A white matt plane that faces the sun sends out `sun` in
    /// the `paper` shading, and the pi-th part of it as radiance in the `physical` one. `sky` lights the ground and
    /// brightens what is drawn of the sky; in a path-traced reference it lights the plant too. Where there is a ground
    /// or water, a sun at or below the horizon sends nothing.
    pub daylight: Daylight,
    /// Factor on the sun per band, R, G, B; of the `physical` shading alone.
    pub sun_color: [f32; 3],
    /// An uneven sky in the place of the even one, in the frame of the world; `daylight.sky` does not count then. Of
    /// the `physical` shading alone.
    pub dome: Option<Sky>,
    /// A sky that is drawn in the place of the one that lights the scene, in either shading. Of fluence 1 by luminance,
    /// it is drawn as bright in the mean as that one.
    pub backdrop: Option<Sky>,
}

/// Part of the light that is shown. In linear light `Off` + `Only` = `On`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Indirect {
    /// Direct and indirect light, and the background.
    On,
    /// Direct light and the background.
    Off,
    /// Indirect light alone, before black.
    Only,
}

/// Parts and strengths of the light in a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// Part of the light that is shown.
    pub indirect: Indirect,
    /// Scale of indirect light in the `paper` shading.
    pub indirect_scale: f32,
    /// Highlights of the sun in the `paper` shading.
    pub highlights: Highlights,
    /// Whether the sky is drawn. In the `physical` shading it has the mean luminance of the even, white sky that lights
    /// the plants, drawn or not.
    pub has_sky: bool,
    /// Whether the sky is drawn behind all else, too. Without it a picture is as one lays it over another: its values
    /// are multiplied by how much it covers ([`crate::forest::Forest::coverage`]). Water mirrors the sky in either.
    pub has_backdrop: bool,
}

impl Default for Lighting {
    fn default() -> Lighting {
        Lighting::of(Daylight { towards_sun: [0.4, 0.7, 0.5], sun: 1.0, sky: 0.02 })
    }
}

impl Default for Look {
    fn default() -> Look {
        Look {
            indirect: Indirect::On,
            indirect_scale: 0.5,
            highlights: Highlights::default(),
            has_sky: true,
            has_backdrop: true,
        }
    }
}

impl Lighting {
    /// A white sun and an even sky.
    pub fn of(daylight: Daylight) -> Lighting {
        Lighting { daylight, sun_color: [1.0; 3], dome: None, backdrop: None }
    }

    /// The default light with the sun in another direction, of any length but zero.
    pub fn towards(sun: [f64; 3]) -> Lighting {
        let light = Lighting::default();
        Lighting { daylight: Daylight { towards_sun: sun, ..light.daylight }, ..light }
    }

    /// The sky that is drawn; `None` where it is the even one, by a factor on its gradient
    /// ([`crate::forest::Scenery::sky_strength`]).
    pub fn drawn_sky(&self, sky_strength: f32) -> Option<Sky> {
        let Some(backdrop) = &self.backdrop else { return self.dome.clone() };
        Some(backdrop.times(match &self.dome {
            Some(dome) => luminance(dome.fluence()),
            None => 4.0 * PI * SKY_LUMINANCE * sky_strength,
        }))
    }

    /// Checks it and gives back the unit vector towards the sun.
    pub(crate) fn validated(&self) -> Result<DVec3, RenderError> {
        range("sun", self.daylight.sun.into(), 0.0, 1e6)?;
        for band in self.sun_color {
            range("sun_color", band.into(), 0.0, 1e6)?;
        }
        range("sky", self.daylight.sky.into(), 0.0, 1e6)?;
        let towards = self.daylight.towards_sun;
        let direction = DVec3::from(towards);
        let length = direction.length();
        if !(length.is_finite() && length > 1e-9) {
            let expected = "a finite direction that is not zero".into();
            return Err(RenderError::Setting {
                name: "towards_sun",
                found: format!("{towards:?}"),
                expected,
            });
        }
        Ok(direction / length)
    }
}

impl Look {
    /// The look by default of plants in the light of files: where all of it was made as the papers say, indirect light
    /// counts as they count it, once.
    pub fn of_light<'m>(files: impl IntoIterator<Item = &'m SpeciesMeta>) -> Look {
        let mut files = files.into_iter().peekable();
        let are_papers = files.peek().is_some() && files.all(SpeciesMeta::is_as_papers_say);
        let default = Look::default();
        Look { indirect_scale: if are_papers { 1.0 } else { default.indirect_scale }, ..default }
    }

    pub(crate) fn check(&self) -> Result<(), RenderError> {
        range("indirect_scale", self.indirect_scale.into(), 0.0, 1e6)?;
        self.highlights.check()
    }

    /// Whether the light that surfaces get straight from the sun is shown.
    pub(crate) fn has_direct(&self) -> bool {
        self.indirect != Indirect::Only
    }

    /// Whether all other light is.
    pub(crate) fn has_indirect(&self) -> bool {
        self.indirect != Indirect::Off
    }
}

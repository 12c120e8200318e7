//! The sky over a scene, before it is known where the sun stands.

use std::path::Path;

use flb_format::Daylight;
use flb_format::sun::towards_sun;
use flb_render::Lighting;
use flb_render::shading::{PHYSICAL_SKY, Units};
use flb_scene::sky::{Sky, SkyError};

use crate::StageError;

/// The sky over a scene.
#[derive(Debug, Clone)]
pub struct StageSky {
    source: Source,
    backdrop: Option<Sky>,
}

#[derive(Debug, Clone)]
enum Source {
    /// The same light from everywhere.
    Even,
    /// A clear day's, by the place of the sun.
    Clear { turbidity: f64 },
    /// An image's, whatever the sun.
    Image(Sky),
}

impl StageSky {
    /// Even sky: the same light from everywhere.
    pub const EVEN: StageSky = StageSky::of(Source::Even);

    const fn of(source: Source) -> StageSky {
        StageSky { source, backdrop: None }
    }

    /// Draws another sky in its place, which lights nothing ([`Lighting::backdrop`]).
    #[must_use]
    pub fn with_backdrop(self, backdrop: Option<Sky>) -> StageSky {
        StageSky { backdrop, ..self }
    }

    /// A clear sky.
    ///
    /// # Errors
    /// [`SkyError`] for a turbidity out of range.
    pub fn clear(turbidity: f64) -> Result<StageSky, SkyError> {
        Sky::clear([0.0, 1.0, 0.0], turbidity)?;
        Ok(StageSky::of(Source::Clear { turbidity }))
    }

    /// The sky of an image file.
    ///
    /// # Errors
    /// [`SkyError`] for a file that cannot be used.
    pub fn image(file: &Path) -> Result<StageSky, SkyError> {
        Ok(StageSky::of(Source::Image(Sky::read(file)?)))
    }

    /// Whether the sky is even.
    pub fn is_even(&self) -> bool {
        matches!(self.source, Source::Even)
    }

    /// Whether the sky is a clear day's.
    pub fn is_clear(&self) -> bool {
        matches!(self.source, Source::Clear { .. })
    }

    /// Whether a scene under the sky has to have a sun; an image may light it alone.
    pub fn needs_sun(&self) -> bool {
        !matches!(self.source, Source::Image(_))
    }

    /// The light of a sun of a strength, or of none, and of the sky over it. `ambient` is the light of an even sky;
    /// `asked` is what was asked for, as of [`StageSky::over`].
    ///
    /// # Errors
    /// As [`StageSky::over`].
    pub fn lighting(
        &self,
        (sun_deg, sun): (Option<[f64; 2]>, f32),
        (ambient, asked): (f32, Option<f32>),
        units: Units,
    ) -> Result<Lighting, StageError> {
        let towards_sun = match sun_deg {
            Some([azimuth, elevation]) => towards_sun(azimuth, elevation),
            None => Lighting::default().daylight.towards_sun,
        };
        let light = Lighting::of(Daylight { towards_sun, sun, sky: ambient });
        let light = Lighting { backdrop: self.backdrop.clone(), ..light };
        Ok(match self.over(towards_sun, asked, units)? {
            Some((dome, sun_color)) => Lighting { dome: Some(dome), sun_color, ..light },
            None => light,
        })
    }

    /// The sky over a sun, and the colour of that sun; `None` where it is even. `ambient` is a factor on a clear sky
    /// and the fluence of an image.
    ///
    /// # Errors
    /// [`StageError::UnevenSkyOverPaper`] for units without an uneven sky; [`StageError::Sky`].
    pub fn over(
        &self,
        towards_sun: [f64; 3],
        ambient: Option<f32>,
        units: Units,
    ) -> Result<Option<(Sky, [f32; 3])>, StageError> {
        if !self.is_even() && !units.has_uneven_sky() {
            return Err(StageError::UnevenSkyOverPaper);
        }
        Ok(match &self.source {
            Source::Even => None,
            Source::Clear { turbidity } => {
                let sky = Sky::clear(towards_sun, *turbidity)?;
                let color = sky.sun().unwrap_or([1.0; 3]);
                Some((sky.times(ambient.unwrap_or(1.0)), color))
            }
            Source::Image(sky) => Some((sky.times(ambient.unwrap_or(PHYSICAL_SKY)), [1.0; 3])),
        })
    }
}

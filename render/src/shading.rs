//! The two shadings, and what follows from each: how a surface is coloured, in which units a picture is, and what of
//! a sun and a sky those units make.
//!
//! Nothing else of this crate, and nothing above it, tells the two apart.

use std::f32::consts::FRAC_1_PI;

use flb_format::SpeciesMeta;
use glam::Vec3;

use crate::backdrop::{OPEN_SKY, SKY_LUMINANCE, paper_sky_strength, sky_radiance};
use crate::highlight::Highlights;
use crate::paper::Paper;
use crate::physical::Physical;
use crate::picture::PHYSICAL_EXPOSURE;
use crate::scene::Hit;
use crate::sun::Sunlight;
use crate::surfaces::Finish;
use crate::{LightQuery, Lighting, Look, Surfaces};

/// Fluence of the sky by default in the `physical` shading, the sun's being 1: a clear day's diffuse light.
pub const PHYSICAL_SKY: f32 = 0.36;

/// Shading model of a picture (lighting-model, section 10).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shading {
    /// Texture colour x light, as in the papers; white in full sun = 1.
    Paper,
    /// Measured surfaces in radiometric units: radiance, with the sun's irradiance as the unit.
    Physical(Surfaces),
}

/// Units of the light in a picture, which all plants of a scene share.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Units {
    /// White in full sun is 1. The light of a sky is a share of what the papers' lattice holds.
    White,
    /// Radiance, the irradiance of the sun being 1. The light of a sky is its fluence.
    Radiance,
}

impl From<Surfaces> for Shading {
    fn from(surfaces: Surfaces) -> Shading {
        Shading::Physical(surfaces)
    }
}

impl Shading {
    /// Shading of a plant without baked light: its colours alone are known.
    pub const UNLIT: Shading = Shading::Paper;

    /// Shading by the light of a species, in its first three bands, which are red, green and blue
    /// ([`SpeciesMeta::with_bands`]).
    ///
    /// # Panics
    /// If the species has surfaces, and fewer than three bands.
    pub fn of(meta: &SpeciesMeta) -> Shading {
        meta.physical().map_or(Shading::Paper, |(surfaces, _)| Surfaces::of(surfaces, meta).into())
    }

    /// Reflectance and transmittance of leaves and wood, where they are known.
    pub fn surfaces(&self) -> Option<&Surfaces> {
        match self {
            Shading::Paper => None,
            Shading::Physical(surfaces) => Some(surfaces),
        }
    }

    /// Units of its pictures.
    pub fn units(&self) -> Units {
        match self {
            Shading::Paper => Units::White,
            Shading::Physical(_) => Units::Radiance,
        }
    }
}

impl Units {
    /// Units of a scene of plants: radiance, where one of them is seen in that; a forest refuses a mixture.
    pub fn of(shadings: impl IntoIterator<Item = Shading>) -> Units {
        match shadings.into_iter().any(|shading| shading.units() == Units::Radiance) {
            true => Units::Radiance,
            false => Units::White,
        }
    }

    /// Light of the sky by default.
    pub fn default_sky(self) -> f32 {
        match self {
            Units::White => Lighting::default().daylight.sky,
            Units::Radiance => PHYSICAL_SKY,
        }
    }

    /// Stops of exposure by default.
    pub fn default_exposure(self) -> f32 {
        match self {
            Units::White => 0.0,
            Units::Radiance => PHYSICAL_EXPOSURE,
        }
    }

    /// Whether a sky may be uneven: only in radiance is it known what comes from the sky itself.
    pub fn has_uneven_sky(self) -> bool {
        self == Units::Radiance
    }

    /// Factor on indirect light. In radiance that has the units of all light, and [`Look::indirect_scale`] is not for
    /// it.
    pub fn indirect_scale(self, look: &Look) -> f32 {
        match self {
            Units::White => look.indirect_scale,
            Units::Radiance => 1.0,
        }
    }

    /// Highlights of the sun. Leaves in radiance are matt until their gloss is known.
    pub fn highlights(self, look: &Look) -> Highlights {
        match self {
            Units::White => look.highlights,
            Units::Radiance => Highlights::MATT,
        }
    }

    /// Whether there are highlights to choose.
    pub fn has_highlights(self) -> bool {
        self == Units::White
    }

    /// Whether indirect light has a factor to choose.
    pub fn has_indirect_scale(self) -> bool {
        self == Units::White
    }

    /// Light that a white ground sends out in a sun overhead, and under open sky; the factor on the gradient of sky.
    pub(crate) fn surroundings(self, sun: f32, sky: f32, look: &Look) -> [f32; 3] {
        match self {
            Units::White => [sun, OPEN_SKY * sky * look.indirect_scale, paper_sky_strength(sky)],
            Units::Radiance => {
                // Irradiance of half a sky is pi times its radiance.
                let radiance = sky_radiance(sky);
                [sun * FRAC_1_PI, radiance, radiance / SKY_LUMINANCE]
            }
        }
    }
}

/// A surface of a plant that a ray from the camera met.
pub(crate) struct Seen<'a> {
    pub instance: u32,
    pub hit: &'a Hit,
    /// Direction of the ray, in the plant's own frame.
    pub looking: Vec3,
    /// In that frame, too.
    pub sun: Sunlight,
    /// Whether the sun itself is shown.
    pub has_direct: bool,
}

impl Seen<'_> {
    /// What the surface sends to the camera. `finish` is of a plant whose surfaces are known; `sees` tells whether the
    /// sun sees a side; `phi` is the light that a surface asks for.
    pub(crate) fn color(
        &self,
        finish: Option<&Finish>,
        look: &Look,
        sees: impl FnOnce(Vec3) -> bool,
        phi: impl FnOnce(LightQuery) -> Vec3,
    ) -> Vec3 {
        let Seen { instance, hit, looking, sun, has_direct } = *self;
        let mut color = Vec3::ZERO;
        match finish {
            None => {
                let Look { highlights, indirect_scale, .. } = *look;
                let paper = Paper { sun, highlights, indirect_scale };
                if has_direct {
                    color += paper.direct(hit, looking, sees);
                }
                if look.has_indirect() {
                    color += paper.indirect(hit, phi(LightQuery::of(instance, hit.point, hit)));
                }
            }
            Some(finish) => {
                let (physical, matt) = (Physical { sun }, finish.at(hit));
                if has_direct {
                    color += physical.direct(hit, &matt, sees);
                }
                if look.has_indirect() {
                    color += physical.indirect(&matt, phi(finish.asks(instance, hit)));
                }
            }
        }
        color
    }
}

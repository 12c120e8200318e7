//! What a daylight makes of the surroundings: how bright sun, ground and sky are drawn, and where the ground ends.

use std::f32::consts::FRAC_1_PI;

use flb_format::Daylight;
use glam::DVec3;

use super::Forest;
use crate::backdrop::on_level_ground;
use crate::shading::Units;
use crate::{Lighting, Look, RenderError};

/// Strengths of everything around the plants under one sun, for one camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scenery {
    /// Towards the sun, unit.
    pub towards_sun: [f64; 3],
    /// Strength of the sun; 0 where it stands below the horizon of a ground or of water.
    pub sun_strength: f32,
    /// Light that a white ground sends out in a sun overhead.
    pub white_in_sun: f32,
    /// Light that a white ground sends out under open sky, R, G, B.
    pub white_under_sky: [f32; 3],
    /// Factor on the gradient of sky.
    pub sky_strength: f32,
    /// Middle of the stand.
    pub center_m: [f64; 3],
    /// Distance from the middle, on level ground, at which the ground has faded into haze.
    pub haze_m: f64,
}

/// Where the ground has faded into the haze: this many radii of the stand, or times the camera's distance from its
/// middle.
const HAZE: [f64; 2] = [4.0, 3.0];

/// Properties of a forest by which its surroundings are drawn, whatever the daylight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Around {
    /// Units of the picture.
    pub units: Units,
    /// Whether there is a ground, or water.
    pub has_ground: bool,
    /// Distance at which the ground has faded into the haze, metres, as [`super::Ground::fades_at_m`].
    pub fades_at_m: Option<f64>,
    /// Lowest and highest coordinates around all plants.
    pub box_m: [[f64; 3]; 2],
}

impl Around {
    /// Computes the surroundings in a light, seen from a point.
    ///
    /// # Errors
    /// [`RenderError::Setting`] for a light or a look outside its limits, and for an uneven sky over the shading
    /// `paper`.
    pub fn scenery(
        &self,
        lighting: &Lighting,
        look: &Look,
        camera_m: [f64; 3],
    ) -> Result<Scenery, RenderError> {
        let (towards, camera) = (lighting.validated()?, DVec3::from(camera_m));
        look.check()?;
        let Daylight { sun, sky, .. } = lighting.daylight;
        let is_up = towards.y > 0.0 || !self.has_ground;
        let [white_in_sun, white_under_even, sky_strength] = self.units.surroundings(sun, sky, look);
        let white_under_sky = match &lighting.dome {
            None => [white_under_even; 3],
            Some(_) if !self.units.has_uneven_sky() => {
                return Err(RenderError::Setting {
                    name: "dome",
                    found: "a sky with the shading `paper`".into(),
                    expected: "the shading `physical`".into(),
                });
            }
            Some(dome) => (on_level_ground(dome) * FRAC_1_PI).to_array(),
        };
        let [min, max] = self.box_m.map(DVec3::from);
        let (center, half) = ((min + max) / 2.0, (max - min) / 2.0);
        let level = |offset: DVec3| (offset.x * offset.x + offset.z * offset.z).sqrt();
        Ok(Scenery {
            towards_sun: towards.to_array(),
            sun_strength: if is_up { sun } else { 0.0 },
            white_in_sun: if is_up { white_in_sun } else { 0.0 },
            white_under_sky,
            sky_strength,
            center_m: center.to_array(),
            haze_m: self
                .fades_at_m
                .unwrap_or((HAZE[0] * level(half)).max(HAZE[1] * (camera - center).length())),
        })
    }
}

impl Forest<'_> {
    /// Properties of the forest by which its surroundings are drawn.
    pub fn around(&self) -> Around {
        let has_ground = self.soil.is_some() || self.water.is_some();
        let fades_at_m = self.ground().and_then(|ground| ground.fades_at_m);
        Around { units: self.units, has_ground, fades_at_m, box_m: self.bounds_m() }
    }
}

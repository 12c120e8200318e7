//! The light of a picture as a sum of parts: light adds up.
//!
//! A renderer lights a scene by one sun of one strength in all bands, and a sky. A sun of a colour under an even sky,
//! and each further sun, is a part of its own: its picture is taken white and without a sky, and then coloured. What
//! the camera sees is found once for all of them.

use flb_render::shading::Units;
use flb_render::{Lighting, Look, Picture};
use flb_scene::scene::Sunlight;

use crate::{StageError, StageSky};

/// What a picture is lit by.
pub(crate) struct Sources<'a> {
    pub sky: &'a StageSky,
    /// Light of an even sky, and what was asked for.
    pub ambient: (f32, Option<f32>),
    pub sunlight: &'a Sunlight,
    pub units: Units,
    pub look: &'a Look,
}

/// The parts of a picture's light.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Parts {
    /// The sky and, where one light holds both, the sun that moves.
    pub first: Part,
    /// Suns.
    pub others: Vec<Part>,
}

/// A part of a picture's light.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Part {
    pub lighting: Lighting,
    pub look: Look,
    /// Azimuth and elevation of its sun, degrees.
    pub sun_deg: Option<[f64; 2]>,
    /// Factor on its picture, R, G, B; of the first part 1.
    pub factor: [f32; 3],
}

impl Sources<'_> {
    /// The parts of a picture under a sun, or under none. `strength` is 1 of a sun that lights the scene, else 0.
    pub(crate) fn parts(
        &self,
        sun_deg: Option<[f64; 2]>,
        strength: impl Fn([f64; 2]) -> f32,
    ) -> Result<Parts, StageError> {
        let strength_of_sun = sun_deg.map_or(0.0, &strength);
        let lighting = self.sky.lighting((sun_deg, strength_of_sun), self.ambient, self.units)?;
        let whole = Part { lighting, look: *self.look, sun_deg, factor: [1.0; 3] };
        let mut parts = self.of_first_sun(whole);
        for added in &self.sunlight.added {
            let sun_deg = Some(added.sun_deg);
            let strength = strength(added.sun_deg);
            if strength > 0.0 {
                let alone = StageSky::EVEN.lighting((sun_deg, strength), (0.0, None), self.units)?;
                parts.others.push(self.sun(alone, sun_deg, added.irradiance));
            }
        }
        Ok(parts)
    }

    /// The sun that moves, and the sky.
    fn of_first_sun(&self, mut whole: Part) -> Parts {
        let irradiance = self.sunlight.irradiance;
        let lighting = &mut whole.lighting;
        if lighting.dome.is_some() {
            (0..3).for_each(|band| lighting.sun_color[band] *= irradiance[band]);
            return Parts { first: whole, others: Vec::new() };
        }
        let is_grey = irradiance == [irradiance[0]; 3];
        if is_grey || lighting.daylight.sun == 0.0 {
            lighting.daylight.sun *= irradiance[0];
            return Parts { first: whole, others: Vec::new() };
        }
        let mut alone = lighting.clone();
        alone.daylight.sky = 0.0;
        lighting.daylight.sun = 0.0;
        let sun = self.sun(alone, whole.sun_deg, irradiance);
        Parts { first: whole, others: vec![sun] }
    }

    fn sun(&self, lighting: Lighting, sun_deg: Option<[f64; 2]>, irradiance: [f32; 3]) -> Part {
        Part { lighting, look: Look { has_sky: false, ..*self.look }, sun_deg, factor: irradiance }
    }
}

impl Parts {
    /// The sum of the pictures of all parts, each taken by `take`.
    pub(crate) fn sum<E>(&self, mut take: impl FnMut(&Part) -> Result<Picture, E>) -> Result<Picture, E> {
        let mut sum = take(&self.first)?;
        for part in &self.others {
            sum.add(&take(part)?, part.factor);
        }
        Ok(sum)
    }
}

#[cfg(test)]
mod tests;

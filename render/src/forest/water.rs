//! Standing water: a level mirror over a body of one colour. Rays to points of it, and what it sends back.
//!
//! It is without end, and hidden by ground that is higher. Nothing shows through it: plants and ground below are hidden
//! by its colour, as in water deeper than one sees. It needs no haze: towards the horizon it mirrors all, and what it
//! mirrors there is the sky's horizon. It sends plants no light, and the sun's disc is not mirrored, as it is drawn
//! nowhere: a ripple would spread it over more than a pixel.

use glam::{DVec3, Vec3};

use super::placed::WorldRay;
use crate::RenderError;

/// A level surface of water without end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Water {
    /// Height of the water (y), metres.
    pub height_m: f64,
    /// Share of the light that has come into it which comes out of it again, R, G, B, each 0 to 1.
    pub color: [f32; 3],
}

/// Of visible light in water, against air (Hecht, Optics: 1.333 at 20 degrees Celsius).
pub(crate) const REFRACTIVE_INDEX: f32 = 1.333;
/// Share of an even sky's light on level water that comes into it: 1 minus the mean of [`reflectance`] over the
/// hemisphere, weighed by the cosine.
pub(crate) const INTO_FROM_SKY: f32 = 0.9336;

impl Water {
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        let refuse = |found: String, expected: &str| {
            Err(RenderError::Setting { name: "water", found, expected: expected.into() })
        };
        if !self.height_m.is_finite() {
            return refuse(format!("height_m {}", self.height_m), "a finite height");
        }
        match self.color.iter().all(|share| (0.0..=1.0).contains(share)) {
            true => Ok(()),
            false => refuse(format!("colour {:?}", self.color), "0..=1 in every band"),
        }
    }

    /// Refuses an eye that is not above the water.
    ///
    /// # Errors
    /// [`RenderError::Underwater`].
    pub fn check_eye(&self, position_m: [f64; 3]) -> Result<(), RenderError> {
        match position_m[1] > self.height_m {
            true => Ok(()),
            false => Err(RenderError::Underwater { eye_m: position_m[1], water_m: self.height_m }),
        }
    }

    /// Distance at which a ray from above comes to the water's level. Ground that covers water there is met before, but
    /// for a ray that passes below the rim of a height map: to that the map is a sheet, with water under it.
    pub(crate) fn along(&self, ray: &WorldRay) -> Option<f64> {
        let above = ray.origin.y - self.height_m;
        (above > 0.0 && ray.direction.y < 0.0).then(|| above / -ray.direction.y)
    }

    /// The point of the water at a distance along a ray.
    pub(crate) fn point(&self, ray: &WorldRay, distance_m: f64) -> DVec3 {
        let along = ray.origin + ray.direction * distance_m;
        DVec3::new(along.x, self.height_m, along.z)
    }

    /// The ray that comes to the camera along another by way of the water.
    pub(crate) fn mirrored(&self, ray: &WorldRay, distance_m: f64) -> WorldRay {
        let DVec3 { x, y, z } = ray.direction;
        WorldRay { origin: self.point(ray, distance_m), direction: DVec3::new(x, -y, z) }
    }

    pub(crate) fn color(&self) -> Vec3 {
        Vec3::from(self.color)
    }
}

/// Share of unpolarised light that water mirrors, by the cosine of its angle to the vertical: the mean of Fresnel's
/// equations for both polarisations (Born and Wolf, Principles of Optics, 7th edition, section 1.5.2, equations 21),
/// squared.
pub(crate) fn reflectance(cosine: f32) -> f32 {
    let cosine = cosine.clamp(0.0, 1.0);
    let inside = (REFRACTIVE_INDEX * REFRACTIVE_INDEX - 1.0 + cosine * cosine).sqrt();
    // By Snell's law n times the cosine inside is `inside`.
    let across = (cosine - inside) / (cosine + inside);
    let within = REFRACTIVE_INDEX * REFRACTIVE_INDEX * cosine;
    let along = (within - inside) / (within + inside);
    0.5 * (across * across + along * along)
}

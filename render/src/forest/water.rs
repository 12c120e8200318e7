//! Water: a mirror over a body of one colour, level or with waves. Rays to points of it, and what it sends back.
//!
//! It is without end, and hidden by ground that is higher. Nothing shows through it: plants and ground below are hidden
//! by its colour, as in water deeper than one sees. It needs no haze: towards the horizon it mirrors all, and what it
//! mirrors there is the sky's horizon. It sends plants no light, and level water does not mirror the sun's disc, as it
//! is drawn nowhere.
//!
//! Waves turn the surface and do not lift it: rays come to the level plane, and there to a facet of it. Ripples that
//! are too short to be drawn spread the sun's disc into a glint around each facet.

use std::f64::consts::PI;

use flb_scene::waves::{WaveField, Waves};
use glam::{DVec3, Vec3};

use super::placed::WorldRay;
use crate::RenderError;

/// A surface of water without end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Water {
    /// Height of the water (y), metres.
    pub height_m: f64,
    /// Share of the light that has come into it which comes out of it again, R, G, B, each 0 to 1.
    pub color: [f32; 3],
    /// Waves on it; `None` where it is level.
    pub waves: Option<Waves>,
}

/// Water made ready for rays.
pub(crate) struct WaterSurface {
    pub water: Water,
    pub field: Option<WaveField>,
}

/// A point of the water that a ray came to.
pub(crate) struct Facet {
    /// Upward normal, unit.
    pub normal: DVec3,
    /// The ray that comes to the camera by way of it.
    pub back: WorldRay,
    /// Share of light that is mirrored.
    pub share: f32,
}

/// Variance, along both axes together, of the slopes that mirror some of the sun's disc. Of directions in a disc of
/// radius r it is r^2/2; the sun's is 4.65 mrad, and what mirrors it turns half as far.
const SUN_VARIANCE: f64 = 0.00465 * 0.00465 / 8.0;

/// Squares of slopes, in variances, beyond which ripples are so rare that no shadow ray looks for the sun: e^-16 of the
/// glint.
pub(crate) const NO_GLINT: f64 = 16.0;
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
        if !self.color.iter().all(|share| (0.0..=1.0).contains(share)) {
            return refuse(format!("colour {:?}", self.color), "0..=1 in every band");
        }
        match self.waves.and_then(|waves| waves.fault()) {
            Some((name, found, expected)) => refuse(format!("waves with {name} {found}"), &expected),
            None => Ok(()),
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

    pub(crate) fn color(&self) -> Vec3 {
        Vec3::from(self.color)
    }
}

impl WaterSurface {
    pub(crate) fn new(water: Water) -> WaterSurface {
        WaterSurface { water, field: water.waves.map(|waves| waves.field()) }
    }

    /// The facet that a ray comes to at a distance, at a time.
    pub(crate) fn facet(&self, ray: &WorldRay, distance_m: f64, time_s: f64) -> Facet {
        let (origin, looking) = (self.water.point(ray, distance_m), ray.direction);
        let Some(field) = &self.field else {
            let direction = DVec3::new(looking.x, -looking.y, looking.z);
            let share = reflectance(direction.y as f32);
            return Facet { normal: DVec3::Y, back: WorldRay { origin, direction }, share };
        };
        let [x, z] = field.slope_at([origin.x, origin.z], time_s);
        let normal = DVec3::new(-x, 1.0, -z).normalize();
        // What faces away lies behind another wave, which mirrors at a small angle.
        let cosine = (-looking.dot(normal)).max(0.0);
        let DVec3 { x, y, z } = looking + normal * (2.0 * cosine);
        // What goes down comes to another wave, and goes up from there.
        let direction = DVec3::new(x, y.abs(), z);
        Facet { normal, back: WorldRay { origin, direction }, share: reflectance(cosine as f32) }
    }

    /// Glint of the sun in the ripples of a facet: its radiance in that of a white matt surface that faces the sun (Cox
    /// and Munk, Measurement of the roughness of the sea surface from photographs of the sun's glitter, 1954).
    pub(crate) fn glint(&self, facet: &Facet, looking: DVec3, towards_sun: DVec3) -> f32 {
        let Some(field) = &self.field else { return 0.0 };
        let half = (towards_sun - looking).normalize_or_zero();
        let (slant, of_sun) = (half.dot(facet.normal), half.dot(towards_sun));
        if slant <= 0.0 || of_sun <= 0.0 || towards_sun.y <= 0.0 {
            return 0.0;
        }
        let variance = glint_variance(field);
        let squared = slant * slant;
        let steep = (1.0 - squared) / squared / variance;
        if steep > NO_GLINT {
            return 0.0;
        }
        let density = libm::exp(-steep) / (PI * variance);
        // At smaller angles than that ripples hide each other.
        let cosine = (-looking.dot(facet.normal)).max((0.5 * variance).sqrt());
        (PI * f64::from(reflectance(of_sun as f32)) * density / (4.0 * cosine * squared * squared)) as f32
    }
}

/// Variance of the slopes that make the sun's glint on waves: of those that are not drawn, and the sun's own size.
pub(crate) fn glint_variance(field: &WaveField) -> f64 {
    field.rest_variance + SUN_VARIANCE
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

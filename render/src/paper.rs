//! The `paper` shading of a plant (lighting-model, section 10): Lambert light and a highlight from the sun,
//! indirect light = texture colour x phi x scale.

use flb_scene::MaterialClass;
use glam::Vec3;

use crate::{scene::Hit, sun::Sunlight};

/// Exponent of the leaves' highlight (Blinn and Phong).
pub(crate) const SHININESS: f32 = 24.0;

pub(crate) struct Paper {
    pub sun: Sunlight,
    /// Strength of the leaves' highlight.
    pub specular: f32,
    /// Factor on all indirect light.
    pub indirect_scale: f32,
}

impl Paper {
    /// Lambert and a highlight, where the sun stands on the side that is looked at and sees that side, which `sees`
    /// tells. `looking` is the direction of the ray from the camera.
    pub(crate) fn direct(&self, hit: &Hit, looking: Vec3, sees: impl FnOnce(Vec3) -> bool) -> Vec3 {
        let cosine = hit.normal.dot(self.sun.towards);
        if cosine <= 0.0 || hit.flat_normal.dot(self.sun.towards) <= 0.0 {
            return Vec3::ZERO;
        }
        if !sees(hit.flat_normal) {
            return Vec3::ZERO;
        }
        let mut color = hit.color * cosine;
        if hit.class == MaterialClass::Leaf && self.specular > 0.0 {
            let half = (self.sun.towards - looking).normalize_or_zero();
            let highlight = libm::powf(hit.normal.dot(half).max(0.0), SHININESS);
            color += Vec3::splat(self.specular * highlight);
        }
        color * self.sun.strength
    }

    /// Texture colour x phi x scale.
    pub(crate) fn indirect(&self, hit: &Hit, phi: Vec3) -> Vec3 {
        hit.color * phi * self.indirect_scale
    }
}

//! The `paper` shading of a plant (lighting-model, section 10): Lambert light and a highlight from the sun,
//! indirect light = texture colour x phi x scale.

use flb_baker::MaterialClass;
use glam::Vec3;

use crate::{
    RenderSettings,
    scene::{Hit, Ray},
    sun::Sun,
};

/// Exponent of the leaves' highlight (Blinn and Phong).
const SHININESS: f32 = 24.0;

pub(crate) struct Paper<'a> {
    pub sun: Sun<'a>,
    pub settings: &'a RenderSettings,
}

impl Paper<'_> {
    /// Lambert and a highlight, where the sun stands on the side that is looked at and sees the point.
    pub(crate) fn direct(&self, hit: &Hit, ray: Ray) -> Vec3 {
        let cosine = hit.normal.dot(self.sun.towards);
        if cosine <= 0.0 || hit.flat_normal.dot(self.sun.towards) <= 0.0 {
            return Vec3::ZERO;
        }
        if !self.sun.sees(hit.point, hit.flat_normal, Some(hit.triangle)) {
            return Vec3::ZERO;
        }
        let mut color = hit.color * cosine;
        if hit.class == MaterialClass::Leaf && self.settings.specular > 0.0 {
            let half = (self.sun.towards - ray.direction).normalize_or_zero();
            let highlight = libm::powf(hit.normal.dot(half).max(0.0), SHININESS);
            color += Vec3::splat(self.settings.specular * highlight);
        }
        color * self.sun.strength
    }

    /// Texture colour x phi x scale.
    pub(crate) fn indirect(&self, hit: &Hit, phi: Vec3) -> Vec3 {
        hit.color * phi * self.settings.indirect_scale
    }
}

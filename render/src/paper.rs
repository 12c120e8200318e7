//! The `paper` shading of a plant (lighting-model, section 10): Lambert light and a highlight k (v.r)^s from the sun,
//! indirect light = texture colour x phi x scale.

use flb_scene::MaterialClass;
use glam::Vec3;

use crate::{highlight::Highlights, scene::Hit, sun::Sunlight};

pub(crate) struct Paper {
    pub sun: Sunlight,
    pub highlights: Highlights,
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
        let highlight = match hit.class {
            MaterialClass::Leaf => self.highlights.leaf,
            _ => self.highlights.wood,
        };
        color += Vec3::splat(highlight.towards(hit.normal, self.sun.towards, looking));
        color * self.sun.strength
    }

    /// Texture colour x phi x scale.
    pub(crate) fn indirect(&self, hit: &Hit, phi: Vec3) -> Vec3 {
        hit.color * phi * self.indirect_scale
    }
}

//! The `physical` shading of a plant (lighting-model, section 10): matt leaves that reflect and transmit,
//! matt wood, no highlight.
//!
//! Normals are those of the flat triangles. The medium was made from these triangles, and a mesh lit by them
//! gives back no more light than it gets, which interpolated normals do not promise.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use crate::{scene::Hit, sun::Sunlight, surfaces::Matt};

pub(crate) struct Physical {
    pub sun: Sunlight,
}

impl Physical {
    /// Radiance that the sun itself causes: R / pi x E |n.s| V from the lit side, T / pi x E |n.s| V through
    /// the leaf, V by a shadow ray from the side that `sees` is given. Both sides of wood are matt and neither
    /// shows what lights the other.
    pub(crate) fn direct(&self, hit: &Hit, matt: &Matt, sees: impl FnOnce(Vec3) -> bool) -> Vec3 {
        let cosine = hit.flat_normal.dot(self.sun.towards);
        let (share, side) = match cosine >= 0.0 {
            true => (matt.reflectance, hit.flat_normal),
            false => (matt.transmittance, -hit.flat_normal),
        };
        if share == Vec3::ZERO || !sees(side) {
            return Vec3::ZERO;
        }
        share * (FRAC_1_PI * self.sun.strength * cosine.abs()) * self.sun.color
    }

    /// Radiance from the fluence that a surface asks for ([`crate::surfaces::Finish::asks`]): a share of it falls on
    /// each side.
    pub(crate) fn indirect(&self, matt: &Matt, phi: Vec3) -> Vec3 {
        (matt.reflectance + matt.transmittance) * phi * (matt.received * FRAC_1_PI)
    }
}

#[cfg(test)]
mod tests;

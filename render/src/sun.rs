//! The sun: one direction, and what stands in its way.

use glam::Vec3;

use crate::scene::{Hit, Ray, Scene};

/// Share of the plant's size that keeps a ray off the surface which it leaves.
const LIFT: f32 = 1e-5;

/// Light of the sun before anything stands in its way, in the frame of the surface that it falls on.
#[derive(Clone, Copy)]
pub(crate) struct Sunlight {
    /// Unit.
    pub towards: Vec3,
    /// Irradiance on a plane that faces it.
    pub strength: f32,
    /// Factor on it per band.
    pub color: Vec3,
}

/// The sun over a single plant.
#[derive(Clone, Copy)]
pub(crate) struct Sun<'a> {
    pub scene: &'a Scene<'a>,
    pub light: Sunlight,
}

impl Sun<'_> {
    /// Whether the sun sees the surface where a ray met it, on the side to which `side` points. Its triangle casts no
    /// shadow.
    pub(crate) fn sees_hit(&self, hit: &Hit, side: Vec3) -> bool {
        let origin = hit.point + side * lift(self.scene);
        !self.scene.is_blocked(Ray { origin, direction: self.light.towards }, Some(hit.triangle))
    }
}

/// How far from its surface a ray starts.
pub(crate) fn lift(scene: &Scene<'_>) -> f32 {
    scene.size() * LIFT
}

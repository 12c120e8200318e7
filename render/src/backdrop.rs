//! What is seen where there is no plant: the sky, and what it sends to the ground.

use std::f32::consts::PI;

use flb_format::direction::MOVING;
use flb_format::sky_part::SkyPart;
use flb_scene::sky::Sky;
use glam::Vec3;

/// The ambient base of the `paper` model in empty space. The ground lies partly outside the lattice, where
/// the field says nothing, so it gets open sky and the sun's shadow.
pub(crate) const OPEN_SKY: f32 = MOVING as f32;
/// Linear colours of the sky at the horizon and overhead.
pub(crate) const HORIZON: Vec3 = Vec3::new(0.60, 0.71, 0.84);
pub(crate) const ZENITH: Vec3 = Vec3::new(0.20, 0.36, 0.66);
/// Mean luminance (Rec. 709) of that gradient over the sky: a third of the horizon's, two thirds of the
/// zenith's.
pub(crate) const SKY_LUMINANCE: f32 = 0.4638;
/// Ambient weight at which the sky of the `paper` shading is drawn at full brightness.
const DAYLIGHT: f32 = 0.02;

/// Irradiance of a sky on level ground.
pub(crate) fn on_level_ground(sky: &Sky) -> Vec3 {
    let up = |patch: &SkyPart| patch.towards[1].max(0.0) as f32;
    sky.patches().iter().map(|patch| Vec3::from(patch.fluence) * up(patch)).sum()
}

/// The sky in a direction of unit length whose upward part is `up`, at full brightness.
pub(crate) fn sky_gradient(up: f32) -> Vec3 {
    HORIZON.lerp(ZENITH, up.clamp(0.0, 1.0).sqrt())
}

/// How bright the sky of the `paper` shading is drawn. Dusk is dimmer than noon, but a picture without ambient
/// light still has a sky.
pub(crate) fn paper_sky_strength(ambient: f32) -> f32 {
    0.35 + 0.65 * (ambient / DAYLIGHT).min(1.0)
}

/// Radiance of an isotropic sky in the `physical` shading, by its fluence over the whole sphere.
pub(crate) fn sky_radiance(fluence: f32) -> f32 {
    fluence / (4.0 * PI)
}

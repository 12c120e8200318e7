//! What surfaces do with light in the `physical` shading, per band R, G, B.

use flb_scene::MaterialClass;
use glam::Vec3;

use crate::{
    RenderError,
    scene::{Hit, Scene},
};

/// How a picture is shaded (lighting-model, section 10).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shading {
    /// Texture colour x light, as in the papers; white in full sun = 1.
    Paper,
    /// Measured surfaces in radiometric units: radiance, with the sun's irradiance as the unit.
    Physical(Surfaces),
}

/// Reflectance and transmittance of the mean leaf and the mean wood, R, G, B, each 0..=1. Textures tell
/// where a surface is brighter or darker: both shares go with a texel's colour over the material's mean
/// colour on the mesh, and never to more than 1 together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surfaces {
    /// Share of the light on a leaf that comes back from the lit side, as from matt paper.
    pub leaf_reflectance: [f32; 3],
    /// Share that comes out of the other side, as evenly. With the reflectance 1 at most.
    pub leaf_transmittance: [f32; 3],
    /// Share of the light on wood that comes back. Nothing passes.
    pub wood_reflectance: [f32; 3],
    /// How far off solids light is asked for, along the normal of the side that is seen, metres of the model; a quarter
    /// of it falls on them, as on leaves. `None`: at the surface, and half of it.
    pub solid_offset_m: Option<f32>,
}

/// How far a sum of two shares may lie above 1: rounding of what was 1.
const ROUNDING: f32 = 1e-6;
/// Mean colour from which ratios are taken no more: the material is black, so its surface is the mean one.
pub(crate) const BLACK: Vec3 = Vec3::splat(1e-9);

impl Surfaces {
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        for (name, shares) in [
            ("leaf_reflectance", self.leaf_reflectance),
            ("leaf_transmittance", self.leaf_transmittance),
            ("wood_reflectance", self.wood_reflectance),
        ] {
            if !shares.iter().all(|share| (0.0..=1.0).contains(share)) {
                let found = format!("{shares:?}");
                return Err(RenderError::Setting { name, found, expected: "0..=1 in every band".into() });
            }
        }
        if let Some(found) = self.solid_offset_m.filter(|offset| !(offset.is_finite() && *offset >= 0.0)) {
            return Err(RenderError::Setting {
                name: "solid_offset_m",
                found: found.to_string(),
                expected: "finite metres, 0 or more".into(),
            });
        }
        let sums: [f32; 3] =
            std::array::from_fn(|band| self.leaf_reflectance[band] + self.leaf_transmittance[band]);
        if sums.iter().any(|&sum| sum > 1.0 + ROUNDING) {
            return Err(RenderError::Setting {
                name: "leaf_reflectance + leaf_transmittance",
                found: format!("{sums:?}"),
                expected: "at most 1 in every band: no leaf sends out more light than it gets".into(),
            });
        }
        Ok(())
    }
}

/// A point of a surface that reflects and transmits as a matt sheet does.
pub(crate) struct Matt {
    pub reflectance: Vec3,
    pub transmittance: Vec3,
    /// Share of the fluence of [`Finish::asks_at`] that falls on the side that is seen.
    pub received: f32,
}

/// The surfaces of one mesh: the file's values, and the mean colour that they stand for.
pub(crate) struct Finish {
    pub surfaces: Surfaces,
    /// Per material, linear.
    pub mean_colors: Vec<Vec3>,
}

impl Finish {
    pub(crate) fn of(scene: &Scene<'_>, surfaces: Surfaces) -> Self {
        Finish { surfaces, mean_colors: scene.mean_colors() }
    }

    /// The surface where a ray met it. What is neither leaf nor wood, such as a pot, is opaque and has no
    /// values in a file: its colour is its reflectance.
    pub(crate) fn at(&self, hit: &Hit) -> Matt {
        let mean = self.mean_colors[hit.material];
        let ratio = Vec3::select(mean.cmpgt(BLACK), hit.color / mean, Vec3::ONE);
        let (reflectance, transmittance) = match hit.class {
            MaterialClass::Leaf => (
                ratio * Vec3::from(self.surfaces.leaf_reflectance),
                ratio * Vec3::from(self.surfaces.leaf_transmittance),
            ),
            MaterialClass::Wood => (ratio * Vec3::from(self.surfaces.wood_reflectance), Vec3::ZERO),
            MaterialClass::Neither => (hit.color, Vec3::ZERO),
        };
        // Texels far brighter than the mean would otherwise send out more than they get.
        let fit = (reflectance + transmittance).max(Vec3::ONE).recip();
        let is_leaf = hit.class == MaterialClass::Leaf;
        let received = if is_leaf || self.surfaces.solid_offset_m.is_some() { 0.25 } else { 0.5 };
        Matt { reflectance: reflectance * fit, transmittance: transmittance * fit, received }
    }

    /// Where light on a surface is asked for.
    pub(crate) fn asks_at(&self, hit: &Hit) -> Vec3 {
        match (hit.class, self.surfaces.solid_offset_m) {
            (MaterialClass::Leaf, _) | (_, None) => hit.point,
            (MaterialClass::Wood | MaterialClass::Neither, Some(offset_m)) => {
                hit.point + hit.flat_normal * offset_m
            }
        }
    }
}

#[cfg(test)]
mod tests;

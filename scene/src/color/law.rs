//! From the colour of a texel to what the surface there reflects and lets through: the one rule of the bake and of
//! every renderer (lighting model, section 10).

use flb_format::material_surface::{MaterialSurface, Texel};
use glam::Vec3;

use crate::MaterialClass;
use crate::mesh::Material;

/// Mean colour from which ratios are taken no more: the material is black, so its surface is the mean one.
pub const BLACK: Vec3 = Vec3::splat(1e-9);

/// Reflectance and transmittance of a material of a mesh, by the colour of its texels, R, G, B.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Law {
    /// The colour at which the surface is the one below.
    pub unit: Vec3,
    /// Reflectance at the colour `unit`.
    pub reflectance: Vec3,
    /// Transmittance at the colour `unit`.
    pub transmittance: Vec3,
}

/// Reflectance and transmittance at a point of a surface; together 1 at most in every band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shares {
    /// Share of the light that comes back.
    pub reflectance: Vec3,
    /// Share that comes out of the other side.
    pub transmittance: Vec3,
    /// Whether both would have been more than 1 together, and were scaled down.
    pub is_clamped: bool,
}

impl Law {
    /// Law of what is neither leaf nor wood, such as a pot: opaque, and its colour is its reflectance.
    pub const PLAIN: Law = Law { unit: Vec3::ONE, reflectance: Vec3::ONE, transmittance: Vec3::ZERO };

    /// Makes the law of a material whose mean colour on the mesh is `mean`, of a plant whose `class` reflects and lets
    /// through `of_class`.
    pub fn of(material: &Material, class: MaterialClass, of_class: [Vec3; 2], mean: Vec3) -> Law {
        if class == MaterialClass::Neither {
            return Law::PLAIN;
        }
        let [reflectance, transmittance] = of_class;
        let own = material.surface.as_ref().and_then(|surface| Law::own(surface, mean));
        own.unwrap_or(Law { unit: mean, reflectance, transmittance })
    }

    /// Of a surface of the material's own; `None` of fewer bands than a picture has.
    pub(super) fn own(surface: &MaterialSurface, mean: Vec3) -> Option<Law> {
        let rgb = |shares: &[f64]| {
            let first = shares.first_chunk::<3>()?;
            Some(Vec3::from(first.map(|share| share as f32)))
        };
        let (reflectance, transmittance) = (rgb(&surface.reflectance)?, rgb(&surface.transmittance)?);
        let unit = if surface.texel == Texel::Albedo { Vec3::ONE } else { mean };
        Some(Law { unit, reflectance, transmittance })
    }

    /// Returns both shares where the texel has this linear colour.
    pub fn at(&self, color: Vec3) -> Shares {
        let ratio = Vec3::select(self.unit.cmpgt(BLACK), color / self.unit, Vec3::ONE);
        let (reflectance, transmittance) = (ratio * self.reflectance, ratio * self.transmittance);
        // Bright texels would otherwise send out more than they get.
        let most = (reflectance + transmittance).max(Vec3::ONE);
        let fit = most.recip();
        let is_clamped = most.max_element() > 1.0 + ROUNDING;
        Shares { reflectance: reflectance * fit, transmittance: transmittance * fit, is_clamped }
    }
}

/// Largest excess of a sum of two shares over 1: rounding of what was 1.
pub const ROUNDING: f32 = 1e-6;

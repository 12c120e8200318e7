//! What surfaces do with light in the `physical` shading, per band R, G, B.

use flb_format::SpeciesMeta;
use flb_format::matter::BandSurfaces;
use flb_format::surface::{Law, ROUNDING, Shares, Surface};
use flb_scene::MaterialClass;
use flb_scene::color::law;
use glam::Vec3;

use crate::{
    LightQuery, RenderError,
    scene::{Hit, Scene},
};

/// Reflectance and transmittance of the mean leaf and the mean wood, R, G, B, each 0..=1. Textures tell where a
/// surface is brighter or darker: both shares go with a texel's colour over the material's mean colour on the mesh,
/// and never to more than 1 together. A material with a surface of its own ([`flb_scene::mesh::Material::surface`])
/// goes by that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surfaces {
    /// Share of the light on a leaf that comes back from the lit side, as from matt paper.
    pub leaf_reflectance: [f32; 3],
    /// Share that comes out of the other side, as evenly. With the reflectance 1 at most.
    pub leaf_transmittance: [f32; 3],
    /// Share of the light on wood that comes back. Nothing passes.
    pub wood_reflectance: [f32; 3],
    /// Distance off solids at which light is asked for, along the normal of the side that is seen, metres of the model;
    /// a quarter of it falls on them, as on leaves. `None`: at the surface, and half of it.
    pub solid_offset_m: Option<f32>,
}

impl Surfaces {
    /// Surfaces in the first three bands of a `physical` species, which are red, green and blue
    /// ([`SpeciesMeta::with_bands`]), and where its light at solids is.
    ///
    /// # Panics
    /// For fewer than three bands.
    pub fn of(surfaces: &flb_format::matter::Surfaces, meta: &SpeciesMeta) -> Surfaces {
        let of =
            |share: fn(&BandSurfaces) -> f64| std::array::from_fn(|band| share(&surfaces.bands[band]) as f32);
        Surfaces {
            leaf_reflectance: of(|band| band.leaf.reflectance),
            leaf_transmittance: of(|band| band.leaf.transmittance),
            wood_reflectance: of(|band| band.wood.reflectance),
            solid_offset_m: meta.solid_offset_m().map(|metres| metres as f32),
        }
    }

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
    /// Share of the fluence of [`Finish::asks`] that falls on the side that is seen.
    pub received: f32,
}

/// The surfaces of one mesh.
pub(crate) struct Finish {
    pub surfaces: Surfaces,
    /// Law of each material.
    pub laws: Vec<Law>,
}

impl Finish {
    pub(crate) fn of(scene: &Scene<'_>, surfaces: Surfaces) -> Self {
        let leaf = [surfaces.leaf_reflectance, surfaces.leaf_transmittance].map(Vec3::from);
        let wood = [surfaces.wood_reflectance.into(), Vec3::ZERO];
        let of_class = |class| if class == MaterialClass::Leaf { leaf } else { wood };
        let materials = scene.mesh.materials.iter().zip(scene.classes).zip(scene.mean_colors());
        let laws = materials.map(|((material, &class), mean)| law(material, class, of_class(class), mean));
        Finish { surfaces, laws: laws.collect() }
    }

    /// The surface where a ray met it.
    pub(crate) fn at(&self, hit: &Hit) -> Matt {
        let surface = self.surface(hit);
        let Shares { reflectance, transmittance, .. } = surface.law().at(hit.color.to_array());
        Matt {
            reflectance: reflectance.into(),
            transmittance: transmittance.into(),
            received: surface.received(),
        }
    }

    fn surface(&self, hit: &Hit) -> Surface {
        Surface::new(self.laws[hit.material], hit.class.into(), self.surfaces.solid_offset_m)
    }

    /// What light on a surface of an instance is asked for.
    pub(crate) fn asks(&self, instance: u32, hit: &Hit) -> LightQuery {
        let point = self.surface(hit).asked_at(hit.point.to_array(), hit.flat_normal.to_array());
        LightQuery::of(instance, point.into(), hit)
    }
}

#[cfg(test)]
mod tests;

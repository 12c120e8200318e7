//! What a surface of a plant makes of light: from the fluence of a file to the radiance of a pixel (lighting model,
//! section 10). It is the one rule of the bake and of every renderer, and needs no mesh and no importer.
//!
//! ```
//! use flb_format::surface::{Surface, SurfacePart};
//! # use flb_format::{Codec, SpeciesMeta};
//! # use flb_format::surface::SurfaceError;
//! # fn pixel(meta: &SpeciesMeta, light: impl Fn([f32; 3]) -> [f32; 3]) -> Result<(), SurfaceError> {
//! // Once for each material: its number in the mesh and the mean of its texels on it, in linear light.
//! let leaf = Surface::of(meta, SurfacePart::Leaf, 0, [0.09, 0.14, 0.04])?;
//! // For a point of it, with the unit normal of the side that is seen and the texel there.
//! let (point_m, normal, texel) = ([0.5, 3.0, -0.2], [0.0, 1.0, 0.0], [0.11, 0.15, 0.03]);
//! let fluence = light(leaf.asked_at(point_m, normal));
//! let mut radiance = leaf.radiance(fluence, texel);
//! // The sun's beam, where no shadow ray meets anything: its irradiance, and the cosine to the side that is seen.
//! let of_sun = leaf.radiance_of_sun([1.0; 3], 0.4, texel);
//! radiance.iter_mut().zip(of_sun).for_each(|(sum, sun)| *sum += sun);
//! # Ok(())
//! # }
//! ```

use std::f32::consts::PI;

use crate::SpeciesMeta;
use crate::colors::BandsError;
use crate::material_surface::{MaterialSurface, Texel};

/// Mean colour from which ratios are taken no more: the material is black, so its surface is the mean one.
pub const BLACK: f32 = 1e-9;

/// Largest excess of a sum of two shares over 1: rounding of what was 1.
pub const ROUNDING: f32 = 1e-6;

/// Reflectance and transmittance of a material of a mesh, by the colour of its texels, R, G, B.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Law {
    /// The colour at which the surface is the one below.
    pub unit: [f32; 3],
    /// Reflectance at the colour `unit`.
    pub reflectance: [f32; 3],
    /// Transmittance at the colour `unit`.
    pub transmittance: [f32; 3],
}

/// Reflectance and transmittance at a point of a surface; together 1 at most in every band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shares {
    /// Share of the light that comes back.
    pub reflectance: [f32; 3],
    /// Share that comes out of the other side.
    pub transmittance: [f32; 3],
    /// Whether both would have been more than 1 together, and were scaled down.
    pub is_clamped: bool,
}

impl Law {
    /// Law of what is neither leaf nor wood, such as a pot: opaque, and its colour is its reflectance.
    pub const PLAIN: Law = Law { unit: [1.0; 3], reflectance: [1.0; 3], transmittance: [0.0; 3] };

    /// Law of a surface of the material's own, whose mean colour on the mesh is `mean`; `None` of fewer bands than a
    /// picture has.
    pub fn of_material(surface: &MaterialSurface, mean: [f32; 3]) -> Option<Law> {
        let rgb = |shares: &[f64]| shares.first_chunk::<3>().map(|shares| shares.map(|share| share as f32));
        let (reflectance, transmittance) = (rgb(&surface.reflectance)?, rgb(&surface.transmittance)?);
        let unit = if surface.texel == Texel::Albedo { [1.0; 3] } else { mean };
        Some(Law { unit, reflectance, transmittance })
    }

    /// Returns both shares where the texel has this linear colour.
    pub fn at(&self, color: [f32; 3]) -> Shares {
        let (mut reflectance, mut transmittance, mut is_clamped) = ([0.0; 3], [0.0; 3], false);
        for band in 0..3 {
            let unit = self.unit[band];
            let ratio = if unit > BLACK { color[band] / unit } else { 1.0 };
            let shares = [self.reflectance[band], self.transmittance[band]].map(|share| ratio * share);
            // Bright texels would otherwise send out more than they get.
            let most = (shares[0] + shares[1]).max(1.0);
            is_clamped |= most > 1.0 + ROUNDING;
            [reflectance[band], transmittance[band]] = shares.map(|share| share * (1.0 / most));
        }
        Shares { reflectance, transmittance, is_clamped }
    }
}

/// Part of a plant that a material is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SurfacePart {
    /// Thin: light passes, and either side is lit by what is around it.
    Leaf,
    /// Solid.
    Wood,
    /// Solid and no part of the plant, such as a pot: its colour is its reflectance.
    Other,
}

/// Reason why a file does not say what a surface makes of light.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceError {
    /// Light of the papers' model, which is multiplied by the texel and a scale of the renderer's own.
    #[error("species \"{species}\" is of the model paper, expected physical: its light is no fluence")]
    NoFluence {
        /// Name of the species.
        species: String,
    },
    /// Bands that are not red, green and blue.
    #[error(transparent)]
    Bands(#[from] BandsError),
}

/// A material of a plant, to a renderer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surface {
    law: Law,
    is_leaf: bool,
    /// Distance off solids at which light is asked for, metres of the model.
    offset_m: Option<f32>,
}

impl Surface {
    /// A surface of a law; light at solids lies `solid_offset_m` off them ([`SpeciesMeta::solid_offset_m`]).
    pub fn new(law: Law, part: SurfacePart, solid_offset_m: Option<f32>) -> Surface {
        let is_leaf = part == SurfacePart::Leaf;
        Surface { law, is_leaf, offset_m: solid_offset_m.filter(|_| !is_leaf) }
    }

    /// The surface of a material by its number in the mesh as `flb` read it, whose texels are `mean_texel` in the mean
    /// on it, in linear light. Of a mesh without textures that is its colour.
    ///
    /// # Errors
    /// [`SurfaceError`].
    pub fn of(
        meta: &SpeciesMeta,
        part: SurfacePart,
        material: usize,
        mean_texel: [f32; 3],
    ) -> Result<Surface, SurfaceError> {
        let Some((surfaces, _)) = meta.physical() else {
            return Err(SurfaceError::NoFluence { species: meta.name.clone() });
        };
        let places = meta.picture_bands(&[])?;
        let bands = places.map(|place| &surfaces.bands[place]);
        let own = meta.material_surfaces().ok().flatten();
        let own = own.and_then(|all| all.into_iter().nth(material).flatten());
        let own = own.and_then(|own| Law::of_material(&own.of_bands(&places), mean_texel));
        let law = match part {
            SurfacePart::Other => Law::PLAIN,
            SurfacePart::Leaf => own.unwrap_or(Law {
                unit: mean_texel,
                reflectance: bands.map(|band| band.leaf.reflectance as f32),
                transmittance: bands.map(|band| band.leaf.transmittance as f32),
            }),
            SurfacePart::Wood => own.unwrap_or(Law {
                unit: mean_texel,
                reflectance: bands.map(|band| band.wood.reflectance as f32),
                transmittance: [0.0; 3],
            }),
        };
        Ok(Surface::new(law, part, meta.solid_offset_m().map(|metres| metres as f32)))
    }

    /// The law of its texels.
    pub fn law(&self) -> &Law {
        &self.law
    }

    /// Where a file is asked for the light on a point of the surface: there, or off it along the unit normal of the
    /// side that is seen.
    pub fn asked_at(&self, point_m: [f32; 3], normal: [f32; 3]) -> [f32; 3] {
        match self.offset_m {
            None => point_m,
            Some(offset_m) => std::array::from_fn(|axis| point_m[axis] + normal[axis] * offset_m),
        }
    }

    /// Share of the fluence at [`Surface::asked_at`] that falls on the side that is seen: a quarter where light is
    /// around the point, half where all of it comes through one side.
    pub fn received(&self) -> f32 {
        if self.is_leaf || self.offset_m.is_some() { 0.25 } else { 0.5 }
    }

    /// Light that the surface sends out of a fluence of scattered light and sky, where its texel has this linear
    /// colour: radiance of the unit of the fluence, per steradian.
    pub fn radiance(&self, fluence: [f32; 3], texel: [f32; 3]) -> [f32; 3] {
        let Shares { reflectance, transmittance, .. } = self.law.at(texel);
        let factor = self.received() / PI;
        std::array::from_fn(|band| fluence[band] * factor * (reflectance[band] + transmittance[band]))
    }

    /// Light that the surface sends out of the sun's beam, of an irradiance per band on a plane that faces it. `cos` is
    /// the cosine of the angle from the normal of the side that is seen to the sun: below 0 the sun is behind, and
    /// shines through.
    pub fn radiance_of_sun(&self, irradiance: [f32; 3], cos: f32, texel: [f32; 3]) -> [f32; 3] {
        let Shares { reflectance, transmittance, .. } = self.law.at(texel);
        let shares = if cos > 0.0 { reflectance } else { transmittance };
        std::array::from_fn(|band| irradiance[band] * cos.abs() * shares[band] / PI)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_law_sends_out_no_more_than_it_gets() {
        let law = Law { unit: [0.1; 3], reflectance: [0.4; 3], transmittance: [0.2; 3] };
        let even = law.at([0.1; 3]);
        assert!(!even.is_clamped && even.reflectance == [0.4; 3], "{even:?}");
        let bright = law.at([1.0; 3]);
        let is_near = |share: f32| (share - 2.0 / 3.0).abs() < 1e-6;
        assert!(bright.is_clamped && bright.reflectance.into_iter().all(is_near), "{bright:?}");
        let black = Law { unit: [0.0; 3], ..law }.at([0.0; 3]);
        assert_eq!(black.reflectance, law.reflectance);
        assert_eq!(Law::PLAIN.at([0.5, 0.3, 0.1]).reflectance, [0.5, 0.3, 0.1]);
    }

    #[test]
    fn a_leaf_of_an_even_light_sends_out_its_shares_and_wood_what_comes_through_one_side() {
        let law = Law { unit: [0.2; 3], reflectance: [0.3, 0.4, 0.1], transmittance: [0.1, 0.2, 0.0] };
        let of = |part, offset_m| Surface::new(law, part, offset_m);
        let near = |found: [f32; 3], expected: [f32; 3]| {
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?} {expected:?}");
        };
        let even = [4.0 * PI; 3];
        let leaf = of(SurfacePart::Leaf, Some(0.1));
        near(leaf.radiance(even, [0.2; 3]), [0.4, 0.6, 0.1]);
        near(leaf.radiance(even, [0.1; 3]), [0.2, 0.3, 0.05]);
        assert_eq!(leaf.asked_at([1.0, 2.0, 3.0], [0.0, 1.0, 0.0]), [1.0, 2.0, 3.0]);
        near(leaf.radiance_of_sun([PI; 3], 0.5, [0.2; 3]), [0.15, 0.2, 0.05]);
        near(leaf.radiance_of_sun([PI; 3], -0.5, [0.2; 3]), [0.05, 0.1, 0.0]);
        let opaque = Law { transmittance: [0.0; 3], ..law };
        let [off, on] = [Some(0.1), None].map(|offset_m| Surface::new(opaque, SurfacePart::Wood, offset_m));
        near(off.radiance(even, [0.2; 3]), [0.3, 0.4, 0.1]);
        near(on.radiance(even, [0.2; 3]), [0.6, 0.8, 0.2]);
        assert_eq!(off.asked_at([1.0, 2.0, 3.0], [0.0, 1.0, 0.0]), [1.0, 2.1, 3.0]);
        assert_eq!(on.asked_at([1.0, 2.0, 3.0], [0.0, 1.0, 0.0]), [1.0, 2.0, 3.0]);
    }
}

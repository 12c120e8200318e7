//! What the colour of a material's texels says of its surface, where a file says it (SPEC.md, section 9.3).

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::SpeciesMeta;

/// Setting of [`SpeciesMeta::settings`] that holds a surface, or null, per material of the mesh.
pub const MATERIALS: &str = "surfaces.materials";

/// Meaning of a texel of a material's colour texture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Texel {
    /// The surface's own reflectance, in linear light.
    Albedo,
    /// Brightness of the surface at a texel relative to its mean.
    Tint,
}

impl Texel {
    /// "albedo" or "tint", as in files.
    pub fn name(self) -> &'static str {
        match self {
            Texel::Albedo => "albedo",
            Texel::Tint => "tint",
        }
    }
}

/// The surface of a material whose texels are not a tint of the species' mean leaf or wood.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaterialSurface {
    /// Meaning of the texels.
    pub texel: Texel,
    /// `[band]`: with `albedo`, what is multiplied by the texel; with `tint`, the reflectance at the mean texel.
    pub reflectance: Vec<f64>,
    /// `[band]`: transmittance, with the same role of the texel as `reflectance`.
    pub transmittance: Vec<f64>,
}

impl MaterialSurface {
    /// Returns the surface with these bands alone.
    pub fn of_bands(&self, kept: &[usize]) -> MaterialSurface {
        let keep = |all: &[f64]| kept.iter().map(|&band| all[band]).collect();
        let (reflectance, transmittance) = (keep(&self.reflectance), keep(&self.transmittance));
        MaterialSurface { texel: self.texel, reflectance, transmittance }
    }
}

/// Surfaces of all materials as a setting; `None` where no material has one of its own.
pub fn setting(surfaces: &[Option<MaterialSurface>]) -> Option<Value> {
    surfaces.iter().any(Option::is_some).then(|| json!(surfaces))
}

impl SpeciesMeta {
    /// Surfaces of the mesh's materials, null for those that are the species' leaf or wood; `None` where the file has
    /// none of its own.
    ///
    /// # Errors
    /// What was found, and what was expected.
    pub fn material_surfaces(&self) -> Result<Option<Vec<Option<MaterialSurface>>>, String> {
        let Some(value) = self.settings.get(MATERIALS) else { return Ok(None) };
        let found: Vec<Option<MaterialSurface>> = serde_json::from_value(value.clone()).map_err(|error| {
            format!("settings.{MATERIALS}: {error}; expected surfaces of SPEC.md section 9.3")
        })?;
        for (index, surface) in found.iter().enumerate() {
            let Some(surface) = surface else { continue };
            let most = if surface.texel == Texel::Tint { 1.0 } else { MAX_SCALE };
            for (name, shares) in
                [("reflectance", &surface.reflectance), ("transmittance", &surface.transmittance)]
            {
                let place = || format!("settings.{MATERIALS}[{index}].{name}");
                if shares.len() != self.band_count() {
                    return Err(format!(
                        "{}: {} values, expected {}",
                        place(),
                        shares.len(),
                        self.band_count()
                    ));
                }
                if let Some(share) = shares.iter().find(|share| !(0.0..=most).contains(*share)) {
                    return Err(format!("{}: {share}, expected 0 to {most}", place()));
                }
            }
        }
        Ok(Some(found))
    }
}

/// Largest factor of a texel: a leaf that transmits so many times what it reflects.
pub const MAX_SCALE: f64 = 1e6;

#[cfg(test)]
mod tests;

//! Reflectance and transmittance of leaf and wood, per band: the optics of the `physical` model.

use serde::{Deserialize, Serialize};

/// A leaf in one band. Both are hemispherical, the mean of its two sides; what is left of 1 is absorbed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LeafSurface {
    /// Share of the light that leaves on the side it came to, 0..=1.
    pub reflectance: f64,
    /// Share that leaves on the other side, 0..=1; with the reflectance at most 1.
    pub transmittance: f64,
}

/// Wood in one band: opaque.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WoodSurface {
    /// Hemispherical reflectance, 0..=1.
    pub reflectance: f64,
}

/// One band: a name and both surfaces.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BandSurfaces {
    /// "R", "G", "B" by default.
    pub name: String,
    /// Surface of leaves.
    pub leaf: LeafSurface,
    /// Surface of wood.
    pub wood: WoodSurface,
}

/// All bands of a species, in the order of the field's bands.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Surfaces {
    /// Surfaces of each band, `[band]`.
    pub bands: Vec<BandSurfaces>,
}

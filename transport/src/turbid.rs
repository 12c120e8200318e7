//! The turbid medium of the `physical` model with its optics: what leaf and wood do with the light that they intercept.
//!
//! The medium itself is part of the file ([`flb_format::turbid`]).

mod phase;

pub use flb_format::turbid::{INCLINATIONS, LeafAngles, Turbid};
pub use phase::Phase;

use flb_format::{BandSurfaces, LeafSurface};

/// What one kind of matter does with the light that it intercepts, in one band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scatter {
    /// Share of it that goes on, 0..=1; the rest is absorbed.
    pub albedo: f64,
    /// Where it goes.
    pub phase: Phase,
}

/// Both kinds of matter in one band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BandScatter {
    /// Leaves.
    pub leaf: Scatter,
    /// Wood.
    pub wood: Scatter,
}

/// What the surfaces of a band do with the light that they intercept: a leaf sends on R + T, T / (R + T) of it through;
/// wood is opaque.
pub fn scatter(band: &BandSurfaces) -> BandScatter {
    let LeafSurface { reflectance, transmittance } = band.leaf;
    let albedo = reflectance + transmittance;
    // A black leaf scatters nothing, so where to does not matter.
    let transmitted = if albedo > 0.0 { transmittance / albedo } else { 0.5 };
    BandScatter {
        leaf: Scatter { albedo, phase: Phase::BiLambert { transmitted } },
        wood: Scatter { albedo: band.wood.reflectance, phase: Phase::BiLambert { transmitted: 0.0 } },
    }
}

#[cfg(test)]
mod tests;

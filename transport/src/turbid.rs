//! The turbid medium of the `physical` model with its optics: what leaf and wood do with the light that they intercept.
//!
//! The medium itself is part of the file ([`flb_format::matter::TurbidMedium`]).

mod facets;
mod phase;

pub(crate) use facets::{Facets, extinction_moment, most_unlike_mean};
pub use flb_format::matter::{INCLINATIONS, LeafAngles, TurbidMedium};
pub use phase::Phase;

use flb_format::matter::{BandSurfaces, LeafSurface};

/// Scattering of intercepted light by one kind of matter, in one band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scatter {
    /// Share of the intercepted light that is scattered, 0..=1; the rest is absorbed.
    pub albedo: f64,
    /// Directions of the scattered light.
    pub phase: Phase,
}

/// Scattering by leaves and by wood in one band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BandScatter {
    /// Scattering by leaves.
    pub leaf: Scatter,
    /// Scattering by wood.
    pub wood: Scatter,
}

/// Returns the scattering by the surfaces of a band: a leaf scatters R + T, T / (R + T) of it through; wood is opaque.
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

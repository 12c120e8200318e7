//! Leaf and wood in the `physical` model: reflectance and transmittance per band, from measured values or from what a
//! leaf is made of.
//!
//! ```text
//! LeafModel -plates, bands-> Surfaces -scatter-> BandScatter of each band
//! ```

mod bands;
mod bark;
mod matter;
mod model;
mod plate;

pub use bands::{Bands, Range, Response};
pub use bark::bark_reflectance;
pub use model::LeafModel;

use flb_format::{BandSurfaces, LeafSurface, Surfaces, WoodSurface};

use crate::turbid::{BandScatter, Phase, Scatter};

/// R, G, B of leaves after Knapp and Carter (1998), who measured 26 species and found them much alike: the back and
/// forward scattered shares of Steele (2009), Table 6.1, taken as reflectance and transmittance. The wood is common bark.
pub fn knapp_carter() -> Surfaces {
    let leaves = [(0.070, 0.055), (0.125, 0.150), (0.040, 0.020)];
    let band = |((name, response), (reflectance, transmittance))| BandSurfaces {
        name,
        leaf: LeafSurface { reflectance, transmittance },
        wood: WoodSurface { reflectance: bands::mean(&response, bark_reflectance) },
    };
    Surfaces { bands: Bands::Rgb.responses().into_iter().zip(leaves).map(band).collect() }
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

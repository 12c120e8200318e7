//! Leaf and wood in the `physical` model: reflectance and transmittance per band, from measured values or from what a
//! leaf is made of.
//!
//! ```text
//! LeafModel -plates, bands-> Surfaces
//! ```

mod bands;
mod bark;
mod matter;
mod model;
mod plate;

pub use bands::{Bands, Range, Response};
pub(crate) use bands::{FROM_XYZ, color_matching};
pub use bark::bark_reflectance;
pub use model::LeafModel;

use flb_format::matter::{BandSurfaces, LeafSurface, Surfaces, WoodSurface};

/// R, G, B of leaves after Knapp and Carter (1998), who measured 26 species and found them much alike: the back and
/// forward scattered shares of Steele (2009), Table 6.1, taken as reflectance and transmittance. The wood is common
/// bark.
pub fn knapp_carter() -> Surfaces {
    let leaves = [(0.070, 0.055), (0.125, 0.150), (0.040, 0.020)];
    let band = |((name, response), (reflectance, transmittance))| BandSurfaces {
        name,
        leaf: LeafSurface { reflectance, transmittance },
        wood: WoodSurface { reflectance: bands::mean(&response, bark_reflectance) },
    };
    Surfaces { bands: Bands::Rgb.responses().into_iter().zip(leaves).map(band).collect() }
}

#[cfg(test)]
mod tests;

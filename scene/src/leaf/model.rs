//! A PROSPECT leaf: from what a leaf is made of to what it does with light (Jacquemoud and Baret, 1990; constituents as
//! in PROSPECT-D, Féret, Gitelson, Noble and Jacquemoud, 2017, without brown pigments).

use flb_format::matter::{BandSurfaces, LeafSurface, Surfaces, WoodSurface};

use super::bands::{Bands, mean};
use super::bark::bark_reflectance;
use super::matter::matter_at;
use super::plate::pile;

/// A leaf. The default is a common green one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeafModel {
    /// N: how many plates scatter as the leaf does. 1 is compact, 1.5 a common broad leaf, 2.5 thick or withered.
    pub structure: f64,
    /// Chlorophyll a and b, ug/cm^2: 10 yellowing, 40 common, 80 dark.
    pub chlorophyll_ug_cm2: f64,
    /// Carotenoids, ug/cm^2: about a fifth of the chlorophyll, more in autumn.
    pub carotenoids_ug_cm2: f64,
    /// Anthocyanins, ug/cm^2: what reddens leaves; 0 in green ones.
    pub anthocyanins_ug_cm2: f64,
    /// Water, as the thickness of a film, cm.
    pub water_cm: f64,
    /// Dry matter, g/cm^2.
    pub dry_matter_g_cm2: f64,
}

impl Default for LeafModel {
    fn default() -> LeafModel {
        LeafModel {
            structure: 1.5,
            chlorophyll_ug_cm2: 40.0,
            carotenoids_ug_cm2: 8.0,
            anthocyanins_ug_cm2: 0.0,
            water_cm: 0.01,
            dry_matter_g_cm2: 0.009,
        }
    }
}

impl LeafModel {
    /// Every parameter: its key, its value, and the least and the greatest that are allowed, which reach far beyond
    /// real leaves.
    pub fn parameters(&self) -> [(&'static str, f64, f64, f64); 6] {
        [
            ("structure", self.structure, 1.0, 5.0),
            ("chlorophyll_ug_cm2", self.chlorophyll_ug_cm2, 0.0, 300.0),
            ("carotenoids_ug_cm2", self.carotenoids_ug_cm2, 0.0, 100.0),
            ("anthocyanins_ug_cm2", self.anthocyanins_ug_cm2, 0.0, 100.0),
            ("water_cm", self.water_cm, 0.0, 0.5),
            ("dry_matter_g_cm2", self.dry_matter_g_cm2, 0.0, 0.1),
        ]
    }

    /// Hemispherical reflectance and transmittance at a wavelength of 400..=900 nm.
    pub fn at(&self, nm: f64) -> (f64, f64) {
        let matter = matter_at(nm);
        let absorption = matter.chlorophyll * self.chlorophyll_ug_cm2
            + matter.carotenoids * self.carotenoids_ug_cm2
            + matter.anthocyanins * self.anthocyanins_ug_cm2
            + matter.water * self.water_cm
            + matter.dry_matter * self.dry_matter_g_cm2;
        pile(self.structure, matter.index, absorption / self.structure)
    }

    /// Computes the leaf's surfaces in `bands`, with the wood of common bark.
    ///
    /// A colour outside sRGB is brought inside: what is negative becomes 0 (the blue transmittance of a green leaf, by
    /// about 0.01), and R + T above 1 (pale yellow leaves, in red) is scaled to 1.
    pub fn surfaces(&self, bands: &Bands) -> Surfaces {
        let band = |(name, response)| {
            let reflectance = mean(&response, |nm| self.at(nm).0).max(0.0);
            let transmittance = mean(&response, |nm| self.at(nm).1).max(0.0);
            // Rounding may leave a sum of 1 + 1e-16: the margin keeps it at most 1.
            let scale = if reflectance + transmittance > 1.0 {
                (1.0 - f64::EPSILON) / (reflectance + transmittance)
            } else {
                1.0
            };
            BandSurfaces {
                name,
                leaf: LeafSurface { reflectance: reflectance * scale, transmittance: transmittance * scale },
                wood: WoodSurface { reflectance: mean(&response, bark_reflectance) },
            }
        };
        Surfaces { bands: bands.responses().into_iter().map(band).collect() }
    }
}

//! Optical parameters of leaf and wood, per band (lighting model, section 2).

use serde::{Deserialize, Serialize};

/// Parameters of one class in one band. `sigma_s = 1 - sigma_a`, so `sigma_t = 1`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClassOptics {
    /// Share of the light that is absorbed per collision, 0..=1.
    pub sigma_a: f64,
    /// Henyey-Greenstein asymmetry, -1 (back) ..= 1 (forward).
    pub g: f64,
}

/// One band: a name and the parameters of both classes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BandOptics {
    /// "R", "G", "B" by default.
    pub name: String,
    /// Optics of leaf sites.
    pub leaf: ClassOptics,
    /// Optics of wood sites.
    pub wood: ClassOptics,
}

/// All bands of a species, in the order of the field's bands.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Optics {
    /// Optics of each band, `[band]`.
    pub bands: Vec<BandOptics>,
}

impl Optics {
    /// The papers' measured defaults (Steele 2009, Table 6.1, after Knapp and Carter 1998);
    /// wood scatters back only.
    pub fn paper() -> Optics {
        let rows = [("R", 0.109, 0.055, 0.070), ("G", 0.091, 0.150, 0.125), ("B", 0.118, 0.020, 0.040)];
        let band = |(name, sigma_a, forward, back): (&str, f64, f64, f64)| BandOptics {
            name: name.to_owned(),
            leaf: ClassOptics { sigma_a, g: (forward - back) / (forward + back) },
            wood: ClassOptics { sigma_a, g: -1.0 },
        };
        Optics { bands: rows.map(band).to_vec() }
    }
}

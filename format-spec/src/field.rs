//! Where sites are ([`Grid`]) and the light that a solve leaves at them ([`Field`]).

use serde::{Deserialize, Serialize};

/// A cubic lattice placed in model space (glTF's: right-handed, +Y up, metres).
/// Lattice axes x, y, z are the model's; the site (x, y, z) covers
/// `origin_m + spacing_m * [x..x+1, y..y+1, z..z+1]` and its texel lies at the site's centre.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Grid {
    /// Sites per edge, N; a power of two, 16..=256.
    pub lattice: u32,
    /// Corner of site (0, 0, 0) with the smallest coordinates, metres.
    pub origin_m: [f64; 3],
    /// Edge of a site, metres.
    pub spacing_m: f64,
}

impl Grid {
    /// N^3.
    pub fn sites(&self) -> usize {
        (self.lattice as usize).pow(3)
    }

    /// Index of a site in `[z][y][x]` arrays, x fastest.
    pub fn index(&self, x: u32, y: u32, z: u32) -> usize {
        let n = self.lattice as usize;
        (z as usize * n + y as usize) * n + x as usize
    }

    /// A point of model space in lattice units: site i covers [i, i + 1).
    pub fn lattice_from_model(&self, point_m: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|axis| (point_m[axis] - self.origin_m[axis]) / self.spacing_m)
    }
}

/// phi of one base: light passing through each site, per band; 1 = the light that enters along the
/// base's direction (18 for the ambient base).
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// Sites per edge, N.
    pub lattice: u32,
    /// Number of bands.
    pub bands: u32,
    /// `[band][z][y][x]`, x fastest.
    pub values: Vec<f32>,
}

impl Field {
    /// A field of zeros.
    pub fn zeros(lattice: u32, bands: u32) -> Field {
        Field { lattice, bands, values: vec![0.0; (lattice as usize).pow(3) * bands as usize] }
    }

    /// The values of one band, `[z][y][x]`.
    pub fn band(&self, band: u32) -> &[f32] {
        let sites = (self.lattice as usize).pow(3);
        &self.values[band as usize * sites..][..sites]
    }
}

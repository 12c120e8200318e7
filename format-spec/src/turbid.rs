//! The turbid medium of the `physical` model: extinction in m^-1 per site.
//!
//! A site is filled with facets that are small, many and independent (Ross, 1981): light along a direction is lost at
//! the rate of the facets' projected area per volume. Extinction depends on the matter alone, never on the band.
//! Leaves may favour directions ([`LeafAngles`]); wood does not.

mod angles;

pub use angles::{INCLINATIONS, LeafAngles};

use crate::Grid;

/// A plant as a turbid medium. Both arrays are `[z][y][x]`, x fastest, N^3 long, finite and not negative; the outer
/// two layers are empty.
#[derive(Debug, Clone, PartialEq)]
pub struct TurbidMedium {
    /// Grid of the sites.
    pub grid: Grid,
    /// Extinction by leaves, m^-1, in the mean over all directions: half of the leaf area density where leaves do not
    /// clump.
    pub leaf_per_m: Vec<f32>,
    /// Extinction by wood, m^-1: a quarter of the area density of closed bodies.
    pub wood_per_m: Vec<f32>,
    /// Distribution of leaf inclinations.
    pub angles: LeafAngles,
}

impl TurbidMedium {
    /// Feeds all values as bytes to a hash.
    pub fn feed(&self, mut hash: impl FnMut(&[u8])) {
        let TurbidMedium { grid, leaf_per_m, wood_per_m, angles } = self;
        hash(&grid.lattice.to_le_bytes());
        for value in grid.origin_m.iter().chain([&grid.spacing_m]).chain(angles.shares()) {
            hash(&value.to_le_bytes());
        }
        for value in leaf_per_m.iter().chain(wood_per_m) {
            hash(&value.to_le_bytes());
        }
    }

    /// Extinction of a site in the mean over all directions, m^-1.
    pub fn extinction(&self, site: usize) -> f32 {
        self.leaf_per_m[site] + self.wood_per_m[site]
    }

    /// Extinction of a site for light along a unit direction whose y (up) component is `up`, m^-1.
    pub fn extinction_along(&self, site: usize, up: f64) -> f64 {
        f64::from(self.leaf_per_m[site]) * self.angles.relative(up) + f64::from(self.wood_per_m[site])
    }

    /// Indices of the sites that hold matter, ascending.
    pub fn sites(&self) -> Vec<u32> {
        (0..self.grid.sites() as u32).filter(|&site| self.extinction(site as usize) > 0.0).collect()
    }
}

#[cfg(test)]
mod tests;

//! The medium that light travels through: density, class and surface area density per site.

use crate::field::Grid;

/// What a site is made of. One site has one class: wood where wood fills more of it than leaf does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum Class {
    /// Nothing: density 0.
    Empty = 0,
    /// Leaf ("green" in the papers).
    Leaf = 1,
    /// Wood ("brown" in the papers).
    Wood = 2,
}

/// A voxelised plant, downsampled to a lattice. Every array is `[z][y][x]`, x fastest, N^3 long.
#[derive(Debug, Clone, PartialEq)]
pub struct Medium {
    /// Where the sites are.
    pub grid: Grid,
    /// Share of the site's fine voxels that are occupied, 0..=1.
    pub density: Vec<f32>,
    /// Class; `Empty` exactly where the density is 0.
    pub class: Vec<Class>,
    /// One-sided leaf area per volume, m^2/m^3, alpha-cut parts left out.
    pub leaf_area_density: Vec<f32>,
    /// Wood surface area per volume, m^2/m^3.
    pub wood_area_density: Vec<f32>,
}

impl Medium {
    /// A medium of empty sites.
    pub fn empty(grid: Grid) -> Medium {
        let zeros = || vec![0.0; grid.sites()];
        Medium {
            grid,
            density: zeros(),
            class: vec![Class::Empty; grid.sites()],
            leaf_area_density: zeros(),
            wood_area_density: zeros(),
        }
    }
}

//! Sites cut into 2x2x2 parts while light is marched, and the means over the parts.

use flb_format::Grid;
use flb_format::beam::{BEAM_RAYS, Beam, Sites, uncollided};
use flb_format::matter::TurbidMedium;

/// A medium on a lattice twice as fine, with the same extinction everywhere.
pub(super) struct Refined {
    pub medium: TurbidMedium,
    /// Non-empty sites of the refined medium.
    pub sites: Vec<u32>,
    places: Sites,
    /// Place of the whole site in the list of non-empty ones, per part.
    whole: Vec<u32>,
    /// Number of whole sites.
    count: usize,
}

/// Parts of a site.
const PARTS: f32 = 8.0;

impl Refined {
    /// `sites` are the medium's non-empty ones.
    pub(super) fn new(medium: &TurbidMedium, sites: &[u32]) -> Refined {
        let Grid { lattice, origin_m, spacing_m } = medium.grid;
        let n = lattice as usize;
        let grid = Grid { lattice: 2 * lattice, origin_m, spacing_m: spacing_m / 2.0 };
        let mut fine = TurbidMedium {
            grid,
            leaf_per_m: vec![0.0; grid.sites()],
            wood_per_m: vec![0.0; grid.sites()],
            angles: medium.angles.clone(),
        };
        let mut parts: Vec<(u32, u32)> = Vec::with_capacity(sites.len() * PARTS as usize);
        for (place, &site) in (0u32..).zip(sites) {
            let site = site as usize;
            let [x, y, z] = medium.grid.site(site).map(|c| 2 * c as usize);
            for part in 0..8 {
                let at = ((z + part / 4) * 2 * n + y + part / 2 % 2) * 2 * n + x + part % 2;
                fine.leaf_per_m[at] = medium.leaf_per_m[site];
                fine.wood_per_m[at] = medium.wood_per_m[site];
                parts.push((at as u32, place));
            }
        }
        parts.sort_unstable();
        let (fine_sites, whole): (Vec<u32>, Vec<u32>) = parts.into_iter().unzip();
        let places = Sites::new(&grid, &fine_sites);
        Refined { medium: fine, sites: fine_sites, places, whole, count: sites.len() }
    }

    /// The beam of a sun in the parts.
    pub(super) fn beam(&self, towards_sun: [f64; 3]) -> Beam {
        // As many per whole site as without parts.
        uncollided(&self.medium, &self.places, &self.sites, towards_sun, BEAM_RAYS / 2)
    }

    /// Values of whole sites, handed to their parts.
    pub(super) fn to_parts<T: Copy>(&self, values: &[T]) -> Vec<T> {
        self.whole.iter().map(|&whole| values[whole as usize]).collect()
    }

    /// Means over the parts of each whole site.
    pub(super) fn means(&self, values: &[f32]) -> Vec<f32> {
        let mut means = vec![0.0; self.count];
        for (&whole, value) in self.whole.iter().zip(values) {
            means[whole as usize] += value / PARTS;
        }
        means
    }
}

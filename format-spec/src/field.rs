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
    /// Number of sites, N^3.
    pub fn sites(&self) -> usize {
        (self.lattice as usize).pow(3)
    }

    /// Index of a site in `[z][y][x]` arrays, x fastest.
    pub fn index(&self, x: u32, y: u32, z: u32) -> usize {
        let n = self.lattice as usize;
        (z as usize * n + y as usize) * n + x as usize
    }

    /// The site at an index of `[z][y][x]` arrays, x fastest: the inverse of [`index`](Self::index).
    pub fn site(&self, index: usize) -> [u32; 3] {
        site_of(index, self.lattice)
    }

    /// Lowest corner of a site in model space, metres.
    pub fn low_m(&self, site: [u32; 3]) -> [f64; 3] {
        self.model_from_lattice(site.map(f64::from))
    }

    /// Middle of a site in model space, metres.
    pub fn middle_m(&self, site: [u32; 3]) -> [f64; 3] {
        self.model_from_lattice(site.map(|c| f64::from(c) + 0.5))
    }

    /// Indices of the sites in the cube of three around a site, itself with them, ascending; those in the lattice.
    pub fn cube_around(&self, site: [u32; 3]) -> impl Iterator<Item = usize> + use<> {
        let grid = *self;
        let [xs, ys, zs] = site.map(|c| c.saturating_sub(1)..=(c + 1).min(self.lattice - 1));
        let rows = zs.flat_map(move |z| ys.clone().map(move |y| (y, z)));
        rows.flat_map(move |(y, z)| xs.clone().map(move |x| grid.index(x, y, z)))
    }

    /// The smallest box that holds some sites, given by their indices: its lowest site, and the site one past its
    /// highest along each axis. `None` of no sites.
    pub fn box_around(&self, sites: &[u32]) -> Option<[[u32; 3]; 2]> {
        let (first, others) = sites.split_first()?;
        let first = self.site(*first as usize);
        let [mut low, mut high] = [first, first];
        for site in others {
            let site = self.site(*site as usize);
            low = std::array::from_fn(|axis| low[axis].min(site[axis]));
            high = std::array::from_fn(|axis| high[axis].max(site[axis]));
        }
        Some([low, high.map(|c| c + 1)])
    }

    /// [`box_around`](Self::box_around) in model space: lowest and highest coordinates, metres.
    pub fn extent_m(&self, sites: &[u32]) -> Option<[[f64; 3]; 2]> {
        let [low, end] = self.box_around(sites)?;
        Some([self.low_m(low), self.low_m(end.map(|c| c - 1)).map(|c| c + self.spacing_m)])
    }

    /// A point in lattice units in model space, metres: the inverse of
    /// [`lattice_from_model`](Self::lattice_from_model).
    pub fn model_from_lattice(&self, point: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|axis| self.origin_m[axis] + self.spacing_m * point[axis])
    }

    /// A point of model space in lattice units: site i covers [i, i + 1).
    pub fn lattice_from_model(&self, point_m: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|axis| (point_m[axis] - self.origin_m[axis]) / self.spacing_m)
    }
}

/// The site at an index of `[z][y][x]` arrays of `lattice` sites along each edge, x fastest; the lattice has fewer than
/// 2^32 sites.
pub fn site_of(index: usize, lattice: u32) -> [u32; 3] {
    let (index, n) = (index as u32, lattice);
    [index % n, index / n % n, index / (n * n)]
}

/// phi of one base: light passing through each site, per band; 1 = the light that enters along the
/// base's direction (18 for the ambient base).
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// Sites per edge, N.
    pub lattice: u32,
    /// Number of bands.
    pub bands: u32,
    /// Values of the field, `[band][z][y][x]`, x fastest.
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

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: Grid = Grid { lattice: 16, origin_m: [-0.8, 0.1, 2.0], spacing_m: 0.3 };

    #[test]
    fn the_site_of_an_index_has_that_index() {
        for index in 0..GRID.sites() {
            let [x, y, z] = GRID.site(index);
            assert_eq!(GRID.index(x, y, z), index);
        }
    }

    #[test]
    fn a_middle_lies_half_a_site_beyond_the_lowest_corner() {
        let (low, middle) = (GRID.low_m([3, 0, 15]), GRID.middle_m([3, 0, 15]));
        let at = [GRID.lattice_from_model(low), GRID.lattice_from_model(middle)];
        for (axis, c) in [3.0, 0.0, 15.0].into_iter().enumerate() {
            assert!((at[0][axis] - c).abs() < 1e-12 && (at[1][axis] - c - 0.5).abs() < 1e-12, "{at:?}");
        }
    }

    #[test]
    fn a_cube_around_a_site_ends_at_the_lattice() {
        let of = |site: [u32; 3]| GRID.cube_around(site).collect::<Vec<_>>();
        let all = of([2, 9, 4]);
        assert_eq!((all.len(), all[13]), (27, GRID.index(2, 9, 4)));
        assert!(all.is_sorted());
        assert_eq!(of([0; 3]).len(), 8);
        assert_eq!(of([GRID.lattice - 1, 0, 4]).len(), 12);
    }

    #[test]
    fn a_box_holds_the_sites_and_no_layer_more() {
        let sites = [[2, 9, 4], [5, 3, 4], [3, 4, 4]].map(|[x, y, z]| GRID.index(x, y, z) as u32);
        assert_eq!(GRID.box_around(&sites), Some([[2, 3, 4], [6, 10, 5]]));
        let [low, high] = GRID.extent_m(&sites).expect("sites");
        assert_eq!(low, GRID.low_m([2, 3, 4]));
        for (high, end) in high.into_iter().zip(GRID.low_m([6, 10, 5])) {
            assert!((high - end).abs() < 1e-12, "{high}, expected {end}");
        }
        assert_eq!((GRID.box_around(&[]), GRID.extent_m(&[])), (None, None));
    }
}

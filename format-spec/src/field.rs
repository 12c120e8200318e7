//! Where sites are ([`Grid`]) and the light that a solve leaves at them ([`Field`]).

use std::borrow::Cow;
use std::sync::Arc;

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
///
/// Fields of a `physical` bake have one value for each site with matter, and one for each cube of empty sites that
/// takes the mean of the matter near it. They are held so ([`CellBand`]): a whole array of an oak takes 14 times as
/// much memory.
#[derive(Debug, Clone)]
pub struct Field {
    /// Sites per edge, N.
    pub lattice: u32,
    /// Number of bands.
    pub bands: u32,
    values: Values,
}

#[derive(Debug, Clone)]
enum Values {
    /// `[band][z][y][x]`, x fastest.
    Whole(Vec<f32>),
    /// One per band.
    Cells(Vec<CellBand>),
}

/// Numbers of the values that sites have, `[z][y][x]`. Bands and fields share it: a clone is the same list.
#[derive(Debug, Clone)]
pub struct Cells {
    of_sites: Arc<[u32]>,
    count: usize,
}

impl Cells {
    /// For each site, `[z][y][x]`, the number of its value.
    pub fn new(of_sites: Vec<u32>) -> Cells {
        let count = of_sites.iter().max().map_or(0, |&largest| largest as usize + 1);
        Cells { of_sites: of_sites.into(), count }
    }

    /// The number of each site, `[z][y][x]`.
    pub fn of_sites(&self) -> &[u32] {
        &self.of_sites
    }

    /// Number of values that a band needs at least: 1 more than the largest number.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Whether both are one list.
    pub fn is_same(&self, other: &Cells) -> bool {
        Arc::ptr_eq(&self.of_sites, &other.of_sites)
    }
}

/// One band of a field in which many sites share a value.
#[derive(Debug, Clone)]
pub struct CellBand {
    cells: Cells,
    values: Vec<f32>,
}

impl CellBand {
    /// Values, and which of them each site has.
    ///
    /// # Panics
    /// If there are fewer values than [`Cells::count`].
    pub fn new(cells: Cells, values: Vec<f32>) -> CellBand {
        assert!(values.len() >= cells.count, "a site has no value");
        CellBand { cells, values }
    }

    /// Numbers of the values that sites have.
    pub fn cells(&self) -> &Cells {
        &self.cells
    }

    /// The values, each once.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    fn of_sites(&self) -> impl Iterator<Item = f32> {
        self.cells.of_sites.iter().map(|&cell| self.values[cell as usize])
    }
}

impl Field {
    /// A field of zeros.
    pub fn zeros(lattice: u32, bands: u32) -> Field {
        Field::new(lattice, bands, vec![0.0; (lattice as usize).pow(3) * bands as usize])
    }

    /// A field of values `[band][z][y][x]`, x fastest.
    pub fn new(lattice: u32, bands: u32, values: Vec<f32>) -> Field {
        Field { lattice, bands, values: Values::Whole(values) }
    }

    /// A field of bands in which many sites share a value.
    pub fn of_cells(lattice: u32, bands: Vec<CellBand>) -> Field {
        Field { lattice, bands: bands.len() as u32, values: Values::Cells(bands) }
    }

    fn sites(&self) -> usize {
        (self.lattice as usize).pow(3)
    }

    /// Number of values: sites times bands, if the field has the shape that it states.
    pub fn len(&self) -> usize {
        match &self.values {
            Values::Whole(values) => values.len(),
            Values::Cells(bands) => bands.iter().map(|band| band.cells.of_sites.len()).sum(),
        }
    }

    /// Whether there are no values.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The values, `[band][z][y][x]`, x fastest.
    pub fn values(&self) -> Cow<'_, [f32]> {
        match &self.values {
            Values::Whole(values) => Cow::Borrowed(values),
            Values::Cells(bands) => bands.iter().flat_map(CellBand::of_sites).collect(),
        }
    }

    /// The values for writing, `[band][z][y][x]`, x fastest: the field is a whole array from now on.
    pub fn values_mut(&mut self) -> &mut [f32] {
        if let Values::Cells(bands) = &self.values {
            self.values = Values::Whole(bands.iter().flat_map(CellBand::of_sites).collect());
        }
        match &mut self.values {
            Values::Whole(values) => values,
            Values::Cells(_) => unreachable!("it was made whole"),
        }
    }

    /// The values of one band, `[z][y][x]`.
    pub fn band(&self, band: u32) -> Cow<'_, [f32]> {
        match &self.values {
            Values::Whole(values) => Cow::Borrowed(&values[band as usize * self.sites()..][..self.sites()]),
            Values::Cells(bands) => bands[band as usize].of_sites().collect(),
        }
    }

    /// The value of a site, given by its index in `[z][y][x]`.
    #[inline]
    pub fn value(&self, band: u32, site: usize) -> f32 {
        match &self.values {
            Values::Whole(values) => values[band as usize * self.sites() + site],
            Values::Cells(bands) => {
                let CellBand { cells, values } = &bands[band as usize];
                values[cells.of_sites[site] as usize]
            }
        }
    }

    /// Band and site of the first value that `is` holds for.
    pub fn position(&self, is: impl Fn(&f32) -> bool) -> Option<(u32, usize)> {
        let of_band = |band: u32| match &self.values {
            // Most bands have no such value, and each cell is one of some site.
            Values::Cells(bands) if !bands[band as usize].values.iter().any(&is) => None,
            _ => Some((band, self.band(band).iter().position(&is)?)),
        };
        (0..self.bands).find_map(of_band)
    }

    /// The values of so many sites along x, from the index of the first in `[z][y][x]`.
    #[inline]
    pub fn row<const LENGTH: usize>(&self, band: u32, first: usize) -> [f32; LENGTH] {
        match &self.values {
            Values::Whole(values) => {
                let values = &values[band as usize * self.sites() + first..][..LENGTH];
                std::array::from_fn(|x| values[x])
            }
            Values::Cells(bands) => {
                let CellBand { cells, values } = &bands[band as usize];
                let cells = &cells.of_sites[first..][..LENGTH];
                std::array::from_fn(|x| values[cells[x] as usize])
            }
        }
    }

    /// Bands in which many sites share a value, if the field is held so.
    pub fn cells(&self) -> Option<&[CellBand]> {
        match &self.values {
            Values::Whole(_) => None,
            Values::Cells(bands) => Some(bands),
        }
    }

    /// Writes a band anew.
    ///
    /// # Panics
    /// If the field has no such band, or the band another number of sites.
    pub fn set_band(&mut self, band: u32, of_band: CellBand) {
        let sites = self.sites();
        assert_eq!(of_band.cells.of_sites.len(), sites, "a band has one value a site");
        match &mut self.values {
            Values::Whole(values) => {
                let values = values[band as usize * sites..][..sites].iter_mut();
                values.zip(of_band.of_sites()).for_each(|(value, of_site)| *value = of_site);
            }
            Values::Cells(bands) => bands[band as usize] = of_band,
        }
    }
}

impl PartialEq for Field {
    fn eq(&self, other: &Field) -> bool {
        self.lattice == other.lattice && self.bands == other.bands && self.values() == other.values()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: Grid = Grid { lattice: 16, origin_m: [-0.8, 0.1, 2.0], spacing_m: 0.3 };

    #[test]
    fn a_field_of_cells_reads_as_the_whole_array_and_becomes_it_where_it_is_written() {
        let cells = Cells::new((0..16_u32.pow(3)).map(|site| site / 5 % 7).collect());
        let of_band = |factor: f32| -> Vec<f32> { (0..7).map(|cell| factor * cell as f32).collect() };
        let band = |factor| CellBand::new(cells.clone(), of_band(factor));
        let mut shared = Field::of_cells(16, vec![band(1.0), band(-2.0)]);
        let values: Vec<f32> = [1.0, -2.0]
            .iter()
            .flat_map(|factor| cells.of_sites().iter().map(move |&cell| factor * cell as f32))
            .collect();
        let mut whole = Field::new(16, 2, values.clone());
        assert_eq!(*shared.values(), values);
        assert_eq!((shared.len(), &shared), (values.len(), &whole));
        for field in [&shared, &whole] {
            assert_eq!(*field.band(1), values[4096..]);
            assert_eq!(field.value(1, 33), values[4096 + 33]);
            assert_eq!(field.row::<4>(0, 17), values[17..21]);
            assert_eq!(field.position(|value| *value == -12.0), Some((1, 30)));
            assert_eq!(field.position(|value| *value > 6.0), None);
        }
        for field in [&mut shared, &mut whole] {
            field.set_band(0, band(3.0));
        }
        assert_eq!(shared, whole);
        assert!(shared.cells().is_some());
        shared.values_mut()[7] = 99.0;
        assert_ne!(shared, whole);
        whole.values_mut()[7] = 99.0;
        assert_eq!(shared, whole);
        assert!(shared.cells().is_none());
    }

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

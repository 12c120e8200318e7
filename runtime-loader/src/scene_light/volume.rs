//! One value per site that holds matter, sampled between them.

use flb_format::Grid;
use flb_format::sample::corners;

use super::export::FlatVolume;

/// Values on a lattice; NaN where nothing is known.
pub(super) struct Volume {
    grid: Grid,
    /// `[z][y][x]`
    values: Vec<f32>,
    /// Mean of what is known; 0 where nothing is.
    pub mean: f32,
}

impl Volume {
    /// `value` at the middles of `sites`.
    pub(super) fn of(grid: &Grid, sites: &[u32], value: impl Fn([f32; 3]) -> f32) -> Volume {
        let mut values = vec![f32::NAN; grid.sites()];
        let mut sum = 0.0;
        for &site in sites {
            let light = value(grid.middle_m(grid.site(site as usize)).map(|c| c as f32));
            values[site as usize] = light;
            sum += f64::from(light);
        }
        let mean = if sites.is_empty() { 0.0 } else { (sum / sites.len() as f64) as f32 };
        Volume { grid: *grid, values, mean }
    }

    pub(super) fn flat(&self) -> FlatVolume<'_> {
        FlatVolume { grid: &self.grid, values: &self.values, mean: self.mean }
    }

    pub(super) fn size_bytes(&self) -> usize {
        size_of_val(&self.values[..])
    }

    /// The mean of the known ones of the eight values around a point, by their trilinear weights; `None` where none is
    /// known.
    pub(super) fn at(&self, point_m: [f64; 3]) -> Option<f32> {
        let n = self.grid.lattice as usize;
        let at = self.grid.lattice_from_model(point_m).map(|c| (c - 0.5).clamp(0.0, (n - 1) as f64));
        let first = at.map(|c| (c as usize).min(n - 2));
        let t: [f32; 3] = std::array::from_fn(|axis| (at[axis] - first[axis] as f64) as f32);
        let (mut sum, mut weights) = (0.0, 0.0);
        for (upper, weight) in corners(t) {
            let [x, y, z] = [0, 1, 2].map(|axis| first[axis] + upper[axis]);
            let value = self.values[(z * n + y) * n + x];
            if weight > 0.0 && !value.is_nan() {
                sum += weight * value;
                weights += weight;
            }
        }
        (weights > 0.0).then(|| sum / weights)
    }
}

//! A grid across the sun's rays, with the instances that each cell's rays may meet: a shadow ray visits one list and no
//! tree (the papers' sun-aligned grid). It is made anew for every sun.

use glam::DVec3;

use super::placed::{Extent, WorldRay};

/// Cells along the edge of the mean instance's box.
const CELLS_PER_BOX: f64 = 4.0;
/// Cells along an edge, at most.
const MAX_CELLS: f64 = 1024.0;
/// A box is listed in cells that it misses by this share of a cell, which is more than a projection's rounding in f64.
pub(super) const PAD: f64 = 1e-6;

pub(crate) struct SunGrid {
    /// Unit vectors across the rays.
    pub across: [DVec3; 2],
    pub low: [f64; 2],
    pub per_m: f64,
    pub count: [u32; 2],
    /// `[row][column]` and one more: where the list of each cell starts.
    pub starts: Vec<u32>,
    /// Distance towards the sun that a box reaches, and its instance; farthest first in each cell.
    pub lists: Vec<(f64, u32)>,
    towards: DVec3,
    pad: f64,
}

impl SunGrid {
    /// Of the boxes of all instances. `towards` is the unit vector towards the sun; `pad` the share of a cell by which
    /// boxes may miss one that they are listed in.
    pub(crate) fn new(extents: impl Iterator<Item = Extent>, towards: DVec3, pad: f64) -> SunGrid {
        let across = [towards.any_orthonormal_vector(), towards.cross(towards.any_orthonormal_vector())];
        let mut boxes: Vec<(f64, u32, [f64; 4])> = (0..)
            .zip(extents)
            .map(|(index, extent)| {
                let [low, high] = [0, 1].map(|end| {
                    across.map(|axis| {
                        reach(&extent, if end == 0 { -axis } else { axis }) * (2.0 * f64::from(end) - 1.0)
                    })
                });
                (reach(&extent, towards), index, [low[0], low[1], high[0], high[1]])
            })
            .collect();
        boxes.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let (mut low, mut high, mut edges) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2], 0.0);
        for (_, _, [left, top, right, bottom]) in &boxes {
            low = [low[0].min(*left), low[1].min(*top)];
            high = [high[0].max(*right), high[1].max(*bottom)];
            edges += (right - left + bottom - top) / 2.0;
        }
        let widest = (high[0] - low[0]).max(high[1] - low[1]);
        let edge_m = (edges / boxes.len().max(1) as f64 / CELLS_PER_BOX).max(widest / MAX_CELLS).max(1e-9);
        let per_m = 1.0 / edge_m;
        let count = [0, 1].map(|axis| (((high[axis] - low[axis]) * per_m).ceil().max(1.0)) as u32);
        let mut grid =
            SunGrid { across, low, per_m, count, starts: Vec::new(), lists: Vec::new(), towards, pad };
        let mut starts = vec![0u32; (count[0] * count[1]) as usize + 1];
        for (_, _, rectangle) in &boxes {
            grid.cells(rectangle).for_each(|cell| starts[cell + 1] += 1);
        }
        for cell in 1..starts.len() {
            starts[cell] += starts[cell - 1];
        }
        let mut lists = vec![(0.0, 0); starts[starts.len() - 1] as usize];
        let mut next = starts.clone();
        for (reach_m, index, rectangle) in &boxes {
            for cell in grid.cells(rectangle) {
                lists[next[cell] as usize] = (*reach_m, *index);
                next[cell] += 1;
            }
        }
        grid.starts = starts;
        grid.lists = lists;
        grid
    }

    /// Instances whose boxes a ray towards the sun may meet.
    pub(crate) fn ahead(&self, ray: &WorldRay) -> impl Iterator<Item = u32> + '_ {
        let at = [0, 1].map(|axis| (ray.origin.dot(self.across[axis]) - self.low[axis]) * self.per_m);
        let is_inside =
            (0..2).all(|axis| at[axis] >= -self.pad && at[axis] <= f64::from(self.count[axis]) + self.pad);
        let list = match is_inside && !self.lists.is_empty() {
            true => {
                let [column, row] = [0, 1].map(|axis| (at[axis].max(0.0) as u32).min(self.count[axis] - 1));
                let cell = (row * self.count[0] + column) as usize;
                &self.lists[self.starts[cell] as usize..self.starts[cell + 1] as usize]
            }
            false => &[],
        };
        let here = ray.origin.dot(self.towards);
        list.iter().take_while(move |(reach_m, _)| *reach_m >= here).map(|(_, index)| *index)
    }

    fn cells(&self, [left, top, right, bottom]: &[f64; 4]) -> impl Iterator<Item = usize> + use<> {
        let columns = self.count[0];
        let cell = |axis: usize, value: f64| {
            (((value - self.low[axis]) * self.per_m).max(0.0) as u32).min(self.count[axis] - 1)
        };
        let pad = self.pad / self.per_m;
        let (first, last) = (cell(0, left - pad), cell(0, right + pad));
        (cell(1, top - pad)..=cell(1, bottom + pad))
            .flat_map(move |row| (first..=last).map(move |column| (row * columns + column) as usize))
    }
}

/// How far a box reaches along a direction.
fn reach(extent: &Extent, direction: DVec3) -> f64 {
    let farthest = DVec3::select(direction.cmpge(DVec3::ZERO), extent.max, extent.min);
    farthest.dot(direction)
}

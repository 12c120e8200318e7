//! A grid over the picture, with the instances that each cell may see in the order of their distance: primary rays
//! visit one list and no tree (the papers' perspective grid, flat as theirs: it holds boxes of instances, not
//! triangles).

use super::placed::Extent;
use crate::lens::Lens;

/// Pixels along the edge of a cell.
pub(super) const CELL_PX: u32 = 16;
/// A box is listed in cells that it misses by this many pixels, which is more than a projection's rounding.
const PAD_PX: f64 = 0.01;

pub(crate) struct ViewGrid {
    pub columns: u32,
    /// `[row][column]` and one more: where the list of each cell starts.
    pub starts: Vec<u32>,
    /// Distance from the eye to the box, and the instance; nearest first in each cell.
    pub lists: Vec<(f64, u32)>,
}

impl ViewGrid {
    /// Of the boxes of all instances, for a picture of `size` pixels.
    pub(crate) fn new(extents: impl Iterator<Item = Extent>, lens: &Lens, size: [u32; 2]) -> ViewGrid {
        let [columns, rows] = size.map(|edge| edge.div_ceil(CELL_PX));
        let mut seen: Vec<(f64, u32, [u32; 4])> = (0..)
            .zip(extents)
            .filter_map(|(index, extent)| {
                let cells = cells(&extent, lens, [columns, rows])?;
                Some((extent.distance(lens.position), index, cells))
            })
            .collect();
        // In this order the lists fill up sorted.
        seen.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut starts = vec![0u32; (columns * rows) as usize + 1];
        let each = |[left, top, right, bottom]: [u32; 4]| {
            (top..=bottom)
                .flat_map(move |row| (left..=right).map(move |column| (row * columns + column) as usize))
        };
        for (_, _, cells) in &seen {
            each(*cells).for_each(|cell| starts[cell + 1] += 1);
        }
        for cell in 1..starts.len() {
            starts[cell] += starts[cell - 1];
        }
        let mut lists = vec![(0.0, 0); starts[starts.len() - 1] as usize];
        let mut next = starts.clone();
        for (distance_m, index, cells) in seen {
            for cell in each(cells) {
                lists[next[cell] as usize] = (distance_m, index);
                next[cell] += 1;
            }
        }
        ViewGrid { columns, starts, lists }
    }

    /// What a ray through a point of the picture may meet, nearest box first.
    pub(crate) fn list(&self, x: f64, y: f64) -> &[(f64, u32)] {
        let [column, row] = [x, y].map(|pixel| pixel as u32 / CELL_PX);
        let cell = (row * self.columns + column) as usize;
        &self.lists[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }
}

/// First column and row, last column and row of the cells that a box is seen in.
fn cells(extent: &Extent, lens: &Lens, count: [u32; 2]) -> Option<[u32; 4]> {
    let corners = extent.corners();
    if corners.iter().all(|corner| lens.is_behind(*corner)) {
        return None;
    }
    let [columns, rows] = count.map(|count| f64::from(count - 1));
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for corner in corners {
        // A box that reaches behind the eye may be seen anywhere.
        let Some(at) = lens.project(corner) else { return Some([0, 0, columns as u32, rows as u32]) };
        for axis in 0..2 {
            low[axis] = low[axis].min(at[axis] - PAD_PX);
            high[axis] = high[axis].max(at[axis] + PAD_PX);
        }
    }
    let [left, top, right, bottom] =
        [low[0], low[1], high[0], high[1]].map(|pixel| (pixel / f64::from(CELL_PX)).floor());
    if right < 0.0 || bottom < 0.0 || left > columns || top > rows {
        return None;
    }
    Some([left.max(0.0) as u32, top.max(0.0) as u32, right.min(columns) as u32, bottom.min(rows) as u32])
}

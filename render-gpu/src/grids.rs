//! The papers' grids, as the CPU made them, to the words by which shaders walk them (`shaders/*_by_grid.wgsl` say in
//! which order).

use flb_render::forest::export::grids::{FlatGrid, FlatSunGrid, FlatViewGrid};

use crate::layout::Words;
use crate::stand::Stand;

/// Share of a cell by which boxes miss cells of a [`FlatSunGrid`] that they are listed in: f32 is off by less, unless a
/// cell is a hundred-thousandth of the stand. `SUN_PAD`
pub(crate) const SUN_PAD: f64 = 0.01;
/// Words before where lists start, of a model's grid; `GRID_HEAD`.
pub(crate) const GRID_HEAD: u32 = 10;
/// Of a sun's; `SUN_HEAD`.
pub(crate) const SUN_HEAD: u32 = 12;
/// Distances are given less this share, and reaches more, since shaders round.
const ROUNDED: f64 = 1e-5;

/// Adds a model's grid, whose triangles begin at this place, and gives back its first word.
pub(crate) fn grid_words(words: &mut Vec<u32>, grid: &FlatGrid, first_triangle: u32) -> u32 {
    let first = words.len() as u32;
    let mut head = Words::default();
    head.floats(grid.min).floats(grid.per_m);
    words.extend(head.0);
    words.extend(grid.count);
    words.push(GRID_HEAD + grid.starts.len() as u32);
    words.extend(&grid.starts);
    words.extend(grid.lists.iter().map(|triangle| triangle + first_triangle));
    first
}

/// A grid over a picture. `places` are those of instances in the tree's order.
pub(crate) fn picture_words(grid: &FlatViewGrid, places: &[u32]) -> Vec<u32> {
    let mut words = Words(vec![grid.columns, 2 + grid.starts.len() as u32]);
    words.0.extend(&grid.starts);
    for &(distance_m, instance) in &grid.lists {
        words.rounded([distance_m * (1.0 - ROUNDED)]).whole(places[instance as usize]);
    }
    words.0
}

/// A grid across the rays of a sun (unit).
pub(crate) fn sun_words(
    grid: &FlatSunGrid,
    places: &[u32],
    towards_sun: [f64; 3],
    stand: &Stand,
) -> Vec<u32> {
    let from_middle = |axis: [f64; 3]| (0..3).map(|at| axis[at] * stand.center_m[at]).sum::<f64>();
    let [low, high] = stand.box_m;
    let slack_m = ROUNDED * (0..3).map(|axis| high[axis] - low[axis]).sum::<f64>();
    let mut words = Words::default();
    words.rounded(grid.across[0]).rounded(grid.across[1]);
    words.rounded([0, 1].map(|axis| grid.low[axis] - from_middle(grid.across[axis])));
    words.rounded([grid.per_m]).whole(grid.count[0]).whole(grid.count[1]);
    words.whole(SUN_HEAD + grid.starts.len() as u32);
    words.0.extend(&grid.starts);
    let middle_m = from_middle(towards_sun);
    for &(reach_m, instance) in &grid.lists {
        words.rounded([reach_m - middle_m + slack_m]).whole(places[instance as usize]);
    }
    words.0
}

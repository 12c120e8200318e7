//! Bodies of matter for the extremes.

use flb_format::Medium;
use flb_format::matter::Class;

use super::super::media::{empty, put};

/// A box of sites from `low` to `high`, exclusive, `wall` sites thick and hollow inside.
pub(super) fn hollow(lattice: u32, [low, high]: [u32; 2], wall: u32, class: Class, density: f32) -> Medium {
    let inside = low + wall..high - wall;
    let is_wall = |site: [u32; 3]| !site.iter().all(|c| inside.contains(c));
    filled(lattice, [[low, high]; 3], class, |site| if is_wall(site) { density } else { 0.0 })
}

/// A box of sites of one density.
pub(super) fn solid(lattice: u32, ranges: [[u32; 2]; 3], class: Class, density: f32) -> Medium {
    filled(lattice, ranges, class, |_| density)
}

/// A box of sites with a density of their own.
pub(super) fn filled(
    lattice: u32,
    ranges: [[u32; 2]; 3],
    class: Class,
    density: impl Fn([u32; 3]) -> f32,
) -> Medium {
    let mut medium = empty(lattice);
    let [x, y, z] = ranges.map(|[low, high]| low..high);
    for z in z {
        for y in y.clone() {
            for x in x.clone() {
                put(&mut medium, [x, y, z], class, density([x, y, z]));
            }
        }
    }
    medium
}

//! Turbid media for the extremes.

use flb_format::Grid;
use flb_format::matter::{LeafAngles, TurbidMedium};

/// Sites along an edge of the lattice: few enough for hundreds of f64 solves.
pub(super) const N: u32 = 16;

/// All sites but the two outer layers.
pub(super) const ALL: [[u32; 2]; 3] = [[2, N - 2]; 3];

/// Edge of a site, metres.
const SPACING_M: f64 = 0.5;

/// Optical depths of an edge of each site, by leaf and by wood.
pub(super) fn filled(depths: impl Fn([u32; 3]) -> [f64; 2]) -> TurbidMedium {
    let grid = Grid { lattice: N, origin_m: [0.0; 3], spacing_m: SPACING_M };
    let per_m = (0..grid.sites()).map(|i| depths(grid.site(i)).map(|depth| (depth / SPACING_M) as f32));
    let (leaf_per_m, wood_per_m) = per_m.map(|[leaf, wood]| (leaf, wood)).unzip();
    TurbidMedium { grid, leaf_per_m, wood_per_m, angles: LeafAngles::spherical() }
}

/// A box of leaf.
pub(super) fn solid(ranges: [[u32; 2]; 3], depth: f64) -> TurbidMedium {
    filled(|site| [if is_in(site, ranges) { depth } else { 0.0 }, 0.0])
}

/// A closed box, its walls two sites thick.
pub(super) fn hollow(leaf: f64, wood: f64) -> TurbidMedium {
    let [outside, inside] = [[[3, 13]; 3], [[5, 11]; 3]];
    filled(|site| if is_in(site, outside) && !is_in(site, inside) { [leaf, wood] } else { [0.0; 2] })
}

/// Clumps of leaves of very different density around a trunk.
pub(super) fn tree() -> TurbidMedium {
    filled(|site| {
        let [x, y, z] = site.map(|c| (f64::from(c) + 0.5) / f64::from(N) * 2.0 - 1.0);
        let is_crown = is_in(site, ALL) && x * x + y * y + z * z < 0.8;
        let wave = libm::sin(7.0 * x + 2.0 * z) * libm::sin(5.0 * y - 1.0) * libm::sin(6.0 * z + 3.0 * y);
        let leaf = if is_crown && wave > 0.1 { 2.0 * wave } else { 0.0 };
        let wood = if is_in(site, [[7, 9], [2, 9], [7, 9]]) { 4.0 } else { 0.0 };
        [leaf, wood]
    })
}

fn is_in(site: [u32; 3], ranges: [[u32; 2]; 3]) -> bool {
    site.iter().zip(ranges).all(|(c, [low, high])| (low..high).contains(c))
}

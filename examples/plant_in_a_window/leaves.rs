//! Leaves to draw, where a program has no mesh: as many as the medium of the file says, turned and placed at random.
//!
//! ```text
//! TurbidMedium -area of each site-> triangles
//! ```

use flb_format::matter::TurbidMedium;

/// Position and normal in the frame of the model, and 0 for a leaf or 1 for wood.
pub(crate) type Vertex = [f32; 7];

/// Leaves of a plant, about.
const LEAVES: f32 = 8_000.0;
/// Two triangles, in the plane of a leaf of area 1 that is twice as long as wide.
const CORNERS: [[f32; 2]; 6] = [[0.0, -1.0], [0.5, 0.0], [0.0, 1.0], [0.0, -1.0], [0.0, 1.0], [-0.5, 0.0]];

/// Leaves whose area is that of the medium: half of the area per volume is the extinction in the mean over all
/// directions, m^-1.
pub(crate) fn vertices(turbid: &TurbidMedium) -> Vec<Vertex> {
    let grid = &turbid.grid;
    let area_of_m2 = |per_m: f32| 2.0 * per_m * (grid.spacing_m * grid.spacing_m * grid.spacing_m) as f32;
    let sites = turbid.sites();
    let total_m2: f32 = sites.iter().map(|&site| area_of_m2(turbid.extinction(site as usize))).sum();
    let leaf_m2 = total_m2 / LEAVES;
    let edge_m = leaf_m2.sqrt();
    let mut random = Random(1);
    let mut vertices = Vec::new();
    for site in sites {
        let n = grid.lattice;
        let low = [site % n, site / n % n, site / (n * n)];
        let index = site as usize;
        for (per_m, is_wood) in [(turbid.leaf_per_m[index], 0.0), (turbid.wood_per_m[index], 1.0)] {
            // A part of a leaf is a whole one with that probability.
            let count = (area_of_m2(per_m) / leaf_m2 + random.part()) as u32;
            for _ in 0..count {
                let place: [f32; 3] = std::array::from_fn(|axis| {
                    let site = f64::from(low[axis]) + f64::from(random.part());
                    (grid.origin_m[axis] + site * grid.spacing_m) as f32
                });
                let [right, up, normal] = random.axes();
                vertices.extend(CORNERS.map(|[u, v]| {
                    let at: [f32; 3] =
                        std::array::from_fn(|axis| place[axis] + edge_m * (u * right[axis] + v * up[axis]));
                    [at[0], at[1], at[2], normal[0], normal[1], normal[2], is_wood]
                }));
            }
        }
    }
    vertices
}

/// The same numbers everywhere (PCG's output function on a counter).
struct Random(u32);

impl Random {
    /// From 0 to below 1.
    fn part(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((self.0 >> ((self.0 >> 28) + 4)) ^ self.0).wrapping_mul(277_803_737);
        ((word ^ (word >> 22)) >> 8) as f32 / (1 << 24) as f32
    }

    /// Three axes at right angles, the last even over all directions.
    fn axes(&mut self) -> [[f32; 3]; 3] {
        let (z, turn) = (2.0 * self.part() - 1.0, std::f32::consts::TAU * self.part());
        let (across, sin, cos) = ((1.0 - z * z).max(0.0).sqrt(), libm::sinf(turn), libm::cosf(turn));
        [[-sin, 0.0, cos], [-z * cos, across, -z * sin], [across * cos, z, across * sin]]
    }
}

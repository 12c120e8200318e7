//! Media made by code: for the extremes, tests and benches of the solvers.

use flb_format::matter::Class;
use flb_format::{Grid, Medium};

/// An empty medium.
pub fn empty(lattice: u32) -> Medium {
    let grid = Grid { lattice, origin_m: [0.0; 3], spacing_m: 0.1 };
    Medium::empty(grid)
}

/// Sets one site.
pub fn put(medium: &mut Medium, site: [u32; 3], class: Class, density: f32) {
    let index = medium.grid.index(site[0], site[1], site[2]);
    medium.density[index] = density;
    medium.class[index] = if density == 0.0 { Class::Empty } else { class };
}

/// A tree: a tapering trunk of wood, and clumps of leaves of scattered density in a crown, some near solid.
/// Every number comes from `seed`; about 5 % of the sites are non-empty.
pub fn tree(lattice: u32, seed: u64) -> Medium {
    let mut medium = empty(lattice);
    let mut random = Random(seed.wrapping_mul(2).wrapping_add(1));
    let n = f64::from(lattice);
    let clumps: Vec<([f64; 3], f64, f64)> = (0..60)
        .map(|_| {
            let height = 0.35 + 0.55 * random.unit();
            let reach = 0.36 * (1.0 - (height - 0.55).abs() * 1.3);
            let (u, v) = (random.unit() * 2.0 - 1.0, random.unit() * 2.0 - 1.0);
            ([0.5 + u * reach, height, 0.5 + v * reach], 0.03 + 0.05 * random.unit(), random.unit())
        })
        .collect();
    for z in 2..lattice - 2 {
        for y in 2..lattice - 2 {
            for x in 2..lattice - 2 {
                let point = [x, y, z].map(|c| (f64::from(c) + 0.5) / n);
                let draw = random.unit();
                let off = [point[0] - 0.5, point[2] - 0.5];
                let from_axis = (off[0] * off[0] + off[1] * off[1]).sqrt();
                let radius = 0.035 * (1.0 - point[1]) + 0.004;
                if from_axis < radius && point[1] < 0.8 {
                    let density = if from_axis < radius * 0.6 { 1.0 } else { 0.2 + 0.6 * draw };
                    put(&mut medium, [x, y, z], Class::Wood, density as f32);
                    continue;
                }
                let mut density: f64 = 0.0;
                for (center, size, thick) in &clumps {
                    let distance: f64 =
                        center.iter().zip(point).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
                    if distance < *size && draw < 0.6 {
                        density =
                            density.max((0.05 + 0.5 * thick * draw * (1.0 - distance / size) * 3.0).min(1.0));
                    }
                }
                if density > 0.0 {
                    put(&mut medium, [x, y, z], Class::Leaf, density as f32);
                }
            }
        }
    }
    medium
}

/// A 64-bit linear congruential generator (Knuth's MMIX constants); upper bits only.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

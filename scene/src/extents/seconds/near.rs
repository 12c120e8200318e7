//! Which of some points are near to a triangle.

use glam::{DVec3, I64Vec3};

/// Cubes that the surroundings of a triangle may meet: one that meets more is compared with all points.
const MAX_CUBES: i64 = 512;
/// Cubes along the plant's longest edge.
const MAX_ACROSS: f64 = 64.0;

/// Points that are looked at, by the cubes of a lattice.
pub(super) struct Near {
    cubes_per_m: f64,
    /// The farthest that a triangle lies from a point that it doubles.
    reach_m: f64,
    /// Number of places, a power of two.
    places: usize,
    /// `[place]`: where its list starts, and the end of the last.
    starts: Vec<u32>,
    /// `(place, number of the point)`, sorted.
    lists: Vec<(u32, u32)>,
    /// A bit each place: whether its list has an entry. Most have none, and bits stay in the fastest memory.
    is_filled: Vec<u64>,
}

impl Near {
    /// Puts points in their cubes, which are twice as long as `size_m`, the size of most triangles, at least.
    pub(super) fn of(points: &[DVec3], reach_m: f64, size_m: f64, longest_m: f64) -> Near {
        // As large as most of the leaf's triangles, which so meet few cubes.
        let cube_m = (2.0 * size_m).max(longest_m / MAX_ACROSS);
        // Several times their entries: most leaves find an empty list.
        let places = (points.len() * 32).next_power_of_two();
        let mut near = Near {
            cubes_per_m: 1.0 / cube_m,
            reach_m,
            places,
            starts: vec![0; places + 1],
            lists: Vec::new(),
            is_filled: vec![0; places.div_ceil(64)],
        };
        let of_points = (0u32..).zip(points).map(|(number, point)| (near.place(near.cube(*point)), number));
        near.lists = of_points.collect();
        near.lists.sort_unstable();
        for (place, _) in &near.lists {
            near.starts[*place as usize + 1] += 1;
            near.is_filled[*place as usize / 64] |= 1 << (place % 64);
        }
        (0..places).for_each(|place| near.starts[place + 1] += near.starts[place]);
        near
    }

    /// Calls `meet` with the numbers of points that may be near to a triangle, some of them more than once.
    pub(super) fn each(&self, corners: &[DVec3; 3], mut meet: impl FnMut(u32)) {
        let [a, b, c] = *corners;
        let low = self.cube(a.min(b).min(c) - self.reach_m);
        let high = self.cube(a.max(b).max(c) + self.reach_m);
        let cubes = high - low + 1;
        if cubes.x.saturating_mul(cubes.y).saturating_mul(cubes.z) > MAX_CUBES {
            return self.lists.iter().for_each(|(_, number)| meet(*number));
        }
        for z in low.z..=high.z {
            for y in low.y..=high.y {
                for x in low.x..=high.x {
                    let place = self.place(I64Vec3::new(x, y, z)) as usize;
                    if self.is_filled[place / 64] >> (place % 64) & 1 == 1 {
                        let list = self.starts[place] as usize..self.starts[place + 1] as usize;
                        self.lists[list].iter().for_each(|(_, number)| meet(*number));
                    }
                }
            }
        }
    }

    /// Without rounding down, which takes the time of all the rest: cubes around 0 are twice as wide.
    fn cube(&self, point: DVec3) -> I64Vec3 {
        (point * self.cubes_per_m).as_i64vec3()
    }

    fn place(&self, cube: I64Vec3) -> u32 {
        let mixed = (cube.x as u64)
            .wrapping_mul(0x9e37_79b9_7f4a_7c15)
            .wrapping_add((cube.y as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f))
            .wrapping_add((cube.z as u64).wrapping_mul(0x1656_67b1_9e37_79f9));
        ((mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 32) as u32 & (self.places as u32 - 1)
    }
}

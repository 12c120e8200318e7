//! Triangles by where they are, so that those near a point are found among few.
//!
//! A triangle is listed in the cubes of a lattice that its box meets. The cubes are as large as its area asks for: a
//! slender one is cut into pieces first, so that a needle is not listed all over the twig. Cubes share the places of a
//! table by a hash; what does not belong there costs a test.

use glam::{DVec3, Vec3};

use super::corners;
use crate::Mesh;

/// How far two sheets of one leaf lie apart at most: as a share of the plant's longest edge, and of the edge of a
/// square as large as the triangle.
const APART: [f64; 2] = [2.5e-4, 0.03];

/// Least cosine between the normals of two sheets of one leaf.
const PARALLEL: f64 = 0.97;

/// How far beyond an edge a point still counts as on the triangle, in weights.
const SLACK: f64 = 1e-3;

/// Error of a distance from a plane in f32, as a share of the coordinates.
const ROUNDING: f64 = 1e-6;

/// Halvings of a slender triangle at most.
const HALVINGS: u32 = 5;

/// Triangles that are tried for a point at most, and that are found on it. More lie in one place only where a mesh has
/// many layers of the same leaves; what lies beyond stays as it is.
const MAX_CANDIDATES: [usize; 2] = [1024, 16];

/// A triangle as a plane that points are near to.
#[derive(Clone, Copy)]
pub(super) struct Flat {
    corners: [DVec3; 3],
    /// Twice the area, to the side from which its vertices run counter-clockwise.
    cross: DVec3,
    twice_area: f64,
}

impl Flat {
    /// `None` for a triangle whose area vanishes.
    pub(super) fn new(mesh: &Mesh, triangle: u32) -> Option<Flat> {
        let corners = corners(mesh, triangle);
        let [a, b, c] = corners;
        let cross = (b - a).cross(c - a);
        let twice_area = cross.length();
        (twice_area > f64::MIN_POSITIVE && twice_area.is_finite()).then_some(Flat {
            corners,
            cross,
            twice_area,
        })
    }

    /// Unit normal, to the side from which its vertices run counter-clockwise.
    pub(super) fn normal(&self) -> DVec3 {
        self.cross / self.twice_area
    }

    /// Square metres.
    pub(super) fn area_m2(&self) -> f64 {
        self.twice_area / 2.0
    }

    /// The mean of its corners.
    pub(super) fn centroid(&self) -> DVec3 {
        let [a, b, c] = self.corners;
        (a + b + c) / 3.0
    }

    /// The point with weights of the second and third vertex.
    pub(super) fn point(&self, [u, v]: [f64; 2]) -> DVec3 {
        let [a, b, c] = self.corners;
        a + (b - a) * u + (c - a) * v
    }

    /// Lowest and highest coordinates of all from which it may be another sheet.
    pub(super) fn low_and_high(&self, longest_m: f64) -> [DVec3; 2] {
        let [a, b, c] = self.corners;
        let reach_m = self.reach_m(longest_m);
        [a.min(b).min(c) - reach_m, a.max(b).max(c) + reach_m]
    }

    /// Whether it may be a sheet of the same leaf, as far as the direction goes.
    pub(super) fn is_parallel(&self, other: &Flat) -> bool {
        self.cross.dot(other.cross).abs() >= PARALLEL * self.twice_area * other.twice_area
    }

    /// How far from it a sheet of the same leaf may lie, metres.
    fn reach_m(&self, longest_m: f64) -> f64 {
        (APART[0] * longest_m).min(APART[1] * libm::sqrt(self.area_m2()))
    }

    /// How far a point lies before the triangle, metres (behind it: below 0), and its weights of the second and third
    /// vertex; `None` where it lies before none of it, or too far off.
    pub(super) fn before(&self, point: DVec3, longest_m: f64) -> Option<(f64, [f64; 2])> {
        let [a, b, c] = self.corners;
        let from = point - a;
        let height = from.dot(self.cross) / self.twice_area;
        if height.abs() > self.reach_m(longest_m) {
            return None;
        }
        let square = self.twice_area * self.twice_area;
        let u = from.cross(c - a).dot(self.cross) / square;
        let v = (b - a).cross(from).dot(self.cross) / square;
        (u >= -SLACK && v >= -SLACK && u + v <= 1.0 + SLACK).then_some((height, [u, v]))
    }

    /// Power of two of the cubes that it is listed in.
    pub(super) fn level(&self, longest_m: f64) -> i16 {
        let [a, b, c] = self.corners;
        let side = (a.max(b).max(c) - a.min(b).min(c)).max_element();
        let wide = libm::sqrt(self.area_m2()).clamp(side / f64::from(1 << HALVINGS), side);
        libm::ilogb(wide + 2.0 * self.reach_m(longest_m)) as i16 + 1
    }

    /// Visits the places of a table that it is listed in, some of them more than once.
    fn for_each_place(&self, longest_m: f64, places: usize, visit: &mut impl FnMut(usize)) {
        let level = self.level(longest_m);
        let cube = libm::ldexp(1.0, i32::from(level));
        let reach_m = self.reach_m(longest_m);
        list(self.corners, HALVINGS, cube, reach_m, &mut |cell| visit(place(cell, level, places)));
    }
}

/// Visits the cubes that the box of a triangle meets, after it was cut into pieces that are no larger than a cube.
fn list(corners: [DVec3; 3], halvings: u32, cube: f64, reach_m: f64, visit: &mut impl FnMut([i64; 3])) {
    let [a, b, c] = corners;
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    if halvings > 0 && (high - low).max_element() > cube {
        let edge = |from: usize| corners[from].distance_squared(corners[(from + 1) % 3]);
        let longest = (1..3).fold(0, |best, from| if edge(from) > edge(best) { from } else { best });
        let [p, q, r] = [0, 1, 2].map(|corner| corners[(longest + corner) % 3]);
        let middle = (p + q) / 2.0;
        list([p, middle, r], halvings - 1, cube, reach_m, visit);
        list([middle, q, r], halvings - 1, cube, reach_m, visit);
        return;
    }
    let at = |point: DVec3| (point / cube).floor().as_i64vec3();
    let (low, high) = (at(low - reach_m), at(high + reach_m));
    for z in low.z..=high.z {
        for y in low.y..=high.y {
            for x in low.x..=high.x {
                visit([x, y, z]);
            }
        }
    }
}

/// A plane in few bytes, to tell in short which points are far from a triangle.
#[derive(Clone, Copy)]
struct Plane {
    normal: Vec3,
    offset: f32,
    /// As far as a point may lie from it, rounding included.
    reach_m: f32,
}

impl Plane {
    /// Of what has no area: far from everything.
    const NONE: Plane = Plane { normal: Vec3::ZERO, offset: f32::INFINITY, reach_m: 0.0 };

    fn of(flat: &Flat, longest_m: f64) -> Plane {
        let normal = flat.normal();
        let largest = flat.corners[0].abs().max_element() + longest_m;
        let reach_m = flat.reach_m(longest_m) + ROUNDING * largest;
        Plane {
            normal: normal.as_vec3(),
            offset: normal.dot(flat.corners[0]) as f32,
            reach_m: reach_m as f32,
        }
    }

    fn is_near(&self, point: Vec3) -> bool {
        (self.normal.dot(point) - self.offset).abs() <= self.reach_m
    }
}

/// Some triangles of a mesh.
pub(super) struct Grid<'a> {
    mesh: &'a Mesh,
    triangles: &'a [u32],
    longest_m: f64,
    /// `[index]`
    planes: Vec<Plane>,
    /// Levels in use, ascending.
    levels: Vec<i16>,
    /// `[place]`: where its list starts, and the end of the last.
    starts: Vec<u32>,
    /// Indices into `triangles`.
    lists: Vec<u32>,
}

impl<'a> Grid<'a> {
    pub(super) fn new(mesh: &'a Mesh, triangles: &'a [u32], longest_m: f64) -> Grid<'a> {
        let places = triangles.len().next_power_of_two();
        let mut starts = vec![0u32; places + 1];
        let mut levels = Vec::new();
        let mut planes = Vec::with_capacity(triangles.len());
        for &triangle in triangles {
            let Some(flat) = Flat::new(mesh, triangle) else {
                planes.push(Plane::NONE);
                continue;
            };
            planes.push(Plane::of(&flat, longest_m));
            let level = flat.level(longest_m);
            if levels.last() != Some(&level) && !levels.contains(&level) {
                levels.push(level);
            }
            flat.for_each_place(longest_m, places, &mut |place| starts[place + 1] += 1);
        }
        levels.sort_unstable();
        for place in 0..places {
            starts[place + 1] += starts[place];
        }
        let mut lists = vec![0u32; starts[places] as usize];
        // Filled from their ends, so that the starts end where they should.
        for (index, &triangle) in triangles.iter().enumerate().rev() {
            if let Some(flat) = Flat::new(mesh, triangle) {
                flat.for_each_place(longest_m, places, &mut |place| {
                    starts[place + 1] -= 1;
                    lists[starts[place + 1] as usize] = index as u32;
                });
            }
        }
        // Each start is now that of the place before it.
        starts.remove(0);
        starts.push(lists.len() as u32);
        Grid { mesh, triangles, longest_m, planes, levels, starts, lists }
    }

    /// Visits the triangles that a point lies before or behind, by their place in the list asked for, in one order,
    /// some of them more than once; only those of a level or above. With how far before it the point lies, metres.
    pub(super) fn near(
        &self,
        point: DVec3,
        from_level: i16,
        mut visit: impl FnMut(u32, &Flat, f64, [f64; 2]),
    ) {
        let [mut tried, mut met] = [0; 2];
        let rough = point.as_vec3();
        for &level in self.levels.iter().filter(|level| **level >= from_level) {
            let cube = libm::ldexp(1.0, i32::from(level));
            let place = place((point / cube).floor().as_i64vec3().to_array(), level, self.starts.len() - 1);
            let list = &self.lists[self.starts[place] as usize..self.starts[place + 1] as usize];
            for &index in list.iter().take(MAX_CANDIDATES[0] - tried) {
                if self.planes[index as usize].is_near(rough)
                    && let Some(flat) = Flat::new(self.mesh, self.triangles[index as usize])
                    && let Some((height, weights)) = flat.before(point, self.longest_m)
                {
                    visit(index, &flat, height, weights);
                    met += 1;
                    if met == MAX_CANDIDATES[1] {
                        return;
                    }
                }
            }
            tried += list.len().min(MAX_CANDIDATES[0] - tried);
        }
    }
}

/// Place of a cube in a table of `places`, a power of two.
fn place([x, y, z]: [i64; 3], level: i16, places: usize) -> usize {
    let mixed = (x as u64)
        .wrapping_mul(0x9e37_79b9_7f4a_7c15)
        .wrapping_add((y as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f))
        .wrapping_add((z as u64).wrapping_mul(0x1656_67b1_9e37_79f9))
        .wrapping_add((level as u64).wrapping_mul(0xff51_afd7_ed55_8ccd));
    let folded = (mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    (folded >> 32) as usize & (places - 1)
}

//! A uniform grid over a model's triangles, walked cell by cell (3DDDA: Fujimoto and others 1986; lists packed as Lagae
//! and Dutre 2008 do): what the papers trace their plants with.

use glam::{UVec3, Vec3};

use crate::scene::{Ray, Scene, TriangleHit};

/// Cells per triangle.
const DENSITY: f32 = 4.0;
/// Cells along an edge, at most.
const MAX_CELLS: f32 = 512.0;
/// Triangles are listed in cells that they miss by this share of a cell, which is more than a walk's rounding.
pub(super) const PAD: f32 = 1e-3;

pub(crate) struct ModelGrid {
    pub min: Vec3,
    /// Cells per metre along each axis.
    pub per_m: Vec3,
    pub count: UVec3,
    /// `[z][y][x]` and one more: where the list of each cell starts.
    pub starts: Vec<u32>,
    /// Triangles, by their number in the order of the scene's hierarchy.
    pub lists: Vec<u32>,
}

impl ModelGrid {
    /// Over all triangles of a scene, whose box it fills.
    pub(super) fn over(scene: &Scene<'_>) -> ModelGrid {
        let size = (scene.max - scene.min).max(Vec3::splat(scene.size() * 1e-3));
        let cells = scene.triangles().len() as f32 * DENSITY;
        let edge = libm::cbrtf(size.x * size.y * size.z / cells);
        let count = (size / edge).ceil().clamp(Vec3::ONE, Vec3::splat(MAX_CELLS));
        let mut grid = ModelGrid {
            min: scene.min,
            per_m: count / size,
            count: count.as_uvec3(),
            starts: Vec::new(),
            lists: Vec::new(),
        };
        let mut starts = vec![0u32; (grid.count.x * grid.count.y * grid.count.z) as usize + 1];
        for corners in scene.triangles() {
            grid.each_cell(corners, |cell| starts[cell + 1] += 1);
        }
        for cell in 1..starts.len() {
            starts[cell] += starts[cell - 1];
        }
        let mut lists = vec![0; starts[starts.len() - 1] as usize];
        let mut next = starts.clone();
        for (triangle, corners) in (0..).zip(scene.triangles()) {
            grid.each_cell(corners, |cell| {
                lists[next[cell] as usize] = triangle;
                next[cell] += 1;
            });
        }
        grid.starts = starts;
        grid.lists = lists;
        grid
    }

    /// As [`Scene::find`].
    pub(super) fn find(
        &self,
        scene: &Scene<'_>,
        ray: Ray,
        far: f32,
        except: Option<u32>,
    ) -> Option<TriangleHit> {
        let mut best: Option<TriangleHit> = None;
        self.walk(ray, far, |list, end| {
            for &at in list {
                scene.meet(at as usize, ray, except, &mut best);
            }
            // Beyond this cell lies nothing that is nearer.
            best.as_ref().is_some_and(|found| found.distance <= end)
        });
        best.filter(|found| found.distance <= far)
    }

    /// As [`Scene::is_blocked`].
    pub(super) fn is_blocked(&self, scene: &Scene<'_>, ray: Ray, except: Option<u32>) -> bool {
        let mut is_blocked = false;
        self.walk(ray, f32::INFINITY, |list, _| {
            is_blocked = list.iter().any(|&at| scene.meets(at as usize, ray, except));
            is_blocked
        });
        is_blocked
    }

    /// Gives `visit` the list of each cell along a ray, and the distance at which the ray leaves it, until that says
    /// that it is done.
    fn walk(&self, ray: Ray, far: f32, mut visit: impl FnMut(&[u32], f32) -> bool) {
        let direction = ray.direction * self.per_m;
        let origin = (ray.origin - self.min) * self.per_m;
        let count = self.count.as_vec3();
        // To the grid's box, should the ray start before it.
        let mut start = 0.0f32;
        let mut end = far;
        for axis in 0..3 {
            let inverse = 1.0 / direction[axis];
            let (a, b) = ((-PAD - origin[axis]) * inverse, (count[axis] + PAD - origin[axis]) * inverse);
            start = start.max(a.min(b));
            end = end.min(a.max(b));
        }
        if start > end {
            return;
        }
        let first = (origin + direction * start).floor().clamp(Vec3::ZERO, count - 1.0);
        let mut cell = first.as_ivec3().to_array();
        let (count, step) = (self.count.as_ivec3().to_array(), direction.signum().as_ivec3().to_array());
        let stride = [1, self.count.x as usize, (self.count.x * self.count.y) as usize];
        let inverse = Vec3::ONE / direction;
        // Of the plane through which the ray leaves the cell along an axis.
        let leaves = |cell: i32, axis: usize| {
            let plane = cell + i32::from(step[axis] > 0);
            match direction[axis] == 0.0 {
                true => f32::INFINITY,
                false => (plane as f32 - origin[axis]) * inverse[axis],
            }
        };
        let mut next: [f32; 3] = std::array::from_fn(|axis| leaves(cell[axis], axis));
        loop {
            let axis = match next[0] <= next[1] {
                true if next[0] <= next[2] => 0,
                false if next[1] <= next[2] => 1,
                _ => 2,
            };
            let at = (0..3).map(|axis| cell[axis] as usize * stride[axis]).sum::<usize>();
            let list = &self.lists[self.starts[at] as usize..self.starts[at + 1] as usize];
            if visit(list, next[axis]) || next[axis] > end {
                return;
            }
            cell[axis] += step[axis];
            if !(0..count[axis]).contains(&cell[axis]) {
                return;
            }
            next[axis] = leaves(cell[axis], axis);
        }
    }

    /// Calls `visit` for every cell that a triangle may reach into.
    fn each_cell(&self, corners: [Vec3; 3], mut visit: impl FnMut(usize)) {
        let [a, b, c] = corners.map(|corner| (corner - self.min) * self.per_m);
        let last = self.count.as_vec3() - 1.0;
        let low = (a.min(b).min(c) - PAD).floor().clamp(Vec3::ZERO, last).as_uvec3();
        let high = (a.max(b).max(c) + PAD).floor().clamp(Vec3::ZERO, last).as_uvec3();
        let normal = (b - a).cross(c - a);
        let reach = normal.abs().element_sum() * (0.5 + PAD);
        // The plane is no help where a triangle lies in one row of cells, or is a needle.
        let is_large = (high - low).min_element() > 0 || (high - low).max_element() > 2;
        for z in low.z..=high.z {
            for y in low.y..=high.y {
                for x in low.x..=high.x {
                    let center = Vec3::new(x as f32, y as f32, z as f32) + 0.5;
                    if !is_large || normal.dot(center - a).abs() <= reach {
                        visit(((z * self.count.y + y) * self.count.x + x) as usize);
                    }
                }
            }
        }
    }
}

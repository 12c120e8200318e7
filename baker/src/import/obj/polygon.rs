//! Polygons to triangles by ear clipping in the plane that fits them best, so that concave leaves
//! keep their outline.

use earcut::Earcut;

/// Buffers that are used again from polygon to polygon.
pub struct Triangulator {
    earcut: Earcut<f64>,
    flat: Vec<[f64; 2]>,
    triangles: Vec<u32>,
}

impl Triangulator {
    /// Empty buffers.
    pub fn new() -> Triangulator {
        Triangulator { earcut: Earcut::new(), flat: Vec::new(), triangles: Vec::new() }
    }

    /// Numbers of corners, three per triangle, wound like the polygon. Triangles and convex
    /// polygons become fans; what ear clipping cannot cut (all corners on a line) becomes one too,
    /// for later stages to drop.
    pub fn triangulate(&mut self, corners: &[[f64; 3]]) -> &[u32] {
        self.triangles.clear();
        let fan = |triangles: &mut Vec<u32>| {
            triangles.extend((2..corners.len() as u32).flat_map(|last| [0, last - 1, last]));
        };
        if corners.len() <= 3 {
            fan(&mut self.triangles);
            return &self.triangles;
        }
        let normal = newell_normal(corners);
        // The projection drops the axis along which the normal is longest, and keeps the winding.
        let size = normal.map(f64::abs);
        let axis = if size[0] >= size[1] && size[0] >= size[2] { 0 } else if size[1] >= size[2] { 1 } else { 2 };
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let (u, v) = if normal[axis] >= 0.0 { (u, v) } else { (v, u) };
        self.flat.clear();
        self.flat.extend(corners.iter().map(|corner| [corner[u], corner[v]]));
        if is_convex(&self.flat) {
            fan(&mut self.triangles);
            return &self.triangles;
        }
        self.earcut.earcut(self.flat.iter().copied(), &[], &mut self.triangles);
        if self.triangles.is_empty() {
            fan(&mut self.triangles);
        }
        for triangle in self.triangles.as_chunks_mut::<3>().0 {
            // Its triangles all turn one way; the polygon, projected, is counter-clockwise.
            let [a, b, c] = triangle.map(|corner| self.flat[corner as usize]);
            if turn(a, b, c) < 0.0 {
                triangle.swap(1, 2);
            }
        }
        &self.triangles
    }
}

/// Newell's method: the normal of the best-fit plane, as long as twice the projected area.
fn newell_normal(corners: &[[f64; 3]]) -> [f64; 3] {
    let origin = corners[0];
    let mut normal = [0.0; 3];
    for (i, &here) in corners.iter().enumerate() {
        let next = corners[(i + 1) % corners.len()];
        let [a, b]: [[f64; 3]; 2] = [here, next].map(|point| std::array::from_fn(|axis| point[axis] - origin[axis]));
        for axis in 0..3 {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            normal[axis] += a[u] * b[v] - a[v] * b[u];
        }
    }
    normal
}

fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Whether every corner turns left (or not at all), once around: a fan is then right.
fn is_convex(flat: &[[f64; 2]]) -> bool {
    let count = flat.len();
    let left = (0..count).all(|i| turn(flat[i], flat[(i + 1) % count], flat[(i + 2) % count]) >= 0.0);
    // A star that winds twice turns left everywhere too; its fan would fold back.
    left && (2..count).all(|i| turn(flat[0], flat[i - 1], flat[i]) >= 0.0)
}

//! Polygons to triangles by ear clipping in the plane that fits them best, so that concave leaves
//! keep their outline.

use earcut::Earcut;

/// Buffers that are used again from polygon to polygon.
pub(super) struct Triangulator {
    earcut: Earcut<f64>,
    /// Numbers of the polygon's corners in the canonical order.
    order: Vec<u32>,
    flat: Vec<[f64; 2]>,
    triangles: Vec<u32>,
    /// Squares of the corners of all polygons that ears were clipped from, added up: how long that may have taken.
    pub work: u64,
}

impl Triangulator {
    /// Empty buffers.
    pub(super) fn new() -> Triangulator {
        Triangulator {
            earcut: Earcut::new(),
            order: Vec::new(),
            flat: Vec::new(),
            triangles: Vec::new(),
            work: 0,
        }
    }

    /// Numbers of corners, three per triangle, wound like the polygon.
    ///
    /// A polygon and its reverse (a leaf card's back) are cut along the same diagonals, whichever
    /// corner they start at, so that the two sides are found to coincide. Convex polygons become
    /// fans; what ear clipping cannot cut (all corners on a line) too, for later stages to drop.
    pub(super) fn triangulate(&mut self, corners: &[[f64; 3]]) -> &[u32] {
        self.triangles.clear();
        if corners.len() <= 3 {
            self.triangles.extend(0..corners.len() as u32);
            return &self.triangles;
        }
        let reversed = self.make_order(corners);
        let at = |i: u32| corners[i as usize];
        let normal = newell_normal(&self.order.iter().map(|&i| at(i)).collect::<Vec<_>>());
        // The projection drops the axis along which the normal is longest, and keeps the winding.
        let size = normal.map(f64::abs);
        let axis = if size[0] >= size[1] && size[0] >= size[2] {
            0
        } else if size[1] >= size[2] {
            1
        } else {
            2
        };
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let (u, v) = if normal[axis] >= 0.0 { (u, v) } else { (v, u) };
        self.flat.clear();
        self.flat.extend(self.order.iter().map(|&i| [at(i)[u], at(i)[v]]));
        if !is_convex(&self.flat) {
            self.work += (corners.len() as u64).pow(2);
            self.earcut.earcut(self.flat.iter().copied(), &[], &mut self.triangles);
        }
        if self.triangles.is_empty() {
            self.triangles.extend((2..corners.len() as u32).flat_map(|last| [0, last - 1, last]));
        }
        for triangle in self.triangles.as_chunks_mut::<3>().0 {
            // The polygon, projected, is counter-clockwise; its triangles have to be so too.
            let [a, b, c] = triangle.map(|corner| self.flat[corner as usize]);
            if (turn(a, b, c) < 0.0) != reversed {
                triangle.swap(1, 2);
            }
            *triangle = triangle.map(|corner| self.order[corner as usize]);
        }
        &self.triangles
    }

    /// From the smallest corner on, towards its smaller neighbour; whether that runs backwards.
    fn make_order(&mut self, corners: &[[f64; 3]]) -> bool {
        let count = corners.len();
        let compare = |a: usize, b: usize| {
            let pairs = corners[a].iter().zip(&corners[b]);
            pairs
                .map(|(a, b)| a.total_cmp(b))
                .find(|order| order.is_ne())
                .unwrap_or(std::cmp::Ordering::Equal)
        };
        let first = (0..count).min_by(|&a, &b| compare(a, b)).expect("a polygon has corners");
        let (next, previous) = ((first + 1) % count, (first + count - 1) % count);
        let reversed = compare(previous, next).is_lt();
        let step = if reversed { count - 1 } else { 1 };
        self.order.clear();
        self.order.extend((0..count).map(|i| ((first + i * step) % count) as u32));
        reversed
    }
}

/// Newell's method: the normal of the best-fit plane, as long as twice the projected area.
fn newell_normal(corners: &[[f64; 3]]) -> [f64; 3] {
    let origin = corners[0];
    let mut normal = [0.0; 3];
    for (i, &here) in corners.iter().enumerate() {
        let next = corners[(i + 1) % corners.len()];
        let [a, b]: [[f64; 3]; 2] =
            [here, next].map(|point| std::array::from_fn(|axis| point[axis] - origin[axis]));
        for (axis, value) in normal.iter_mut().enumerate() {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            *value += a[u] * b[v] - a[v] * b[u];
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

#[cfg(test)]
mod tests {
    use super::*;

    const ARROW: [[f64; 3]; 4] = [[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [0.4, 0.4, 1.0], [0.0, 2.0, 1.0]];

    fn area_vector(corners: &[[f64; 3]], triangles: &[u32]) -> ([f64; 3], f64) {
        let mut sum = [0.0; 3];
        let mut size = 0.0;
        for triangle in triangles.as_chunks::<3>().0 {
            let normal = newell_normal(&triangle.map(|i| corners[i as usize]));
            sum = std::array::from_fn(|axis| sum[axis] + normal[axis] / 2.0);
            size += 0.5 * normal.iter().map(|x| x * x).sum::<f64>().sqrt();
        }
        (sum, size)
    }

    #[test]
    fn concave_polygon_keeps_its_area_and_winding_from_every_start() {
        for start in 0..4 {
            for backwards in [false, true] {
                let mut corners = ARROW;
                corners.rotate_left(start);
                if backwards {
                    corners.reverse();
                }
                let mut triangulator = Triangulator::new();
                let triangles = triangulator.triangulate(&corners);
                assert_eq!(triangles.len(), 6);
                let (vector, size) = area_vector(&corners, triangles);
                let sign = if backwards { -1.0 } else { 1.0 };
                assert!((vector[2] - sign * 0.8).abs() < 1e-12, "{vector:?}");
                assert!((size - 0.8).abs() < 1e-12, "folded: {size}");
            }
        }
    }

    #[test]
    fn a_polygon_and_its_reverse_share_their_diagonals() {
        let corners: Vec<[f64; 3]> = (0..7)
            .map(|i| f64::from(i) * 0.9)
            .map(|a| [libm::cos(a), libm::sin(a) * 0.5, libm::sin(a)])
            .collect();
        let cut = |corners: &[[f64; 3]]| {
            let mut triangulator = Triangulator::new();
            let triangles = triangulator.triangulate(corners).as_chunks::<3>().0.to_vec();
            let mut keys: Vec<_> = triangles
                .iter()
                .map(|t| {
                    let mut key = t.map(|i| corners[i as usize].map(f64::to_bits));
                    key.sort_unstable();
                    key
                })
                .collect();
            keys.sort_unstable();
            keys
        };
        let mut back = corners.clone();
        back.reverse();
        back.rotate_left(3);
        assert_eq!(cut(&corners), cut(&back));
    }

    #[test]
    fn corners_on_a_line_do_not_panic() {
        let corners: Vec<[f64; 3]> = (0..5).map(|i| [f64::from(i), 0.0, 0.0]).collect();
        assert_eq!(Triangulator::new().triangulate(&corners).len() % 3, 0);
        assert_eq!(Triangulator::new().triangulate(&[[1.0; 3]; 6]).len() % 3, 0);
    }
}

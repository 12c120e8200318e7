//! Which voxels a triangle touches: the separating axis test in exact integers, walked so that the work goes
//! with the voxels found and not with the triangle's box.
//!
//! The thirteen axes of Akenine-Moller's test (2001), arranged as Schwarz and Seidel do (2010): a triangle and a
//! box meet iff the box meets the triangle's bounds and plane, and in each of the three axis-aligned
//! projections the rectangle meets the projected triangle. Both are closed sets.
//!
//! Sizes: vertices < 2^28 units (4096 voxels of 2^16), so edge functions < 2^61 fit i64; the plane needs i128.

use super::triangle::UNITS;

/// One triangle's tests, in voxel indices.
pub(super) struct Overlap {
    /// Voxels that the bounds meet, per axis: first and last.
    bounds: [[i64; 2]; 3],
    /// Projections along x, y, z: `planes[axis]` looks along `axis` at axes `(axis + 1) % 3, (axis + 2) % 3`.
    projections: [Projection; 3],
    plane: Plane,
    /// The axis along which the triangle is steepest: columns along it hold few voxels.
    along: usize,
}

/// The three half-planes of a projected triangle: a voxel passes where `c + p i + q j >= 0` for all, with i and j
/// its indices along the projection's two axes. Six for a triangle seen edge on.
struct Projection {
    lines: [[i64; 3]; 6],
    count: usize,
}

impl Projection {
    fn new(vertices: &[[i64; 3]; 3], axis: usize, facing: i64) -> Projection {
        let (p, q) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut projection = Projection { lines: [[0; 3]; 6], count: 0 };
        let mut add = |start: &[i64; 3], normal: [i64; 2]| {
            let reach = (normal[0].max(0) + normal[1].max(0)) * UNITS;
            let c = reach - normal[0] * start[p] - normal[1] * start[q];
            projection.lines[projection.count] = [c, normal[0] * UNITS, normal[1] * UNITS];
            projection.count += 1;
        };
        for edge in 0..3 {
            let (a, b) = (&vertices[edge], &vertices[(edge + 1) % 3]);
            let inward = [-(b[q] - a[q]), b[p] - a[p]];
            if facing >= 0 {
                add(a, inward);
            }
            if facing <= 0 {
                add(a, inward.map(|c| -c));
            }
        }
        projection
    }

    fn passes(&self, i: i64, j: i64) -> bool {
        self.lines[..self.count].iter().all(|&[c, p, q]| c + p * i + q * j >= 0)
    }
}

/// The triangle's plane: a voxel (x, y, z) passes where `least <= n . (x, y, z) <= most`.
struct Plane {
    normal: [i128; 3],
    least: i128,
    most: i128,
}

impl Overlap {
    pub fn new(vertices: &[[i64; 3]; 3]) -> Overlap {
        let edge =
            |to: usize| -> [i64; 3] { std::array::from_fn(|axis| vertices[to][axis] - vertices[0][axis]) };
        let (e, f) = (edge(1), edge(2));
        let normal = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]];
        let bounds = std::array::from_fn(|axis| {
            let along = [vertices[0][axis], vertices[1][axis], vertices[2][axis]];
            let (low, high) = (along[0].min(along[1]).min(along[2]), along[0].max(along[1]).max(along[2]));
            // The voxel below one whose lower face is just reached is touched as well.
            [(low - 1).div_euclid(UNITS), high.div_euclid(UNITS)]
        });
        let projections = std::array::from_fn(|axis| Projection::new(vertices, axis, normal[axis].signum()));
        let wide = normal.map(i128::from);
        let offset: i128 = (0..3).map(|axis| wide[axis] * i128::from(vertices[0][axis])).sum();
        let reach = |pick: fn(i128) -> i128| wide.iter().map(|&n| pick(n)).sum::<i128>() * i128::from(UNITS);
        let plane = Plane {
            normal: wide.map(|n| n * i128::from(UNITS)),
            least: offset - reach(|n| n.max(0)),
            most: offset - reach(|n| n.min(0)),
        };
        let along = (0..3).max_by_key(|&axis| normal[axis].abs()).expect("three axes");
        Overlap { bounds, projections, plane, along }
    }

    /// Calls `visit` with every voxel that the triangle touches and whose z lies in `zs` (first, last).
    pub fn for_each(&self, zs: [i64; 2], mut visit: impl FnMut([i64; 3])) {
        let mut bounds = self.bounds;
        bounds[2] = [bounds[2][0].max(zs[0]), bounds[2][1].min(zs[1])];
        let w = self.along;
        let (p, q) = ((w + 1) % 3, (w + 2) % 3);
        if bounds[w][0] > bounds[w][1] {
            return;
        }
        for i in bounds[p][0]..=bounds[p][1] {
            let [first, last] = self.row(i, &bounds);
            for j in first..=last {
                if !self.projections[w].passes(i, j) {
                    continue;
                }
                let mut at = [0; 3];
                (at[p], at[q]) = (i, j);
                let [low, high] = self.column(&at, bounds[w]);
                for k in low..=high {
                    at[w] = k;
                    // The projection along p sees (q, w), that along q sees (w, p).
                    if self.on_plane(&at)
                        && self.projections[p].passes(j, k)
                        && self.projections[q].passes(k, i)
                    {
                        visit(at);
                    }
                }
            }
        }
    }

    /// A range of j that holds every voxel of row i; estimated in f64, never too small.
    fn row(&self, i: i64, bounds: &[[i64; 2]; 3]) -> [i64; 2] {
        let w = self.along;
        let (p, q) = ((w + 1) % 3, (w + 2) % 3);
        let mut range = bounds[q];
        let lines = &self.projections[w];
        for &[c, along_p, along_q] in &lines.lines[..lines.count] {
            narrow(&mut range, (c + along_p * i) as f64, along_q as f64);
        }
        if bounds[w] != self.bounds[w] {
            // Only some layers of the triangle: the plane crosses them in a part of the row.
            let Plane { normal, least, most } = &self.plane;
            let ends = bounds[w].map(|k| normal[w] * i128::from(k));
            let base = normal[p] * i128::from(i);
            narrow(&mut range, (base + ends[0].max(ends[1]) - least) as f64, normal[q] as f64);
            narrow(&mut range, (most - base - ends[0].min(ends[1])) as f64, -normal[q] as f64);
        }
        range
    }

    /// A range of voxels along the column through `at` that holds every one on the plane.
    fn column(&self, at: &[i64; 3], bounds: [i64; 2]) -> [i64; 2] {
        let w = self.along;
        let Plane { normal, least, most } = &self.plane;
        let base = normal[(w + 1) % 3] * i128::from(at[(w + 1) % 3])
            + normal[(w + 2) % 3] * i128::from(at[(w + 2) % 3]);
        let mut range = bounds;
        narrow(&mut range, (base - least) as f64, normal[w] as f64);
        narrow(&mut range, (most - base) as f64, -normal[w] as f64);
        range
    }

    fn on_plane(&self, at: &[i64; 3]) -> bool {
        let Plane { normal, least, most } = &self.plane;
        let value: i128 = (0..3).map(|axis| normal[axis] * i128::from(at[axis])).sum();
        *least <= value && value <= *most
    }
}

/// Keeps of a range what can satisfy `c + slope * index >= 0`, and a little more than rounding needs.
fn narrow(range: &mut [i64; 2], c: f64, slope: f64) {
    const SLACK: f64 = 1e-3;
    if slope > 0.0 {
        range[0] = range[0].max(libm::ceil(-c / slope - SLACK) as i64);
    } else if slope < 0.0 {
        range[1] = range[1].min(libm::floor(-c / slope + SLACK) as i64);
    } else if c < 0.0 {
        *range = [1, 0];
    }
}

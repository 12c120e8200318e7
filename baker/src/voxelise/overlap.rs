//! Which voxels a triangle touches: the separating axis test in exact integers, walked so that the work goes
//! with the voxels found and not with the triangle's box.
//!
//! The thirteen axes of Akenine-Moller's test (2001), arranged as Schwarz and Seidel do (2010): a triangle and a
//! box meet iff the box meets the triangle's bounds and plane, and in each of the three axis-aligned
//! projections the rectangle meets the projected triangle. Both are closed sets.
//!
//! Sizes: vertices < 2^28 units (4096 voxels of 2^16), so edge functions < 2^61 fit i64; the plane does where the
//! triangle is small, as nearly all are, and needs i128 else.

use super::triangle::UNITS;

/// Columns along each edge of a square that is asked for as one.
pub(super) const SQUARE: i64 = 4;

/// One triangle's tests, in voxel indices less `origin`.
pub(super) struct Overlap {
    /// The first voxel of the bounds.
    origin: [i64; 3],
    /// Voxels that the bounds meet, per axis: first (0) and last.
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
    fn new(vertices: &[[i64; 3]; 3], origin: &[i64; 3], axis: usize, facing: i64) -> Projection {
        let (p, q) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut projection = Projection { lines: [[0; 3]; 6], count: 0 };
        let mut add = |start: &[i64; 3], normal: [i64; 2]| {
            let reach = (normal[0].max(0) + normal[1].max(0)) * UNITS;
            let c = reach
                - normal[0] * (start[p] - origin[p] * UNITS)
                - normal[1] * (start[q] - origin[q] * UNITS);
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
    /// In square units: < 2^57.
    normal: [i64; 3],
    least: i128,
    most: i128,
    /// Least and most where every value within the bounds fits.
    narrow: Option<[i64; 2]>,
}

impl Plane {
    fn new(normal: [i64; 3], vertex: &[i64; 3], origin: &[i64; 3], bounds: &[[i64; 2]; 3]) -> Plane {
        let wide = normal.map(i128::from);
        let units = i128::from(UNITS);
        let offset: i128 = (0..3)
            .map(|axis| wide[axis] * (i128::from(vertex[axis]) - i128::from(origin[axis]) * units))
            .sum();
        let reach = |pick: fn(i128) -> i128| wide.iter().map(|&n| pick(n)).sum::<i128>() * units;
        // In units times units^2 until here; whole numbers of units^2 lie between the rounded ends.
        let least = -(-(offset - reach(|n| n.max(0)))).div_euclid(units);
        let most = (offset - reach(|n| n.min(0))).div_euclid(units);
        // Twice: the difference of a value and an end has to fit as well.
        let largest: i128 = (0..3).map(|axis| wide[axis].abs() * i128::from(bounds[axis][1] + 2)).sum();
        let narrow = (2 * largest < i128::from(i64::MAX)).then_some([least as i64, most as i64]);
        Plane { normal, least, most, narrow }
    }

    fn holds(&self, at: &[i64; 3]) -> bool {
        match self.narrow {
            Some([least, most]) => {
                let value: i64 = (0..3).map(|axis| self.normal[axis] * at[axis]).sum();
                least <= value && value <= most
            }
            None => {
                let value: i128 =
                    (0..3).map(|axis| i128::from(self.normal[axis]) * i128::from(at[axis])).sum();
                self.least <= value && value <= self.most
            }
        }
    }

    /// How far `n . at` lies above the least and below the most.
    fn room(&self, at: &[i64; 3]) -> [f64; 2] {
        match self.narrow {
            Some([least, most]) => {
                let value: i64 = (0..3).map(|axis| self.normal[axis] * at[axis]).sum();
                [(value - least) as f64, (most - value) as f64]
            }
            None => {
                let value: i128 =
                    (0..3).map(|axis| i128::from(self.normal[axis]) * i128::from(at[axis])).sum();
                [(value - self.least) as f64, (self.most - value) as f64]
            }
        }
    }
}

/// A voxel near the triangle.
pub(super) struct Candidate<'o> {
    overlap: &'o Overlap,
    /// Less the origin.
    at: [i64; 3],
}

impl Candidate<'_> {
    /// Whether the triangle touches it.
    pub(super) fn touched(&self) -> bool {
        let Overlap { projections, plane, along, .. } = self.overlap;
        let (p, q) = ((along + 1) % 3, (along + 2) % 3);
        let [i, j, k] = [self.at[p], self.at[q], self.at[*along]];
        // The projection along p sees (q, w), that along q sees (w, p).
        plane.holds(&self.at) && projections[p].passes(j, k) && projections[q].passes(k, i)
    }
}

impl Overlap {
    pub(super) fn new(vertices: &[[i64; 3]; 3]) -> Overlap {
        let edge =
            |to: usize| -> [i64; 3] { std::array::from_fn(|axis| vertices[to][axis] - vertices[0][axis]) };
        let (e, f) = (edge(1), edge(2));
        let normal = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]];
        let ends: [[i64; 2]; 3] = std::array::from_fn(|axis| {
            let along = [vertices[0][axis], vertices[1][axis], vertices[2][axis]];
            let (low, high) = (along[0].min(along[1]).min(along[2]), along[0].max(along[1]).max(along[2]));
            // The voxel below one whose lower face is just reached is touched as well.
            [(low - 1).div_euclid(UNITS), high.div_euclid(UNITS)]
        });
        let origin = ends.map(|[first, _]| first);
        let bounds = ends.map(|[first, last]| [0, last - first]);
        let projections =
            std::array::from_fn(|axis| Projection::new(vertices, &origin, axis, normal[axis].signum()));
        let plane = Plane::new(normal, &vertices[0], &origin, &bounds);
        let along = (0..3).max_by_key(|&axis| normal[axis].abs()).expect("three axes");
        Overlap { origin, bounds, projections, plane, along }
    }

    /// The axis along which columns run.
    pub(super) fn along(&self) -> usize {
        self.along
    }

    /// Calls `visit` with candidates whose z lies in `zs` (first, last): every voxel that the triangle touches
    /// is among them, once, and few others. Leaves out the columns of which `skip` says so, asked for squares of
    /// at most [`SQUARE`] columns and then for each, given the first and last voxels along the two axes after
    /// `along`.
    pub(super) fn for_each(
        &self,
        zs: [i64; 2],
        skip: impl Fn([[i64; 2]; 2]) -> bool,
        mut visit: impl FnMut([i64; 3], Candidate),
    ) {
        let mut bounds = self.bounds;
        let layers = zs.map(|z| z - self.origin[2]);
        bounds[2] = [bounds[2][0].max(layers[0]), bounds[2][1].min(layers[1])];
        let w = self.along;
        let (p, q) = ((w + 1) % 3, (w + 2) % 3);
        if bounds[w][0] > bounds[w][1] {
            return;
        }
        let walk = Walk::new(self, bounds);
        let mut from = bounds[p][0];
        while from <= bounds[p][1] {
            let to = (from + SQUARE - 1).min(bounds[p][1]);
            let rows: [[i64; 2]; SQUARE as usize] = std::array::from_fn(|row| {
                if from + row as i64 <= to { walk.row(from + row as i64) } else { [1, 0] }
            });
            let first = rows.iter().filter(|row| row[0] <= row[1]).map(|row| row[0]).min();
            let last = rows.iter().filter(|row| row[0] <= row[1]).map(|row| row[1]).max();
            let (mut start, last) = (first.unwrap_or(1), last.unwrap_or(0));
            while start <= last {
                let end = (start + SQUARE - 1).min(last);
                let square =
                    [[from, to].map(|i| i + self.origin[p]), [start, end].map(|j| j + self.origin[q])];
                if !skip(square) {
                    for (i, row) in (from..=to).zip(&rows) {
                        for j in start.max(row[0])..=end.min(row[1]) {
                            let column = [i + self.origin[p], j + self.origin[q]];
                            if !skip(column.map(|at| [at; 2])) {
                                walk.column(i, j, &mut visit);
                            }
                        }
                    }
                }
                start = end + 1;
            }
            from = to + 1;
        }
    }
}

/// A walk over the columns of a triangle's voxels.
struct Walk<'o> {
    overlap: &'o Overlap,
    /// Those of the triangle, or of some layers of it.
    bounds: [[i64; 2]; 3],
    /// 1 / the slope along q of the lines of the projection along `along`.
    per_line: [f64; 6],
    /// 1 / the plane's normal.
    per_normal: [f64; 3],
}

impl<'o> Walk<'o> {
    fn new(overlap: &'o Overlap, bounds: [[i64; 2]; 3]) -> Walk<'o> {
        let per_line = overlap.projections[overlap.along].lines.map(|line| 1.0 / line[2] as f64);
        Walk { overlap, bounds, per_line, per_normal: overlap.plane.normal.map(|n| 1.0 / n as f64) }
    }

    /// A range of j that holds every voxel of row i; estimated in f64, never too small.
    fn row(&self, i: i64) -> [i64; 2] {
        let Overlap { along: w, plane, projections, .. } = self.overlap;
        let (p, q) = ((w + 1) % 3, (w + 2) % 3);
        let mut range = self.bounds[q];
        let lines = &projections[*w];
        for (&[c, along_p, _], &per_slope) in lines.lines[..lines.count].iter().zip(&self.per_line) {
            narrow(&mut range, (c + along_p * i) as f64, per_slope);
        }
        if self.bounds[*w] != self.overlap.bounds[*w] {
            // Only some layers of the triangle: the plane crosses them in a part of the row.
            let end = |k: i64| {
                let mut at = [0; 3];
                (at[p], at[*w]) = (i, k);
                plane.room(&at)
            };
            let [a, b] = self.bounds[*w].map(end);
            narrow(&mut range, a[0].max(b[0]), self.per_normal[q]);
            narrow(&mut range, a[1].max(b[1]), -self.per_normal[q]);
        }
        range
    }

    /// Visits the candidates of one column: those on the plane, and at most a few more.
    fn column(&self, i: i64, j: i64, visit: &mut impl FnMut([i64; 3], Candidate)) {
        let overlap = self.overlap;
        let w = overlap.along;
        if !overlap.projections[w].passes(i, j) {
            return;
        }
        let mut at = [0; 3];
        (at[(w + 1) % 3], at[(w + 2) % 3]) = (i, j);
        let room = overlap.plane.room(&at);
        let mut range = self.bounds[w];
        narrow(&mut range, room[0], self.per_normal[w]);
        narrow(&mut range, room[1], -self.per_normal[w]);
        for k in range[0]..=range[1] {
            at[w] = k;
            let voxel = std::array::from_fn(|axis| at[axis] + overlap.origin[axis]);
            visit(voxel, Candidate { overlap, at });
        }
    }
}

/// Keeps of a range what can satisfy `c + slope * index >= 0`, and a little more than rounding needs. The slope
/// is given as 1 / slope, infinite for 0.
fn narrow(range: &mut [i64; 2], c: f64, per_slope: f64) {
    const SLACK: f64 = 1e-3;
    /// Far beyond any index.
    const FAR: f64 = (1u64 << 40) as f64;
    if per_slope.is_infinite() {
        if c < 0.0 {
            *range = [1, 0];
        }
        return;
    }
    let at = (-c * per_slope).clamp(-FAR, FAR);
    if per_slope > 0.0 {
        range[0] = range[0].max(-floor(SLACK - at));
    } else {
        range[1] = range[1].min(floor(at + SLACK));
    }
}

/// Rounds down what is far below 2^63.
fn floor(c: f64) -> i64 {
    let whole = c as i64;
    whole - i64::from(whole as f64 > c)
}

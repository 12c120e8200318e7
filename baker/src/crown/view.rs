//! Parallel rays along one axis, on a square grid of pixels, and which of them pass a box.

use super::directions::Axis;

/// A grid of parallel rays. Mirrored axes have mirrored grids, so a mirrored plant is sampled alike.
pub(super) struct View {
    /// The axis.
    pub axis: Axis,
    /// Unit vectors across it: along a row of pixels, and along a column.
    across: [[f64; 3]; 2],
    /// Middle of the grid, metres.
    centre: [f64; 3],
    /// Distance between rays, metres.
    pub pixel_m: f64,
    /// Pixels along a row, and rows.
    pub size: [usize; 2],
}

impl View {
    /// Rays that cover a box around `centre` with half extents `half` in metres.
    pub fn new(axis: Axis, centre: [f64; 3], half: [f64; 3], pixel_m: f64) -> View {
        let d = axis.along;
        // The coordinate axis that is most nearly across; by magnitude, so that mirrored axes choose alike.
        let most = (0..3).fold(0, |best, k| if d[k].abs() < d[best].abs() - 1e-9 { k } else { best });
        let raw: [f64; 3] = std::array::from_fn(|k| f64::from(u8::from(k == most)) - d[most] * d[k]);
        let length = libm::sqrt(raw.iter().map(|c| c * c).sum());
        let u = raw.map(|c| c / length);
        let v = [d[1] * u[2] - d[2] * u[1], d[2] * u[0] - d[0] * u[2], d[0] * u[1] - d[1] * u[0]];
        let pixels = |side: [f64; 3]| {
            let reach: f64 = (0..3).map(|k| side[k].abs() * half[k]).sum();
            2 * (libm::ceil(reach / pixel_m) as usize + 1)
        };
        View { axis, across: [u, v], centre, pixel_m, size: [pixels(u), pixels(v)] }
    }

    /// Rays in all.
    pub fn rays(&self) -> usize {
        self.size[0] * self.size[1]
    }

    /// Where a point lies: pixel coordinates (ray (i, j) is at i + 0.5, j + 0.5) and metres along the axis.
    pub fn project(&self, point: [f64; 3]) -> [f64; 3] {
        let from_centre: [f64; 3] = std::array::from_fn(|k| point[k] - self.centre[k]);
        let along = |side: [f64; 3]| (0..3).map(|k| side[k] * from_centre[k]).sum::<f64>();
        let pixel = |k: usize| along(self.across[k]) / self.pixel_m + self.size[k] as f64 / 2.0;
        [pixel(0), pixel(1), along(self.axis.along)]
    }

    /// Visits the rays that pass the cube with lowest corner `low` and edge `edge`, in metres: ray, and where it
    /// enters and leaves, metres along the axis.
    pub fn for_each_ray(&self, low: [f64; 3], edge: f64, mut visit: impl FnMut(usize, f64, f64)) {
        let d = self.axis.along;
        let [x, y, _] = self.project(low.map(|c| c + edge / 2.0));
        let range = |middle: f64, k: usize| {
            let reach = self.across[k].iter().map(|c| c.abs()).sum::<f64>() * edge / 2.0 / self.pixel_m;
            let first = libm::ceil(middle - reach - 0.5).max(0.0) as usize;
            let end = (libm::floor(middle + reach - 0.5) + 1.0).max(0.0) as usize;
            first..end.min(self.size[k])
        };
        let (columns, rows) = (range(x, 0), range(y, 1));
        // A ray's coordinate k over the cube's lowest corner, where it starts in the plane of the grid, is
        // start_k + i step_k. It is between the cube's two faces across k from near_k - i slope_k to far_k - i slope_k.
        let step = self.across[0].map(|c| c * self.pixel_m);
        let inverse = d.map(|c| if c == 0.0 { 0.0 } else { 1.0 / c });
        let slope: [f64; 3] = std::array::from_fn(|k| step[k] * inverse[k]);
        for j in rows {
            let row = (j as f64 + 0.5 - self.size[1] as f64 / 2.0) * self.pixel_m;
            let start: [f64; 3] = std::array::from_fn(|k| {
                let first = (0.5 - self.size[0] as f64 / 2.0) * step[k];
                self.centre[k] - low[k] + self.across[1][k] * row + first
            });
            let near: [f64; 3] = std::array::from_fn(|k| match d[k] {
                0.0 => f64::NEG_INFINITY,
                c if c > 0.0 => -start[k] * inverse[k],
                _ => (edge - start[k]) * inverse[k],
            });
            let far: [f64; 3] = std::array::from_fn(|k| match d[k] {
                0.0 => f64::INFINITY,
                _ => near[k] + edge * inverse[k].abs(),
            });
            // Across an axis that the rays do not follow, they are between the faces or they are not.
            let mut columns = columns.clone();
            for k in (0..3).filter(|&k| d[k] == 0.0) {
                let between = |i: usize| (0.0..edge).contains(&(start[k] + step[k] * i as f64));
                while !columns.is_empty() && !between(columns.start) {
                    columns.start += 1;
                }
                while !columns.is_empty() && !between(columns.end - 1) {
                    columns.end -= 1;
                }
            }
            for i in columns {
                let at = i as f64;
                let from = [0, 1, 2].map(|k| near[k] - at * slope[k]);
                let until = [0, 1, 2].map(|k| far[k] - at * slope[k]);
                let enter = greater(greater(from[0], from[1]), from[2]);
                let leave = lesser(lesser(until[0], until[1]), until[2]);
                if enter < leave {
                    visit(j * self.size[0] + i, enter, leave);
                }
            }
        }
    }
}

/// `f64::min` for what is no NaN: one instruction.
fn lesser(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

/// `f64::max` for what is no NaN: one instruction.
fn greater(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

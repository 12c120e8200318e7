//! Parallel rays along one axis, on a square grid of pixels, and which of them pass a box.

use super::directions::Axis;

/// A grid of parallel rays. Mirrored axes have mirrored grids, so a mirrored plant is sampled alike.
pub(super) struct View {
    /// The axis.
    pub axis: Axis,
    /// Unit vectors across it: along a row of pixels, and along a column.
    across: [[f64; 3]; 2],
    /// Middle of the grid, metres.
    center: [f64; 3],
    /// Distance between rays, metres.
    pixel_m: f64,
    /// Pixels along a row, and rows.
    pub size: [usize; 2],
    /// Start of ray (0, 0), metres.
    corner: [f64; 3],
    /// From a ray's start to the next one's, along a row and along a column, metres.
    step: [[f64; 3]; 2],
    /// 1 / component of the axis, or 0 where that is 0.
    inverse: [f64; 3],
    /// `step` times `inverse`.
    slope: [[f64; 3]; 2],
}

impl View {
    /// Rays that cover a box around `center` with half extents `half` in metres.
    pub(super) fn new(axis: Axis, center: [f64; 3], half: [f64; 3], pixel_m: f64) -> View {
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
        let (across, size) = ([u, v], [pixels(u), pixels(v)]);
        let step = across.map(|side| side.map(|c| c * pixel_m));
        let inverse = d.map(|c| if c == 0.0 { 0.0 } else { 1.0 / c });
        let first = size.map(|pixels| 0.5 - pixels as f64 / 2.0);
        let corner = std::array::from_fn(|k| center[k] + first[0] * step[0][k] + first[1] * step[1][k]);
        let slope = step.map(|step| std::array::from_fn(|k| step[k] * inverse[k]));
        View { axis, across, center, pixel_m, size, corner, step, inverse, slope }
    }

    /// Rays in all.
    pub(super) fn rays(&self) -> usize {
        self.size[0] * self.size[1]
    }

    /// Where a point lies: pixel coordinates (ray (i, j) is at i + 0.5, j + 0.5) and metres along the axis.
    pub(super) fn project(&self, point: [f64; 3]) -> [f64; 3] {
        let from_center: [f64; 3] = std::array::from_fn(|k| point[k] - self.center[k]);
        let along = |side: [f64; 3]| (0..3).map(|k| side[k] * from_center[k]).sum::<f64>();
        let pixel = |k: usize| along(self.across[k]) / self.pixel_m + self.size[k] as f64 / 2.0;
        [pixel(0), pixel(1), along(self.axis.along)]
    }

    /// Visits the rays that pass the cube with lowest corner `low` and edge `edge`, in metres: ray, and where it
    /// enters and leaves, metres along the axis.
    pub(super) fn for_each_ray(&self, low: [f64; 3], edge: f64, mut visit: impl FnMut(usize, f64, f64)) {
        let d = self.axis.along;
        let [x, y, _] = self.project(low.map(|c| c + edge / 2.0));
        let range = |middle: f64, k: usize| {
            let reach = self.across[k].iter().map(|c| c.abs()).sum::<f64>() * edge / 2.0 / self.pixel_m;
            let first = libm::ceil(middle - reach - 0.5).max(0.0) as usize;
            let end = (libm::floor(middle + reach - 0.5) + 1.0).max(0.0) as usize;
            first..end.min(self.size[k])
        };
        let (columns, rows) = (range(x, 0), range(y, 1));
        // Ray (i, j) starts in the plane of the grid, start_k + i step_0k + j step_1k over the cube's lowest corner. It
        // is between the cube's two faces across k from near_k to far_k, both less i slope_0k + j slope_1k.
        let start: [f64; 3] = std::array::from_fn(|k| self.corner[k] - low[k]);
        let near: [f64; 3] = std::array::from_fn(|k| match d[k] {
            0.0 => f64::NEG_INFINITY,
            c if c > 0.0 => -start[k] * self.inverse[k],
            _ => (edge - start[k]) * self.inverse[k],
        });
        let far: [f64; 3] = std::array::from_fn(|k| match d[k] {
            0.0 => f64::INFINITY,
            _ => near[k] + edge * self.inverse[k].abs(),
        });
        for j in rows {
            let down = j as f64;
            // Across an axis that the rays do not follow, they are between the faces or they are not.
            let mut columns = columns.clone();
            for k in (0..3).filter(|&k| d[k] == 0.0) {
                let row = start[k] + down * self.step[1][k];
                let between = |i: usize| (0.0..edge).contains(&(row + self.step[0][k] * i as f64));
                while !columns.is_empty() && !between(columns.start) {
                    columns.start += 1;
                }
                while !columns.is_empty() && !between(columns.end - 1) {
                    columns.end -= 1;
                }
            }
            let near: [f64; 3] = std::array::from_fn(|k| near[k] - down * self.slope[1][k]);
            let far: [f64; 3] = std::array::from_fn(|k| far[k] - down * self.slope[1][k]);
            for i in columns {
                let right = i as f64;
                let from: [f64; 3] = std::array::from_fn(|k| near[k] - right * self.slope[0][k]);
                let until: [f64; 3] = std::array::from_fn(|k| far[k] - right * self.slope[0][k]);
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

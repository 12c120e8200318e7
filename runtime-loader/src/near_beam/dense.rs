//! The sun's beam at a point by the dense extinction, in binary64: for points that lie near no site, and what the
//! faster ways of [`Extinction`](crate::extinction::Extinction) are held against.

use flb_format::matter::TurbidMedium;

/// Share of the sun's light that comes to a point, in lattice coordinates, unscattered.
pub(crate) fn transmittance(turbid: &TurbidMedium, point: [f64; 3], towards_sun: [f64; 3]) -> f32 {
    libm::expf(-depth(turbid, point, towards_sun) as f32)
}

/// Optical depth from a point, in lattice coordinates, along a direction until the lattice ends, exactly through every
/// site (3D DDA, Amanatides and Woo 1987).
pub(crate) fn depth(turbid: &TurbidMedium, point: [f64; 3], direction: [f64; 3]) -> f64 {
    let n = turbid.grid.lattice as usize;
    // Where the ray is inside the lattice.
    let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
    for axis in 0..3 {
        let (d, p) = (direction[axis], point[axis]);
        if d == 0.0 {
            if !(0.0..n as f64).contains(&p) {
                return 0.0;
            }
            continue;
        }
        let ends = [-p / d, (n as f64 - p) / d];
        enter = enter.max(ends[0].min(ends[1]));
        leave = leave.min(ends[0].max(ends[1]));
    }
    if !(enter < leave && leave.is_finite()) || point.iter().any(|c| c.is_nan()) {
        return 0.0;
    }
    let relative = turbid.angles.relative(direction[1]) as f32;
    let strides = [1, n as isize, (n * n) as isize];
    let mut site = 0;
    let mut next = [f64::INFINITY; 3];
    let mut step = [0.0; 3];
    let mut jump = [0; 3];
    let mut most = [0_usize; 3];
    for axis in 0..3 {
        let d = direction[axis];
        let p = point[axis] + enter * d;
        let at = (p.max(0.0) as usize).min(n - 1);
        site += at as isize * strides[axis];
        if d == 0.0 {
            continue;
        }
        let face = if d > 0.0 { at + 1 } else { at };
        // Rounding may put the entry a little past its face.
        next[axis] = ((face as f64 - point[axis]) / d).max(enter);
        step[axis] = 1.0 / d.abs();
        jump[axis] = if d > 0.0 { strides[axis] } else { -strides[axis] };
        most[axis] = if d > 0.0 { n - 1 - at } else { at };
    }
    let (mut depth, mut t) = (0.0_f64, enter);
    loop {
        let axis = if next[0] <= next[1] {
            if next[0] <= next[2] { 0 } else { 2 }
        } else if next[1] <= next[2] {
            1
        } else {
            2
        };
        let at = site as usize;
        let per_m = turbid.leaf_per_m[at] * relative + turbid.wood_per_m[at];
        depth += f64::from(per_m) * (next[axis] - t);
        if most[axis] == 0 {
            return depth * turbid.grid.spacing_m;
        }
        t = next[axis];
        next[axis] += step[axis];
        site += jump[axis];
        most[axis] -= 1;
    }
}

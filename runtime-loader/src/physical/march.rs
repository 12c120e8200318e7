//! The near beam of single points, by marching the extinction from them towards the sun.
//!
//! The mean over a cube weighs places by their extinction, so places are drawn in proportion to it: from sums of the
//! extinction over boxes, one axis after the other. Light that was scattered once is followed back: any way, as far as light
//! of that way comes, and from there towards the sun. Offsets come from the caller; with a low-discrepancy set the error of the
//! mean falls nearly with their number.

use std::borrow::Cow;
use std::f64::consts::PI;

use flb_format::Turbid;
use flb_format::beam::{MOST_MEANS, means, reaches};

use super::PhysicalSampler;

/// The means where one beam lights all around and nothing scatters.
pub fn everywhere(beam: f32, single: bool) -> [f32; MOST_MEANS] {
    std::array::from_fn(|j| if j <= reaches(single).len() { beam } else { 0.0 })
}

/// Beyond this optical depth less than 1e-8 is left: nothing.
const DARK: f64 = 18.5;

/// Finds the near beam of a species at points, for any sun, without preparing one.
///
/// Price: a search of the sums takes about 12 steps per place and a march one step per site that the ray crosses, up to three
/// times the lattice; a call makes one march and three more for every offset.
/// Memory: 8 bytes per site for the sums.
pub struct Marcher<'s> {
    turbid: &'s Turbid,
    /// Whether the fields need light scattered once.
    single: bool,
    sums: Cow<'s, Sums>,
}

/// Sums of the extinction over boxes of sites, which a [`Marcher`] draws places by.
#[derive(Debug, Clone, PartialEq)]
pub struct Sums(
    /// Over all sites below x, y, z; `[z][y][x]`, (N + 1)^3.
    Vec<f64>,
);

impl Sums {
    /// Of a medium.
    pub fn of(turbid: &Turbid) -> Sums {
        let n = turbid.grid.lattice as usize;
        let edge = n + 1;
        let mut sums = vec![0.0; edge * edge * edge];
        for z in 0..n {
            for y in 0..n {
                let mut row = 0.0;
                for x in 0..n {
                    row += f64::from(turbid.extinction((z * n + y) * n + x));
                    let at = ((z + 1) * edge + y + 1) * edge + x + 1;
                    sums[at] = row + sums[at - edge] + sums[at - edge * edge] - sums[at - edge - edge * edge];
                }
            }
        }
        Sums(sums)
    }

    /// Memory that they take.
    pub fn size_bytes(&self) -> usize {
        size_of_val(&self.0[..])
    }
}

impl<'s> Marcher<'s> {
    /// For a sampler's species.
    pub fn new(sampler: &'s PhysicalSampler) -> Marcher<'s> {
        let (turbid, single) = (&sampler.turbid, sampler.suns.needs_single());
        Marcher { turbid, single, sums: Cow::Owned(Sums::of(turbid)) }
    }

    /// For a medium whose sums are there; `single` says whether the fields need light scattered once.
    pub fn with_sums(turbid: &'s Turbid, sums: &'s Sums, single: bool) -> Marcher<'s> {
        Marcher { turbid, single, sums: Cow::Borrowed(sums) }
    }

    /// Estimates the means of the near beam (SPEC.md, section 10.4) at a point of model space, for a sun along the unit
    /// vector `towards_sun`: near_0 at the point itself, and each near_j from as many places in its cube as there are
    /// offsets. Offsets are points of the unit cube, each coordinate from 0 to below 1; without any, and where a cube
    /// holds no matter, near_j is near_0, and no light is scattered once. Means that the fields do not have are 0.
    pub fn near(
        &self,
        point_model_m: [f32; 3],
        towards_sun: [f64; 3],
        offsets: &[[f32; 3]],
    ) -> [f32; MOST_MEANS] {
        let n = self.turbid.grid.lattice as usize;
        let point = self.turbid.grid.lattice_from_model(point_model_m.map(f64::from));
        let site = point.map(|c| (c.max(0.0) as usize).min(n - 1));
        let mut near = everywhere(left(self.turbid, point, towards_sun), self.single);
        if self.single && !offsets.is_empty() {
            let light = |offset: &[f32; 3]| self.scattered_once(point, towards_sun, *offset);
            near[means(true) - 1] = offsets.iter().map(light).sum::<f32>() / offsets.len() as f32;
        }
        for (reach, near) in reaches(self.single).iter().zip(&mut near[1..]) {
            let reach = *reach as usize;
            let cube = site.map(|c| [c.saturating_sub(reach), (c + reach + 1).min(n)]);
            if offsets.is_empty() || self.sum(cube) <= 0.0 {
                continue;
            }
            let light = |offset: &[f32; 3]| left(self.turbid, self.draw(cube, *offset), towards_sun);
            *near = offsets.iter().map(light).sum::<f32>() / offsets.len() as f32;
        }
        near
    }

    /// Light that comes to a point, in lattice coordinates, along one way after one scattering, drawn by the offset: the ways are even,
    /// and how far off the light was scattered goes by the optical depth.
    fn scattered_once(&self, point: [f64; 3], towards_sun: [f64; 3], offset: [f32; 3]) -> f32 {
        let [u, v, w] = offset.map(f64::from);
        let z = 2.0 * u - 1.0;
        let (sin, cos) = libm::sincos(2.0 * PI * v);
        let across = libm::sqrt((1.0 - z * z).max(0.0));
        let back = [across * cos, across * sin, z];
        match travel(self.turbid, point, back, -libm::log1p(-w)) {
            Travel::Out { .. } => 0.0,
            Travel::Stopped { t } => {
                // Any place of the site, as its light is taken as even: by the digits of the offset that nothing else hangs on.
                let place = |axis: usize| {
                    let within = 64.0 * f64::from(offset[axis]);
                    libm::floor(point[axis] + t * back[axis]) + within - libm::floor(within)
                };
                left(self.turbid, std::array::from_fn(place), towards_sun)
            }
        }
    }

    /// A place in a box of sites, by density of extinction; even within its site.
    fn draw(&self, mut range: [[usize; 2]; 3], offset: [f32; 3]) -> [f64; 3] {
        let mut place = [0.0; 3];
        for axis in [2, 1, 0] {
            let whole = range;
            let [low, high] = whole[axis];
            let up_to = |end: usize| {
                let mut part = whole;
                part[axis] = [low, end];
                self.sum(part)
            };
            let wanted = f64::from(offset[axis]) * up_to(high);
            // The last layer in front of which less lies than is wanted.
            let (mut a, mut b) = (low, high);
            while b - a > 1 {
                let middle = (a + b) / 2;
                *(if up_to(middle) <= wanted { &mut a } else { &mut b }) = middle;
            }
            let before = up_to(a);
            let within = up_to(a + 1) - before;
            let t = if within > 0.0 { ((wanted - before) / within).clamp(0.0, 1.0) } else { 0.5 };
            place[axis] = a as f64 + t;
            range[axis] = [a, a + 1];
        }
        place
    }

    /// Extinction over a box of sites: first and behind the last, `[x, y, z]`.
    fn sum(&self, [x, y, z]: [[usize; 2]; 3]) -> f64 {
        let edge = self.turbid.grid.lattice as usize + 1;
        let row = |y: usize, z: usize| {
            let start = (z * edge + y) * edge;
            self.sums.0[start + x[1]] - self.sums.0[start + x[0]]
        };
        let layer = |z: usize| row(y[1], z) - row(y[0], z);
        layer(z[1]) - layer(z[0])
    }
}

/// Share of the sun's light that comes to a point, in lattice coordinates, unscattered.
pub fn left(turbid: &Turbid, point: [f64; 3], towards_sun: [f64; 3]) -> f32 {
    match travel(turbid, point, towards_sun, DARK) {
        Travel::Out { depth } => libm::expf(-depth as f32),
        Travel::Stopped { .. } => 0.0,
    }
}

/// Where a ray ends.
enum Travel {
    /// Outside the lattice, behind this optical depth.
    Out { depth: f64 },
    /// Where the optical depth is the most that was asked for, so many site edges from its start.
    Stopped { t: f64 },
}

/// Follows a ray from a point, in lattice coordinates, exactly through every site (3D DDA, Amanatides and Woo 1987).
fn travel(turbid: &Turbid, point: [f64; 3], direction: [f64; 3], most_depth: f64) -> Travel {
    let n = turbid.grid.lattice as usize;
    // Where the ray is inside the lattice.
    let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
    for axis in 0..3 {
        let (d, p) = (direction[axis], point[axis]);
        if d == 0.0 {
            if !(0.0..n as f64).contains(&p) {
                return Travel::Out { depth: 0.0 };
            }
            continue;
        }
        let ends = [-p / d, (n as f64 - p) / d];
        enter = enter.max(ends[0].min(ends[1]));
        leave = leave.min(ends[0].max(ends[1]));
    }
    if !(enter < leave && leave.is_finite()) || point.iter().any(|c| c.is_nan()) {
        return Travel::Out { depth: 0.0 };
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
    let stop = most_depth / turbid.grid.spacing_m;
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
        if depth > stop {
            return Travel::Stopped { t: next[axis] - (depth - stop) / f64::from(per_m) };
        }
        if most[axis] == 0 {
            return Travel::Out { depth: depth * turbid.grid.spacing_m };
        }
        t = next[axis];
        next[axis] += step[axis];
        site += jump[axis];
        most[axis] -= 1;
    }
}

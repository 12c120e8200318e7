//! From the suns of a scene and the ways its plants are turned to the bases that can ever have weight.
//!
//! A base has weight exactly where the light's direction d lies in the star of its corner, the triangles of the
//! polyhedron that share the corner without their outer edges. From the weights of [`blend`](super::blend), with c the
//! corner: along an axis a, `d_a > |d_b| + |d_c|`; between two axes a and b, `d_a > 0`, `d_b > 0` and
//! `d_a + d_b > |d_c|` (signs as c's). Either is an open convex cone with four plane faces, so "some sun of the set
//! gives the base weight" is "the set meets the cone", which is decided without sampling:
//!
//! * plants that turn freely about the vertical see a band of elevations, and every cone covers an interval of
//!   elevations;
//! * for one given rotation the set is cut into patches. A patch that is farther outside one face than its radius is
//!   outside the cone. A patch whose centre is a sun inside the cone meets it. Any other is halved, down to patches of
//!   the guard's size.
//!
//! The answer errs on one side only: a base is kept where the set passes its cone within [`GUARD_DEG`], so
//! that a renderer that rounds a sun's direction otherwise than we do still finds the base.

use super::towards_sun;
use crate::bases::BaseSet;
use crate::direction::{DIRECTIONS, MOVING};

/// A base is kept where a sun of the set is within this of giving it weight.
pub const GUARD_DEG: f64 = 0.01;
/// [`GUARD_DEG`] as a length on the unit sphere, rounded up.
const GUARD: f64 = 1.75e-4;
/// Patches up to this radius are kept for the next rotation; smaller ones are made again.
const KEPT_RADIUS: f64 = 0.02;
/// Hour angles that a zone is first cut into, so that no patch is larger than the proof's halving likes.
const FIRST_HOURS: usize = 16;
/// Elevation of the diagonals' horizontal star at its highest: atan(sqrt 2), degrees.
const DIAGONAL_TOP_DEG: f64 = 54.735_610_317_245_35;

/// Suns in the world's frame: +Y up, north = -Z, east = +X.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SunSet {
    /// Suns that stand still: azimuth and elevation, degrees, as [`towards_sun`] takes them. They may stand below the
    /// horizon.
    pub fixed_deg: Vec<[f64; 2]>,
    /// Suns that move; what of a zone is below the horizon does not count.
    pub zones: Vec<Zone>,
}

/// The suns of whole days: every hour angle, at declinations of a range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Zone {
    /// Latitude of the observer, degrees, -90 to 90: the elevation of the celestial north pole.
    pub latitude_deg: f64,
    /// Smallest and largest declination of the sun, degrees, -90 to 90.
    pub declination_deg: [f64; 2],
}

impl Zone {
    /// Every sun above the horizon.
    pub const SKY: Zone = Zone { latitude_deg: 90.0, declination_deg: [0.0, 90.0] };

    /// Lowest and highest elevation, degrees, at or above the horizon; `None` if no sun rises.
    ///
    /// A declination d culminates at 90 - |latitude - d| and is lowest at -90 + |latitude + d|.
    pub fn elevations_deg(&self) -> Option<[f64; 2]> {
        let [low, high] = self.declination_deg;
        let highest = 90.0 - (self.latitude_deg - self.latitude_deg.clamp(low, high)).abs();
        let lowest = -90.0 + (self.latitude_deg + (-self.latitude_deg).clamp(low, high)).abs();
        (highest >= 0.0).then_some([lowest.max(0.0), highest])
    }

    /// Unit vector towards the sun at a declination and an hour angle, degrees.
    fn sun(&self, declination_deg: f64, hour_deg: f64) -> [f64; 3] {
        let (sin_latitude, cos_latitude) = super::sin_cos_deg(self.latitude_deg);
        let (sin_declination, cos_declination) = super::sin_cos_deg(declination_deg);
        let (sin_hour, cos_hour) = super::sin_cos_deg(hour_deg);
        // In the frame of the meridian: towards the pole, and towards the culmination of declination 0.
        let (pole, noon) = (sin_declination, cos_declination * cos_hour);
        [
            -cos_declination * sin_hour,
            pole * sin_latitude + noon * cos_latitude,
            noon * sin_latitude - pole * cos_latitude,
        ]
    }
}

/// A rotation, world from model: `[row][column]`.
pub type Rotation = [[f64; 3]; 3];

/// A set of suns, made ready for questions.
pub struct Reach {
    any_yaw: BaseSet,
    zones: Vec<Zone>,
    patches: Vec<Patch>,
    /// The first patches are the roots.
    roots: usize,
}

/// A part of the set.
#[derive(Clone, Copy)]
struct Patch {
    /// Towards the sun, unit length; of several fixed suns their mean, which need not be one of them.
    center: [f64; 3],
    /// No sun of the patch is farther from the centre, as a straight line.
    radius: f64,
    /// Index of the zone, its declinations and hour angles; `None` for fixed suns.
    zone: Option<(usize, [[f64; 2]; 2])>,
    /// Index of the first of two halves, where they are kept. A patch of fixed suns without halves is one sun.
    halves: Option<usize>,
}

impl Reach {
    /// Prepares a set; the work is bounded, whatever the set.
    pub fn new(suns: &SunSet) -> Reach {
        let mut patches: Vec<Patch> = Vec::new();
        let mut fixed: Vec<[f64; 3]> = suns.fixed_deg.iter().map(|[a, e]| towards_sun(*a, *e)).collect();
        patches.extend((!fixed.is_empty()).then(|| ball(&fixed)));
        let risen = |(_, zone): &(usize, &Zone)| zone.elevations_deg().is_some();
        for (index, zone) in suns.zones.iter().enumerate().filter(risen) {
            for hour in 0..FIRST_HOURS {
                let width = 360.0 / FIRST_HOURS as f64;
                let hours = [hour as f64 * width, (hour + 1) as f64 * width];
                patches.push(zone_patch(index, zone, [zone.declination_deg, hours]));
            }
        }
        let roots = patches.len();
        if !fixed.is_empty() {
            split(&mut fixed, &mut patches, 0);
        }
        let mut reach = Reach { any_yaw: any_yaw(suns), zones: suns.zones.clone(), patches, roots };
        let mut at = 0;
        while at < reach.patches.len() {
            let patch = reach.patches[at];
            if patch.zone.is_some() && patch.radius > KEPT_RADIUS && !patch.is_below_horizon() {
                reach.patches[at].halves = Some(reach.patches.len());
                let halves = reach.halve(&patch);
                reach.patches.extend(halves);
            }
            at += 1;
        }
        reach
    }

    /// Whether there is no sun at all.
    pub fn is_dark(&self) -> bool {
        self.any_yaw.is_empty()
    }

    /// The directional bases that plants need which turn freely about the vertical.
    pub fn any_yaw(&self) -> BaseSet {
        self.any_yaw
    }

    /// Adds the directional bases that a plant of this rotation needs. A rotation about the vertical alone must keep Y
    /// exactly (its second row and column are those of the identity) to be spared the bases on the far side of the
    /// horizon.
    pub fn add_rotated(&self, rotation: &Rotation, reached: &mut BaseSet) {
        let keeps_up = rotation[1] == [0.0, 1.0, 0.0];
        let possible = if keeps_up { self.any_yaw } else { BaseSet::ALL };
        for base in 1..=MOVING as u8 {
            if reached.contains(base) || !possible.contains(base) {
                continue;
            }
            // A sun s gives weight where face . (rotation^-1 (-s)) > 0, that is -(rotation face) . s > 0.
            let faces = faces(base).map(|face| std::array::from_fn(|row| -dot(rotation[row], face)));
            if self.patches[..self.roots].iter().any(|patch| self.meets(patch, &faces)) {
                *reached = reached.with(base);
            }
        }
    }

    /// Whether a patch comes within the guard of the cone of these faces.
    fn meets(&self, patch: &Patch, faces: &[[f64; 3]; 4]) -> bool {
        let depth = faces.iter().map(|face| dot(*face, patch.center)).fold(f64::INFINITY, f64::min);
        if depth + patch.radius <= -GUARD || patch.is_below_horizon() {
            return false;
        }
        let center_is_sun =
            if patch.zone.is_some() { patch.center[1] >= 0.0 } else { patch.halves.is_none() };
        if (depth > 0.0 && center_is_sun) || patch.radius <= GUARD {
            return true;
        }
        match patch.halves {
            Some(first) => self.patches[first..first + 2].iter().any(|half| self.meets(half, faces)),
            None => self.halve(patch).iter().any(|half| self.meets(half, faces)),
        }
    }

    /// Cuts a patch of a zone across its longer side.
    fn halve(&self, patch: &Patch) -> [Patch; 2] {
        let (zone, sides) = patch.zone.expect("fixed suns have halves, or are one of no radius");
        let longer = usize::from(sides[1][1] - sides[1][0] > sides[0][1] - sides[0][0]);
        let middle = 0.5 * (sides[longer][0] + sides[longer][1]);
        [0, 1].map(|half| {
            let mut sides = sides;
            sides[longer][1 - half] = middle;
            zone_patch(zone, &self.zones[zone], sides)
        })
    }
}

impl Patch {
    /// Whether all of it is below the horizon, which only counts for zones.
    fn is_below_horizon(&self) -> bool {
        self.zone.is_some() && self.center[1] + self.radius < 0.0
    }
}

/// A patch around fixed suns; not none.
fn ball(suns: &[[f64; 3]]) -> Patch {
    let share = 1.0 / suns.len() as f64;
    let center = std::array::from_fn(|axis| suns.iter().map(|sun| sun[axis]).sum::<f64>() * share);
    let from_center = |sun: &[f64; 3]| {
        let apart: [f64; 3] = std::array::from_fn(|axis| sun[axis] - center[axis]);
        libm::sqrt(dot(apart, apart))
    };
    // Wider than what the mean and the lengths round.
    let radius = suns.iter().map(from_center).fold(0.0, f64::max) + 1e-12;
    Patch { center, radius, zone: None, halves: None }
}

/// Halves fixed suns, of which `patches[at]` is the ball, along their longest extent, until each is alone: a path given
/// as a thousand suns is then asked for in tens of steps.
fn split(suns: &mut [[f64; 3]], patches: &mut Vec<Patch>, at: usize) {
    if suns.len() == 1 {
        return;
    }
    let extent = |axis: usize| {
        let values = || suns.iter().map(|sun| sun[axis]);
        values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
    };
    let extents: [f64; 3] = std::array::from_fn(extent);
    let longest = (1..3).fold(0, |best, axis| if extents[axis] > extents[best] { axis } else { best });
    suns.sort_unstable_by(|a, b| a[longest].total_cmp(&b[longest]));
    let (left, right) = suns.split_at_mut(suns.len() / 2);
    let first = patches.len();
    patches[at].halves = Some(first);
    patches.extend([ball(left), ball(right)]);
    split(left, patches, first);
    split(right, patches, first + 1);
}

/// Between two points of the sphere `a` and `b` radians apart along meridian and parallel lie at most
/// `sqrt(a^2 + b^2)` as a straight line: its square is 4 sin^2(a / 2) + 4 cos cos sin^2(b / 2).
fn zone_patch(index: usize, zone: &Zone, sides: [[f64; 2]; 2]) -> Patch {
    let middle = sides.map(|[low, high]| 0.5 * (low + high));
    let half = sides.map(|[low, high]| (0.5 * (high - low)).to_radians());
    // Wider than the exact radius by far more than the sines round.
    let radius = libm::sqrt(half[0] * half[0] + half[1] * half[1]) * (1.0 + 1e-9) + 1e-12;
    let center = zone.sun(middle[0], middle[1]);
    Patch { center, radius, zone: Some((index, sides)), halves: None }
}

/// The unit normals of a star's four faces, inwards.
fn faces(base: u8) -> [[f64; 3]; 4] {
    let c = DIRECTIONS[base as usize].map(f64::from);
    let along: Vec<usize> = (0..3).filter(|&axis| c[axis] != 0.0).collect();
    let third = 1.0 / libm::sqrt(3.0);
    // c plus or minus each axis that it lacks.
    let slanted = |signs: &[f64]| {
        let mut face = c;
        for (axis, sign) in (0..3).filter(|axis| !along.contains(axis)).zip(signs) {
            face[axis] = *sign;
        }
        face.map(|v| v * third)
    };
    let straight = |axis: usize| std::array::from_fn(|i| if i == axis { c[i] } else { 0.0 });
    match along[..] {
        [a, b] => [straight(a), straight(b), slanted(&[1.0]), slanted(&[-1.0])],
        _ => [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]].map(|signs| slanted(&signs)),
    }
}

/// The bases of every sun of the set, turned about the vertical by any angle.
fn any_yaw(suns: &SunSet) -> BaseSet {
    let fixed = suns.fixed_deg.iter().map(|[_, elevation_deg]| [*elevation_deg; 2]);
    let bands = fixed.chain(suns.zones.iter().filter_map(Zone::elevations_deg));
    bands.map(of_elevations).fold(BaseSet::NONE, BaseSet::union)
}

/// The bases that some direction at elevations of a closed range gives weight, widened by the guard. Turning about the
/// vertical keeps the horizon and the zenith exactly, so there the range is not widened.
fn of_elevations([low, high]: [f64; 2]) -> BaseSet {
    let widened = |value: f64, by: f64| if value * (value + by) <= 0.0 { 0.0 } else { value + by };
    let low = if low >= 90.0 { 90.0 } else { widened(low, -GUARD_DEG) };
    let high = if high <= -90.0 { -90.0 } else { widened(high, GUARD_DEG) };
    // Elevation of the sun; light that travels down comes from above.
    let meets = |base: &u8| {
        let [x, y, z] = DIRECTIONS[usize::from(*base)];
        let axial = x * x + y * y + z * z == 1;
        // Both ends open, but that the zenith itself belongs to the star of straight down.
        let (from, to) = match (y, axial) {
            (0, true) => (-45.0, 45.0),
            (0, false) => (-DIAGONAL_TOP_DEG, DIAGONAL_TOP_DEG),
            (-1, true) => (45.0, f64::INFINITY),
            (-1, false) => (0.0, 90.0),
            (_, true) => (f64::NEG_INFINITY, -45.0),
            (_, false) => (-90.0, 0.0),
        };
        high > from && low < to
    };
    (1..=MOVING as u8).filter(meets).collect()
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests;

//! From a camera to the lattice that a species deserves: the finest that its largest picture can show.

use flb_format::Placement;
use flb_format::meta::Bounds;

use flb_scene::scene::Camera;

/// The smallest and the largest lattice.
const LATTICES: [u32; 2] = [16, 256];
/// Steps of the search for the nearest point of a camera's straight line: each keeps 0.618 of the rest.
const SEARCH_STEPS: usize = 48;

/// Size at which a species is seen, and the lattice that follows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OnScreen {
    /// Largest size of the bounds' longest edge, pixels: infinite where the camera comes inside the bounds.
    pub size_px: f64,
    /// Distance from the camera to the bounds there.
    pub distance_m: f64,
    /// The lattice that the rule asks for, before the limits of the format; a power of two, or 0 for an infinite one.
    pub wanted: u64,
    /// The lattice, 16 to 256.
    pub lattice: u32,
}

/// The largest that any of the instances (all of one species, with these bounds) is seen from the camera's path.
///
/// The lattice is the smallest power of two that has a site for every `pixels_per_site` pixels of the plant's longest
/// edge. The default of 4 is the papers' own ratio, 128 sites across a tree that fills a picture of 512 pixels: light
/// varies smoothly from site to site, and twice the sites cost eight times the memory and time. A pixel is that of the
/// picture's centre, as the camera may turn.
pub fn on_screen<'a>(
    camera: &Camera,
    bounds: &Bounds,
    instances: impl Iterator<Item = &'a Placement>,
) -> Option<OnScreen> {
    let extent_m = (0..3).map(|axis| bounds.max[axis] - bounds.min[axis]).fold(0.0, f64::max);
    let pixels_per_radian =
        f64::from(camera.height_px) / (2.0 * libm::tan(camera.fov_deg.to_radians() / 2.0));
    let mut largest: Option<(f64, f64)> = None;
    for instance in instances {
        let size = |distance_m: f64| pixels_per_radian * extent_m * instance.transform.scale / distance_m;
        // A sphere around the bounds is nearer than they are, and quickly asked.
        let ball = Ball::around(bounds, instance);
        for leg in legs(&camera.path_m) {
            let nearest = (ball.distance_to(leg) - ball.radius_m).max(0.0);
            if largest.is_some_and(|(size_px, _)| size(nearest) <= size_px) {
                continue;
            }
            let distance_m = distance_to_bounds(leg, bounds, instance);
            if largest.is_none_or(|(size_px, _)| size(distance_m) > size_px) {
                largest = Some((size(distance_m), distance_m));
            }
        }
    }
    largest.map(|(size_px, distance_m)| {
        // A hair over a power of two is rounding, not a reason to double the lattice.
        let sites = libm::ceil(size_px / camera.pixels_per_site * (1.0 - 1e-9));
        let wanted = if sites < 1e15 { (sites as u64).next_power_of_two() } else { 0 };
        let lattice = if wanted == 0 { LATTICES[1] } else { wanted.min(256) as u32 }.max(LATTICES[0]);
        OnScreen { size_px, distance_m, wanted, lattice }
    })
}

/// The straight lines of a camera's path; a single point is a line without length.
fn legs(path_m: &[[f64; 3]]) -> impl Iterator<Item = [[f64; 3]; 2]> {
    let alone = (path_m.len() == 1).then(|| [path_m[0]; 2]);
    alone.into_iter().chain(path_m.windows(2).map(|pair| [pair[0], pair[1]]))
}

/// A sphere in the world.
struct Ball {
    center_m: [f64; 3],
    radius_m: f64,
}

impl Ball {
    fn around(bounds: &Bounds, instance: &Placement) -> Ball {
        let middle: [f64; 3] = std::array::from_fn(|axis| 0.5 * (bounds.min[axis] + bounds.max[axis]));
        let half = std::array::from_fn(|axis| 0.5 * (bounds.max[axis] - bounds.min[axis]));
        let center_m = std::array::from_fn(|row| {
            instance.transform.position_m[row]
                + instance.transform.scale * dot(instance.transform.rotation[row], middle)
        });
        // Larger than the exact radius by more than all of this rounds.
        let radius_m = length(half) * instance.transform.scale * (1.0 + 1e-9) + 1e-9 * length(center_m);
        Ball { center_m, radius_m }
    }

    /// From the nearest point of a line.
    fn distance_to(&self, [a, b]: [[f64; 3]; 2]) -> f64 {
        let (along, to) = (minus(b, a), minus(self.center_m, a));
        let squared = dot(along, along);
        let t = if squared > 0.0 { (dot(along, to) / squared).clamp(0.0, 1.0) } else { 0.0 };
        length(minus(to, along.map(|c| c * t)))
    }
}

/// Metres from the nearest point of a line to an instance's bounds. The distance to a convex body is convex along
/// the line, so a golden-section search finds its smallest value.
fn distance_to_bounds(leg: [[f64; 3]; 2], bounds: &Bounds, instance: &Placement) -> f64 {
    let [a, b]: [[f64; 3]; 2] = leg.map(|point| {
        let from = minus(point, instance.transform.position_m);
        std::array::from_fn(|column| {
            (0..3).map(|row| instance.transform.rotation[row][column] * from[row]).sum::<f64>()
                / instance.transform.scale
        })
    });
    let distance = |t: f64| {
        let outside = std::array::from_fn(|axis| {
            let at = a[axis] + t * (b[axis] - a[axis]);
            at - at.clamp(bounds.min[axis], bounds.max[axis])
        });
        length(outside) * instance.transform.scale
    };
    let mut best = distance(0.0).min(distance(1.0));
    if a == b {
        return best;
    }
    let golden = 0.5 * (5.0f64.sqrt() - 1.0);
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..SEARCH_STEPS {
        let (left, right) = (high - golden * (high - low), low + golden * (high - low));
        let (at_left, at_right) = (distance(left), distance(right));
        best = best.min(at_left).min(at_right);
        if at_left < at_right { high = right } else { low = left }
    }
    best
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests;

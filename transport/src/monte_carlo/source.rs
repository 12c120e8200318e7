//! Where light enters the bounding box, from where, and how much of it.

use glam::DVec3;

use super::Illumination;
use super::draw::{Draw, Even};
use super::sites::{PhotonPosition, Sites};

/// A ray of light at the side of the box.
pub(super) struct Start {
    pub place: PhotonPosition,
    pub direction: DVec3,
    /// Area of the box across the direction, in square sites: the light that all rays of the direction carry.
    pub area: f64,
    /// An even number, 0..1, for the first collision.
    pub depth: f64,
}

/// An endless sequence of rays.
pub(super) enum Source {
    Beam(DVec3, Even<3>),
    Sky(Even<5>),
}

impl Source {
    /// `light` is checked.
    pub(super) fn new(light: Illumination, draw: &mut Draw) -> Source {
        match light {
            Illumination::Sun(toward) => Source::Beam(-DVec3::from_array(toward), Even::new(draw)),
            Illumination::Sky => Source::Sky(Even::new(draw)),
        }
    }

    pub(super) fn start(&mut self, sites: &Sites) -> Start {
        match self {
            Source::Beam(direction, points) => {
                let [u, v, depth] = points.point();
                enter(sites, *direction, u, v, depth)
            }
            Source::Sky(points) => {
                let [u, v, depth, height, turn] = points.point();
                let (up, turn) = (2.0 * height - 1.0, std::f64::consts::TAU * turn);
                let level = (1.0 - up * up).max(0.0).sqrt();
                let direction = DVec3::new(level * libm::cos(turn), up, level * libm::sin(turn));
                enter(sites, direction, u, v, depth)
            }
        }
    }
}

/// A point of the lit sides, even as seen along the direction: `u` chooses the side, too.
fn enter(sites: &Sites, direction: DVec3, u: f64, v: f64, depth: f64) -> Start {
    let size = sites.size.map(f64::from);
    let shown: [f64; 3] = std::array::from_fn(|axis| match sites.wraps[axis] {
        true => 0.0,
        false => direction[axis].abs() * size[(axis + 1) % 3] * size[(axis + 2) % 3],
    });
    let area = shown[0] + shown[1] + shown[2];
    let mut along = u * area;
    let mut side = 0;
    // Rounding may carry `along` past the last side that is lit at all.
    while side < 2
        && (along >= shown[side] || shown[side] == 0.0)
        && shown[side + 1..].iter().any(|&s| s > 0.0)
    {
        along -= shown[side];
        side += 1;
    }
    let mut at = DVec3::ZERO;
    at[(side + 1) % 3] = (along / shown[side]).clamp(0.0, 1.0) * size[(side + 1) % 3];
    at[(side + 2) % 3] = v * size[(side + 2) % 3];
    Start { place: sites.on_side(side, at, direction), direction, area, depth }
}

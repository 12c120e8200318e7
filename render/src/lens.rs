//! What a camera's rays are made of, whether it was placed in a forest or before a plant: where it stands and what it
//! sees at distance 1.

use glam::DVec3;

/// A perspective camera with the size of its picture.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lens {
    /// Position of the lens, metres.
    pub position: DVec3,
    /// Unit vector into the middle of the picture.
    pub forward: DVec3,
    /// Half the picture's width at distance 1, to the right.
    pub right: DVec3,
    /// Half the picture's height at distance 1, upwards.
    pub up: DVec3,
    /// Pixels.
    size: [f64; 2],
}

impl Lens {
    /// One that looks along a unit vector, opened so far in degrees from the lower to the upper edge.
    pub(crate) fn along(position: DVec3, forward: DVec3, fov_deg: f64, size: [u32; 2]) -> Lens {
        let ([right, up], [half_width, half_height]) = (upright(forward), half(fov_deg, size));
        Lens { position, forward, right: right * half_width, up: up * half_height, size: size.map(f64::from) }
    }

    /// Unit vector through a point of the picture, in pixels from the upper left corner.
    pub(crate) fn direction(&self, x: f64, y: f64) -> DVec3 {
        let across = x / self.size[0] * 2.0 - 1.0;
        let down = y / self.size[1] * 2.0 - 1.0;
        (self.forward + self.right * across - self.up * down).normalize()
    }

    /// Where a point is seen, in pixels from the upper left corner; nothing at or behind the plane of the eye.
    pub(crate) fn project(&self, point: DVec3) -> Option<[f64; 2]> {
        let offset = point - self.position;
        let depth = offset.dot(self.forward);
        // Nearer than a billionth of the way off, the picture's coordinates lose their meaning.
        if depth <= 1e-9 * offset.length() {
            return None;
        }
        let along = |axis: DVec3| offset.dot(axis) / axis.length_squared() / depth;
        Some([(1.0 + along(self.right)) / 2.0 * self.size[0], (1.0 - along(self.up)) / 2.0 * self.size[1]])
    }

    /// Whether a point lies behind the plane of the eye.
    pub(crate) fn is_behind(&self, point: DVec3) -> bool {
        (point - self.position).dot(self.forward) < 0.0
    }
}

/// Unit vectors to the right and upwards in a picture whose middle lies along a unit vector. Straight up and straight
/// down, the top of the picture is north.
pub(crate) fn upright(forward: DVec3) -> [DVec3; 2] {
    let right = forward.cross(DVec3::Y).try_normalize().unwrap_or(DVec3::X);
    [right, right.cross(forward)]
}

/// Half the width and height, at distance 1, of a picture of `size` pixels that is opened so far from the lower to the
/// upper edge.
pub(crate) fn half(fov_deg: f64, size: [u32; 2]) -> [f64; 2] {
    let [width, height] = size.map(f64::from);
    let half_height = libm::tan(fov_deg.to_radians() / 2.0);
    [half_height * width / height, half_height]
}

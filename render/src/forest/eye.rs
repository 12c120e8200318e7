//! A perspective camera that stands at a point and looks at another.

use glam::DVec3;

use super::placed::WorldRay;
use crate::RenderError;

/// Where a picture is taken from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Eye {
    /// Where it stands.
    pub position_m: [f64; 3],
    /// What it looks at, in the middle of the picture.
    pub look_at_m: [f64; 3],
    /// Vertical opening angle.
    pub fov_deg: f64,
}

impl Eye {
    /// Unit vector into the middle of a picture of `size` pixels, and from there half its width to the right and half its height
    /// up, all at distance 1.
    ///
    /// # Errors
    /// [`RenderError::Setting`] for an eye that sees nothing.
    pub fn frame(&self, size: [u32; 2]) -> Result<[[f64; 3]; 3], RenderError> {
        let lens = Lens::new(self, size)?;
        Ok([lens.forward, lens.right, lens.up].map(|axis| axis.to_array()))
    }
}

/// An [`Eye`] with the size of its picture.
pub(crate) struct Lens {
    pub position: DVec3,
    forward: DVec3,
    /// Half the picture's width and height at distance 1.
    right: DVec3,
    up: DVec3,
    size: [f64; 2],
}

impl Lens {
    pub fn new(eye: &Eye, size: [u32; 2]) -> Result<Lens, RenderError> {
        let refuse = |name, found: String, expected: &str| {
            Err(RenderError::Setting { name, found, expected: expected.into() })
        };
        let (position, target) = (DVec3::from(eye.position_m), DVec3::from(eye.look_at_m));
        if !position.is_finite() {
            return refuse("position_m", format!("{:?}", eye.position_m), "finite coordinates");
        }
        let Some(forward) = (target - position).try_normalize() else {
            let found = format!("{:?}", eye.look_at_m);
            return refuse("look_at_m", found, "a finite point other than where the camera stands");
        };
        if !(0.001..=179.0).contains(&eye.fov_deg) {
            return refuse("fov_deg", eye.fov_deg.to_string(), "0.001..=179");
        }
        // Straight up and straight down, the top of the picture is north.
        let right = forward.cross(DVec3::Y).try_normalize().unwrap_or(DVec3::X);
        let up = right.cross(forward);
        let [width, height] = size.map(f64::from);
        let half_height = libm::tan(eye.fov_deg.to_radians() / 2.0);
        let half_width = half_height * width / height;
        Ok(Lens { position, forward, right: right * half_width, up: up * half_height, size: [width, height] })
    }

    /// The ray through a point of the picture, in pixels from the upper left corner.
    pub fn ray(&self, x: f64, y: f64) -> WorldRay {
        let across = x / self.size[0] * 2.0 - 1.0;
        let down = y / self.size[1] * 2.0 - 1.0;
        let direction = (self.forward + self.right * across - self.up * down).normalize();
        WorldRay { origin: self.position, direction }
    }

    /// Where a point is seen, in pixels from the upper left corner; nothing at or behind the plane of the eye.
    pub fn project(&self, point: DVec3) -> Option<[f64; 2]> {
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
    pub fn is_behind(&self, point: DVec3) -> bool {
        (point - self.position).dot(self.forward) < 0.0
    }
}

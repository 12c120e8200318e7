//! The camera of a forest's picture: an [`Eye`] that was checked, and the rays it sends out.

use flb_format::eye::Eye;
use glam::DVec3;

use super::placed::WorldRay;
use crate::{RenderError, lens::Lens};

/// The lens of an eye for a picture of `size` pixels.
///
/// # Errors
/// [`RenderError::Setting`] for an eye that sees nothing.
pub(crate) fn lens(eye: &Eye, size: [u32; 2]) -> Result<Lens, RenderError> {
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
    Ok(Lens::along(position, forward, eye.fov_deg, size))
}

impl Lens {
    /// The ray through a point of the picture, in pixels from the upper left corner.
    pub(crate) fn ray(&self, x: f64, y: f64) -> WorldRay {
        WorldRay { origin: self.position, direction: self.direction(x, y) }
    }
}

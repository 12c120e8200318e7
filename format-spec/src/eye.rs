//! Where a picture is taken from: what scene files say, renderers trace and streamers load for.

/// A point that is looked from and one that is looked at. The top of the picture is up; straight up and straight down,
/// it is north.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Eye {
    /// Position of the eye, metres.
    pub position_m: [f64; 3],
    /// Point in the middle of the picture, metres; another point than the position.
    pub look_at_m: [f64; 3],
    /// Vertical opening angle, degrees, above 0, below 180.
    pub fov_deg: f64,
}

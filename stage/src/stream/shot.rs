//! What a painter is asked for.

use flb_format::eye::Eye;

/// Content of a picture: light or false colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Show {
    /// All light.
    Whole,
    /// Baked light alone.
    Indirect,
    /// Sun alone.
    Direct,
    /// The light of one base, by its place among those of each species.
    Base(u16),
    /// Missing light: from nothing loaded (red) over other bases and averages to nothing missing (green).
    Level,
    /// Share of the detail around a point that is loaded: from none (black) to all (white).
    Residency,
    /// Distance of the light of what is loaded from that of the whole file: from nothing (black) to 10 % of the light
    /// there and more (white).
    Error,
}

/// Eye, sun and content of a painted picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shot {
    /// Position and direction of the camera.
    pub eye: Eye,
    /// Azimuth and elevation of the sun, degrees.
    pub sun_deg: [f64; 2],
    /// Content of the picture.
    pub show: Show,
}

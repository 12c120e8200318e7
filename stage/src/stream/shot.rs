//! What a painter is asked for.

use flb_format::Eye;

/// What the picture shows.
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
    /// What of the light is missing: from nothing (red) over other bases and averages to nothing missing (green).
    Level,
    /// How much of the detail around a point is loaded: from none (black) to all (white).
    Residency,
    /// How far the light of what is loaded is from that of the whole file: from nothing (black) to 10 % of the light
    /// there and more (white).
    Error,
}

/// What a picture is painted by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shot {
    /// From where.
    pub eye: Eye,
    /// Azimuth and elevation of the sun, degrees.
    pub sun_deg: [f64; 2],
    /// What.
    pub show: Show,
}

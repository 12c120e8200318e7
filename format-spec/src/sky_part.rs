//! A small part of a sky: what light under an uneven sky is summed over.

/// A part of a sky that is small enough to be a sun.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkyPart {
    /// Unit, in the world.
    pub towards: [f64; 3],
    /// Part of the sphere; those of all parts sum to 4 pi.
    pub solid_angle: f64,
    /// Radiance times solid angle, R, G, B.
    pub fluence: [f32; 3],
}

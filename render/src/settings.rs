//! Limits of a picture, and the checks of numbers that a caller chose.

use crate::RenderError;

/// Longest edge of a picture, pixels.
pub const MAX_EDGE: u32 = 16_384;
/// Largest number of pixels of a picture: 64 Mi, 768 MiB of linear colour.
pub const MAX_PIXELS: u64 = 1 << 26;
/// Largest number of samples per pixel.
pub const MAX_SAMPLES: u32 = 4_096;

pub(crate) fn range(name: &'static str, found: f64, low: f64, high: f64) -> Result<(), RenderError> {
    match found >= low && found <= high {
        true => Ok(()),
        false => {
            Err(RenderError::Setting { name, found: found.to_string(), expected: format!("{low}..={high}") })
        }
    }
}

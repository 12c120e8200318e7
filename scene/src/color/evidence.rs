//! Whether a texture is a tint of a measured surface, or a colour of its own.

use glam::DVec3;

/// Largest distance between the colours of a texture and of a surface that is a tint of it.
pub const MAX_APART: f64 = 0.15;

/// Least reflectance of a texture that says nothing because it is white: exporters write white where the colour is
/// elsewhere.
const WHITE: f64 = 0.95;

/// Largest reflectance of a texture that is black: no plant is, and a picture without light tells no colour.
const DARK: f64 = 1e-3;

/// Evidence of a material's mean colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Evidence {
    /// White: the material has no colour of its own.
    White,
    /// Black.
    Black,
    /// Distance from the measured colour, [`MAX_APART`] at most.
    Near(f64),
    /// Distance from the measured colour, more than [`MAX_APART`].
    Far(f64),
}

impl Evidence {
    /// Judges a mean colour, linear R, G, B, beside the reflectance of the measured surface.
    pub fn of(mean: DVec3, measured: DVec3) -> Evidence {
        if mean.min_element() >= WHITE {
            return Evidence::White;
        }
        if mean.max_element() <= DARK {
            return Evidence::Black;
        }
        let apart = apart(mean, measured);
        if apart <= MAX_APART { Evidence::Near(apart) } else { Evidence::Far(apart) }
    }
}

/// Distance of a colour from a measured one, whatever the brightness of both: shares of R, G and B that the colour has
/// more than the measured one, but for the strongest of that. A purer green is no other colour than green. 0 for the
/// same hue, 1 for a pure one of another band beside a pure one.
pub fn apart(color: DVec3, measured: DVec3) -> f64 {
    let share = |color: DVec3| color / color.element_sum().max(f64::MIN_POSITIVE);
    let more = (share(color) - share(measured)).max(DVec3::ZERO);
    let strongest =
        DVec3::select(measured.cmpeq(DVec3::splat(measured.max_element())), DVec3::ZERO, DVec3::ONE);
    (more * strongest).element_sum()
}

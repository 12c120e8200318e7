//! Whether a texture is a tint of a measured surface, or a colour of its own.

use glam::DVec3;

/// Largest distance between the colours of a texture and of a surface that is a tint of it.
pub const MOST_APART: f64 = 0.15;

/// Least reflectance of a texture that says nothing because it is white: exporters write white where the colour is
/// elsewhere.
const WHITE: f64 = 0.95;

/// Largest reflectance of a texture that is black: no plant is, and a picture without light tells no colour.
const DARK: f64 = 1e-3;

/// What a material's mean colour tells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Evidence {
    /// White: the material has no colour of its own.
    White,
    /// Black.
    Black,
    /// So far from the measured colour, [`MOST_APART`] at most.
    Near(f64),
    /// So far from it, more than that.
    Far(f64),
}

impl Evidence {
    /// Of a mean colour, linear R, G, B, beside the reflectance of the measured surface.
    pub fn of(mean: DVec3, measured: DVec3) -> Evidence {
        if mean.min_element() >= WHITE {
            return Evidence::White;
        }
        if mean.max_element() <= DARK {
            return Evidence::Black;
        }
        let apart = apart(mean, measured);
        if apart <= MOST_APART { Evidence::Near(apart) } else { Evidence::Far(apart) }
    }
}

/// How far two colours are apart, whatever their brightness: half of the sum of the differences of their shares of R, G
/// and B. 0 for colours of one hue and saturation, 1 for two pure ones.
pub fn apart(a: DVec3, b: DVec3) -> f64 {
    let share = |color: DVec3| color / color.element_sum().max(f64::MIN_POSITIVE);
    (share(a) - share(b)).abs().element_sum() / 2.0
}

//! Whether a texture is a tint of a measured surface, or a colour of its own.

use std::fmt;

use glam::DVec3;

/// Largest distance between the colours of a texture and of a surface that is a tint of it.
pub const MAX_APART: f64 = 0.15;

/// Least reflectance of a texture that says nothing because it is white: exporters write white where the colour is
/// elsewhere.
const WHITE: f64 = 0.95;

/// Largest reflectance of a texture that is black: no plant is, and a picture without light tells no colour.
const DARK: f64 = 1e-3;

/// Largest ratio of brightness between a texture of wood and the measured wood that it is a tint of, either way.
const MAX_BRIGHTER: f64 = 2.5;

/// Evidence of a material's mean colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Evidence {
    /// White: the material has no colour of its own.
    White,
    /// Black.
    Black,
    /// Distance from the measured colour, [`MAX_APART`] at most.
    Near(f64),
    /// Not the measured colour.
    Far(Difference),
}

/// How a colour is another one than the measured one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Difference {
    /// Distance, more than [`MAX_APART`].
    Hue(f64),
    /// Brightness, relative to the measured colour: of wood, whose hue may tell nothing.
    Brightness(f64),
}

impl fmt::Display for Difference {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Difference::Hue(apart) => write!(out, "{apart:.2} apart"),
            Difference::Brightness(times) => write!(out, "{times:.1} times as bright"),
        }
    }
}

impl Evidence {
    /// Judges the mean colour of leaves, linear R, G, B, beside the reflectance of measured ones.
    pub fn of(mean: DVec3, measured: DVec3) -> Evidence {
        Evidence::extreme(mean).unwrap_or_else(|| Evidence::by_hue(apart(mean, measured)))
    }

    /// Judges the mean colour of wood beside the reflectance of measured wood. A birch and a white pot have the hue of
    /// bark, and not its brightness.
    pub fn of_wood(mean: DVec3, measured: DVec3) -> Evidence {
        let brightness = mean.element_sum() / measured.element_sum().max(f64::MIN_POSITIVE);
        let is_bark = (MAX_BRIGHTER.recip()..=MAX_BRIGHTER).contains(&brightness);
        Evidence::extreme(mean).unwrap_or_else(|| match Evidence::by_hue(hues_apart(mean, measured)) {
            Evidence::Near(_) if !is_bark => Evidence::Far(Difference::Brightness(brightness)),
            by_hue => by_hue,
        })
    }

    fn extreme(mean: DVec3) -> Option<Evidence> {
        match mean {
            mean if mean.min_element() >= WHITE => Some(Evidence::White),
            mean if mean.max_element() <= DARK => Some(Evidence::Black),
            _ => None,
        }
    }

    fn by_hue(apart: f64) -> Evidence {
        if apart <= MAX_APART { Evidence::Near(apart) } else { Evidence::Far(Difference::Hue(apart)) }
    }
}

fn shares(color: DVec3) -> DVec3 {
    color / color.element_sum().max(f64::MIN_POSITIVE)
}

/// Distance between two hues: shares of R, G and B that one has more than the other. 0 for the same one, 1 for two pure
/// bands.
fn hues_apart(color: DVec3, measured: DVec3) -> f64 {
    (shares(color) - shares(measured)).max(DVec3::ZERO).element_sum()
}

/// Distance of a colour from a measured one, whatever the brightness of both: shares of R, G and B that the colour has
/// more than the measured one, but for the strongest of that. A purer green is no other colour than green. 0 for the
/// same hue, 1 for a pure one of another band beside a pure one.
pub fn apart(color: DVec3, measured: DVec3) -> f64 {
    let more = (shares(color) - shares(measured)).max(DVec3::ZERO);
    let strongest =
        DVec3::select(measured.cmpeq(DVec3::splat(measured.max_element())), DVec3::ZERO, DVec3::ONE);
    (more * strongest).element_sum()
}

//! Highlights of the `paper` shading: k (v.r)^s, as Steele and Geist print it.

use flb_scene::scene::{HIGHLIGHT_EXPONENTS, HighlightChoice, MAX_HIGHLIGHT};
use glam::Vec3;

use crate::RenderError;
use crate::settings::range;

/// Highlight of the sun on a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Highlight {
    /// Strength k, in the light of a white matt surface that faces the sun; 0 is matt.
    pub strength: f32,
    /// Exponent s of the cosine between the mirrored sun and the eye; the higher, the smaller the highlight.
    pub exponent: f32,
}

/// Highlights of a picture in the `paper` shading. The papers have them on leaves, wood and water, and print no values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Highlights {
    /// Highlight of leaves.
    pub leaf: Highlight,
    /// Highlight of all other surfaces of plants.
    pub wood: Highlight,
    /// Highlight of level water.
    pub water: Highlight,
}

impl Highlight {
    /// A surface without one.
    pub const MATT: Highlight = Highlight { strength: 0.0, exponent: 1.0 };

    /// What a surface sends to the eye that a sun of strength 1 lights; all directions are unit vectors, `looking` goes
    /// from the eye to the surface.
    pub(crate) fn towards(&self, normal: Vec3, sun: Vec3, looking: Vec3) -> f32 {
        if self.strength == 0.0 {
            return 0.0;
        }
        let mirrored = normal * (2.0 * normal.dot(sun)) - sun;
        self.strength * libm::powf(mirrored.dot(-looking).max(0.0), self.exponent)
    }

    fn check(&self, name: &'static str) -> Result<(), RenderError> {
        range(name, self.strength.into(), 0.0, MAX_HIGHLIGHT)?;
        let [low, high] = HIGHLIGHT_EXPONENTS;
        // As f32 has them.
        range(name, self.exponent.into(), f64::from(low as f32), high)
    }
}

impl Default for Highlights {
    fn default() -> Highlights {
        // About as wide as the Blinn-Phong highlight of exponent 24 that came before it.
        let leaf = Highlight { strength: 0.08, exponent: 6.0 };
        Highlights { leaf, wood: Highlight::MATT, water: Highlight::MATT }
    }
}

impl Highlights {
    /// No surface has one.
    pub const MATT: Highlights =
        Highlights { leaf: Highlight::MATT, wood: Highlight::MATT, water: Highlight::MATT };

    /// Puts what was chosen in the place of the usual.
    #[must_use]
    pub fn with(self, choice: &HighlightChoice) -> Highlights {
        let one = |chosen: Option<[f32; 2]>, usual| match chosen {
            Some([strength, exponent]) => Highlight { strength, exponent },
            None => usual,
        };
        Highlights {
            leaf: one(choice.leaf, self.leaf),
            wood: one(choice.wood, self.wood),
            water: one(choice.water, self.water),
        }
    }

    pub(crate) fn check(&self) -> Result<(), RenderError> {
        self.leaf.check("highlight of leaves")?;
        self.wood.check("highlight of wood")?;
        self.water.check("highlight of water")
    }
}

#[cfg(test)]
mod tests;

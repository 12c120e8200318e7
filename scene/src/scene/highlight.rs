//! The `[highlight]` of a scene file: the sun's highlights k (v.r)^s on plants of the model `paper` and on water.

use serde::Deserialize;
use toml::Spanned;

use super::reading::{Checked, Reading};

/// Largest strength of a highlight.
pub const MAX_HIGHLIGHT: f64 = 1e3;
/// Smallest and largest exponent of a highlight.
pub const HIGHLIGHT_EXPONENTS: [f64; 2] = [0.01, 1e4];

/// Strength and exponent of the highlights that were chosen; `None` is the default.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct HighlightChoice {
    /// Highlight of leaves.
    pub leaf: Option<[f32; 2]>,
    /// Highlight of all other surfaces of plants.
    pub wood: Option<[f32; 2]>,
    /// Highlight of water.
    pub water: Option<[f32; 2]>,
}

impl HighlightChoice {
    /// Whether any was chosen.
    pub fn is_any(&self) -> bool {
        *self != HighlightChoice::default()
    }

    /// Fills in what was not chosen.
    #[must_use]
    pub fn or(self, other: HighlightChoice) -> HighlightChoice {
        HighlightChoice {
            leaf: self.leaf.or(other.leaf),
            wood: self.wood.or(other.wood),
            water: self.water.or(other.water),
        }
    }
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct RawHighlight {
    leaf: Option<Spanned<[f64; 2]>>,
    wood: Option<Spanned<[f64; 2]>>,
    water: Option<Spanned<[f64; 2]>>,
}

impl Reading<'_> {
    pub(super) fn highlight(&self, raw: RawHighlight) -> Checked<HighlightChoice> {
        let one = |name: &str, raw: Option<Spanned<[f64; 2]>>| -> Checked<Option<[f32; 2]>> {
            let Some(raw) = raw else { return Ok(None) };
            let (at, [strength, exponent]) = (raw.span().start, raw.into_inner());
            self.within(at, &format!("strength of highlight.{name}"), strength, 0.0, MAX_HIGHLIGHT)?;
            let [low, high] = HIGHLIGHT_EXPONENTS;
            self.within(at, &format!("exponent of highlight.{name}"), exponent, low, high)?;
            Ok(Some([strength as f32, exponent as f32]))
        };
        Ok(HighlightChoice {
            leaf: one("leaf", raw.leaf)?,
            wood: one("wood", raw.wood)?,
            water: one("water", raw.water)?,
        })
    }
}

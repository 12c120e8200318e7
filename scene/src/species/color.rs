//! `leaf_colour` and `wood_colour` of a species file: one word, or one for each pattern of materials.

use serde::Deserialize;

use super::{MAX_PATTERN_BYTES, MAX_PATTERNS, Malformed};
use crate::color::{ColorRule, ColorSource};
use crate::import::ImportError;

#[derive(Deserialize)]
#[serde(untagged)]
pub(super) enum RawColor {
    OfAll(String),
    ByMaterial(Vec<RawRule>),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawRule {
    material: Option<String>,
    colour: String,
}

/// The rules of a key, in the order of the file.
pub(super) fn resolve(
    key: &str,
    raw: Option<RawColor>,
    malformed: &Malformed,
) -> Result<Vec<ColorRule>, ImportError> {
    let source = |place: &str, word: &str| match word {
        "texture" => Ok(ColorSource::Texture),
        "measured" => Ok(ColorSource::Measured),
        other => Err(malformed(place, format!("{other:?}"), "\"texture\" or \"measured\"")),
    };
    let rules = match raw {
        None => return Ok(Vec::new()),
        Some(RawColor::OfAll(word)) => {
            return Ok(vec![ColorRule { pattern: None, source: source(key, &word)? }]);
        }
        Some(RawColor::ByMaterial(rules)) => rules,
    };
    if rules.len() > MAX_PATTERNS {
        return Err(malformed(key, format!("{} patterns", rules.len()), "at most 256 patterns"));
    }
    let rule = |(index, rule): (usize, RawRule)| {
        if let Some(long) = rule.material.as_ref().filter(|pattern| pattern.len() > MAX_PATTERN_BYTES) {
            let place = format!("{key}[{index}].material");
            return Err(malformed(&place, format!("a pattern of {} bytes", long.len()), "at most 256 bytes"));
        }
        let source = source(&format!("{key}[{index}].colour"), &rule.colour)?;
        Ok(ColorRule { pattern: rule.material, source })
    };
    rules.into_iter().enumerate().map(rule).collect()
}

#[cfg(test)]
mod tests;

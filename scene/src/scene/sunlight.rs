//! The strength and colour of a scene's sun, and further suns.

use toml::{Spanned, Value};

use super::reading::{Checked, Reading};
use crate::import::excerpt;

/// Most suns beside the one that moves.
pub const MAX_ADDED_SUNS: usize = 16;
/// Largest irradiance, in that for which light is stored.
pub const MAX_IRRADIANCE: f32 = 1e6;

/// The light of the sun that pictures are taken under, and of the suns that stand still beside it.
#[derive(Debug, Clone, PartialEq)]
pub struct Sunlight {
    /// Irradiance on a plane that faces the sun, R, G, B; 1 is that for which light is stored. A clear sky colours it
    /// as well.
    pub irradiance: [f32; 3],
    /// Further suns, at most [`MAX_ADDED_SUNS`].
    pub added: Vec<AddedSun>,
}

/// A further sun, which stands still.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AddedSun {
    /// Azimuth and elevation, degrees.
    pub sun_deg: [f64; 2],
    /// Irradiance on a plane that faces the sun, R, G, B.
    pub irradiance: [f32; 3],
}

impl Default for Sunlight {
    fn default() -> Sunlight {
        Sunlight { irradiance: [1.0; 3], added: Vec::new() }
    }
}

/// Reads an irradiance: one value for all bands, or R, G and B; from 0, and not 0 in all of them. `Err` is what was
/// expected.
pub fn irradiance(values: &[f64]) -> Result<[f32; 3], &'static str> {
    let bands = match values {
        [all] => [*all; 3],
        [r, g, b] => [*r, *g, *b],
        _ => return Err("one number, or three for R, G, B"),
    };
    let is_light = |value: &f64| (0.0..=f64::from(MAX_IRRADIANCE)).contains(value);
    match bands.iter().all(is_light) && bands.map(|value| value as f32) != [0.0; 3] {
        true => Ok(bands.map(|value| value as f32)),
        false => Err("0 to 10^6, and not 0 in all bands"),
    }
}

impl Reading<'_> {
    pub(super) fn sunlight(
        &self,
        irradiance: Option<&Spanned<Value>>,
        added: Option<&Spanned<Value>>,
    ) -> Checked<Sunlight> {
        let mut sunlight = Sunlight::default();
        if let Some(raw) = irradiance {
            sunlight.irradiance = self.irradiance(raw.span().start, "sun.irradiance", raw.get_ref())?;
        }
        let Some(raw) = added else { return Ok(sunlight) };
        let at = raw.span().start;
        let expected = "a list of { at = [azimuth, elevation], irradiance = ... }";
        let Some(list) = raw.get_ref().as_array() else {
            return Err(self.malformed(at, "sun.added", excerpt(raw.get_ref().to_string()), expected));
        };
        self.limit("sun.added", list.len(), MAX_ADDED_SUNS)?;
        for one in list {
            let odd = || self.malformed(at, "sun.added", excerpt(one.to_string()), expected);
            let table = one.as_table().ok_or_else(odd)?;
            let is_known = |key: &&String| ["at", "irradiance"].contains(&key.as_str());
            if let Some(key) = table.keys().find(|key| !is_known(key)) {
                let found = format!("the key {key:?}");
                return Err(self.malformed(at, "sun.added", excerpt(found), "at and irradiance alone"));
            }
            let Some([azimuth, elevation]) = table.get("at").and_then(pair) else { return Err(odd()) };
            let sun_deg = [
                self.within(at, "azimuth of sun.added", azimuth, -3600.0, 3600.0)?,
                self.within(at, "elevation of sun.added", elevation, -90.0, 90.0)?,
            ];
            let irradiance = match table.get("irradiance") {
                Some(value) => self.irradiance(at, "irradiance of sun.added", value)?,
                None => [1.0; 3],
            };
            sunlight.added.push(AddedSun { sun_deg, irradiance });
        }
        Ok(sunlight)
    }

    fn irradiance(&self, at: usize, what: &str, raw: &Value) -> Checked<[f32; 3]> {
        let values: Option<Vec<f64>> = match raw.as_array() {
            Some(list) => list.iter().map(number).collect(),
            None => number(raw).map(|one| vec![one]),
        };
        let found = values.ok_or("one number, or three for R, G, B").and_then(|values| irradiance(&values));
        found.map_err(|expected| self.malformed(at, what, excerpt(raw.to_string()), expected))
    }
}

/// Two numbers.
pub(super) fn pair(value: &Value) -> Option<[f64; 2]> {
    match value.as_array()?.as_slice() {
        [one, other] => Some([number(one)?, number(other)?]),
        _ => None,
    }
}

fn number(value: &Value) -> Option<f64> {
    value.as_float().or(value.as_integer().map(|whole| whole as f64))
}

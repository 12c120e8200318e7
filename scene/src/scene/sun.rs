//! The `[sun]` of a scene file: suns that stand still, or a path through a day.

use std::fmt;

use serde::Deserialize;
use serde::de::{Deserializer, Error, MapAccess, Visitor};
use toml::value::Datetime;
use toml::{Spanned, Value};

use super::reading::{Checked, Reading};
use super::sunlight::{Sunlight, pair};
use super::{Day, SunPath, Suns};
use crate::import::{ImportError, excerpt};

/// Suns that stand still.
pub const MAX_FIXED_SUNS: usize = 1024;

/// Keys of the table.
const KEYS: [&str; 4] = ["fixed", "path", "irradiance", "added"];

/// Where the suns stand, as one of `fixed` and `path`, and their light. Deserialized by hand, as toml would take a list
/// for a table.
#[derive(Default)]
pub(super) struct RawSun {
    fixed: Option<Spanned<Value>>,
    path: Option<Spanned<RawPath>>,
    irradiance: Option<Spanned<Value>>,
    added: Option<Spanned<Value>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawPath {
    latitude_deg: f64,
    longitude_deg: f64,
    from: Datetime,
    to: Datetime,
}

impl<'de> Deserialize<'de> for RawSun {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<RawSun, D::Error> {
        struct Table;
        impl<'de> Visitor<'de> for Table {
            type Value = RawSun;

            fn expecting(&self, out: &mut fmt::Formatter) -> fmt::Result {
                out.write_str("a table with fixed = [[azimuth, elevation], ...] in degrees, or path = {...}")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<RawSun, A::Error> {
                let mut sun = RawSun::default();
                while let Some(key) = map.next_key::<String>()? {
                    match key.as_str() {
                        "fixed" => sun.fixed = Some(map.next_value()?),
                        "path" => sun.path = Some(map.next_value()?),
                        "irradiance" => sun.irradiance = Some(map.next_value()?),
                        "added" => sun.added = Some(map.next_value()?),
                        _ => return Err(A::Error::unknown_field(&key, &KEYS)),
                    }
                }
                Ok(sun)
            }
        }
        deserializer.deserialize_map(Table)
    }
}

impl Reading<'_> {
    pub(super) fn suns(&self, raw: Spanned<RawSun>) -> Checked<(Suns, Sunlight)> {
        let at = raw.span().start;
        let RawSun { fixed, path, irradiance, added } = raw.into_inner();
        let sunlight = self.sunlight(irradiance.as_ref(), added.as_ref())?;
        let suns = match (fixed, path) {
            (Some(fixed), None) => {
                let at = fixed.span().start;
                let suns = self.fixed(at, fixed.get_ref())?;
                if suns.is_empty() {
                    return Err(self.malformed(at, "sun.fixed", "none", "one sun or more"));
                }
                for [azimuth, elevation] in &suns {
                    self.within(at, "azimuth of sun.fixed", *azimuth, -3600.0, 3600.0)?;
                    self.within(at, "elevation of sun.fixed", *elevation, -90.0, 90.0)?;
                }
                Suns::Fixed(suns)
            }
            (None, Some(path)) => {
                let (at, RawPath { latitude_deg, longitude_deg, from, to }) =
                    (path.span().start, path.into_inner());
                let path = Day::from_toml(from)
                    .and_then(|from| SunPath::new(latitude_deg, longitude_deg, from, Day::from_toml(to)?));
                path.map(Suns::Path).map_err(|message| ImportError::Syntax {
                    file: self.file.to_owned(),
                    message: format!("line {}, sun.path: {message}", self.line(at)),
                })?
            }
            (None, None) if irradiance.is_some() || added.is_some() => Suns::Sky,
            (fixed, _) => {
                let found = if fixed.is_some() { "fixed and path" } else { "neither fixed nor path" };
                return Err(self.malformed(at, "sun", found, "one of fixed and path"));
            }
        };
        Ok((suns, sunlight))
    }

    /// A list of suns, or one sun.
    fn fixed(&self, at: usize, raw: &Value) -> Checked<Vec<[f64; 2]>> {
        let listed = raw.as_array().map_or(0, Vec::len);
        self.limit("sun.fixed", listed, MAX_FIXED_SUNS)?;
        let suns = match pair(raw) {
            Some(one) => Some(vec![one]),
            None => raw.as_array().and_then(|list| list.iter().map(pair).collect()),
        };
        suns.ok_or_else(|| {
            let odd = raw.as_array().and_then(|list| list.iter().find(|value| pair(value).is_none()));
            let found = excerpt(odd.unwrap_or(raw).to_string());
            self.malformed(at, "sun.fixed", found, "[azimuth, elevation] in degrees, or a list of them")
        })
    }
}

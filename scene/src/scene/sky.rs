//! The `[sky]` of a scene file: where its light comes from, and how much there is.

use std::fmt;
use std::path::PathBuf;

use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use toml::Spanned;

use super::reading::{Checked, Reading};
use crate::sky::clear::{CLEAR_TURBIDITY, TURBIDITIES};

/// The sky over a scene.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum SceneSky {
    /// Even sky, the same from all sides.
    #[default]
    Even,
    /// Blue, with the colours of its sun ([`crate::sky::clear`]).
    Clear {
        /// Haze, 2 to 10.
        turbidity: f64,
    },
    /// An image of the whole sphere ([`crate::sky::image`]), a relative path made relative to the scene's folder.
    Image(PathBuf),
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct RawSky {
    ambient: Option<Spanned<f64>>,
    clear: Option<Spanned<RawClear>>,
    image: Option<PathBuf>,
    backdrop: Option<PathBuf>,
}

impl RawSky {
    /// Reads a table, or the file of an image alone.
    pub(super) fn of_table_or_file<'de, D: Deserializer<'de>>(from: D) -> Result<RawSky, D::Error> {
        from.deserialize_any(TableOrFile)
    }
}

struct TableOrFile;

impl<'de> Visitor<'de> for TableOrFile {
    type Value = RawSky;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a table, or the file of an image")
    }

    fn visit_str<E: Error>(self, file: &str) -> Result<RawSky, E> {
        Ok(RawSky { image: Some(file.into()), ..RawSky::default() })
    }

    fn visit_map<A: MapAccess<'de>>(self, table: A) -> Result<RawSky, A::Error> {
        RawSky::deserialize(MapAccessDeserializer::new(table))
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawClear {
    turbidity: Option<Spanned<f64>>,
}

impl Reading<'_> {
    /// The sky, the factor on it where it is said, and the image that is drawn in its place.
    pub(super) fn sky(&self, raw: RawSky) -> Checked<(SceneSky, Option<f64>, Option<PathBuf>)> {
        let ambient = raw
            .ambient
            .map(|ambient| self.within(ambient.span().start, "sky.ambient", ambient.into_inner(), 0.0, 1e6));
        let sky = match (raw.clear, raw.image) {
            (Some(clear), Some(_)) => {
                return Err(self.malformed(clear.span().start, "sky", "clear and image", "one of them"));
            }
            (None, Some(file)) => SceneSky::Image(self.folder.join(file)),
            (Some(clear), None) => SceneSky::Clear { turbidity: self.turbidity(clear.into_inner())? },
            (None, None) => SceneSky::Even,
        };
        Ok((sky, ambient.transpose()?, raw.backdrop.map(|file| self.folder.join(file))))
    }

    fn turbidity(&self, raw: RawClear) -> Checked<f64> {
        let Some(turbidity) = raw.turbidity else { return Ok(CLEAR_TURBIDITY) };
        let (least, most) = (*TURBIDITIES.start(), *TURBIDITIES.end());
        self.within(turbidity.span().start, "sky.clear.turbidity", turbidity.into_inner(), least, most)
    }
}

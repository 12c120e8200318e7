//! The `[ground]` of a scene file: a plane, or the name of a height map and where it lies. The picture is read by who
//! draws it, so that a plan does without.

use std::path::PathBuf;

use serde::Deserialize;
use toml::{Spanned, Value};

use super::reading::{Checked, MAX_COORDINATE_M, Reading};

/// Ground on which plants stand.
#[derive(Debug, Clone, PartialEq)]
pub struct Ground {
    /// Shape of the ground.
    pub terrain: Terrain,
    /// Linear reflectance R, G, B, each 0 to 1.
    pub color: [f64; 3],
}

/// The shape of a ground.
#[derive(Debug, Clone, PartialEq)]
pub enum Terrain {
    /// Level and without end.
    Plane {
        /// Height of the plane (y), metres.
        height_m: f64,
    },
    /// Heights from a picture.
    Map(HeightMap),
}

/// Place and heights of a grey picture as a height field.
#[derive(Debug, Clone, PartialEq)]
pub struct HeightMap {
    /// The picture, relative paths made relative to the scene's folder.
    pub file: PathBuf,
    /// Position of the middle of its upper left pixel, metres. Columns run to +X, rows to +Z.
    pub origin_m: [f64; 3],
    /// Distance to the middle of the lower right pixel, along x and z, metres; above 0.
    pub size_m: [f64; 2],
    /// Heights of black and of white, above the origin's; the first is the lower one.
    pub height_m: [f64; 2],
}

/// Dry grass, as under a single plant.
const COLOR: [f64; 3] = [0.23, 0.22, 0.15];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawGround {
    height_m: Option<Spanned<Value>>,
    height_map: Option<PathBuf>,
    origin_m: Option<[f64; 3]>,
    size_m: Option<[f64; 2]>,
    #[serde(rename = "colour")]
    color: Option<Spanned<[f64; 3]>>,
}

impl Reading<'_> {
    pub(super) fn ground(&self, raw: Spanned<RawGround>) -> Checked<Ground> {
        let (at, raw) = (raw.span().start, raw.into_inner());
        let color = match raw.color {
            None => COLOR,
            Some(color) => {
                let at = color.span().start;
                for share in color.get_ref() {
                    self.within(at, "ground.colour", *share, 0.0, 1.0)?;
                }
                color.into_inner()
            }
        };
        let height_at = raw.height_m.as_ref().map_or(at, |height| height.span().start);
        let height = raw.height_m.map(Spanned::into_inner);
        let terrain = match (raw.height_map, raw.origin_m, raw.size_m) {
            (None, None, None) => Terrain::Plane { height_m: self.plane_height(height_at, height)? },
            (Some(file), Some(origin_m), Some(size_m)) => {
                self.points(at, "ground.origin_m", &[origin_m])?;
                for edge in size_m {
                    self.within(at, "ground.size_m", edge, 1e-3, MAX_COORDINATE_M)?;
                }
                let height_m = self.map_heights(height_at, height)?;
                Terrain::Map(HeightMap { file: self.folder.join(file), origin_m, size_m, height_m })
            }
            (Some(_), ..) => {
                let found = "a height_map without origin_m or size_m";
                return Err(self.malformed(at, "ground", found, "both of them"));
            }
            (None, ..) => {
                let found = "origin_m or size_m without height_map";
                return Err(self.malformed(
                    at,
                    "ground",
                    found,
                    "a plane by height_m alone, or a height_map",
                ));
            }
        };
        Ok(Ground { terrain, color })
    }

    fn plane_height(&self, at: usize, height: Option<Value>) -> Checked<f64> {
        let Some(height) = height else { return Ok(0.0) };
        match number(&height) {
            Some(height_m) => {
                self.within(at, "ground.height_m", height_m, -MAX_COORDINATE_M, MAX_COORDINATE_M)
            }
            None => Err(self.malformed(at, "ground.height_m", height.to_string(), "a number for a plane")),
        }
    }

    fn map_heights(&self, at: usize, height: Option<Value>) -> Checked<[f64; 2]> {
        let pair = height.as_ref().and_then(Value::as_array).and_then(|values| match &values[..] {
            [low, high] => Some([number(low)?, number(high)?]),
            _ => None,
        });
        let Some([low, high]) = pair else {
            let found = height.map_or("none".to_owned(), |height| height.to_string());
            return Err(self.malformed(at, "ground.height_m", found, "[low, high] for a height_map"));
        };
        self.within(at, "ground.height_m", low, -MAX_COORDINATE_M, MAX_COORDINATE_M)?;
        self.within(at, "ground.height_m", high, low, MAX_COORDINATE_M)?;
        Ok([low, high])
    }
}

fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|integer| integer as f64))
}

//! The `[water]` of a scene file: a level surface without end, hidden where ground is higher.

use serde::Deserialize;
use toml::Spanned;

use super::reading::{Checked, MAX_COORDINATE_M, Reading};
use super::{Ground, Terrain};

/// Standing water.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Water {
    /// Height of the water (y), metres; above a level ground.
    pub height_m: f64,
    /// Share of the light that has come into it which comes out of it again, R, G, B, each 0 to 1.
    pub color: [f64; 3],
}

/// A lake, dark and blue-green: red light is lost after a few metres.
const COLOR: [f64; 3] = [0.01, 0.035, 0.04];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawWater {
    height_m: Spanned<f64>,
    #[serde(rename = "colour")]
    color: Option<Spanned<[f64; 3]>>,
}

impl Reading<'_> {
    pub(super) fn water(&self, raw: RawWater, ground: Option<&Ground>) -> Checked<Water> {
        let (at, height_m) = (raw.height_m.span().start, raw.height_m.into_inner());
        self.within(at, "water.height_m", height_m, -MAX_COORDINATE_M, MAX_COORDINATE_M)?;
        let color = raw.color.map_or(Ok(COLOR), |color| {
            let at = color.span().start;
            let within = |share: &f64| self.within(at, "water.colour", *share, 0.0, 1.0).map(drop);
            color.get_ref().iter().try_for_each(within).map(|()| color.into_inner())
        })?;
        match ground.map(|ground| &ground.terrain) {
            // It would never be seen.
            Some(Terrain::Plane { height_m: level }) if height_m <= *level => {
                let expected = format!("above the level ground at {level}");
                Err(self.malformed(at, "water.height_m", height_m.to_string(), &expected))
            }
            _ => Ok(Water { height_m, color }),
        }
    }
}

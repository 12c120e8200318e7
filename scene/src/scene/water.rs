//! The `[water]` of a scene file: a surface without end, hidden where ground is higher; level, or with waves.

use serde::Deserialize;
use toml::Spanned;

use super::reading::{Checked, MAX_COORDINATE_M, Reading};
use super::{Ground, Terrain};
use crate::waves::{MAX_TIME_S, Waves};

/// Standing water.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Water {
    /// Height of the water (y), metres; above a level ground.
    pub height_m: f64,
    /// Share of the light that has come into it which comes out of it again, R, G, B, each 0 to 1.
    pub color: [f64; 3],
    /// Waves on it; `None` where it is level.
    pub waves: Option<MovingWaves>,
}

/// Waves, and the times at which pictures show them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MovingWaves {
    /// Waves.
    pub waves: Waves,
    /// Time of the first picture, seconds.
    pub time_s: f64,
    /// Time from a picture to the next, seconds.
    pub step_s: f64,
}

/// A lake, dark and blue-green: red light is lost after a few metres.
const COLOR: [f64; 3] = [0.01, 0.035, 0.04];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawWater {
    height_m: Spanned<f64>,
    #[serde(rename = "colour")]
    color: Option<Spanned<[f64; 3]>>,
    waves: Option<Spanned<RawWaves>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawWaves {
    wind_m_s: f64,
    from_deg: Option<f64>,
    fetch_m: Option<f64>,
    steepness: Option<f64>,
    seed: Option<u32>,
    time_s: Option<f64>,
    step_s: Option<f64>,
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
        let waves = raw.waves.map(|raw| self.waves(raw)).transpose()?;
        match ground.map(|ground| &ground.terrain) {
            // It would never be seen.
            Some(Terrain::Plane { height_m: level }) if height_m <= *level => {
                let expected = format!("above the level ground at {level}");
                Err(self.malformed(at, "water.height_m", height_m.to_string(), &expected))
            }
            _ => Ok(Water { height_m, color, waves }),
        }
    }

    fn waves(&self, raw: Spanned<RawWaves>) -> Checked<MovingWaves> {
        let (at, raw) = (raw.span().start, raw.into_inner());
        let usual = Waves::default();
        let waves = Waves {
            wind_m_s: raw.wind_m_s,
            from_deg: raw.from_deg.unwrap_or(usual.from_deg),
            fetch_m: raw.fetch_m.unwrap_or(usual.fetch_m),
            steepness: raw.steepness.unwrap_or(usual.steepness),
            seed: raw.seed.unwrap_or(usual.seed),
        };
        if let Some((name, found, expected)) = waves.fault() {
            return Err(self.malformed(at, &format!("water.waves.{name}"), found.to_string(), &expected));
        }
        let time = |name: &str, value: Option<f64>| {
            self.within(at, &format!("water.waves.{name}"), value.unwrap_or(0.0), -MAX_TIME_S, MAX_TIME_S)
        };
        Ok(MovingWaves { waves, time_s: time("time_s", raw.time_s)?, step_s: time("step_s", raw.step_s)? })
    }
}

#[cfg(test)]
mod tests;

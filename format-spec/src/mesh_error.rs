//! How far the light of a species is from the truth on its own mesh, as a file keeps it among its settings.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::SpeciesMeta;

/// Key of [`SpeciesMeta::settings`] under which it is kept. What codes fields anew drops it.
pub const MESH_ERROR: &str = "judge.mesh";

/// Light at points of the mesh against irradiance that was path traced there.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeshError {
    /// Suns that it was judged under, besides the sky.
    pub suns: u32,
    /// Points on leaves and wood.
    pub points: u32,
    /// Paths from each side of each point.
    pub samples: u32,
    /// Error on leaves, in the mean of both sides; `None` without leaves.
    pub leaf: Option<ClassError>,
    /// Error on wood; `None` without wood.
    pub wood: Option<ClassError>,
}

/// Error on the surfaces of one class.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClassError {
    /// Error under all suns, their own beams left out.
    pub suns: Option<SourceError>,
    /// Error under the even sky.
    pub sky: Option<SourceError>,
}

/// Error under one kind of light, per band R, G, B.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SourceError {
    /// Mean irradiance of the file over the mean truth.
    pub ratio: [f64; 3],
    /// Root mean square error over the mean truth, the truth's noise taken out.
    pub rms: [f64; 3],
}

impl SourceError {
    /// Returns the error rounded to four decimals: more is noise.
    pub fn rounded(self) -> SourceError {
        let round = |values: [f64; 3]| values.map(|value| libm::round(value * 1e4) / 1e4);
        SourceError { ratio: round(self.ratio), rms: round(self.rms) }
    }

    fn is_sound(&self) -> bool {
        self.ratio.iter().chain(&self.rms).all(|share| share.is_finite() && *share >= 0.0)
    }
}

impl MeshError {
    /// Reads the error from a species' metadata; `None` where it is absent or not sound.
    pub fn of(meta: &SpeciesMeta) -> Option<MeshError> {
        let found: MeshError = serde_json::from_value(meta.settings.get(MESH_ERROR)?.clone()).ok()?;
        let classes = [found.leaf, found.wood].into_iter().flatten();
        let mut sources = classes.flat_map(|class| [class.suns, class.sky]).flatten();
        sources.all(|source| source.is_sound()).then_some(found)
    }

    /// Returns the error as a setting's value.
    pub fn to_value(&self) -> Value {
        serde_json::to_value(self).expect("numbers have a JSON")
    }
}

//! Keys of what a store holds: BLAKE3 of the stage and of all that its result depends on, one named part each.

use flb_format::light::SunBasis;
use flb_transport::lattice::SolveSettings;
use flb_transport::ordinates::OrdinatesSettings;
use flb_transport::turbid::{BandScatter, Phase, Scatter};
use serde_json::{Value, json};

use crate::VoxelSettings;
use crate::artefact;
use crate::crown::CrownSettings;

/// Key of an artefact: stage and parts that it depends on. Two keys are one if stage and parts are, names and order
/// included.
#[derive(Debug, Clone, PartialEq)]
pub struct Key {
    stage: &'static str,
    parts: Vec<(&'static str, Value)>,
}

impl Key {
    /// Makes the key of a stage that depends on nothing yet.
    pub fn new(stage: &'static str) -> Key {
        Key { stage, parts: Vec::new() }
    }

    /// Returns the key with one part more.
    pub fn with(mut self, name: &'static str, value: Value) -> Key {
        self.parts.push((name, value));
        self
    }

    /// Returns the key with settings added, a part each.
    pub fn with_all(mut self, parts: impl IntoIterator<Item = (&'static str, Value)>) -> Key {
        self.parts.extend(parts);
        self
    }

    /// The stage's name.
    pub fn stage(&self) -> &'static str {
        self.stage
    }

    /// Names and values of the parts.
    pub fn parts(&self) -> &[(&'static str, Value)] {
        &self.parts
    }

    /// 64 hexadecimal digits: of schema, version, stage and parts.
    pub fn digest(&self) -> String {
        artefact::key(self.stage, &[], &json!(self.parts).to_string())
    }

    /// The name of the artefact: stage, a hyphen, the digest.
    pub fn name(&self) -> String {
        format!("{}-{}", self.stage, self.digest())
    }
}

/// A digest as a part.
pub fn hex(digest: [u8; 32]) -> Value {
    json!(blake3::Hash::from_bytes(digest).to_string())
}

/// Parts of the voxeliser's settings.
pub fn of_voxels(settings: &VoxelSettings) -> [(&'static str, Value); 3] {
    let &VoxelSettings { voxels, lattice, ignore_alpha } = settings;
    [("voxels", json!(voxels)), ("lattice", json!(lattice)), ("ignore_alpha", json!(ignore_alpha))]
}

/// Parts of how a crown is measured.
pub fn of_crown(settings: &CrownSettings) -> [(&'static str, Value); 2] {
    let &CrownSettings { ignore_alpha, angles } = settings;
    [("ignore_alpha", json!(ignore_alpha)), ("leaf_angles", json!(angles.name()))]
}

/// Parts of a solve of the `physical` model. Which GPU solves, if one does, is a part that its caller adds.
pub fn of_ordinates(settings: &OrdinatesSettings) -> [(&'static str, Value); 8] {
    let OrdinatesSettings { ordinates, rays, parts, suns, bases, field, tolerance, max_passes, backend: _ } =
        settings;
    [
        ("ordinates", json!(ordinates.count())),
        ("rays", json!(rays)),
        ("parts", json!(parts)),
        ("suns", of_suns(suns)),
        ("bases", json!(bases)),
        ("field", json!(field.name())),
        ("tolerance", json!(tolerance)),
        ("max_passes", json!(max_passes)),
    ]
}

/// A basis of the sun's direction as the value of a part.
pub fn of_suns(suns: &SunBasis) -> Value {
    match suns {
        SunBasis::Lattice18 => json!("lattice18"),
        SunBasis::Harmonics { degree, single, leaning } => {
            json!({ "degree": degree, "single": single, "leaning": leaning })
        }
        SunBasis::Directions(directions) => json!(directions.directions()),
    }
}

/// Parts of a solve of the `paper` model on a lattice; `gpu` is the one that solves.
pub fn of_lattice(settings: &SolveSettings, lattice: u32, gpu: Option<&str>) -> [(&'static str, Value); 6] {
    let SolveSettings { solver, steps, tolerance, max_sweeps, bases } = settings;
    [
        ("solver", json!(super::solver_name(*solver))),
        ("steps", json!(steps.map(|steps| steps.count(lattice)))),
        ("tolerance", json!(tolerance)),
        ("max_sweeps", json!(max_sweeps)),
        ("bases", json!(bases)),
        ("gpu", json!(gpu)),
    ]
}

/// Returns the scattering of matter in each band as the value of a part.
pub fn of_bands(bands: &[BandScatter]) -> Value {
    let of = |scatter: &Scatter| {
        let phase = match scatter.phase {
            Phase::HenyeyGreenstein { g } => json!({ "g": g }),
            Phase::BiLambert { transmitted } => json!({ "transmitted": transmitted }),
        };
        json!([scatter.albedo, phase])
    };
    bands.iter().map(|band| json!({ "leaf": of(&band.leaf), "wood": of(&band.wood) })).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_changes_the_key_and_its_name_counts() {
        let key = || Key::new("crown").with("lattice", json!(32));
        assert_eq!(key().digest(), key().digest());
        let others = [
            Key::new("light").with("lattice", json!(32)),
            Key::new("crown").with("voxels", json!(32)),
            Key::new("crown").with("lattice", json!(64)),
            key().with("more", json!(null)),
        ];
        for other in others {
            assert_ne!(other.digest(), key().digest(), "{other:?}");
        }
        assert_eq!(key().name(), format!("crown-{}", key().digest()));
    }

    #[test]
    fn every_setting_is_a_part_of_its_own() {
        let settings = OrdinatesSettings::default();
        let names: Vec<&str> = of_ordinates(&settings).iter().map(|(name, _)| *name).collect();
        let other = OrdinatesSettings { tolerance: 0.5, rays: 3, ..settings.clone() };
        let differ: Vec<&str> = of_ordinates(&settings)
            .iter()
            .zip(of_ordinates(&other))
            .filter(|(a, b)| **a != *b)
            .map(|(a, _)| a.0)
            .collect();
        assert_eq!(differ, ["rays", "tolerance"]);
        assert_eq!(names.len(), 8);
    }
}

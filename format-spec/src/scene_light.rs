//! What the entries of a library of scene light say of themselves, in the settings of their metadata.
//!
//! Such a library is an ordinary one. Its entry `scene` is the lattice over a whole scene, in the scene's frame; the
//! other entries are species alone, each in its own frame, on sites as large. All have one band, luminance. What a
//! scene takes from a plant's light, or adds to it, is the quotient or the difference of the two.

use serde_json::Value;

use crate::SpeciesMeta;
use crate::light::FieldKind;
use crate::surfaces::Surfaces;
use crate::turbid::TurbidMedium;

/// Name of the entry of the whole scene.
pub const SCENE_NAME: &str = "scene";
/// Name of the band.
pub const LUMINANCE: &str = "luminance";
/// Density of sites of the ground in the entry of the scene; those of plants have less.
pub const GROUND_DENSITY: f32 = 1.0;

/// Setting that tells the digest of the scene's plants and ground, which makes an entry that of a scene.
pub const DIGEST: &str = "scene.digest";
/// Setting that tells whose light an entry is: the scene's name of the species.
pub const SPECIES: &str = "scene.species";

/// Setting of a species alone that tells the digest of the plant that its light was solved for.
pub const PLANT: &str = "scene.plant";

/// Role of an entry of a library.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Role {
    /// All plants of a scene together, and its ground.
    Scene {
        /// Digest of the plants, where they stand, and the ground.
        digest: String,
    },
    /// One species by itself.
    Alone {
        /// Name of the species in the scene.
        species: String,
    },
}

/// BLAKE3 of all that a plant does to light, 64 hexadecimal digits: its surfaces, what its fields hold, its fine
/// medium.
pub fn plant_digest(surfaces: &Surfaces, field: FieldKind, turbid: &TurbidMedium) -> String {
    let surfaces = serde_json::to_vec(surfaces).expect("names and numbers make JSON");
    let mut hasher = blake3::Hasher::new();
    hasher.update(&surfaces).update(field.name().as_bytes());
    turbid.feed(|bytes| {
        hasher.update(bytes);
    });
    hasher.finalize().to_hex().to_string()
}

impl Role {
    /// The role of an entry; `None` for an ordinary species.
    pub fn of(meta: &SpeciesMeta) -> Option<Role> {
        let text = |key: &str| meta.settings.get(key).and_then(Value::as_str).map(str::to_owned);
        match (text(DIGEST), text(SPECIES)) {
            (Some(digest), _) => Some(Role::Scene { digest }),
            (None, Some(species)) => Some(Role::Alone { species }),
            (None, None) => None,
        }
    }

    /// The name of its entry.
    pub fn name(&self) -> String {
        match self {
            Role::Scene { .. } => SCENE_NAME.to_owned(),
            Role::Alone { species } => format!("{species} alone"),
        }
    }

    /// The setting that tells it: key and value.
    pub fn setting(&self) -> (String, Value) {
        match self {
            Role::Scene { digest } => (DIGEST.to_owned(), digest.as_str().into()),
            Role::Alone { species } => (SPECIES.to_owned(), species.as_str().into()),
        }
    }
}

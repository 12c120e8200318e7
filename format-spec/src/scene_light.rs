//! What the entries of a library of scene light say of themselves, in the settings of their metadata.
//!
//! Such a library is an ordinary one. Its entry `scene` is the lattice over a whole scene, in the scene's frame; the
//! other entries are species alone, each in its own frame, on sites as large. All have one band, luminance. What a
//! scene takes from a plant's light, or adds to it, is the quotient or the difference of the two.

use serde_json::Value;

use crate::container::Container;
use crate::light::FieldKind;
use crate::optics::Optics;
use crate::surfaces::Surfaces;
use crate::turbid::TurbidMedium;
use crate::{FormatError, Medium, Source, SpeciesMeta};

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

/// Light that a whole scene's is compared with, to say how neighbours change the light of a plant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum SceneFactor {
    /// The plant by itself, whose own shade is in its own light already
    #[default]
    Alone,
    /// An empty scene, as the papers have it: the plant's own shade counts once more
    Empty,
}

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

/// BLAKE3 of all that a plant of the model `paper` does to light, 64 hexadecimal digits: its optics, the density and
/// the class of every site.
pub fn paper_plant_digest(optics: &Optics, medium: &Medium) -> String {
    let optics = serde_json::to_vec(optics).expect("names and numbers make JSON");
    let mut hasher = blake3::Hasher::new();
    hasher.update(&optics);
    for value in medium.grid.origin_m.iter().chain([&medium.grid.spacing_m]) {
        hasher.update(&value.to_le_bytes());
    }
    for (density, class) in medium.density.iter().zip(&medium.class) {
        hasher.update(&density.to_le_bytes()).update(&[*class as u8]);
    }
    hasher.finalize().to_hex().to_string()
}

/// The digest of a plant as a file has it: [`plant_digest`] or [`paper_plant_digest`].
///
/// # Errors
/// As [`Container::read_turbid`] and [`Container::read_medium`].
///
/// # Panics
/// If there is no such species.
pub fn digest_of_species(
    container: &Container,
    source: &dyn Source,
    species: usize,
) -> Result<String, FormatError> {
    let meta = &container.species()[species].meta;
    if let Some(optics) = meta.optics() {
        return Ok(paper_plant_digest(optics, &container.read_medium(source, species)?));
    }
    let (surfaces, light) = meta.physical().expect("a species is of one of two models");
    Ok(plant_digest(surfaces, light.field, &container.read_turbid(source, species)?))
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

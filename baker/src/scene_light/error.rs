//! Why there is no light of a scene.

use crate::crown::CrownError;
use flb_format::light::FieldKind;
use flb_scene::ImportError;
use flb_transport::ordinates::OrdinatesError;

/// Fault of the plants of a scene, or of the lattice over them.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneLightError {
    /// Scene without instances.
    #[error("the scene has no instances, expected one or more")]
    NoInstances,
    /// An instance of nothing.
    #[error("instance {instance} is of species {found}, expected one of 0 to {most}")]
    Species {
        /// Index of the instance.
        instance: usize,
        /// Species that it names.
        found: usize,
        /// Largest index of a species.
        most: usize,
    },
    /// A species that stops no light.
    #[error("species {species:?} holds no matter, expected extinction above 0 in some site")]
    Empty {
        /// Name of the species.
        species: String,
    },
    /// Light in other bands than a picture's.
    #[error(
        "species {species:?} has the bands {found}, expected R, G and B among them, of which luminance is made"
    )]
    Bands {
        /// Name of the species.
        species: String,
        /// Names of the bands.
        found: String,
    },
    /// Species whose fields hold different things, so that they cannot be changed alike.
    #[error("the light of {:?} is {}, that of {:?} {}", .first.0, .first.1.name(), .other.0, .other.1.name())]
    Fields {
        /// Name of one species, and what its fields hold.
        first: (String, FieldKind),
        /// Name of another species, and what its fields hold.
        other: (String, FieldKind),
    },
    /// Species of both models, whose light is carried in other ways.
    #[error(
        "species {paper:?} is of the model paper, species {physical:?} of physical: expected one model in all of a scene's light"
    )]
    Models {
        /// Name of a species of the model `paper`.
        paper: String,
        /// Name of a species of `physical`.
        physical: String,
    },
    /// A lattice that no file holds.
    #[error("a lattice of {found} sites, expected a power of two from 16 to 256")]
    Lattice {
        /// Sites per edge.
        found: u32,
    },
    /// A plant that lies aslant in the scene, and is longer than any file's lattice of such sites.
    #[error(
        "species {species:?} covers {found} sites of the scene's lattice along an edge, expected up to 250"
    )]
    TooFine {
        /// Name of the species.
        species: String,
        /// Sites, rounded up.
        found: f64,
    },
    /// The ground's height map.
    #[error(transparent)]
    Ground(#[from] ImportError),
    /// The medium of a species.
    #[error(transparent)]
    Crown(#[from] CrownError),
    /// The solve.
    #[error(transparent)]
    Solve(#[from] OrdinatesError),
}

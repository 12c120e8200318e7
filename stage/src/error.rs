//! What can go wrong on a stage.

use std::path::{Path, PathBuf};

/// Errors of a stage.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StageError {
    /// The scene lacks what a frame needs.
    #[error("{0}")]
    Scene(String),
    /// A scene's sun has a path, and no frames along it were asked for.
    #[error("the scene's sun has a path, expected a number of frames along it, or one sun")]
    WholeSunPath,
    /// A scene has no sun, and none was named.
    #[error("the scene has no suns of its own, expected one that is named")]
    NoSun,
    /// An error in a file.
    #[error("{}", at(.path, .source))]
    At {
        /// Path of the file.
        path: PathBuf,
        /// Error in the file.
        source: Box<StageError>,
    },
    /// A species that no picture can be made of.
    #[error("species {species:?} has no mesh as its file, which a picture needs")]
    NoMesh {
        /// Name of the species.
        species: String,
    },
    /// A library that has no such species.
    #[error("no species is named {wanted:?}; there are: {found}")]
    NoSpecies {
        /// Name that was asked for.
        wanted: String,
        /// Names of the library's species.
        found: String,
    },
    /// A library of several species, none of which was named.
    #[error("holds {count} species, expected the name of one of them: {found}")]
    ManySpecies {
        /// Number of the library's species.
        count: usize,
        /// Names of the library's species.
        found: String,
    },
    /// Bands of which no picture can be made.
    #[error(transparent)]
    Bands(#[from] flb_format::colors::BandsError),
    /// Metadata of a species that say what cannot be.
    #[error("species {species:?}: {message}")]
    Metadata {
        /// Name of the species.
        species: String,
        /// Fault of the metadata.
        message: String,
    },
    /// A mesh without anything to see.
    #[error("no triangle with finite corners")]
    NoTriangles,
    /// A mesh of another number of materials than that which the light was baked with.
    #[error(
        "the mesh has {found} materials, species {species:?} was baked with {expected}: not the mesh that it was baked \
         from"
    )]
    MaterialCount {
        /// Name of the species.
        species: String,
        /// Number of materials of the mesh.
        found: usize,
        /// Number of materials of the file.
        expected: usize,
    },
    /// A mesh that does not fit the light.
    #[error("{0}")]
    OtherMesh(String),
    /// Plants that are not those of the scene's species.
    #[error("{found} plants, expected one for each of the scene's {expected} species")]
    PlantCount {
        /// Number of plants.
        found: usize,
        /// Number of species.
        expected: usize,
    },
    /// A file that was made without its sky's light is lit by a sky.
    #[error("the file has no light of the sky (base 0 was left out), expected no light of a sky")]
    NoSkyLight {
        /// The library.
        library: PathBuf,
    },
    /// Frames of scene light alone, of a scene without any.
    #[error("the scene has no scene light, which is to be shown: bake it by `flb bake-scene`")]
    NoSceneLight,
    /// Frames that only the CPU can make.
    #[error("scene light by itself, single bases and alpha are shown on the CPU alone")]
    OnCpuAlone,
    /// Pictures of nothing, or of one thing twice.
    #[error(
        "{0} is to be shown, expected each of light, direct, indirect, base:N, global and alpha once at most"
    )]
    Shows(String),
    /// Layers that are too large together.
    #[error("{found} pixels in all layers together, expected at most {limit}")]
    LayerPixels {
        /// Pixels of all layers.
        found: u64,
        /// Most pixels of all layers.
        limit: u64,
    },
    /// A base that no species has.
    #[error("base {base} is to be shown: the species have bases 0 to {last}")]
    NoBase {
        /// Place of the base.
        base: u16,
        /// Last place of any species.
        last: usize,
    },
    /// Species of both models.
    #[error(
        "species {:?} ({}) is of the model {}, species {:?} ({}) of {}: expected one model, as their light is in \
         different units",
        .species[0].0, .species[0].1.display(), .models[0], .species[1].0, .species[1].1.display(), .models[1]
    )]
    Models {
        /// Two species: their names in the scene, and the files of their light.
        species: Box<[(String, PathBuf); 2]>,
        /// Names of the models of their light.
        models: [&'static str; 2],
    },
    /// A file of the model `paper` under an uneven sky.
    #[error(
        "an uneven sky lights files of the model physical alone: a paper file does not say what comes from the sky \
         itself"
    )]
    UnevenSkyOverPaper,
    /// Highlights on plants of the model `physical`.
    #[error(
        "highlights are for paper files: leaves of a physical file are matt until their gloss is measured"
    )]
    HighlightOfPhysical,
    /// Scene light that was baked for other plants, or another ground.
    #[error(
        "is the light of other plants or another ground than the scene's (digest {found}, expected {expected}): bake it \
         again with flb bake-scene"
    )]
    OtherScene {
        /// First digits of the light's digest.
        found: String,
        /// First digits of the scene's digest.
        expected: String,
    },
    /// Scene light that was baked for another plant by a name.
    #[error(
        "is made of another light of species {species:?} than {library} holds now (of another mesh, model or optics): make \
         it again with flb bake-scene",
        library = .library.display()
    )]
    OtherPlant {
        /// Name of the species in the scene.
        species: String,
        /// The library of the plant's own light.
        library: PathBuf,
    },
    /// A library breaks a promise of the format.
    #[error(transparent)]
    Format(Box<flb_format::FormatError>),
    /// A file that the scene names cannot be used.
    #[error(transparent)]
    Import(#[from] flb_scene::ImportError),
    /// A sky that is none.
    #[error(transparent)]
    Sky(#[from] flb_scene::sky::SkyError),
    /// The scene cannot be drawn.
    #[error(transparent)]
    Render(#[from] flb_render::RenderError),
    /// Light of the scene cannot be read.
    #[error(transparent)]
    Runtime(#[from] flb_runtime::RuntimeError),
    /// Fewer GPUs than were asked for.
    #[error("{expected} GPUs were asked for, found {}: {}", .found.len(), .found.join(", "))]
    GpuCount {
        /// Names of the GPUs found.
        found: Vec<String>,
        /// Number of GPUs that were asked for.
        expected: usize,
    },
    /// A build without GPUs.
    #[error("this build has no renderer on a GPU; build it with the feature `gpu`, or render on the CPU")]
    NoGpuBuilt,
    /// The device failed.
    #[cfg(feature = "gpu")]
    #[error(transparent)]
    Device(#[from] flb_gpu::DeviceError),
    /// The GPU cannot draw it.
    #[cfg(feature = "gpu")]
    #[error(transparent)]
    Forest(#[from] flb_render_gpu::ForestError),
    /// No species has light that a GPU could follow.
    #[error(
        "no species of the scene has light, and a GPU follows that of a file: name one with `light`, or draw on the CPU"
    )]
    Unlit,
    /// A GPU samples the light of one file alone.
    #[error(
        "the species' light lies in {0} files, and a GPU follows one: pack them into one with flb pack, or draw on the CPU"
    )]
    Libraries(usize),
}

impl StageError {
    /// The same with the file that it is about, unless that is told already.
    pub(crate) fn at(self, path: &Path) -> StageError {
        match self {
            StageError::At { .. } => self,
            error => StageError::At { path: path.to_owned(), source: Box::new(error) },
        }
    }
}

/// An error after the name of its file, which many name themselves.
fn at(path: &Path, error: &StageError) -> String {
    let (name, text) = (path.display().to_string(), error.to_string());
    if text.starts_with(&name) { text } else { format!("{name}: {text}") }
}

//! What can go wrong while a library is opened and loaded.

use std::io;
use std::path::PathBuf;

use flb_format::FormatError;

/// Errors of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RuntimeError {
    /// The file could not be opened, asked about, mapped, or read behind its URL.
    #[error("{path}: cannot {action}: {source}", path = path.display())]
    Io {
        /// The file as it was named.
        path: PathBuf,
        /// "open", "map", "read" or "ask for the length of".
        action: &'static str,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The environment, where it says how s3 is to be read.
    #[cfg(feature = "remote")]
    #[error("{path}: {source}", path = path.display())]
    Environment {
        /// The file as it was named.
        path: PathBuf,
        /// Variable that is wrong, and why.
        source: crate::source::EnvironmentError,
    },
    /// A folder, a pipe, a device: something whose length is not that of its bytes.
    #[error("{path}: found {found}, expected a regular file", path = path.display())]
    NotAFile {
        /// The file as it was named.
        path: PathBuf,
        /// Kind of the path, such as a folder.
        found: &'static str,
    },
    /// A file of no bytes, which cannot be mapped.
    #[error("{path}: FLB-1001 file at byte 0: the file has 0 bytes, expected at least 8", path = path.display())]
    Empty {
        /// The file as it was named.
        path: PathBuf,
    },
    /// The bytes do not keep what SPEC.md promises.
    #[error("{path}: {source}", path = path.display())]
    Format {
        /// The file as it was named.
        path: PathBuf,
        /// Broken rule and its place.
        source: Box<FormatError>,
    },
    /// A species was asked for by a number that the library does not have.
    #[error("{path}: asked for species {index}, the library holds {count}", path = path.display())]
    NoSuchSpecies {
        /// The file as it was named.
        path: PathBuf,
        /// Number that was asked for, from 0.
        index: usize,
        /// Species in the library.
        count: usize,
    },
    /// A species of another model than the sampler is for.
    #[error("{path}: species \"{species}\" is of the model \"{found}\", expected \"{expected}\"", path = path.display())]
    OtherModel {
        /// The file as it was named.
        path: PathBuf,
        /// Name of the species.
        species: String,
        /// Model of the species.
        found: &'static str,
        /// Model that the sampler is for.
        expected: &'static str,
    },
    /// A species whose bases cannot be streamed block by block.
    #[error(
        "{path}: species \"{species}\" is coded as {codec}, expected classed or haar: other codecs are loaded whole \
         (`flb pack {path} -o NEW.flb --codec classed` codes it anew)",
        path = path.display()
    )]
    NotStreamed {
        /// The file as it was named.
        path: PathBuf,
        /// Name of the species.
        species: String,
        /// Codec of its first base.
        codec: &'static str,
    },
    /// A library that is none of scene light.
    #[error("{path}: found {found}, expected the light of a scene (`flb bake-scene`)", path = path.display())]
    NoSceneLight {
        /// The file as it was named.
        path: PathBuf,
        /// Fault of the file.
        found: String,
    },
    /// Scene light that cannot be compared with an empty scene.
    #[error(
        "fields of light scattered at single suns lack the sun's own beam, which an empty scene's light is: compare with each plant alone, or bake the scene with --suns sh1"
    )]
    SceneFactor,
    /// A sun without a direction.
    #[error("the direction towards the sun is {found:?}, expected finite numbers that are not all 0")]
    NoDirection {
        /// Vector that was given.
        found: [f64; 3],
    },
    /// Light that cannot be of an uneven sky.
    #[error("an uneven sky over {found}, expected {expected}")]
    UnevenSky {
        /// Light or sky that was found.
        found: &'static str,
        /// Light or sky that is required.
        expected: &'static str,
    },
    /// Light could not be put on a GPU.
    #[cfg(feature = "gpu")]
    #[error(transparent)]
    Gpu(#[from] crate::gpu::GpuError),
    /// A sun or a sky of a strength that is no number.
    #[error("the light of the {what} is {found}, expected a finite number")]
    Daylight {
        /// "sun" or "sky".
        what: &'static str,
        /// Strength that was given.
        found: f32,
    },
    /// Light of another number of bands than is asked for.
    #[error("the light has {found} bands, expected {expected}")]
    Bands {
        /// Number of bands of the species.
        found: usize,
        /// Number of bands that is needed.
        expected: usize,
    },
    /// The file holds a base that the light needs, and it was not loaded.
    #[error("{path}: base {base} of species \"{species}\" was not loaded: the light was loaded for other suns", path = path.display())]
    NotLoaded {
        /// The file as it was named.
        path: PathBuf,
        /// Name of the species.
        species: String,
        /// The base that is needed.
        base: u8,
    },
    /// The file does not hold a base that the light needs.
    #[error("{path}: species \"{species}\" has no base {base}, which the light needs; it has {}", list(available), path = path.display())]
    MissingBase {
        /// The file as it was named.
        path: PathBuf,
        /// Name of the species.
        species: String,
        /// The base that was asked for.
        base: u8,
        /// Bases that the species has.
        available: Vec<u8>,
    },
    /// The file does not hold a base that the light needs, because the program that made the file left it out on
    /// purpose.
    #[error("{path}: species \"{species}\" has no base {base}, which the light needs: it was left out ({reason})", path = path.display())]
    LeftOut {
        /// The file as it was named.
        path: PathBuf,
        /// Name of the species.
        species: String,
        /// The base that was asked for.
        base: u8,
        /// Reason why it was left out, as the file says.
        reason: String,
    },
}

/// Number of the promise that a file of no bytes breaks.
const NO_BYTES: u32 = 1001;

impl RuntimeError {
    /// The number of the promise of SPEC.md that the file's bytes break: 1003 for `FLB-1003`. `None` where the fault is
    /// not one of bytes.
    pub fn code(&self) -> Option<u32> {
        match self {
            RuntimeError::Empty { .. } => Some(NO_BYTES),
            RuntimeError::Format { source, .. } => Some(source.code()),
            _ => None,
        }
    }
}

fn list(bases: &[u8]) -> String {
    if bases.is_empty() {
        return "none".to_owned();
    }
    bases.iter().map(u8::to_string).collect::<Vec<_>>().join(", ")
}

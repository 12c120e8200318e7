//! What can go wrong in a farm.

use std::path::PathBuf;

use flb_baker::BakeError;
use flb_files::FileError;
use flb_packer::PackError;
use flb_runtime::{LocationError, RuntimeError};
use flb_scene::ImportError;
use flb_stage::StageError;

use crate::recipe::RecipeError;

/// Errors of a library of species.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FarmError {
    /// A manifest, a species file or a mesh.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// Settings of a species that cannot be.
    #[error("{place}: {error}")]
    Recipe {
        /// Place in a manifest.
        place: String,
        /// The error.
        error: RecipeError,
    },
    /// A mesh that cannot be read for a bake.
    #[error(transparent)]
    Stage(#[from] StageError),
    /// A bake.
    #[error("{}: {source}", mesh.display())]
    Bake {
        /// File of the plant.
        mesh: PathBuf,
        /// The error.
        source: Box<BakeError>,
    },
    /// The coding of a light, or a library of several.
    #[error(transparent)]
    Pack(#[from] PackError),
    /// A file that was made and cannot be read.
    #[error(transparent)]
    Runtime(#[from] RuntimeError),
    /// A file that cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// A file that is another one than when the work was planned.
    #[error("{}: changed while it was read, expected the bytes of the plan: build again", file.display())]
    Changed {
        /// The file.
        file: PathBuf,
    },
    /// A file that was made and is not sound: a fault of ours.
    #[error("{species}: the file that was made is not sound: {issue}")]
    Unsound {
        /// Name of the species.
        species: String,
        /// Fault, with its place.
        issue: String,
    },
    /// A name that no species has.
    #[error("{}: no species is named {name:?}{}", manifest.display(), nearest.as_ref().map(|near| format!(", did you mean {near:?}?")).unwrap_or_default())]
    NoSpecies {
        /// The manifest.
        manifest: PathBuf,
        /// Name that was asked for.
        name: String,
        /// Name that is nearest to it.
        nearest: Option<String>,
    },
    /// A plan of tasks that is none.
    #[error("{}: found {found}, expected a plan that `flb farm emit` wrote", plan.display())]
    TaskPlan {
        /// File of the plan.
        plan: PathBuf,
        /// Content.
        found: String,
    },
    /// Tasks that a plan does not have.
    #[error(
        "found tasks {first}-{last}, expected numbers from 1 to {tasks}, the first no greater than the last"
    )]
    TaskRange {
        /// First number.
        first: usize,
        /// Last number.
        last: usize,
        /// Tasks of the plan.
        tasks: usize,
    },
    /// A plan of tasks that is older than the manifest, or than what it names.
    #[error("{}: {species} is made of other inputs or settings than the plan says: plan again", manifest.display())]
    Older {
        /// The manifest.
        manifest: PathBuf,
        /// Name of the species.
        species: String,
    },
    /// A command of an engine that is missing, refuses, or answers something else.
    #[error("{command}: {found}")]
    Engine {
        /// The command, or the file with its answer.
        command: String,
        /// Answer.
        found: String,
    },
    /// Work that was submitted before and is in the queue.
    #[error("{}: job {job} is in the queue still: wait for it, cancel it, or choose another folder", folder.display())]
    InQueue {
        /// Folder that it was submitted from.
        folder: PathBuf,
        /// Name of the job to the engine.
        job: String,
    },
    /// A built library that is not what a build leaves.
    #[error("{}: found {found}, expected {expected}", file.display())]
    Library {
        /// The file.
        file: PathBuf,
        /// Content that was found.
        found: String,
        /// Content that is required.
        expected: String,
    },
    /// A path that is no text, where files for engines would hold it.
    #[error("{}: found a path that is no UTF-8, expected one that a plan of tasks can hold", path.display())]
    NotText {
        /// The path.
        path: PathBuf,
    },
    /// A cache that is named by no folder and no bucket.
    #[error(transparent)]
    Location(#[from] LocationError),
    /// A bucket that does not do what is asked of it.
    #[error("{url}: {error}")]
    Bucket {
        /// URL of the cache.
        url: String,
        /// The error.
        error: String,
    },
    /// Light that takes more memory than there may be.
    #[error("{0}")]
    Room(String),
    /// A thread that the system does not give.
    #[error("threads: {0}")]
    Threads(String),
    /// The work was stopped.
    #[error("stopped")]
    Stopped,
}

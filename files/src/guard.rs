//! What a command has read and written, so that it overwrites neither.
//!
//! The guard is off in libraries: a service may read a file today and write it tomorrow. A command switches it on once,
//! by [`guard_inputs`], before it reads anything.

use std::collections::HashMap;
use std::fs::{self, Metadata};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, OnceLock, PoisonError};

use crate::FileError;

/// Which file it is, under whatever name.
#[cfg(unix)]
pub(crate) type Id = (u64, u64);
#[cfg(not(unix))]
pub(crate) type Id = PathBuf;

/// The first name that each file was met under.
#[derive(Default)]
struct Met {
    read: HashMap<Id, PathBuf>,
    written: HashMap<Id, PathBuf>,
}

static MET: OnceLock<Mutex<Met>> = OnceLock::new();

/// From now on every file that is read counts as an input of this process, and every file that it publishes as an
/// output: [`publish`](crate::publish) refuses to replace either. It cannot be switched off.
pub fn guard_inputs() {
    MET.get_or_init(Mutex::default);
}

fn with<T>(act: impl FnOnce(&mut Met) -> T) -> Option<T> {
    // Each map stays whole if a thread panics while it holds them.
    MET.get().map(|met| act(&mut met.lock().unwrap_or_else(PoisonError::into_inner)))
}

#[cfg(unix)]
pub(crate) fn id(_path: &Path, metadata: &Metadata) -> Option<Id> {
    use std::os::unix::fs::MetadataExt;
    Some((metadata.dev(), metadata.ino()))
}

#[cfg(not(unix))]
pub(crate) fn id(path: &Path, _metadata: &Metadata) -> Option<Id> {
    fs::canonicalize(path).ok()
}

/// Counts a file as an input that this process does not read, but another input names: what stands in a scene is not to
/// be overwritten by what is made of the scene.
pub fn guard_input(path: &Path) {
    if let Ok(metadata) = fs::metadata(path) {
        note_read(path, &metadata);
    }
}

/// Refuses an output that was read since it was checked, before more work is done for it.
///
/// # Errors
/// [`FileError::OutputIsInput`], [`FileError::TwoOutputs`].
pub fn check_unread(output: &Path) -> Result<(), FileError> {
    fs::metadata(output).map_or(Ok(()), |metadata| check(output, &metadata))
}

/// Counts a file as an input.
pub(crate) fn note_read(path: &Path, metadata: &Metadata) {
    with(|met| id(path, metadata).map(|id| met.read.entry(id).or_insert_with(|| path.to_owned()).clone()));
}

/// Counts the file of this name as an output.
pub(crate) fn note_written(path: &Path) {
    with(|met| {
        let id = fs::metadata(path).ok().and_then(|metadata| id(path, &metadata));
        id.map(|id| met.written.entry(id).or_insert_with(|| path.to_owned()).clone())
    });
}

/// Whether a file counts as an input.
pub(crate) fn is_read(path: &Path, metadata: &Metadata) -> bool {
    with(|met| id(path, metadata).is_some_and(|id| met.read.contains_key(&id))).unwrap_or(false)
}

/// Refuses an existing output that was read or published before.
pub(crate) fn check(output: &Path, metadata: &Metadata) -> Result<(), FileError> {
    let found = with(|met| {
        let id = id(output, metadata)?;
        let output = output.to_owned();
        // The system gives the number of a file that is gone to another.
        let is_there = |first: &&PathBuf| {
            fs::metadata(first).is_ok_and(|found| self::id(first, &found).as_ref() == Some(&id))
        };
        let read = met.read.get(&id).filter(is_there).cloned();
        let read = read.map(|input| FileError::OutputIsInput { output: output.clone(), input });
        read.or_else(|| met.written.get(&id).filter(is_there).map(|first| two_outputs(first, &output)))
    });
    found.flatten().map_or(Ok(()), Err)
}

/// The error of two outputs that are one file.
pub(crate) fn two_outputs(first: &Path, second: &Path) -> FileError {
    FileError::TwoOutputs { first: first.to_owned(), second: second.to_owned() }
}

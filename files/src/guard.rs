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

/// Whose file it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Owner {
    /// The user's: an input or an output.
    User,
    /// The program's own, such as those of a cache: it may read and replace them as often as it likes.
    Program,
}

/// The names that each file was met under.
#[derive(Default)]
struct NamesOfFiles {
    read: HashMap<Id, Names>,
    written: HashMap<Id, Names>,
}

/// A file's name as it was met first, and where it led: a link may be gone before what it leads to.
struct Names {
    first: PathBuf,
    end: Option<PathBuf>,
}

impl Names {
    fn of(path: &Path) -> Names {
        Names { first: path.to_owned(), end: fs::canonicalize(path).ok() }
    }

    /// Whether one of them is still that of this file. The system gives the number of a file that is gone to another.
    fn lead_to(&self, id: &Id) -> bool {
        let leads = |path: &PathBuf| {
            fs::metadata(path).is_ok_and(|found| self::id(path, &found).as_ref() == Some(id))
        };
        leads(&self.first) || self.end.as_ref().is_some_and(leads)
    }
}

/// Files of the user, and of the program.
#[derive(Default)]
struct Guard {
    user: NamesOfFiles,
    program: NamesOfFiles,
}

impl Guard {
    fn of(&mut self, owner: Owner) -> &mut NamesOfFiles {
        match owner {
            Owner::User => &mut self.user,
            Owner::Program => &mut self.program,
        }
    }
}

static GUARD: OnceLock<Mutex<Guard>> = OnceLock::new();

/// Guards inputs from now on: every file that is read counts as an input of this process, and every file that it
/// publishes as an output; [`publish`](crate::publish) refuses to replace either. It cannot be switched off.
pub fn guard_inputs() {
    GUARD.get_or_init(Mutex::default);
}

fn with<T>(act: impl FnOnce(&mut Guard) -> T) -> Option<T> {
    // Each map stays whole if a thread panics while it holds them.
    GUARD.get().map(|guard| act(&mut guard.lock().unwrap_or_else(PoisonError::into_inner)))
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
        note_read(path, &metadata, Owner::User);
    }
}

/// Refuses an output that was read since it was checked, before more work is done for it.
///
/// # Errors
/// [`FileError::OutputIsInput`], [`FileError::TwoOutputs`].
pub fn check_unread(output: &Path) -> Result<(), FileError> {
    let found = fs::metadata(output).ok().and_then(|metadata| id(output, &metadata));
    found.map_or(Ok(()), |id| check(output, &id, Owner::User))
}

/// Counts a file as read.
pub(crate) fn note_read(path: &Path, metadata: &Metadata, owner: Owner) {
    with(|guard| note(&mut guard.of(owner).read, path, metadata));
}

/// Counts a file as written under this name.
pub(crate) fn note_written(path: &Path, metadata: &Metadata, owner: Owner) {
    with(|guard| note(&mut guard.of(owner).written, path, metadata));
}

fn note(met: &mut HashMap<Id, Names>, path: &Path, metadata: &Metadata) {
    let Some(id) = id(path, metadata) else { return };
    if !met.get(&id).is_some_and(|names| names.lead_to(&id)) {
        met.insert(id, Names::of(path));
    }
}

/// Whether a file counts as an input.
pub(crate) fn is_read(path: &Path, metadata: &Metadata) -> bool {
    with(|guard| id(path, metadata).is_some_and(|id| guard.user.read.contains_key(&id))).unwrap_or(false)
}

/// Refuses to replace a file that was read or published before. The program replaces its own.
pub(crate) fn check(output: &Path, id: &Id, owner: Owner) -> Result<(), FileError> {
    let found = with(|guard| {
        let met = [Some(&guard.user), (owner == Owner::User).then_some(&guard.program)];
        let first = |names: &HashMap<Id, Names>| {
            names.get(id).filter(|names| names.lead_to(id)).map(|names| names.first.clone())
        };
        met.into_iter().flatten().find_map(|met| {
            let read = first(&met.read);
            let read = read.map(|input| FileError::OutputIsInput { output: output.to_owned(), input });
            read.or_else(|| first(&met.written).map(|first| two_outputs(&first, output)))
        })
    });
    found.flatten().map_or(Ok(()), Err)
}

/// The error of two outputs that are one file.
pub(crate) fn two_outputs(first: &Path, second: &Path) -> FileError {
    FileError::TwoOutputs { first: first.to_owned(), second: second.to_owned() }
}

//! A file appears under its name whole or not at all: a temporary file in the same folder is filled, flushed to the
//! disk, renamed, and the folder flushed. One that a killed writer of the same output left is removed first.
//!
//! The folder is opened once and everything happens in it, whatever its path leads to meanwhile. What is replaced gives
//! its mode, owner and access list to what replaces it.

mod disk;
mod folder;
mod left_behind;

use std::ffi::OsStr;
use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use disk::{A_LINK, Disk};
pub use disk::{names_in, stop_publishing};
use folder::Folder;
use left_behind::Temporary;

use crate::guard::{self, Owner};
use crate::{Existing, FileError};

/// Bytes gathered before they go to the system.
const BUFFER_BYTES: usize = 1 << 20;

/// Lets `write` fill a new file at `path`; a link is followed. An existing file is replaced only by
/// [`Existing::Replace`]; where anything fails, it is left as it was.
///
/// # Errors
/// [`FileError::Exists`]; [`FileError::NotAFile`] for a folder, pipe or device; [`FileError::ReadOnly`]; a file that
/// [`guard_inputs`](crate::guard_inputs) protects; write errors.
pub fn publish(
    path: &Path,
    existing: Existing,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), FileError> {
    fill(path, open_folder(path, existing, Owner::User)?, existing, write)
}

/// Publishes a file as [`publish`] with [`Existing::Replace`], for files that the program keeps for itself and reads by
/// [`open_own`](crate::open_own): those of a cache. It replaces the name: where that is a link, the link goes, and what
/// it leads to stays.
///
/// # Errors
/// As [`publish`]. An input or an output of the user is refused here too.
pub fn publish_own(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), FileError> {
    fill(path, open_folder(path, Existing::Replace, Owner::Program)?, Existing::Replace, write)
}

/// Memory that is there, free, when a file is begun: an allocation that fails ends the process at once, and would leave
/// what was begun.
const ROOM_BYTES: usize = 4 << 20;

/// An error where the system does not give [`ROOM_BYTES`]; they are given back.
fn check_room(path: &Path) -> Result<(), FileError> {
    let mut room: Vec<u8> = Vec::new();
    let taken = room.try_reserve_exact(ROOM_BYTES);
    // Else the compiler leaves out what is not used.
    std::hint::black_box(&room);
    let source = io::ErrorKind::OutOfMemory.into();
    taken.map_err(|_| FileError::Write { path: path.to_owned(), source })
}

/// Publishes in an open folder.
fn fill(
    path: &Path,
    (disk, target): (Disk, PathBuf),
    existing: Existing,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), FileError> {
    check_room(path)?;
    let mut written = None;
    publish_in(&disk, name_in(&target), existing, |file| {
        let mut out = BufWriter::with_capacity(BUFFER_BYTES, file);
        write(&mut out)?;
        out.flush()?;
        written = out.get_ref().metadata().ok();
        Ok(())
    })
    .map_err(|source| match source.downcast() {
        Ok(refused) => refused,
        Err(source) if source.kind() == io::ErrorKind::AlreadyExists => {
            FileError::Exists { path: path.to_owned() }
        }
        Err(source) => FileError::Write { path: path.to_owned(), source },
    })?;
    if let Some(written) = written {
        guard::note_written(path, &written, disk.owner());
    }
    Ok(())
}

/// Finds out whether a file could be published at `path`, by making a file without a name, or one that is removed at
/// once where the file system has none such. It removes nothing else: what looks like a temporary file may be an input
/// that is not read yet.
///
/// # Errors
/// As [`publish`].
pub(crate) fn probe(path: &Path, existing: Existing) -> Result<(), FileError> {
    let (disk, target) = open_folder(path, existing, Owner::User)?;
    let made = match disk.takes_unnamed_file() {
        Ok(false) => Temporary::create(&disk, name_in(&target)).map(drop),
        taken => taken.map(drop),
    };
    made.map_err(|source| FileError::Write { path: path.to_owned(), source })
}

/// The steps. What they do to a folder is behind [`Folder`], so that a test can let two writers take turns, stop one
/// between any two steps, and cut the power.
fn publish_in<F: Folder>(
    folder: &F,
    name: &OsStr,
    existing: Existing,
    write: impl FnOnce(&mut F::File) -> io::Result<()>,
) -> io::Result<()> {
    left_behind::remove(folder, name);
    let mut temporary = Temporary::create(folder, name)?;
    write(temporary.file())?;
    temporary.rename(name, existing)?;
    // Without this the rename itself may be lost with the power.
    folder.sync_names()
}

/// The folder to write in, and the path in it. Links of the user are resolved once; what lies there is judged in the
/// open folder, whatever the path leads to by then.
fn open_folder(path: &Path, existing: Existing, owner: Owner) -> Result<(Disk, PathBuf), FileError> {
    let not_a_file = |found| FileError::NotAFile { path: path.to_owned(), found };
    let failed = |source| FileError::Write { path: path.to_owned(), source };
    if path.file_name().is_none() {
        return Err(not_a_file("no file name"));
    }
    if path
        .as_os_str()
        .as_encoded_bytes()
        .last()
        .is_some_and(|last| std::path::is_separator(char::from(*last)))
    {
        return Err(not_a_file("the name of a folder"));
    }
    let target = match owner {
        Owner::User => resolved(path)?,
        Owner::Program => path.to_owned(),
    };
    if target.file_name().is_none() {
        return Err(not_a_file("a folder"));
    }
    let folder = folder_of(&target);
    let mut disk = Disk::open(&folder, path, owner).map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => {
            let words = format!("the folder {} does not exist", folder.display());
            failed(io::Error::new(error.kind(), words))
        }
        _ => failed(error),
    })?;
    let Some(found) = disk.replaces(name_in(&target)).map_err(failed)? else {
        return Ok((disk, target));
    };
    disk.check_found(found.id.as_ref())?;
    match found.other_kind {
        Some(A_LINK) if owner == Owner::Program => return Ok((disk, target)),
        Some(kind) => return Err(not_a_file(kind)),
        None => {}
    }
    if existing == Existing::Keep {
        return Err(FileError::Exists { path: path.to_owned() });
    }
    if let Some(mode) = found.read_only {
        return Err(FileError::ReadOnly { path: path.to_owned(), mode });
    }
    Ok((disk, target))
}

/// Where an output of the user lies.
fn resolved(path: &Path) -> Result<PathBuf, FileError> {
    match fs::symlink_metadata(path) {
        Ok(found) if found.is_symlink() => fs::canonicalize(path)
            .map_err(|_| FileError::NotAFile { path: path.to_owned(), found: "a link that leads nowhere" }),
        Ok(_) => Ok(path.to_owned()),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(path.to_owned()),
        Err(source) => Err(FileError::Write { path: path.to_owned(), source }),
    }
}

fn name_in(target: &Path) -> &OsStr {
    target.file_name().expect("a target with a name")
}

/// The folder of an output.
pub(crate) fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
        _ => PathBuf::from("."),
    }
}

#[cfg(test)]
mod model;
#[cfg(test)]
mod tests;

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

use disk::Disk;
pub use disk::{names_in, stop_publishing};
use folder::Folder;
use left_behind::Temporary;

use crate::{FileError, guard};

/// Bytes gathered before they go to the system.
const BUFFER_BYTES: usize = 1 << 20;

/// Lets `write` fill a new file at `path`. An existing file is replaced only with `force`; where
/// anything fails, it is left as it was.
///
/// # Errors
/// [`FileError::Exists`]; [`FileError::NotAFile`] for a folder, pipe or device; [`FileError::ReadOnly`]; a file that
/// [`guard_inputs`](crate::guard_inputs) protects; write errors.
pub fn publish(
    path: &Path,
    force: bool,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), FileError> {
    guard::check_unread(path)?;
    fill(path, open_folder(path, force)?, force, write)
}

/// As [`publish`] by force, for files that the program keeps for itself and may have read: those of a cache. It replaces
/// the name: where that is a link, the link goes, and what it leads to stays.
///
/// # Errors
/// As [`publish`], but for the guard.
pub fn publish_own(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), FileError> {
    match fs::symlink_metadata(path) {
        Ok(found) if found.is_symlink() => {
            let disk = Disk::open(&folder_of(path));
            let disk = disk.map_err(|source| FileError::Write { path: path.to_owned(), source })?;
            fill(path, (disk, path.to_owned()), true, write)
        }
        _ => fill(path, open_folder(path, true)?, true, write),
    }
}

/// Publishes in an open folder.
fn fill(
    path: &Path,
    (disk, target): (Disk, PathBuf),
    force: bool,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), FileError> {
    publish_in(&disk, name_in(&target), force, |file| {
        let mut out = BufWriter::with_capacity(BUFFER_BYTES, file);
        write(&mut out)?;
        out.flush()
    })
    .map_err(|source| match source.kind() {
        io::ErrorKind::AlreadyExists => FileError::Exists { path: path.to_owned() },
        _ => FileError::Write { path: path.to_owned(), source },
    })?;
    guard::note_written(path);
    Ok(())
}

/// Finds out whether a file could be published at `path`, by making a file without a name, or one that is removed at once
/// where the file system has none such. It removes nothing else: what looks like a temporary file may be an input that is
/// not read yet.
///
/// # Errors
/// As [`publish`].
pub fn probe(path: &Path, force: bool) -> Result<(), FileError> {
    let (disk, target) = open_folder(path, force)?;
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
    force: bool,
    write: impl FnOnce(&mut F::File) -> io::Result<()>,
) -> io::Result<()> {
    left_behind::remove(folder, name);
    let mut temporary = Temporary::create(folder, name)?;
    write(temporary.file())?;
    temporary.rename(name, force)?;
    // Without this the rename itself may be lost with the power.
    folder.sync_names()
}

/// The folder to write in, and the path in it, links resolved.
fn open_folder(path: &Path, force: bool) -> Result<(Disk, PathBuf), FileError> {
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
    let target = match fs::symlink_metadata(path) {
        Ok(found) if found.is_symlink() => {
            fs::canonicalize(path).map_err(|_| not_a_file("a link that leads nowhere"))?
        }
        Ok(_) => path.to_owned(),
        Err(error) if error.kind() == io::ErrorKind::NotFound => path.to_owned(),
        Err(error) => return Err(failed(error)),
    };
    if target.file_name().is_none() {
        return Err(not_a_file("a folder"));
    }
    let folder = folder_of(&target);
    let mut disk = Disk::open(&folder).map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => {
            let words = format!("the folder {} does not exist", folder.display());
            failed(io::Error::new(error.kind(), words))
        }
        _ => failed(error),
    })?;
    let Some(found) = disk.replaces(name_in(&target)).map_err(failed)? else {
        return Ok((disk, target));
    };
    if let Some(kind) = found.other_kind {
        return Err(not_a_file(kind));
    }
    if !force {
        return Err(FileError::Exists { path: path.to_owned() });
    }
    if let Some(mode) = found.read_only {
        return Err(FileError::ReadOnly { path: path.to_owned(), mode });
    }
    Ok((disk, target))
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

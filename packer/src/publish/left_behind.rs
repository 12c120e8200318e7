//! Temporary files of writers that were killed: told from those of living ones by a lock, and removed.
//!
//! A writer holds an exclusive lock on its temporary file for as long as it fills it, and the system takes the lock back
//! with the process, however that ends. Process numbers would not do: they are given out again, and mean nothing on
//! another machine of a farm. Where the file system has no locks nothing is removed; one that pretends to lock across
//! machines and does not may fail the slower of two writers of one output, as its file is gone when it is to be renamed.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::path::Path;

/// How the name of a temporary file for the output `name` starts; random letters and digits and [`SUFFIX`] follow.
pub fn prefix(name: &str) -> String {
    format!(".{name}.flb-")
}

/// How the name of a temporary file ends.
pub const SUFFIX: &str = ".tmp";

/// Random letters and digits between prefix and suffix.
pub const RANDOM_LENGTH: usize = 8;

/// Locks a new temporary file for as long as it is open. `false`: another run took it for left behind, so this one
/// needs another file.
pub fn claim(file: &File) -> io::Result<bool> {
    match file.try_lock() {
        Ok(()) => still_named(file),
        Err(TryLockError::WouldBlock) => Ok(false),
        // A file system without locks: nobody else can lock it either, so nobody removes it.
        Err(TryLockError::Error(_)) => Ok(true),
    }
}

/// Whether a file has a name yet: it may have been removed between its making and its lock.
#[cfg(unix)]
fn still_named(file: &File) -> io::Result<bool> {
    use std::os::unix::fs::MetadataExt;
    Ok(file.metadata()?.nlink() > 0)
}

#[cfg(not(unix))]
fn still_named(_file: &File) -> io::Result<bool> {
    Ok(true) // an open file cannot be removed
}

/// Removes the temporary files for the output `name` in `folder` whose writers are gone. What cannot be looked at or
/// removed stays: it does no harm but take room.
pub fn remove(folder: &Path, name: &str) {
    let prefix = prefix(name);
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        let is_ours = entry.file_name().to_str().is_some_and(|found| is_temporary(found, &prefix));
        if is_file && is_ours && is_abandoned(&entry.path()) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

fn is_temporary(found: &str, prefix: &str) -> bool {
    let random = found.strip_prefix(prefix).and_then(|rest| rest.strip_suffix(SUFFIX));
    random.is_some_and(|r| r.len() == RANDOM_LENGTH && r.bytes().all(|b| b.is_ascii_alphanumeric()))
}

/// The lock is let go with the file: whoever makes a file of this name meanwhile finds out in [`claim`].
fn is_abandoned(path: &Path) -> bool {
    let opened = OpenOptions::new().read(true).write(true).open(path);
    opened.is_ok_and(|file| file.try_lock().is_ok())
}

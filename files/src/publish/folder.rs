//! What publishing asks of a folder. [`Disk`](super::disk::Disk) is the real one; the tests' model is the other.

use std::ffi::{OsStr, OsString};
use std::io;

use crate::Existing;

/// Who holds the lock of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Lock {
    /// We do, until the file is closed.
    Ours,
    /// Another open file does.
    Theirs,
    /// This file system has no locks.
    None,
}

/// A folder that stays the same, whatever its path leads to meanwhile. Names are of files in it.
pub(super) trait Folder {
    /// An open file. Closing it lets go of its lock.
    type File;

    /// Makes a new, empty file; [`io::ErrorKind::AlreadyExists`] where something has that name.
    fn create(&self, name: &OsStr) -> io::Result<Self::File>;
    /// Opens an existing file, to lock it.
    fn open(&self, name: &OsStr) -> io::Result<Self::File>;
    /// Locks a file for this writer alone, without waiting.
    fn try_lock(&self, file: &Self::File) -> io::Result<Lock>;
    /// Whether `name` is the name of this file.
    fn is_named(&self, file: &Self::File, name: &OsStr) -> io::Result<bool>;
    /// Flushes a file's content to the disk.
    fn sync(&self, file: &Self::File) -> io::Result<()>;
    /// Refuses to replace what has this name now, if it is an input or another output.
    fn check(&self, name: &OsStr) -> io::Result<()>;
    /// Gives a file another name; what has that name is replaced, or with [`Existing::Keep`] is an
    /// [`io::ErrorKind::AlreadyExists`].
    fn rename(&self, from: &OsStr, to: &OsStr, existing: Existing) -> io::Result<()>;
    /// Removes a name.
    fn remove(&self, name: &OsStr) -> io::Result<()>;
    /// All names that begin with these letters.
    fn names_with(&self, prefix: &str) -> io::Result<Vec<OsString>>;
    /// Flushes the names to the disk.
    fn sync_names(&self) -> io::Result<()>;
}

//! A folder on a disk, and the temporary files that are being filled in it, for a signal that ends the process.

#[cfg(unix)]
mod by_handle;
#[cfg(any(not(unix), test))]
mod by_path;

use std::ffi::{OsStr, OsString};
use std::fs::{File, TryLockError};
use std::io;
use std::mem;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use super::folder::{Folder, Lock};
use crate::guard::{self, Id, Owner};
use crate::{Existing, FileError};

#[cfg(unix)]
use by_handle::Handle;
#[cfg(not(unix))]
use by_path::Handle;

/// The kind of a link.
pub(super) const A_LINK: &str = "a link";

/// An existing file that is to be replaced.
pub(super) struct Found {
    /// Identity of the file.
    pub id: Option<Id>,
    /// Kind of the file, if it is no regular one.
    pub other_kind: Option<&'static str>,
    /// Mode of the file, if it may not be written.
    pub read_only: Option<u32>,
}

/// An open folder, in which one output is published.
pub(super) struct Disk {
    handle: Arc<Handle>,
    /// As messages call it.
    output: PathBuf,
    owner: Owner,
}

impl Disk {
    /// Opens a folder, which stays the same from now on.
    pub(super) fn open(folder: &Path, output: &Path, owner: Owner) -> io::Result<Disk> {
        Ok(Disk { handle: Arc::new(Handle::open(folder)?), output: output.to_owned(), owner })
    }

    /// Looks at what has a name already, and follows no link: new files get the mode, owner and access list of a file.
    pub(super) fn replaces(&mut self, name: &OsStr) -> io::Result<Option<Found>> {
        let handle = Arc::get_mut(&mut self.handle).expect("no file has been made in it");
        handle.replaces(name)
    }

    /// Whose the output is.
    pub(super) fn owner(&self) -> Owner {
        self.owner
    }

    /// Refuses a file that the guard protects.
    pub(super) fn check_found(&self, id: Option<&Id>) -> Result<(), FileError> {
        id.map_or(Ok(()), |id| guard::check(&self.output, id, self.owner))
    }
}

impl Disk {
    /// Whether a new file without a name can be made here; `false`: the file system has no such files.
    pub(super) fn takes_unnamed_file(&self) -> io::Result<bool> {
        self.handle.takes_unnamed_file()
    }
}

/// Temporary files that are being filled, each with its folder.
static UNFINISHED: Mutex<Vec<(Arc<Handle>, OsString)>> = Mutex::new(Vec::new());

/// Removes the temporary file of every [`publish`](crate::publish) that is under way, and lets none begin or end after
/// it: for the thread of a signal handler, right before it ends the process. (A killed process leaves them behind,
/// hidden, beside the output; the next [`publish`](crate::publish) there removes them.)
pub fn stop_publishing() {
    let mut unfinished = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
    for (folder, name) in unfinished.drain(..) {
        // It may be gone already: renamed, or removed with its folder.
        let _ = folder.remove(&name);
    }
    // Held for ever: who comes to a step that would note or forget a file waits there for the end of the process.
    mem::forget(unfinished);
}

impl Disk {
    fn forget(&self, name: &OsStr) {
        let mut unfinished = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
        unfinished.retain(|(folder, noted)| !(Arc::ptr_eq(folder, &self.handle) && noted == name));
    }
}

/// Names in a folder, at most so many.
///
/// # Errors
/// A folder that cannot be listed.
pub fn names_in(folder: &Path, most: usize) -> io::Result<Vec<OsString>> {
    Handle::open(folder)?.names(most, |_| true)
}

impl Folder for Disk {
    type File = File;

    fn create(&self, name: &OsStr) -> io::Result<File> {
        // Under one lock, so that no signal finds the file made and not noted.
        let mut unfinished = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
        let file = self.handle.create(name)?;
        unfinished.push((Arc::clone(&self.handle), name.to_owned()));
        Ok(file)
    }

    fn open(&self, name: &OsStr) -> io::Result<File> {
        let file = self.handle.open_existing(name)?;
        // A user may bake from what a killed writer left.
        match guard::is_read(Path::new(name), &file.metadata()?) {
            true => Err(io::ErrorKind::ResourceBusy.into()),
            false => Ok(file),
        }
    }

    fn try_lock(&self, file: &File) -> io::Result<Lock> {
        loop {
            return match file.try_lock() {
                Ok(()) => Ok(Lock::Ours),
                Err(TryLockError::WouldBlock) => Ok(Lock::Theirs),
                Err(TryLockError::Error(error)) if error.kind() == io::ErrorKind::Interrupted => continue,
                // A file system without locks: other writers cannot take one either, so none removes the file.
                Err(TryLockError::Error(_)) => Ok(Lock::None),
            };
        }
    }

    fn is_named(&self, file: &File, name: &OsStr) -> io::Result<bool> {
        self.handle.is_named(file, name)
    }

    fn sync(&self, file: &File) -> io::Result<()> {
        file.sync_all()
    }

    fn check(&self, name: &OsStr) -> io::Result<()> {
        // What the work was begun for may have been moved away, and an input into its place.
        self.check_found(self.handle.id(name)?.as_ref()).map_err(io::Error::other)
    }

    fn rename(&self, from: &OsStr, to: &OsStr, existing: Existing) -> io::Result<()> {
        match existing {
            Existing::Replace => self.handle.rename(from, to),
            Existing::Keep => self.handle.rename_new(from, to),
        }?;
        self.forget(from);
        Ok(())
    }

    fn remove(&self, name: &OsStr) -> io::Result<()> {
        let removed = self.handle.remove(name);
        self.forget(name);
        removed
    }

    fn names_with(&self, prefix: &str) -> io::Result<Vec<OsString>> {
        let has_prefix = |name: &OsStr| name.as_encoded_bytes().starts_with(prefix.as_bytes());
        self.handle.names(usize::MAX, has_prefix)
    }

    fn sync_names(&self) -> io::Result<()> {
        self.handle.sync()
    }
}

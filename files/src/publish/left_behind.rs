//! Temporary files: made under a lock, told by it from those of writers that were killed, and removed.
//!
//! A writer holds an exclusive lock on its temporary file for as long as it fills it, and the system takes the lock
//! back with the process, however that ends. Process numbers would not do: they are given out again, and mean nothing
//! on another machine of a farm. Where the file system has no locks nothing is removed; one that pretends to lock
//! across machines and does not may fail the slower of two writers of one output, as its file is gone when it is to be
//! renamed.
//!
//! Who removes a file holds its lock until the name is gone. A writer that made it and has not locked it yet then finds
//! the lock taken, or, later, that its file has no name, and makes another.

use std::ffi::{OsStr, OsString};
use std::hash::{BuildHasher, RandomState};
use std::io;

use super::folder::{Folder, Lock};
use crate::Existing;

/// How the name of a temporary file ends.
const SUFFIX: &str = ".tmp";
/// Random letters and digits between prefix and suffix.
const RANDOM_LENGTH: usize = 8;
/// Bytes that file systems give to a name.
const MAX_NAME_BYTES: usize = 255;
/// Names that are tried. Each round lost is one that another writer won, which goes on.
const ROUNDS: usize = 1000;

/// A file that is being filled: locked, and removed unless it is renamed.
pub(super) struct Temporary<'f, F: Folder> {
    folder: &'f F,
    name: OsString,
    file: F::File,
    is_renamed: bool,
}

impl<'f, F: Folder> Temporary<'f, F> {
    /// A new file that other writers of the output `name` see is in use.
    pub(super) fn create(folder: &'f F, name: &OsStr) -> io::Result<Temporary<'f, F>> {
        let prefix = prefix(name);
        for _ in 0..ROUNDS {
            let name: OsString = format!("{prefix}{}{SUFFIX}", random_word()).into();
            let file = match folder.create(&name) {
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => continue,
                made => made?,
            };
            let temporary = Temporary { folder, name, file, is_renamed: false };
            match folder.try_lock(&temporary.file)? {
                Lock::Ours if folder.is_named(&temporary.file, &temporary.name)? => return Ok(temporary),
                // Without locks no other writer can take it for left behind.
                Lock::None => return Ok(temporary),
                // Another writer took it for left behind: it removes it.
                Lock::Ours | Lock::Theirs => continue,
            }
        }
        Err(io::Error::other("other writers of this file took away every temporary file"))
    }

    /// To fill it.
    pub(super) fn file(&mut self) -> &mut F::File {
        &mut self.file
    }

    /// Flushes its content and gives it its name, unless an input has that name by now.
    pub(super) fn rename(mut self, name: &OsStr, existing: Existing) -> io::Result<()> {
        self.folder.sync(&self.file)?;
        self.folder.check(name)?;
        self.folder.rename(&self.name, name, existing)?;
        self.is_renamed = true;
        Ok(())
    }
}

impl<F: Folder> Drop for Temporary<'_, F> {
    fn drop(&mut self) {
        if !self.is_renamed {
            // Its lock is still held. The name may be gone already.
            let _ = self.folder.remove(&self.name);
        }
    }
}

/// Removes the temporary files for the output `name` whose writers are gone. What cannot be looked at or removed stays:
/// it does no harm but take room.
pub(super) fn remove<F: Folder>(folder: &F, name: &OsStr) {
    let prefix = prefix(name);
    let names = folder.names_with(&prefix).unwrap_or_default();
    for name in names.iter().filter(|name| name.to_str().is_some_and(|name| is_temporary(name, &prefix))) {
        let Ok(file) = folder.open(name) else { continue };
        let is_abandoned = matches!(folder.try_lock(&file), Ok(Lock::Ours));
        // The name may be of another file by now, and this one of the finished output.
        if is_abandoned && folder.is_named(&file, name).unwrap_or(false) {
            let _ = folder.remove(name);
        }
        drop(file); // and its lock, after the name is gone
    }
}

/// How the name of a temporary file for the output `name` starts; random letters and digits and [`SUFFIX`] follow. A
/// name that is too long for this, or no text, gives its digest.
fn prefix(name: &OsStr) -> String {
    let most = MAX_NAME_BYTES - ("..flb-".len() + RANDOM_LENGTH + SUFFIX.len());
    match name.to_str().filter(|name| name.len() <= most) {
        Some(name) => format!(".{name}.flb-"),
        None => {
            let digest = blake3::hash(name.as_encoded_bytes()).to_hex();
            format!(".{}.flb-", &digest.as_str()[..32])
        }
    }
}

fn is_temporary(found: &str, prefix: &str) -> bool {
    let random = found.strip_prefix(prefix).and_then(|rest| rest.strip_suffix(SUFFIX));
    random.is_some_and(|r| r.len() == RANDOM_LENGTH && r.bytes().all(|b| b.is_ascii_alphanumeric()))
}

/// Letters and digits that differ from call to call: the standard library keys every such state anew.
fn random_word() -> String {
    const LETTERS: &[u8; 32] = b"abcdefghijklmnopqrstuvwxyz234567";
    let random = RandomState::new().hash_one(0u8);
    (0..RANDOM_LENGTH).map(|at| char::from(LETTERS[(random >> (5 * at)) as usize % 32])).collect()
}

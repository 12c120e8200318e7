//! Entries as files of a folder.

use std::fs;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use flb_files::{FileError, open_own, publish_own};
use flb_scene::ImportError;

use super::shelf::{Listed, NotRead, Shelf, Writing};
use crate::FarmError;

/// Time for which an entry that was used counts as used just now.
const USE: Duration = Duration::from_hours(24);

/// A folder.
pub(super) struct Folder(pub PathBuf);

impl Folder {
    fn path(&self, entry: &str) -> PathBuf {
        self.0.join(entry)
    }
}

impl Shelf for Folder {
    fn get(&self, entry: &str) -> Result<Option<Vec<u8>>, NotRead> {
        let path = self.path(entry);
        // A link is not ours: what it leads to may be an input or an output of this very command.
        if !fs::symlink_metadata(&path).is_ok_and(|found| found.is_file()) {
            return Ok(None);
        }
        let bytes = read_whole(&path).map_err(NotRead::Entry)?;
        note_use(&path);
        Ok(Some(bytes))
    }

    fn has(&self, entry: &str) -> Result<bool, String> {
        Ok(self.path(entry).is_file())
    }

    /// A file that is there is replaced: it has the same bytes, or was refused.
    fn put(&self, entry: &str, bytes: &[u8], _: Writing) -> Result<(), String> {
        publish_own(&self.path(entry), |file| file.write_all(bytes)).map_err(|error| error.to_string())
    }

    fn list(&self) -> Result<Vec<Listed>, FarmError> {
        let refuse = |source| ImportError::Io { path: self.0.clone(), source };
        let mut kept = Vec::new();
        for entry in fs::read_dir(&self.0).map_err(refuse)? {
            let entry = entry.map_err(refuse)?;
            // Another command may have removed it, or put a link in its place.
            let Some(metadata) = entry.metadata().ok().filter(fs::Metadata::is_file) else { continue };
            let Ok(name) = entry.file_name().into_string() else { continue };
            let used = metadata.modified().unwrap_or(UNIX_EPOCH);
            kept.push(Listed { name, bytes: metadata.len(), used });
        }
        Ok(kept)
    }

    fn remove(&self, entry: &str) -> Result<(), FarmError> {
        let path = self.path(entry);
        match fs::remove_file(&path) {
            Err(source) if source.kind() != ErrorKind::NotFound => {
                Err(FileError::Write { path, source }.into())
            }
            _ => Ok(()),
        }
    }

    fn name(&self, entry: &str) -> String {
        self.path(entry).display().to_string()
    }
}

/// Notes the use of an entry as its time of change, once a day, for those who remove what is not used. Where that fails
/// the entry only looks older.
fn note_use(path: &Path) {
    let Ok((file, metadata)) = open_own(path) else { return };
    let now = SystemTime::now();
    let age = metadata.modified().ok().and_then(|used| now.duration_since(used).ok());
    if age.is_some_and(|age| age >= USE) {
        let _ = file.set_modified(now); // as said above
    }
}

/// Copies an entry, so that what is checked is what is used, whatever happens to the file.
fn read_whole(path: &Path) -> Result<Vec<u8>, String> {
    let (mut file, metadata) = open_own(path).map_err(|error| error.to_string())?;
    let length = usize::try_from(metadata.len()).map_err(|error| error.to_string())?;
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(length).map_err(|_| {
        format!("{length} bytes of memory needed for the file, which the system does not give")
    })?;
    file.read_to_end(&mut bytes).map_err(|error| error.to_string())?;
    Ok(bytes)
}

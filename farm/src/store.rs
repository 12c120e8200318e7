//! The folder of results: what stages made, under the names of their keys, so that the same build reads it back instead
//! of working again.
//!
//! Every entry is checked before it is used; one that fails is made again. A store never fails a command: where it
//! cannot be read or written, the work is done as without one. All of this is told to a function of its opener.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, SystemTime};

use flb_baker::bake::Store;
use flb_files::{open_own, publish_own};

/// Hears what is amiss with a store.
pub type Tell<'t> = &'t (dyn Fn(&str) + Sync);

/// A folder that keeps results, if there is one.
pub struct Folder<'t> {
    folder: Option<PathBuf>,
    /// Whether a write has failed, so that no other is tried.
    is_closed: AtomicBool,
    tell: Tell<'t>,
}

impl Store for Folder<'_> {
    fn get(&self, name: &str) -> Option<Vec<u8>> {
        self.read(&format!("{name}.artefact"))
    }

    fn put(&self, name: &str, bytes: &[u8]) {
        self.write(&format!("{name}.artefact"), bytes);
    }

    fn refuse(&self, name: &str, reason: &str) {
        self.damaged(&format!("{name}.artefact"), reason);
    }

    fn keeps(&self) -> bool {
        self.folder.is_some()
    }
}

impl<'t> Folder<'t> {
    /// Keeps results in `folder`, which is made if it is missing; `None` keeps nothing.
    pub fn open(folder: Option<&Path>, tell: Tell<'t>) -> Folder<'t> {
        let store = Folder { folder: folder.map(Path::to_owned), is_closed: AtomicBool::new(false), tell };
        if let Some(Err(error)) = folder.map(fs::create_dir_all) {
            store.close(&error);
        }
        store
    }

    /// The bytes of an entry; `None` if there is none, or if it cannot be read.
    pub fn read(&self, entry: &str) -> Option<Vec<u8>> {
        // A link is not ours: what it leads to may be an input or an output of this very command.
        let is_ours = |path: &PathBuf| fs::symlink_metadata(path).is_ok_and(|found| found.is_file());
        let path = self.path(entry).filter(is_ours)?;
        let bytes = read_whole(&path).inspect_err(|reason| self.damaged(entry, reason)).ok()?;
        note_use(&path);
        Some(bytes)
    }

    /// Whether there is an entry.
    pub fn has(&self, entry: &str) -> bool {
        self.path(entry).is_some_and(|path| path.is_file())
    }

    /// Keeps an entry, whole or not at all.
    pub fn write(&self, entry: &str, bytes: &[u8]) {
        let Some(path) = self.path(entry).filter(|_| !self.is_closed.load(Ordering::Relaxed)) else { return };
        if let Err(error) = publish_own(&path, |file| file.write_all(bytes)) {
            self.close(&error);
        }
    }

    /// Tells that an entry cannot be used.
    pub fn damaged(&self, entry: &str, reason: &str) {
        let path = self.path(entry).unwrap_or_default();
        (self.tell)(&format!("{}: {reason}; made again", path.display()));
    }

    fn close(&self, error: &dyn std::fmt::Display) {
        if !self.is_closed.swap(true, Ordering::Relaxed) {
            let folder = self.folder.as_deref().unwrap_or(Path::new("")).display();
            (self.tell)(&format!(
                "warning: {folder}: the cache takes nothing more, and the work goes on without: {error}"
            ));
        }
    }

    fn path(&self, entry: &str) -> Option<PathBuf> {
        self.folder.as_ref().map(|folder| folder.join(entry))
    }
}

/// Time for which an entry that was used counts as used just now.
const USE: Duration = Duration::from_hours(24);

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
pub(crate) fn read_whole(path: &Path) -> Result<Vec<u8>, String> {
    let (mut file, metadata) = open_own(path).map_err(|error| error.to_string())?;
    let length = usize::try_from(metadata.len()).map_err(|error| error.to_string())?;
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(length).map_err(|_| {
        format!("{length} bytes of memory needed for the file, which the system does not give")
    })?;
    file.read_to_end(&mut bytes).map_err(|error| error.to_string())?;
    Ok(bytes)
}

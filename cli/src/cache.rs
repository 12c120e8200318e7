//! The folder of stage artefacts: results that the same build reads back instead of working again.
//!
//! An artefact is named by its stage and a BLAKE3 of inputs, settings and schema, and holds that name under its digest.
//! It is checked before use; one that fails its check is made again. A cache never fails a command: where it cannot be
//! read or written the work is done as without one. All of this is said on stderr.

use std::cell::Cell;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use flb_baker::bake::Store;
use flb_files::{open_own, publish_own};

use crate::exit::{Failure, INPUT_OUTPUT};
use crate::memory::room_for;
use crate::print::say;

/// Where artefacts are kept, if anywhere.
pub(crate) struct Cache {
    folder: Option<PathBuf>,
    /// Whether a write has failed, so that no other is tried.
    is_closed: Cell<bool>,
}

impl Store for Cache {
    fn get(&self, name: &str) -> Option<Vec<u8>> {
        // A link is not ours: what it leads to may be an input or an output of this very command.
        let is_ours = |path: &PathBuf| fs::symlink_metadata(path).is_ok_and(|found| found.is_file());
        let path = self.path(name).filter(is_ours)?;
        read_whole(&path).inspect_err(|failure| self.refuse(name, &failure.message)).ok()
    }

    fn put(&self, name: &str, bytes: &[u8]) {
        let Some(path) = self.path(name).filter(|_| !self.is_closed.get()) else { return };
        if let Err(error) = publish_own(&path, |file| file.write_all(bytes)) {
            self.close(&error);
        }
    }

    fn refuse(&self, name: &str, reason: &str) {
        let path = self.path(name).unwrap_or_default();
        say!("{}: {reason}; made again", path.display());
    }

    fn keeps(&self) -> bool {
        self.folder.is_some()
    }
}

impl Cache {
    /// A cache in `folder`, which is made if it is missing; `None` keeps nothing.
    pub(crate) fn open(folder: Option<&Path>) -> Cache {
        let cache = Cache { folder: folder.map(Path::to_owned), is_closed: Cell::new(false) };
        if let Some(Err(error)) = folder.map(fs::create_dir_all) {
            cache.close(&error);
        }
        cache
    }

    fn close(&self, error: &dyn std::fmt::Display) {
        self.is_closed.set(true);
        let folder = self.folder.as_deref().unwrap_or(Path::new("")).display();
        say!("warning: {folder}: the cache takes nothing more, and the work goes on without: {error}");
    }

    fn path(&self, name: &str) -> Option<PathBuf> {
        self.folder.as_ref().map(|folder| folder.join(format!("{name}.artefact")))
    }
}

/// Copies an artefact, so that what is checked is what is used, whatever happens to the file.
fn read_whole(path: &Path) -> Result<Vec<u8>, Failure> {
    let io = |error: &dyn std::fmt::Display| Failure::new(INPUT_OUTPUT, error);
    let (mut file, metadata) = open_own(path).map_err(|error| io(&error))?;
    let mut bytes = room_for(usize::try_from(metadata.len()).map_err(|error| io(&error))?)?;
    file.read_to_end(&mut bytes).map_err(|error| io(&error))?;
    Ok(bytes)
}

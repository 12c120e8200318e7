//! The folder of stage artefacts: results that the same build reads back instead of working again.
//!
//! An artefact is named by its stage and a BLAKE3 of inputs, settings and schema, and holds that name under its digest.
//! It is checked before use; one that fails its check is made again. A cache never fails a command: where it cannot be
//! read or written the work is done as without one. All of this is said on stderr.

use std::cell::Cell;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use flb_baker::artefact::{self, Artefact};
use flb_files::{open_regular, publish_own};

use crate::exit::{Failure, INPUT_OUTPUT};
use crate::memory::room_for;
use crate::print::say;

/// Where artefacts are kept, if anywhere.
pub struct Cache {
    folder: Option<PathBuf>,
    /// Whether a write has failed, so that no other is tried.
    is_closed: Cell<bool>,
}

impl Cache {
    /// A cache in `folder`, which is made if it is missing; `None` keeps nothing.
    pub fn open(folder: Option<&Path>) -> Cache {
        let cache = Cache { folder: folder.map(Path::to_owned), is_closed: Cell::new(false) };
        if let Some(Err(error)) = folder.map(fs::create_dir_all) {
            cache.close(&error);
        }
        cache
    }

    /// The digest of what a stage starts from, for the keys of what it makes. Where nothing is kept no key is used, and
    /// none is worked out.
    pub fn digest<A: Artefact>(&self, input: &A) -> Result<[u8; 32], Failure> {
        match &self.folder {
            Some(_) => Ok(artefact::digest(input)?),
            None => Ok([0; 32]),
        }
    }

    /// The artefact `stage`-`key`, if it passes `check`, or else made by `make` and kept.
    pub fn reuse_or_make<A: Artefact>(
        &self,
        stage: &str,
        key: &str,
        check: impl FnOnce(&A) -> Result<(), Failure>,
        make: impl FnOnce() -> Result<A, Failure>,
    ) -> Result<A, Failure> {
        if let Some(value) = self.read(stage, key, check) {
            return Ok(value);
        }
        let value = make()?;
        self.keep(stage, key, &value)?;
        Ok(value)
    }

    /// All artefacts of `stage` under `keys`, or `None` if one is missing or fails its check.
    pub fn read_all<A: Artefact>(
        &self,
        stage: &str,
        keys: impl Iterator<Item = String>,
        check: impl Fn(&A) -> Result<(), Failure>,
    ) -> Option<Vec<A>> {
        keys.map(|key| self.read(stage, &key, &check)).collect()
    }

    /// One artefact; `None` if it is missing, or fails its check, which is said on stderr.
    pub fn read<A: Artefact>(
        &self,
        stage: &str,
        key: &str,
        check: impl FnOnce(&A) -> Result<(), Failure>,
    ) -> Option<A> {
        // A link is not ours: what it leads to may be an input or an output of this very command.
        let is_ours = |path: &PathBuf| fs::symlink_metadata(path).is_ok_and(|found| found.is_file());
        let path = self.path(stage, key).filter(is_ours)?;
        let read = || {
            let value = artefact::from_bytes(&read_whole(&path)?, key)?;
            check(&value).map(|()| value)
        };
        read().inspect_err(|failure| say!("{}: {}; made again", path.display(), failure.message)).ok()
    }

    /// Keeps an artefact, if anything is kept.
    pub fn keep<A: Artefact>(&self, stage: &str, key: &str, value: &A) -> Result<(), Failure> {
        let Some(path) = self.path(stage, key).filter(|_| !self.is_closed.get()) else { return Ok(()) };
        let bytes = artefact::to_bytes(value, key)?;
        if let Err(error) = publish_own(&path, |file| file.write_all(&bytes)) {
            self.close(&error);
        }
        Ok(())
    }

    fn close(&self, error: &dyn std::fmt::Display) {
        self.is_closed.set(true);
        let folder = self.folder.as_deref().unwrap_or(Path::new("")).display();
        say!("warning: {folder}: the cache takes nothing more, and the work goes on without: {error}");
    }

    fn path(&self, stage: &str, key: &str) -> Option<PathBuf> {
        self.folder.as_ref().map(|folder| folder.join(format!("{stage}-{key}.artefact")))
    }
}

/// Copies an artefact, so that what is checked is what is used, whatever happens to the file.
fn read_whole(path: &Path) -> Result<Vec<u8>, Failure> {
    let io = |error: &dyn std::fmt::Display| Failure::new(INPUT_OUTPUT, error);
    let (mut file, metadata) = open_regular(path).map_err(|error| io(&error))?;
    let mut bytes = room_for(usize::try_from(metadata.len()).map_err(|error| io(&error))?)?;
    file.read_to_end(&mut bytes).map_err(|error| io(&error))?;
    Ok(bytes)
}

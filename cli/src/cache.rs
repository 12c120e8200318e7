//! The folder of stage artefacts: results that the same build reads back instead of working again.
//!
//! An artefact is named by its stage and a BLAKE3 of inputs, settings and schema. It is checked before
//! use; one that fails its check is made again, with a word on stderr.

use std::fs;
use std::path::{Path, PathBuf};

use flb_baker::artefact::{self, Artefact};
use flb_format::Source;
use flb_packer::publish::publish;
use flb_runtime::FileSource;

use crate::exit::{Failure, INPUT_OUTPUT};
use crate::memory::room_for;

/// Where artefacts are kept, if anywhere.
pub struct Cache {
    folder: Option<PathBuf>,
}

impl Cache {
    /// A cache in `folder`, which is made if it is missing; `None` keeps nothing.
    pub fn open(folder: Option<&Path>) -> Result<Cache, Failure> {
        if let Some(folder) = folder {
            fs::create_dir_all(folder).map_err(|error| Failure::new(INPUT_OUTPUT, error).at(folder))?;
        }
        Ok(Cache { folder: folder.map(Path::to_owned) })
    }

    /// The digest of what a stage starts from, for the keys of what it makes. Where nothing is kept no key is used, and none is worked out.
    pub fn digest<A: Artefact>(&self, input: &A) -> Result<[u8; 32], Failure> {
        match &self.folder {
            Some(_) => Ok(*blake3::hash(&artefact::to_bytes(input)?).as_bytes()),
            None => Ok([0; 32]),
        }
    }

    /// The artefact `stage`-`key`, read back by `from_bytes`, or else made by `make` and kept.
    pub fn reuse_or_make<T>(
        &self,
        stage: &str,
        key: &str,
        make: impl FnOnce() -> Result<T, Failure>,
        to_bytes: impl FnOnce(&T) -> Result<Vec<u8>, Failure>,
        from_bytes: impl FnOnce(&[u8]) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        if let Some(value) = self.read(stage, key, from_bytes) {
            return Ok(value);
        }
        let value = make()?;
        self.keep(stage, key, || to_bytes(&value))?;
        Ok(value)
    }

    /// All artefacts of `stage` under `keys`, or `None` if one is missing or fails its check.
    pub fn read_all<T>(
        &self,
        stage: &str,
        keys: impl Iterator<Item = String>,
        from_bytes: impl Fn(&[u8]) -> Result<T, Failure>,
    ) -> Option<Vec<T>> {
        keys.map(|key| self.read(stage, &key, &from_bytes)).collect()
    }

    /// One artefact; `None` if it is missing, or fails its check, which is said on stderr.
    pub fn read<T>(
        &self,
        stage: &str,
        key: &str,
        from_bytes: impl FnOnce(&[u8]) -> Result<T, Failure>,
    ) -> Option<T> {
        let path = self.path(stage, key).filter(|path| path.exists())?;
        match read_whole(&path).and_then(|bytes| from_bytes(&bytes)) {
            Ok(value) => Some(value),
            Err(failure) => {
                eprintln!("flb: {}: {}; made again", path.display(), failure.message);
                None
            }
        }
    }

    /// Keeps an artefact, if anything is kept.
    pub fn keep(
        &self,
        stage: &str,
        key: &str,
        bytes: impl FnOnce() -> Result<Vec<u8>, Failure>,
    ) -> Result<(), Failure> {
        let Some(path) = self.path(stage, key) else { return Ok(()) };
        let bytes = bytes()?;
        Ok(publish(&path, true, |file| file.write_all(&bytes))?)
    }

    fn path(&self, stage: &str, key: &str) -> Option<PathBuf> {
        self.folder.as_ref().map(|folder| folder.join(format!("{stage}-{key}.artefact")))
    }
}

/// Copies an artefact, so that what is checked is what is used, whatever happens to the file.
fn read_whole(path: &Path) -> Result<Vec<u8>, Failure> {
    let file = FileSource::open(path)?;
    let io = |error| Failure::new(INPUT_OUTPUT, error).at(path);
    let length = usize::try_from(file.len_bytes().map_err(io)?).map_err(|e| Failure::new(INPUT_OUTPUT, e))?;
    let mut bytes = room_for(length).map_err(|failure| failure.at(path))?;
    bytes.resize(length, 0);
    file.read_exact_at(0, &mut bytes).map_err(io)?;
    Ok(bytes)
}

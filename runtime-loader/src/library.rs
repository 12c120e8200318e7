//! An open file: its container and the source of its bytes.

use std::path::{Path, PathBuf};

use flb_format::Source;
use flb_format::container::Container;

use crate::{FileSource, MappedSource, RuntimeError};

/// A library of species, opened and with its tables verified. Pages are verified as they are read.
pub struct Library {
    path: PathBuf,
    source: Box<dyn Source>,
    container: Container,
}

impl Library {
    /// Maps the file. See [`MappedSource`] for what nobody may do to the file meanwhile.
    pub fn open(path: impl AsRef<Path>) -> Result<Library, RuntimeError> {
        let path = path.as_ref();
        Library::from_source(path, Box::new(MappedSource::open(path)?))
    }

    /// Reads the file by positioned reads.
    pub fn open_positioned(path: impl AsRef<Path>) -> Result<Library, RuntimeError> {
        let path = path.as_ref();
        Library::from_source(path, Box::new(FileSource::open(path)?))
    }

    /// Takes bytes from anywhere; `path` only names them in errors.
    pub fn from_source(path: impl Into<PathBuf>, source: Box<dyn Source>) -> Result<Library, RuntimeError> {
        let path = path.into();
        match Container::open(source.as_ref()) {
            Ok(container) => Ok(Library { path, source, container }),
            Err(source) => Err(RuntimeError::Format { path, source: Box::new(source) }),
        }
    }

    /// The file as it was named.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The verified tables and metadata.
    pub fn container(&self) -> &Container {
        &self.container
    }

    /// The bytes.
    pub fn source(&self) -> &dyn Source {
        self.source.as_ref()
    }

    /// Index of the species of this name.
    pub fn find_species(&self, name: &str) -> Option<usize> {
        self.container.species().iter().position(|species| species.meta.name == name)
    }
}

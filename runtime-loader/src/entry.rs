//! Species of a library by their number, and why something of one is not there.

use std::path::Path;

use flb_format::container::Species;

use crate::{Library, RuntimeError};

pub(crate) fn known_species(library: &Library, index: usize) -> Result<&Species, RuntimeError> {
    let all = library.container().species();
    let path = || library.path().to_owned();
    all.get(index).ok_or_else(|| RuntimeError::NoSuchSpecies { path: path(), index, count: all.len() })
}

pub(crate) fn other_model(library: &Library, species: &Species, expected: &'static str) -> RuntimeError {
    let (name, found) = (species.meta.name.clone(), species.meta.model.name());
    RuntimeError::OtherModel { path: library.path().to_owned(), species: name, found, expected }
}

/// Why a species has no such base.
pub(crate) fn no_base(path: &Path, species: &Species, base: u8) -> RuntimeError {
    let (path, name) = (path.to_owned(), species.meta.name.clone());
    match species.meta.left_out.as_ref().filter(|left_out| left_out.bases.contains(base)) {
        Some(left_out) => {
            RuntimeError::LeftOut { path, species: name, base, reason: left_out.reason.clone() }
        }
        None => {
            let available = species.bases.iter().map(|b| b.base).collect();
            RuntimeError::MissingBase { path, species: name, base, available }
        }
    }
}

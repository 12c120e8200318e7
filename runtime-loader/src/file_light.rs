//! Light of a species that was read from a file, of either model: all that was asked for is there, or an error says
//! what is not.

use std::path::PathBuf;

use flb_format::container::Species;
use flb_format::sun;

use crate::entry::{known_species, no_base};
use crate::resident::ResidentSpecies;
use crate::sampler::bases_needed;
use crate::sun_terms::SunTerms;
use crate::{Library, RuntimeError};

/// What was read.
pub(crate) struct FileLight {
    path: PathBuf,
    species: Species,
    light: ResidentSpecies,
}

/// The bases of the model `paper` that suns and the sky need, ascending.
pub(crate) fn bases_for(
    suns: impl IntoIterator<Item = [f64; 3]>,
    has_sky: bool,
) -> Result<Vec<u8>, RuntimeError> {
    let mut bases: Vec<u8> = has_sky.then_some(0).into_iter().collect();
    for towards_sun in suns {
        let no_direction = RuntimeError::NoDirection { found: towards_sun };
        bases.extend(bases_needed(&sun::blend(towards_sun).ok_or(no_direction)?, false));
        bases.sort_unstable();
        bases.dedup();
    }
    Ok(bases)
}

impl FileLight {
    /// Reads, verifies and keeps these bases.
    pub(crate) fn load(library: &Library, index: usize, bases: &[u8]) -> Result<FileLight, RuntimeError> {
        let light = ResidentSpecies::load(library, index, bases)?;
        let species = known_species(library, index)?.clone();
        Ok(FileLight { path: library.path().to_owned(), species, light })
    }

    /// Reads, verifies and keeps every base.
    pub(crate) fn load_whole(library: &Library, index: usize) -> Result<FileLight, RuntimeError> {
        let bases: Vec<u8> = known_species(library, index)?.bases.iter().map(|base| base.base).collect();
        FileLight::load(library, index, &bases)
    }

    /// What is there.
    pub(crate) fn light(&self) -> &ResidentSpecies {
        &self.light
    }

    /// Refuses a sun, and a sky where it counts, of which a basis is not there.
    pub(crate) fn check(&self, towards_sun: Option<[f64; 3]>, has_sky: bool) -> Result<(), RuntimeError> {
        if let Some(towards_sun) = towards_sun {
            let no_direction = RuntimeError::NoDirection { found: towards_sun };
            let terms = SunTerms::of(self.light.species_suns(), towards_sun).ok_or(no_direction)?;
            if let Some(missing) = self.light.lacks(&terms) {
                return Err(self.missing(missing));
            }
        }
        match has_sky && self.light.item(0).is_none() {
            true => Err(self.missing(0)),
            false => Ok(()),
        }
    }

    /// Why there is no such base.
    pub(crate) fn missing(&self, base: u8) -> RuntimeError {
        match self.species.bases.iter().any(|known| known.base == base) {
            true => {
                let (path, species) = (self.path.clone(), self.species.meta.name.clone());
                RuntimeError::NotLoaded { path, species, base }
            }
            false => no_base(&self.path, &self.species, base),
        }
    }
}

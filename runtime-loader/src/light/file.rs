//! Light of a species that was read from a file, of either model.

use std::path::PathBuf;
use std::sync::OnceLock;

use flb_format::SunBasis;
use flb_format::container::Species;
use flb_format::sun;

use crate::extinction::Extinction;
use crate::sampler::{known_species, no_base};
use crate::sun_terms::unit;
use crate::{Library, PhysicalSampler, RuntimeError, SpeciesSampler, SunTerms, bases_needed};

/// What was read.
pub struct FileLight {
    model: Model,
    /// Of a species whose suns need a near beam: made for the first point that is marched from.
    extinction: OnceLock<Extinction>,
}

enum Model {
    Paper { path: PathBuf, species: Box<Species>, fields: SpeciesSampler },
    Physical(Box<PhysicalSampler>),
}

/// The bases of the model `paper` that suns and the sky need, ascending.
pub fn bases_for(suns: impl IntoIterator<Item = [f64; 3]>, has_sky: bool) -> Result<Vec<u8>, RuntimeError> {
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
    /// These bases of the model `paper`, or all of `physical`.
    pub fn load(library: &Library, index: usize, bases: &[u8]) -> Result<FileLight, RuntimeError> {
        let species = known_species(library, index)?;
        let model = match species.meta.physical() {
            Some(_) => Model::Physical(Box::new(PhysicalSampler::load(library, index)?)),
            None => Model::Paper {
                path: library.path().to_owned(),
                species: Box::new(species.clone()),
                fields: SpeciesSampler::load(library, index, bases)?,
            },
        };
        Ok(FileLight { model, extinction: OnceLock::new() })
    }

    /// Its fields, by their bases.
    pub fn fields(&self) -> &SpeciesSampler {
        match &self.model {
            Model::Paper { fields, .. } => fields,
            Model::Physical(sampler) => sampler.fields(),
        }
    }

    /// Only of the model `physical`.
    pub fn physical(&self) -> Option<&PhysicalSampler> {
        match &self.model {
            Model::Paper { .. } => None,
            Model::Physical(sampler) => Some(sampler),
        }
    }

    /// The extinction for marches of the near beam.
    pub fn extinction(&self, sampler: &PhysicalSampler) -> &Extinction {
        self.extinction.get_or_init(|| Extinction::of(sampler.turbid()))
    }

    pub fn size_bytes(&self) -> usize {
        match &self.model {
            Model::Paper { fields, .. } => fields.size_bytes(),
            Model::Physical(sampler) => sampler.size_bytes(),
        }
    }

    /// What a sun gives each base, all of which are there.
    pub fn terms(&self, towards_sun: [f64; 3]) -> Result<SunTerms, RuntimeError> {
        match &self.model {
            Model::Physical(sampler) => sampler.terms(towards_sun),
            Model::Paper { fields, .. } => {
                let terms =
                    unit(towards_sun).and_then(|unit| SunTerms::of(&SunBasis::Lattice18, towards_sun, unit));
                let terms = terms.ok_or(RuntimeError::NoDirection { found: towards_sun })?;
                match terms.bases().map(|(base, _)| base).filter(|base| !fields.has_base(*base)).min() {
                    Some(missing) => Err(self.missing(missing)),
                    None => Ok(terms),
                }
            }
        }
    }

    /// Why there is no such base.
    pub fn missing(&self, base: u8) -> RuntimeError {
        match &self.model {
            Model::Physical(sampler) => sampler.no_base(base),
            Model::Paper { path, species, .. } => {
                match species.bases.iter().any(|known| known.base == base) {
                    true => {
                        let (path, species) = (path.clone(), species.meta.name.clone());
                        RuntimeError::NotLoaded { path, species, base }
                    }
                    false => no_base(path, species, base),
                }
            }
        }
    }
}

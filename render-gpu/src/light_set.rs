//! The light of a forest's species on the GPU: files to bases in a `GpuLight`, and a sun to the terms of every
//! instance.

use flb_format::container::Species;
use flb_format::container::records::Codec;
use flb_format::{Placement, SpeciesMeta};
use flb_gpu::Gpu;
use flb_runtime::gpu::{GpuError, GpuLight, GpuSpecies, LightSettings, MAX_TERMS, Term};
use flb_runtime::{Library, RuntimeError};

use crate::ForestError;
use crate::layout::Words;
use crate::light_words::{LightWords, check_species};

/// Source of a species' light.
pub enum LightSource<'l> {
    /// Light that is the same everywhere, per band.
    Even([f32; 3]),
    /// Light of a file.
    Library {
        /// The file.
        library: &'l Library,
        /// Index of the file's species.
        species: usize,
    },
}

impl LightSource<'_> {
    /// Of an instance.
    fn most_terms(&self) -> u32 {
        let LightSource::Library { library, species } = self else { return 0 };
        let meta = library.container().species().get(*species).map(|entry| &entry.meta);
        let is_of_harmonics = |meta: &SpeciesMeta| meta.model.suns().has_near_beam();
        if meta.is_some_and(is_of_harmonics) { MAX_TERMS } else { BLEND_TERMS }
    }
}

/// Terms of an instance of a blend: three bases, and the sky's.
const BLEND_TERMS: u32 = 4;
/// Bytes of the tables of species and bases, and some more.
pub(crate) const TABLES_BYTES: u64 = 1 << 18;
/// Budgets for light that are tried: from what five species take to what WebGPU can bind.
const BUDGETS: [u64; 3] = [32 << 20, 64 << 20, (128 << 20) - TABLES_BYTES];
/// Least of light that is not bounded.
pub(crate) const ANY: f32 = f32::MIN;

/// The light of all species of a forest.
pub struct LightSet {
    light: GpuLight,
    species: Vec<SpeciesTerms>,
}

enum SpeciesTerms {
    Even([f32; 3]),
    Bases(Bases),
}

/// Whether a species' light can be evaluated on the GPU; else its storage.
///
/// # Errors
/// Words for [`ForestError::Unlit`].
pub fn can_light(species: &Species) -> Result<(), String> {
    match species.bases.first().map(|base| base.codec) {
        None | Some(Codec::Classed | Codec::Haar) => Ok(()),
        Some(codec) => Err(format!("bases of codec {}", codec.name())),
    }
}

impl LightSet {
    /// Reads and sends all bases of the species of a forest, in its order, with room for the terms of so many
    /// instances.
    ///
    /// # Errors
    /// [`ForestError::Unlit`] by [`can_light`]; [`ForestError::Runtime`] for a file that cannot be read;
    /// [`ForestError::Light`] for light that does not fit into 128 MiB.
    pub fn load(gpu: &Gpu, sources: &[LightSource<'_>], instances: usize) -> Result<LightSet, ForestError> {
        let terms =
            instances as u64 * u64::from(sources.iter().map(LightSource::most_terms).max().unwrap_or(1));
        let most_terms = terms.clamp(1, u64::from(u32::MAX)) as u32;
        let tables = u64::from(most_terms) * 8 + TABLES_BYTES;
        for budget in BUDGETS {
            let settings = LightSettings { budget_bytes: budget + tables, most_bases: MAX_BASES, most_terms };
            match LightSet::load_within(gpu, sources, settings) {
                Err(ForestError::Light(GpuError::Full { .. })) if budget < BUDGETS[BUDGETS.len() - 1] => {}
                done => return done,
            }
        }
        unreachable!("the last budget's answer was given")
    }

    fn load_within(
        gpu: &Gpu,
        sources: &[LightSource<'_>],
        settings: LightSettings,
    ) -> Result<LightSet, ForestError> {
        let mut light = GpuLight::new(&gpu.device, &gpu.queue, settings)?;
        let species = sources
            .iter()
            .map(|source| match source {
                LightSource::Even(light) => Ok(SpeciesTerms::Even(*light)),
                LightSource::Library { library, species } => {
                    Ok(SpeciesTerms::Bases(Bases::load(&mut light, library, *species)?))
                }
            })
            .collect::<Result<Vec<_>, ForestError>>()?;
        gpu.check()?;
        Ok(LightSet { light, species })
    }

    /// Memory of light on the GPU, but for what is free of its budget.
    pub fn size_bytes(&self) -> u64 {
        self.light.size_bytes() - self.light.free_bytes()
    }

    /// The buffers.
    pub fn light(&self) -> &GpuLight {
        &self.light
    }

    /// Sends the terms of every plant under a sun (unit, world), and gives back their `SpeciesTerms`s.
    pub(crate) fn aim(
        &mut self,
        plants: &[Placement],
        towards_sun: [f64; 3],
        sun: f32,
        sky: f32,
    ) -> Result<Words, ForestError> {
        check_species(plants, self.species.len())?;
        let (mut words, mut terms) = (Words::default(), Vec::new());
        for plant in plants {
            let light = match &self.species[plant.species] {
                SpeciesTerms::Even(light) => {
                    LightWords { constant: *light, least: ANY, ..LightWords::default() }
                }
                SpeciesTerms::Bases(bases) => {
                    let first_term = terms.len() as u32;
                    let towards_sun = plant.transform.model_from_world_direction(towards_sun);
                    let near_count = bases.terms(towards_sun, [sun, sky], &mut terms)?;
                    LightWords {
                        constant: [0.0; 3],
                        species: Some(bases.on_gpu.number().word()),
                        towards_sun,
                        first_term,
                        term_count: terms.len() as u32 - first_term,
                        near_count,
                        least: if bases.on_gpu.is_bounded() { 0.0 } else { ANY },
                        sky_count: u32::from(sky != 0.0),
                    }
                }
            };
            light.add_to(&mut words);
        }
        self.light.set_terms(0, &terms)?;
        Ok(words)
    }
}

/// Bases of all species together.
pub(crate) const MAX_BASES: u32 = 1024;

/// A species of a file, and its name for errors.
struct Bases {
    name: String,
    on_gpu: GpuSpecies,
}

impl Bases {
    fn load(light: &mut GpuLight, library: &Library, index: usize) -> Result<Bases, ForestError> {
        let mut name = String::new();
        if let Some(entry) = library.container().species().get(index) {
            name.clone_from(&entry.meta.name);
            can_light(entry).map_err(|found| ForestError::Unlit { species: name.clone(), found })?;
        }
        let on_gpu = GpuSpecies::load(light, library, index).map_err(|error| match error {
            RuntimeError::Gpu(error) => ForestError::Light(error),
            error => ForestError::Runtime(error),
        })?;
        Ok(Bases { name, on_gpu })
    }

    /// As [`GpuSpecies::terms`].
    fn terms(
        &self,
        towards_sun: [f64; 3],
        [sun, sky]: [f32; 2],
        terms: &mut Vec<Term>,
    ) -> Result<u32, ForestError> {
        self.on_gpu.terms(towards_sun, sun, sky, terms).map_err(|error| match error {
            GpuError::NoBase { base, .. } => ForestError::NoBase { species: self.name.clone(), base },
            error => ForestError::Light(error),
        })
    }
}

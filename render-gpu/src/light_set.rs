//! The light of a forest's species on the GPU: files to bases in a `GpuLight`, and a sun to the terms of every
//! instance.

use std::sync::Arc;

use flb_format::container::Species;
use flb_format::{Codec, Placement};
use flb_gpu::Gpu;
use flb_runtime::gpu::{GpuError, GpuLight, GpuSpecies, LightSettings, MAX_TERMS, SkyOnGpu, Term};
use flb_runtime::light::SkyBeams;
use flb_runtime::{Library, RuntimeError};

use crate::ForestError;
use crate::layout::Words;
use crate::light_words::{DaylightOn, LightWords, check_species, uneven};
use crate::skies::Skies;

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
    fn most_terms(&self, has_beams: bool) -> u32 {
        let LightSource::Library { library, species } = self else { return 0 };
        let Some(entry) = library.container().species().get(*species) else { return BLEND_TERMS };
        let suns = entry.meta.model.suns();
        let of_sun = if suns.has_near_beam() { MAX_TERMS } else { BLEND_TERMS };
        of_sun + if has_beams { SkyOnGpu::most_terms(suns) } else { 0 }
    }
}

/// Terms of an instance of a blend: three bases, and the sky's.
const BLEND_TERMS: u32 = 4;
/// Bytes of the tables of species and bases, and some more.
pub(crate) const TABLES_BYTES: u64 = 1 << 18;
/// Budgets for light that are tried: from what five species take to what WebGPU can bind.
const BUDGETS: [u64; 3] = [32 << 20, 64 << 20, MAX_LIGHT_BYTES];
/// Bytes for light, at most.
pub(crate) const MAX_LIGHT_BYTES: u64 = (128 << 20) - TABLES_BYTES;
/// Least of light that is not bounded.
pub(crate) const ANY: f32 = f32::MIN;

/// The light of all species of a forest.
pub struct LightSet {
    light: GpuLight,
    species: Vec<SpeciesTerms>,
    skies: Skies,
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
        LightSet::load_for_skies(gpu, sources, &[], instances)
    }

    /// Loads lights for uneven skies too: `beams` are those of the species, in the forest's order. Without them an even
    /// sky stands in.
    ///
    /// # Errors
    /// As [`LightSet::load`].
    pub fn load_for_skies(
        gpu: &Gpu,
        sources: &[LightSource<'_>],
        beams: &[Option<Arc<SkyBeams>>],
        instances: usize,
    ) -> Result<LightSet, ForestError> {
        let has_beams = |species: usize| beams.get(species).is_some_and(Option::is_some);
        let each = sources.iter().enumerate().map(|(number, source)| source.most_terms(has_beams(number)));
        let terms = instances as u64 * u64::from(each.max().unwrap_or(1));
        let most_terms = terms.clamp(1, u64::from(u32::MAX)) as u32;
        let tables = u64::from(most_terms) * 8 + TABLES_BYTES;
        for budget in BUDGETS {
            let settings = LightSettings { budget_bytes: budget + tables, most_bases: MAX_BASES, most_terms };
            match LightSet::load_within(gpu, sources, beams, settings) {
                Err(ForestError::Light(GpuError::Full { .. })) if budget < BUDGETS[BUDGETS.len() - 1] => {}
                done => return done,
            }
        }
        unreachable!("the last budget's answer was given")
    }

    fn load_within(
        gpu: &Gpu,
        sources: &[LightSource<'_>],
        beams: &[Option<Arc<SkyBeams>>],
        settings: LightSettings,
    ) -> Result<LightSet, ForestError> {
        let mut light = GpuLight::new(&gpu.device, &gpu.queue, settings)?;
        let species: Vec<SpeciesTerms> = sources
            .iter()
            .map(|source| match source {
                LightSource::Even(light) => Ok(SpeciesTerms::Even(*light)),
                LightSource::Library { library, species } => {
                    Ok(SpeciesTerms::Bases(Bases::load(&mut light, library, *species)?))
                }
            })
            .collect::<Result<Vec<_>, ForestError>>()?;
        for (species, beams) in species.iter().zip(beams) {
            if let (SpeciesTerms::Bases(bases), Some(beams)) = (species, beams) {
                light.set_sky_beams(bases.on_gpu.number(), beams)?;
            }
        }
        gpu.check()?;
        Ok(LightSet { light, species, skies: Skies::new(beams.to_vec()) })
    }

    /// Memory of light on the GPU, but for what is free of its budget.
    pub fn size_bytes(&self) -> u64 {
        self.light.size_bytes() - self.light.free_bytes()
    }

    /// The buffers.
    pub fn light(&self) -> &GpuLight {
        &self.light
    }

    /// Sends the terms of every plant, and gives back their `SpeciesTerms`s.
    pub(crate) fn aim(
        &mut self,
        plants: &[Placement],
        daylight: &DaylightOn<'_>,
    ) -> Result<Words, ForestError> {
        check_species(plants, self.species.len())?;
        let (mut words, mut terms) = (Words::default(), Vec::new());
        let skies = match daylight.dome {
            Some(dome) => self.skies.over(plants, dome)?,
            None => &[],
        };
        for (number, plant) in plants.iter().enumerate() {
            let light = match &self.species[plant.species] {
                SpeciesTerms::Even(light) => {
                    LightWords { constant: *light, least: ANY, ..LightWords::default() }
                }
                SpeciesTerms::Bases(bases) => {
                    let first_term = terms.len() as u32;
                    let towards_sun = plant.transform.model_from_world_direction(daylight.towards_sun);
                    let (even, sky_count) = match skies.get(number).and_then(Option::as_ref) {
                        Some(sky) => {
                            let of_sky = bases.sky_terms(sky)?;
                            terms.extend(&of_sky);
                            (0.0, uneven(of_sky.len()))
                        }
                        None => (daylight.even(), u32::from(daylight.even() != 0.0)),
                    };
                    let near_count = bases.terms(towards_sun, [daylight.sun, even], &mut terms)?;
                    LightWords {
                        constant: [0.0; 3],
                        species: Some(bases.on_gpu.number().word()),
                        towards_sun,
                        first_term,
                        term_count: terms.len() as u32 - first_term,
                        near_count,
                        least: if bases.on_gpu.is_bounded() { 0.0 } else { ANY },
                        sky_count,
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
        self.on_gpu.terms(towards_sun, sun, sky, terms).map_err(|error| self.named(error))
    }

    /// As [`GpuSpecies::sky_terms`].
    fn sky_terms(&self, sky: &SkyOnGpu) -> Result<Vec<Term>, ForestError> {
        self.on_gpu.sky_terms(sky).map_err(|error| self.named(error))
    }

    fn named(&self, error: GpuError) -> ForestError {
        match error {
            GpuError::NoBase { base, .. } => ForestError::NoBase { species: self.name.clone(), base },
            error => ForestError::Light(error),
        }
    }
}

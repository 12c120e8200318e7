//! The light of a forest's species as a streamer brings it: what was sent so far to the terms of every instance.

use std::sync::Arc;

use flb_format::Placement;
use flb_format::light::SunBasis;
use flb_gpu::Gpu;
use flb_runtime::gpu::{Followed, Follower, GpuLight, GpuSpeciesId, LightSettings, MAX_TERMS, SkyOnGpu};
use flb_runtime::light::SkyBeams;
use flb_runtime::residency::{Unit, UnitKind, Units};
use flb_runtime::resident::Resident;
use flb_runtime::stream::Frame;

use crate::ForestError;
use crate::layout::Words;
use crate::light_set::{MAX_BASES, MAX_LIGHT_BYTES, TABLES_BYTES};
use crate::light_words::{DaylightOn, LightWords, check_species, uneven};
use crate::skies::Skies;

/// Bytes of beams for each of an extinction, at most: 128 of a site in place of 8.
const BEAMS_TO_EXTINCTION: u64 = 16;

/// Light of species of one library that follows a streamer. Whatever is missing, there is light: the coarse before the
/// fine.
pub struct StreamedLights {
    follower: Follower,
    /// `[species of the forest]`: number in the library; `None` has no light.
    species: Vec<Option<usize>>,
    skies: Skies,
}

impl StreamedLights {
    /// Makes lights of a streamer's units, with room for so many bytes and for the terms of so many instances.
    ///
    /// # Errors
    /// [`ForestError::Light`] for a budget that no buffer has.
    pub fn new(
        gpu: &Gpu,
        units: &Units,
        species: Vec<Option<usize>>,
        instances: usize,
        budget_bytes: u64,
    ) -> Result<StreamedLights, ForestError> {
        StreamedLights::with_room(
            gpu,
            units,
            species,
            [instances as u64 * u64::from(MAX_TERMS), budget_bytes],
        )
    }

    /// Makes lights for uneven skies too, beside the budget. `suns` are those of the forest's species.
    ///
    /// # Errors
    /// As [`StreamedLights::new`].
    pub fn for_skies(
        gpu: &Gpu,
        units: &Units,
        species: Vec<Option<usize>>,
        suns: &[&SunBasis],
        instances: usize,
        budget_bytes: u64,
    ) -> Result<StreamedLights, ForestError> {
        let of_sky = suns.iter().map(|suns| SkyOnGpu::most_terms(suns)).max().unwrap_or(0);
        let of_extinction = |unit: &Unit| (unit.kind == UnitKind::Extinction).then_some(unit.memory_bytes);
        let extinction: u64 = units.all().filter_map(|unit| of_extinction(units.get(unit))).sum();
        let budget_bytes = budget_bytes + BEAMS_TO_EXTINCTION * extinction;
        let terms = instances as u64 * u64::from(MAX_TERMS + of_sky);
        StreamedLights::with_room(gpu, units, species, [terms, budget_bytes.min(MAX_LIGHT_BYTES)])
    }

    fn with_room(
        gpu: &Gpu,
        units: &Units,
        species: Vec<Option<usize>>,
        [terms, budget_bytes]: [u64; 2],
    ) -> Result<StreamedLights, ForestError> {
        let most_terms = terms.clamp(1, u64::from(u32::MAX)) as u32;
        let budget_bytes = budget_bytes + u64::from(most_terms) * 8 + TABLES_BYTES;
        let settings = LightSettings { budget_bytes, most_bases: MAX_BASES, most_terms };
        let light = GpuLight::new(&gpu.device, &gpu.queue, settings)?;
        gpu.check()?;
        let skies = Skies::new(species.iter().map(|_| None).collect());
        Ok(StreamedLights { follower: Follower::new(light, units), species, skies })
    }

    /// Sets what uneven skies over the plants of a species of the forest share, from the next relight on. Until then an
    /// even sky stands in.
    pub fn set_sky_beams(&mut self, species: usize, beams: Arc<SkyBeams>) {
        self.skies.set(species, beams);
    }

    /// Sends what a frame of the streamer brought, as [`Follower::follow`]; to be called for every frame.
    ///
    /// # Errors
    /// [`ForestError::Light`].
    pub fn follow(
        &mut self,
        frame: &Frame,
        units: &Units,
        resident: &Resident,
        most_bytes: u64,
    ) -> Result<Followed, ForestError> {
        Ok(self.follower.follow(frame, units, resident, most_bytes)?)
    }

    /// The buffers.
    pub fn light(&self) -> &GpuLight {
        self.follower.light()
    }

    /// Sends the terms of every plant, and gives back their `SpeciesTerms`s.
    pub(crate) fn aim(
        &mut self,
        resident: &Resident,
        plants: &[Placement],
        daylight: &DaylightOn<'_>,
    ) -> Result<Words, ForestError> {
        check_species(plants, self.species.len())?;
        let (mut words, mut terms) = (Words::default(), Vec::new());
        let skies = match daylight.dome {
            Some(dome) => {
                for (number, species) in self.species.iter().enumerate() {
                    if let (Some(species), Some(beams)) = (species, self.skies.beams(number)) {
                        self.follower.send_sky_beams(*species, beams)?;
                    }
                }
                self.skies.over(plants, dome)?
            }
            None => &[],
        };
        for (number, plant) in plants.iter().enumerate() {
            let Some(species) = self.species[plant.species] else {
                LightWords::default().add_to(&mut words);
                continue;
            };
            let towards_sun = plant.transform.model_from_world_direction(daylight.towards_sun);
            let first_term = terms.len() as u32;
            let sky = skies.get(number).and_then(Option::as_ref);
            let sky = sky.and_then(|sky| self.follower.sky_terms(species, resident, sky));
            let (of_sky, mut constant, sky_count) = match sky {
                Some(of_sky) => {
                    let count = uneven(of_sky.len());
                    (of_sky, [0.0; 3], count)
                }
                None => {
                    let (of_sky, all) =
                        self.follower.terms(species, resident, towards_sun, 0.0, daylight.even());
                    let count = of_sky.len() as u32;
                    (of_sky, std::array::from_fn(|band| all.constant()[band]), count)
                }
            };
            let (of_sun, of_all_sun) = self.follower.terms(species, resident, towards_sun, daylight.sun, 0.0);
            constant.iter_mut().zip(of_all_sun.constant()).for_each(|(sum, of_sun)| *sum += of_sun);
            terms.extend(of_sky.iter().chain(&of_sun));
            let light = LightWords {
                constant,
                species: self.follower.species(species).map(GpuSpeciesId::word),
                towards_sun,
                first_term,
                term_count: terms.len() as u32 - first_term,
                near_count: of_all_sun.near_bases().0.len() as u32,
                least: 0.0,
                sky_count,
            };
            light.add_to(&mut words);
        }
        self.follower.light_mut().set_terms(0, &terms)?;
        Ok(words)
    }
}

//! The light of a forest's species as a streamer brings it: what was sent so far to the terms of every instance.

use flb_format::Placement;
use flb_gpu::Gpu;
use flb_runtime::gpu::{Followed, Follower, GpuLight, GpuSpeciesId, LightSettings, MAX_TERMS};
use flb_runtime::residency::Units;
use flb_runtime::resident::Resident;
use flb_runtime::stream::Frame;

use crate::ForestError;
use crate::layout::Words;
use crate::light_set::{MAX_BASES, TABLES_BYTES};
use crate::light_words::{LightWords, check_species};

/// Light of species of one library that follows a streamer. Whatever is missing, there is light: the coarse before the
/// fine.
pub struct StreamedLights {
    follower: Follower,
    /// `[species of the forest]`: number in the library; `None` has no light.
    species: Vec<Option<usize>>,
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
        let most_terms = (instances as u64 * u64::from(MAX_TERMS)).clamp(1, u64::from(u32::MAX)) as u32;
        let budget_bytes = budget_bytes + u64::from(most_terms) * 8 + TABLES_BYTES;
        let settings = LightSettings { budget_bytes, most_bases: MAX_BASES, most_terms };
        let light = GpuLight::new(&gpu.device, &gpu.queue, settings)?;
        gpu.check()?;
        Ok(StreamedLights { follower: Follower::new(light, units), species })
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

    /// Sends the terms of every plant under a sun (unit, world) and a sky of these strengths, and gives back their
    /// `SpeciesTerms`s.
    pub(crate) fn aim(
        &mut self,
        resident: &Resident,
        plants: &[Placement],
        towards_sun: [f64; 3],
        [sun, sky]: [f32; 2],
    ) -> Result<Words, ForestError> {
        check_species(plants, self.species.len())?;
        let (mut words, mut terms) = (Words::default(), Vec::new());
        for plant in plants {
            let Some(species) = self.species[plant.species] else {
                LightWords::default().add_to(&mut words);
                continue;
            };
            let towards_sun = plant.transform.model_from_world_direction(towards_sun);
            let first_term = terms.len() as u32;
            let (of_sky, of_all_sky) = self.follower.terms(species, resident, towards_sun, 0.0, sky);
            let (of_sun, of_all_sun) = self.follower.terms(species, resident, towards_sun, sun, 0.0);
            terms.extend(of_sky.iter().chain(&of_sun));
            let light = LightWords {
                constant: std::array::from_fn(|band| {
                    of_all_sky.constant()[band] + of_all_sun.constant()[band]
                }),
                species: self.follower.species(species).map(GpuSpeciesId::word),
                towards_sun,
                first_term,
                term_count: terms.len() as u32 - first_term,
                near_count: of_all_sun.near_bases().0.len() as u32,
                least: 0.0,
                sky_count: of_sky.len() as u32,
            };
            light.add_to(&mut words);
        }
        self.follower.light_mut().set_terms(0, &terms)?;
        Ok(words)
    }
}

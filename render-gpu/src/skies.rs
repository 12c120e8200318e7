//! The uneven sky over every plant, found once for all pictures under it.

use std::sync::Arc;

use flb_format::Placement;
use flb_runtime::RuntimeError;
use flb_runtime::gpu::SkyOnGpu;
use flb_runtime::light::SkyBeams;
use flb_scene::sky::Sky;
use rayon::prelude::*;

/// Skies over the plants of a forest.
#[derive(Default)]
pub(crate) struct Skies {
    /// `[species of the forest]`; without them an even sky stands in.
    beams: Vec<Option<Arc<SkyBeams>>>,
    /// The sky and the plants that `over` is of.
    of: Option<(Sky, Vec<Placement>)>,
    /// `[plant]`
    over: Vec<Option<SkyOnGpu>>,
}

impl Skies {
    pub(crate) fn new(beams: Vec<Option<Arc<SkyBeams>>>) -> Skies {
        Skies { beams, ..Skies::default() }
    }

    /// Sets the beams of a species.
    pub(crate) fn set(&mut self, species: usize, beams: Arc<SkyBeams>) {
        self.beams.resize_with(self.beams.len().max(species + 1), || None);
        self.beams[species] = Some(beams);
        self.of = None;
    }

    pub(crate) fn beams(&self, species: usize) -> Option<&Arc<SkyBeams>> {
        self.beams.get(species).and_then(Option::as_ref)
    }

    /// `[plant]`: the sky over it.
    pub(crate) fn over(
        &mut self,
        plants: &[Placement],
        sky: &Sky,
    ) -> Result<&[Option<SkyOnGpu>], RuntimeError> {
        let is_known = |(of_sky, of_plants): &(Sky, Vec<Placement>)| of_sky == sky && of_plants == plants;
        if !self.of.as_ref().is_some_and(is_known) {
            self.of = None;
            let one = |plant: &Placement| match self.beams(plant.species) {
                Some(beams) => Ok(SkyOnGpu::of(&beams.sky(sky.patches(), &plant.transform)?)),
                None => Ok(None),
            };
            self.over = plants.par_iter().map(one).collect::<Result<_, RuntimeError>>()?;
            self.of = Some((sky.clone(), plants.to_vec()));
        }
        Ok(&self.over)
    }
}

//! The uneven sky over every plant, found once for all pictures under it.

use std::num::NonZero;
use std::sync::Arc;
use std::thread;

use flb_format::Placement;
use flb_runtime::gpu::SkyOnGpu;
use flb_runtime::{RuntimeError, SkyBeams};

use crate::dome::Dome;

/// Skies over the plants of a forest.
#[derive(Default)]
pub(crate) struct Skies {
    /// `[species of the forest]`; without them an even sky stands in.
    beams: Vec<Option<Arc<SkyBeams>>>,
    /// What `over` is of: the sky's generation and the plants.
    of: Option<(u64, Vec<Placement>)>,
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
        dome: &Dome,
    ) -> Result<&[Option<SkyOnGpu>], RuntimeError> {
        let is_known =
            |(generation, of): &(u64, Vec<Placement>)| *generation == dome.generation() && of == plants;
        if !self.of.as_ref().is_some_and(is_known) {
            self.of = None;
            self.over = self.find(plants, dome)?;
            self.of = Some((dome.generation(), plants.to_vec()));
        }
        Ok(&self.over)
    }

    fn find(&self, plants: &[Placement], dome: &Dome) -> Result<Vec<Option<SkyOnGpu>>, RuntimeError> {
        let one = |plant: &Placement| {
            let Some(beams) = self.beams(plant.species) else { return Ok(None) };
            Ok(SkyOnGpu::of(&beams.sky(dome.parts(), &plant.transform)?))
        };
        let each = plants.len().div_ceil(thread::available_parallelism().map_or(1, NonZero::get)).max(1);
        thread::scope(|scope| {
            let one = &one;
            let find =
                move |plants: &[Placement]| plants.iter().map(one).collect::<Result<Vec<_>, RuntimeError>>();
            let running: Vec<_> =
                plants.chunks(each).map(|plants| scope.spawn(move || find(plants))).collect();
            let mut over = Vec::with_capacity(plants.len());
            for thread in running {
                over.extend(thread.join().expect("the work does not panic")?);
            }
            Ok(over)
        })
    }
}

//! The loaded units of all species of a library: they come and go between frames.

use std::sync::{Arc, OnceLock};

use flb_format::Container;
use flb_format::blocks::BlockFault;

use super::{Payload, ResidentSpecies};
use crate::base::Base;
use crate::residency::{UnitId, UnitKind, Units};

/// Loaded units of a library.
#[derive(Debug)]
pub struct Resident {
    /// Shared with who holds a species as it was ([`Resident::shared`]): what changes is then another one.
    pub(super) species: Vec<Arc<ResidentSpecies>>,
}

impl Resident {
    /// Makes a set of loaded units that is empty.
    pub fn new(container: &Container, units: &Units) -> Resident {
        let species = container.species().iter().enumerate().map(|(index, species)| {
            let items = units.bases(index).iter().map(|base| base.item).collect();
            Arc::new(ResidentSpecies::empty(species, items))
        });
        Resident { species: species.collect() }
    }

    /// Blends over so many frames, 1 or more: each unit that comes takes gradually the place of what stood in for it.
    #[must_use]
    pub fn blending_over(mut self, frames: u16) -> Resident {
        self.species.iter_mut().for_each(|species| Arc::make_mut(species).blend_frames = frames.max(1));
        self
    }

    /// A frame passes: what has come is shown a little more.
    pub fn advance(&mut self) {
        for number in 0..self.species.len() {
            if !self.is_blending(number) {
                continue;
            }
            let species = Arc::make_mut(&mut self.species[number]);
            let most = species.blend_frames;
            let ages = species.ages.iter_mut().chain([&mut species.extinction_age]);
            ages.filter(|age| (1..most).contains(*age)).for_each(|age| *age += 1);
            species.generation += 1;
        }
    }

    /// Whether a unit of a species has come that is not shown in full yet.
    pub fn is_blending(&self, species: usize) -> bool {
        let species = &self.species[species];
        let ages = species.ages.iter().chain([&species.extinction_age]);
        ages.into_iter().any(|age| (1..species.blend_frames).contains(age))
    }

    /// Loaded units of a species.
    ///
    /// # Panics
    /// If there is no such species.
    pub fn species(&self, species: usize) -> &ResidentSpecies {
        &self.species[species]
    }

    /// Loaded units of a species as they are now, to be held while others come and go: on another thread, say.
    ///
    /// # Panics
    /// If there is no such species.
    pub fn shared(&self, species: usize) -> Arc<ResidentSpecies> {
        Arc::clone(&self.species[species])
    }

    /// Memory of everything loaded.
    pub fn size_bytes(&self) -> usize {
        self.species.iter().map(|species| species.size_bytes()).sum()
    }

    /// Puts a unit in its place; one that it stands on is there.
    ///
    /// # Errors
    /// [`BlockFault`] for a page that is not of its base; nothing is changed.
    ///
    /// # Panics
    /// If the payload is not of the unit's kind, or what it stands on is not there.
    pub fn insert(&mut self, units: &Units, unit: UnitId, payload: Payload) -> Result<(), BlockFault> {
        let unit = units.get(unit);
        let species = Arc::make_mut(&mut self.species[unit.species as usize]);
        let was_whole = species.is_whole(unit.kind);
        match (unit.kind, payload) {
            (UnitKind::Shared, Payload::Shared(shared, _)) => species.shared = Some(shared),
            (UnitKind::Extinction, Payload::Extinction(extinction)) => {
                species.extinction = Some(Arc::from(extinction));
                species.extinction_age = 1;
                species.sites = OnceLock::new();
            }
            (UnitKind::Averages { base }, Payload::Averages(coded)) => {
                assert!(species.shared.is_some(), "averages stand on a block map");
                species.bases[base as usize] = Some(Base::Near(Arc::from(coded)));
                species.ages[base as usize] = 1;
            }
            (UnitKind::Detail { base, .. }, Payload::Detail(payload)) => {
                let Some(Base::Near(base)) = &mut species.bases[base as usize] else {
                    panic!("detail stands on averages")
                };
                Arc::make_mut(base).add(unit.blocks[0], unit.blocks[1], &payload)?;
            }
            (kind, _) => panic!("a payload of another kind than {kind:?}"),
        }
        species.changed(unit.kind, was_whole);
        Ok(())
    }

    /// Drops a unit; nothing that stands on it is there any more.
    pub fn remove(&mut self, units: &Units, unit: UnitId) {
        let unit = units.get(unit);
        let species = Arc::make_mut(&mut self.species[unit.species as usize]);
        let was_whole = species.is_whole(unit.kind);
        match unit.kind {
            UnitKind::Shared => species.shared = None,
            UnitKind::Extinction => {
                species.extinction = None;
                species.extinction_age = 0;
                species.sites = OnceLock::new();
            }
            UnitKind::Averages { base } => {
                species.bases[base as usize] = None;
                species.ages[base as usize] = 0;
            }
            UnitKind::Detail { base, .. } => {
                if let Some(Base::Near(base)) = &mut species.bases[base as usize] {
                    Arc::make_mut(base).remove(unit.blocks[0]);
                }
            }
        }
        species.changed(unit.kind, was_whole);
    }
}

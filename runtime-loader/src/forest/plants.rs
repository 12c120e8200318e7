//! Plants by an identity that outlives the coming and going of others.

use std::sync::Arc;

use super::ForestSettings;
use super::stand::Stand;
use crate::Placement;

/// A plant of a forest. The identity of one that was taken away is of no other plant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PlantId {
    pub(super) slot: u32,
    generation: u32,
}

/// Species and stand of a plant, as snapshots know them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plant {
    generation: u32,
    /// Place among all, [`GONE`] of one that is no more.
    pub index: u32,
    pub species: u32,
    pub stand: Stand,
}

const GONE: u32 = u32::MAX;

/// Plants, shared with snapshots.
#[derive(Debug, Default)]
pub(super) struct Plants {
    slots: Arc<Vec<Plant>>,
    /// `[index]`: slot.
    order: Vec<u32>,
    free: Vec<u32>,
}

impl Plants {
    pub(super) fn add(&mut self, plant: &Placement, settings: &ForestSettings) -> PlantId {
        let index = self.order.len() as u32;
        let slots = Arc::make_mut(&mut self.slots);
        let slot = self.free.pop().unwrap_or_else(|| {
            let stand = Stand::Upright(0.0);
            slots.push(Plant { generation: 0, index: GONE, species: 0, stand });
            slots.len() as u32 - 1
        });
        slots[slot as usize].stand(index, plant, settings);
        self.order.push(slot);
        PlantId { slot, generation: slots[slot as usize].generation }
    }

    pub(super) fn set(&mut self, id: PlantId, plant: &Placement, settings: &ForestSettings) {
        let one = &mut Arc::make_mut(&mut self.slots)[id.slot as usize];
        one.stand(one.index, plant, settings);
    }

    /// The last plant takes the place of one that goes.
    pub(super) fn remove(&mut self, id: PlantId) {
        let slots = Arc::make_mut(&mut self.slots);
        let one = &mut slots[id.slot as usize];
        let index = one.index;
        (one.index, one.generation) = (GONE, one.generation.wrapping_add(1));
        self.free.push(id.slot);
        self.order.swap_remove(index as usize);
        if let Some(moved) = self.order.get(index as usize) {
            slots[*moved as usize].index = index;
        }
    }

    /// A plant that is there.
    pub(super) fn get(&self, id: PlantId) -> Option<Plant> {
        find(&self.slots, id).copied()
    }

    /// Plants that are there and tilted.
    pub(super) fn tilted(&self) -> impl Iterator<Item = &Plant> {
        self.slots.iter().filter(|plant| plant.is_there() && matches!(plant.stand, Stand::Tilted(_)))
    }

    pub(super) fn shared(&self) -> Arc<Vec<Plant>> {
        Arc::clone(&self.slots)
    }
}

impl Plant {
    /// Whether it is no empty slot.
    pub(super) fn is_there(&self) -> bool {
        self.index != GONE
    }

    fn stand(&mut self, index: u32, plant: &Placement, settings: &ForestSettings) {
        let stand = Stand::of(&plant.transform, settings.yaws, settings.step_deg);
        *self = Plant { generation: self.generation, index, species: plant.species as u32, stand };
    }
}

/// A plant that is there.
pub(super) fn find(slots: &[Plant], id: PlantId) -> Option<&Plant> {
    slots.get(id.slot as usize).filter(|plant| plant.generation == id.generation && plant.is_there())
}

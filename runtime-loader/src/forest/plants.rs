//! Plants by an identity that outlives the coming and going of others.

use std::sync::Arc;

use crate::Placement;

/// A plant of a forest. The identity of one that was taken away is of no other plant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PlantId {
    pub(super) slot: u32,
    generation: u32,
}

/// Species and turn of a plant, as snapshots know them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plant {
    generation: u32,
    /// Place among all, [`GONE`] of one that is no more.
    pub index: u32,
    pub species: u32,
    pub turn: Turn,
}

/// How a plant is turned: the yaw before its own, and the share of the next one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Turn {
    pub first: u32,
    pub share: f32,
}

const GONE: u32 = u32::MAX;
/// Share of a turn that counts for none.
const EXACT: f32 = 1e-3;

/// Plants, shared with snapshots.
#[derive(Debug, Default)]
pub(super) struct Plants {
    slots: Arc<Vec<Plant>>,
    /// `[index]`: slot.
    order: Vec<u32>,
    free: Vec<u32>,
}

impl Turn {
    /// Of so many yaws. What is no number is the first of them.
    fn of(yaw_deg: f64, yaws: u32) -> Turn {
        let turns = yaw_deg / 360.0 * f64::from(yaws);
        let low = libm::floor(turns);
        let (first, share) = ((low as u32) % yaws, (turns - low) as f32);
        match share {
            share if share > 1.0 - EXACT => Turn { first: (first + 1) % yaws, share: 0.0 },
            share if share >= EXACT => Turn { first, share },
            _ => Turn { first, share: 0.0 },
        }
    }

    /// The yaws that count, with their shares.
    pub(super) fn both(self, yaws: u32) -> impl Iterator<Item = (u32, f32)> {
        let next = (self.share > 0.0).then_some(((self.first + 1) % yaws, self.share));
        std::iter::once((self.first, 1.0 - self.share)).chain(next)
    }
}

impl Plants {
    pub(super) fn add(&mut self, plant: &Placement, yaws: u32) -> PlantId {
        let index = self.order.len() as u32;
        let slots = Arc::make_mut(&mut self.slots);
        let slot = self.free.pop().unwrap_or_else(|| {
            let turn = Turn { first: 0, share: 0.0 };
            slots.push(Plant { generation: 0, index: GONE, species: 0, turn });
            slots.len() as u32 - 1
        });
        slots[slot as usize].stand(index, plant, yaws);
        self.order.push(slot);
        PlantId { slot, generation: slots[slot as usize].generation }
    }

    pub(super) fn set(&mut self, id: PlantId, plant: &Placement, yaws: u32) {
        let one = &mut Arc::make_mut(&mut self.slots)[id.slot as usize];
        one.stand(one.index, plant, yaws);
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

    pub(super) fn shared(&self) -> Arc<Vec<Plant>> {
        Arc::clone(&self.slots)
    }
}

impl Plant {
    /// Whether it is no empty slot.
    pub(super) fn is_there(&self) -> bool {
        self.index != GONE
    }

    fn stand(&mut self, index: u32, plant: &Placement, yaws: u32) {
        let (species, turn) = (plant.species as u32, Turn::of(plant.transform.yaw_deg(), yaws));
        *self = Plant { generation: self.generation, index, species, turn };
    }
}

/// A plant that is there.
pub(super) fn find(slots: &[Plant], id: PlantId) -> Option<&Plant> {
    slots.get(id.slot as usize).filter(|plant| plant.generation == id.generation && plant.is_there())
}

//! Scene light under one sun: what others leave and add at points of instances.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::f64::consts::TAU;
use std::sync::Arc;

use flb_format::{Placement, Transform};

use super::export::{FLOOR, luminance};
use super::octahedron::{self, Corner};
use super::volume::Volume;
use super::{PreparedSceneLight, SceneFactor, SceneLight};
use crate::RuntimeError;

/// Turns about the vertical for which a species alone is lit, where many instances share them.
pub const TURNS: usize = 32;

/// Largest number of tilted plants of a species that have volumes of their own; where there are more, each lies between
/// three of 402 directions of the sun, which all of them share.
pub const TILTS: usize = 96;

/// Change that other plants and the ground make to the light of one source at a point of a plant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Modulation {
    /// Share of the plant's own light that the others leave: 0..=1, but that it may be more where the scene is compared
    /// with an empty one.
    pub scale: f32,
    /// Luminance that the others add, from 0, of a source of fluence 1.
    pub add: f32,
}

/// Change that other plants and the ground make to the light at a point of a plant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Modulations {
    /// Change of the sun's light.
    pub sun: Modulation,
    /// Change of the sky's light.
    pub sky: Modulation,
}

/// Scene light under one sun.
pub struct SceneLightAtSun<'l> {
    pub(super) light: &'l SceneLight,
    pub(super) placed: &'l [Placement],
    /// `[species of the scene]`: its number in the light.
    pub(super) species: Arc<[Option<usize>]>,
    /// `None` without a sun.
    pub(super) scene: Option<Volume>,
    /// Of species alone, whatever [`VolumeBlend`] points at.
    pub(super) alone: Vec<Volume>,
    /// Per instance; none without a sun.
    pub(super) blends: Vec<VolumeBlend>,
}

/// Which volumes the light of an instance alone is made of, and how much of each, together 1: of one of its own, two
/// turns, or three directions.
#[derive(Debug, Clone, Copy)]
pub(super) struct VolumeBlend {
    pub volumes: [usize; 3],
    pub weights: [f32; 3],
}

impl Modulation {
    /// No change, as where no neighbour is.
    pub const UNCHANGED: Modulation = Modulation { scale: 1.0, add: 0.0 };

    fn of(scene: Option<f32>, alone: Option<f32>, mean: f32) -> Modulation {
        let (Some(scene), Some(alone)) = (scene, alone) else { return Modulation::UNCHANGED };
        let floor = FLOOR * mean;
        let scale = if scene < alone { (scene + floor) / (alone + floor) } else { 1.0 };
        Modulation { scale, add: (scene - alone).max(0.0) }
    }

    /// The papers' factor: the scene's light by that of an empty scene.
    fn of_empty(scene: Option<f32>, empty: f32) -> Modulation {
        scene.map_or(Modulation::UNCHANGED, |scene| Modulation { scale: scene / empty, add: 0.0 })
    }
}

impl Modulations {
    /// No change, as where no neighbour is.
    pub const UNCHANGED: Modulations = Modulations { sun: Modulation::UNCHANGED, sky: Modulation::UNCHANGED };

    /// Adds to light per band (R, G, B), in which the shares that are left are counted already, what others add, in its
    /// own colour. `sun` and `sky` are the fluence of both.
    pub fn add(&self, sun: f32, sky: f32, phi: &mut [f32; 3]) {
        let added = sun * self.sun.add + sky * self.sky.add;
        if added > 0.0 {
            let luminance = luminance(*phi);
            match luminance > 0.0 {
                true => phi.iter_mut().for_each(|band| *band *= 1.0 + added / luminance),
                false => phi.iter_mut().for_each(|band| *band += added),
            }
        }
    }
}

impl<'l> PreparedSceneLight<'l> {
    /// Prepares scene light under a sun that stands in a direction (world, any length), or none, with plants where they
    /// stand. Their species are those of [`SceneLight::prepare`]; others change nothing of the light of a plant of
    /// another one.
    ///
    /// # Errors
    /// [`RuntimeError::NoDirection`]; where the library holds lattice directions and has not one that the sun needs,
    /// [`RuntimeError::LeftOut`] or [`RuntimeError::MissingBase`].
    pub fn at_sun(
        &self,
        sun: Option<[f64; 3]>,
        placed: &'l [Placement],
    ) -> Result<SceneLightAtSun<'l>, RuntimeError> {
        let light = self.light;
        let numbers = Arc::clone(&self.species);
        let Some(sun) = sun else {
            let (alone, blends) = (Vec::new(), Vec::new());
            return Ok(SceneLightAtSun { light, placed, species: numbers, scene: None, alone, blends });
        };
        let is_empty = light.factor == SceneFactor::Empty;
        let scene = Some(light.scene.under(self.scene.as_ref(), sun, is_empty)?);
        let mut alone = Vec::new();
        let mut blends = vec![VolumeBlend { volumes: [0; 3], weights: [0.0; 3] }; placed.len()];
        if is_empty {
            return Ok(SceneLightAtSun { light, placed, species: numbers, scene, alone, blends });
        }
        for (species, (_, coarse)) in light.alone.iter().enumerate() {
            let mine: Vec<usize> = (0..placed.len())
                .filter(|&index| number(&numbers, &placed[index]) == Some(species))
                .collect();
            let is_many = mine.len() > TURNS;
            let is_upright = |index: usize| is_many && placed[index].transform.is_upright();
            let share_corners = mine.iter().filter(|&&index| !is_upright(index)).count() > TILTS;
            let mut known = BTreeMap::new();
            for index in mine {
                let transform = &placed[index].transform;
                let parts = match (is_upright(index), share_corners) {
                    (true, _) => turns(&transform.rotation),
                    (false, true) => octahedron::around(transform.model_from_world_direction(sun))
                        .map(|(corner, weight)| (Side::Corner(corner), weight)),
                    (false, false) => [1.0, 0.0, 0.0].map(|weight| (Side::Own(index), weight)),
                };
                blends[index].weights = parts.map(|(_, weight)| weight);
                for (volume, (side, _)) in blends[index].volumes.iter_mut().zip(parts) {
                    *volume = match known.entry(side) {
                        Entry::Occupied(known) => *known.get(),
                        Entry::Vacant(place) => {
                            let towards_sun = side.towards_sun(placed, sun);
                            alone.push(coarse.under(self.alone[species].as_ref(), towards_sun, false)?);
                            *place.insert(alone.len() - 1)
                        }
                    };
                }
            }
        }
        Ok(SceneLightAtSun { light, placed, species: numbers, scene, alone, blends })
    }
}

impl SceneLightAtSun<'_> {
    /// The number of a plant's species in the light; `None`: others change nothing of its light.
    pub(super) fn number(&self, plant: &Placement) -> Option<usize> {
        number(&self.species, plant)
    }

    /// Change of the light at a point of an instance's model, metres.
    ///
    /// # Panics
    /// If there is no such instance.
    pub fn at(&self, instance: u32, point_model_m: [f32; 3]) -> Modulations {
        let index = instance as usize;
        let Some(species) = self.number(&self.placed[index]) else { return Modulations::UNCHANGED };
        let point = point_model_m.map(f64::from);
        let world = self.placed[index].transform.world_from_model_point(point);
        if self.light.factor == SceneFactor::Empty {
            let scene = &self.light.scene;
            let of_sun = |sun: &Volume| Modulation::of_empty(sun.at(world), 1.0);
            let sun = self.scene.as_ref().map_or(Modulation::UNCHANGED, of_sun);
            return Modulations { sun, sky: Modulation::of_empty(scene.sky.at(world), scene.open_sky) };
        }
        let coarse = &self.light.alone[species].1;
        let sky = Modulation::of(self.light.scene.sky.at(world), coarse.sky.at(point), coarse.sky.mean);
        let Some(scene) = &self.scene else { return Modulations { sun: Modulation::UNCHANGED, sky } };
        let VolumeBlend { volumes, weights } = self.blends[index];
        let parts = || volumes.iter().zip(weights).filter(|(_, weight)| *weight > 0.0);
        let sum = |sum: f32, (volume, weight): (&usize, f32)| {
            self.alone[*volume].at(point).map(|value| sum + weight * value)
        };
        let alone = parts().try_fold(0.0, sum);
        let mean = parts().map(|(volume, weight)| weight * self.alone[*volume].mean).sum();
        Modulations { sun: Modulation::of(scene.at(world), alone, mean), sky }
    }

    /// Memory that it takes beside the library's.
    pub fn size_bytes(&self) -> usize {
        let volumes: usize = self.scene.iter().chain(&self.alone).map(Volume::size_bytes).sum();
        volumes + size_of_val(&self.blends[..])
    }
}

fn number(species: &[Option<usize>], plant: &Placement) -> Option<usize> {
    species.get(plant.species).copied().flatten()
}

/// From which side the sun lights a species alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Side {
    /// As it lights an instance.
    Own(usize),
    /// As it lights a turn.
    Turn(usize),
    /// A direction.
    Corner(Corner),
}

impl Side {
    /// In the frame of the model.
    fn towards_sun(self, placed: &[Placement], sun: [f64; 3]) -> [f64; 3] {
        match self {
            Side::Own(index) => placed[index].transform.model_from_world_direction(sun),
            Side::Turn(turn) => turned(turn).model_from_world_direction(sun),
            Side::Corner(corner) => octahedron::direction(corner),
        }
    }
}

/// The turns below and above a rotation about the vertical, and how much each counts.
fn turns(rotation: &[[f64; 3]; 3]) -> [(Side, f32); 3] {
    let yaw = libm::atan2(rotation[2][0], rotation[0][0]);
    let turns = if yaw < 0.0 { yaw + TAU } else { yaw } / TAU * TURNS as f64;
    let below = libm::floor(turns);
    let (first, share) = (below as usize % TURNS, (turns - below) as f32);
    [(first, 1.0 - share), ((first + 1) % TURNS, share), (first, 0.0)]
        .map(|(turn, weight)| (Side::Turn(turn), weight))
}

fn turned(turn: usize) -> Transform {
    let (sin, cos) = match turn {
        0 => (0.0, 1.0),
        _ => libm::sincos(TAU * turn as f64 / TURNS as f64),
    };
    Transform { rotation: [[cos, 0.0, -sin], [0.0, 1.0, 0.0], [sin, 0.0, cos]], ..Transform::IDENTITY }
}

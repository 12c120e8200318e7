//! Scene light under one sun: what others leave and add at points of instances.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::f64::consts::TAU;

use super::flat::{FLOOR, LUMINANCE};
use super::volume::Volume;
use super::{SceneLight, Shades, octahedron};
use crate::RuntimeError;

/// Turns about the vertical for which a species alone is lit, where many instances share them.
pub const TURNS: usize = 32;

/// Most tilted plants of a species that have volumes of their own; where there are more, each lies between three of 402 directions of the sun, which all of them share.
pub const TILTS: usize = 96;

/// A plant that stands in the scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stood {
    /// Number of its species ([`SceneLight::find_species`]); `None`: others change nothing of its light.
    pub species: Option<usize>,
    /// Where the model's origin stands.
    pub position_m: [f64; 3],
    /// World from model, rows.
    pub rotation: [[f64; 3]; 3],
    /// Above 0.
    pub scale: f64,
}

/// What others do to the light of one source at a point of a plant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Share {
    /// The share of the plant's own light that they leave, 0..=1.
    pub left: f32,
    /// Luminance that they add, from 0, of a source of fluence 1.
    pub added: f32,
}

/// What others do to the light at a point of a plant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shares {
    /// Of the sun.
    pub sun: Share,
    /// Of the sky.
    pub sky: Share,
}

/// Scene light under one sun.
pub struct Shade<'l> {
    pub(super) light: &'l SceneLight,
    pub(super) stood: &'l [Stood],
    /// `None` without a sun.
    pub(super) scene: Option<Volume>,
    /// Of species alone, whatever [`Aim`] points at.
    pub(super) alone: Vec<Volume>,
    /// Per instance; none without a sun.
    pub(super) aims: Vec<Aim>,
}

/// Which volumes the light of an instance alone is made of, and how much of each, together 1: of one of its own, two turns, or three directions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Aim {
    pub volumes: [usize; 3],
    pub weights: [f32; 3],
}

impl Share {
    /// Nobody is there.
    pub const ALL: Share = Share { left: 1.0, added: 0.0 };

    fn of(scene: Option<f32>, alone: Option<f32>, mean: f32) -> Share {
        let (Some(scene), Some(alone)) = (scene, alone) else { return Share::ALL };
        let floor = FLOOR * mean;
        let left = if scene < alone { (scene + floor) / (alone + floor) } else { 1.0 };
        Share { left, added: (scene - alone).max(0.0) }
    }
}

impl Shares {
    /// Nobody is there.
    pub const ALL: Shares = Shares { sun: Share::ALL, sky: Share::ALL };

    /// Adds to light per band (R, G, B), in which the shares that are left are counted already, what others add, in its own colour. `sun` and `sky` are the
    /// fluence of both.
    pub fn add(&self, sun: f32, sky: f32, phi: &mut [f32; 3]) {
        let added = sun * self.sun.added + sky * self.sky.added;
        if added > 0.0 {
            let [red, green, blue] = LUMINANCE;
            let luminance = red * phi[0] + green * phi[1] + blue * phi[2];
            match luminance > 0.0 {
                true => phi.iter_mut().for_each(|band| *band *= 1.0 + added / luminance),
                false => phi.iter_mut().for_each(|band| *band += added),
            }
        }
    }
}

impl<'l> Shades<'l> {
    /// Under a sun that stands in a direction (world, any length), or none, with plants where they stand.
    ///
    /// # Errors
    /// [`RuntimeError::NoDirection`]; where the library holds lattice directions and has not one that the sun needs,
    /// [`RuntimeError::LeftOut`] or [`RuntimeError::MissingBase`].
    pub fn under(&self, sun: Option<[f64; 3]>, stood: &'l [Stood]) -> Result<Shade<'l>, RuntimeError> {
        let light = self.light;
        let Some(sun) = sun else {
            return Ok(Shade { light, stood, scene: None, alone: Vec::new(), aims: Vec::new() });
        };
        let scene = Some(light.scene.under(self.scene.as_ref(), sun)?);
        let mut alone = Vec::new();
        let mut aims = vec![Aim { volumes: [0; 3], weights: [0.0; 3] }; stood.len()];
        for (species, (_, coarse)) in light.alone.iter().enumerate() {
            let mut lit = |towards_sun: [f64; 3]| {
                alone.push(coarse.under(self.alone[species].as_ref(), towards_sun)?);
                Ok::<usize, RuntimeError>(alone.len() - 1)
            };
            let mine: Vec<usize> =
                (0..stood.len()).filter(|&index| stood[index].species == Some(species)).collect();
            let is_many = mine.len() > TURNS;
            let is_upright = |index: &usize| is_many && stood[*index].rotation[1] == [0.0, 1.0, 0.0];
            let (upright, tilted): (Vec<usize>, Vec<usize>) = mine.into_iter().partition(is_upright);
            let mut turns = BTreeMap::new();
            for index in upright {
                let (first, share) = turn(&stood[index].rotation);
                let ends = [first, (first + 1) % TURNS, first];
                aims[index].weights = [1.0 - share, share, 0.0];
                aims[index].volumes =
                    each(ends, |turn| once(&mut turns, turn, || lit(in_model(&turned(turn), sun))))?;
            }
            let mut corners = BTreeMap::new();
            let shares_corners = tilted.len() > TILTS;
            for index in tilted {
                let towards_sun = in_model(&stood[index].rotation, sun);
                aims[index] = match shares_corners {
                    true => {
                        let around = octahedron::around(towards_sun);
                        let mut lit = |corner| lit(octahedron::direction(corner));
                        let volumes = each(around, |(corner, _)| once(&mut corners, corner, || lit(corner)))?;
                        Aim { volumes, weights: around.map(|(_, weight)| weight) }
                    }
                    false => Aim { volumes: [lit(towards_sun)?; 3], weights: [1.0, 0.0, 0.0] },
                };
            }
        }
        Ok(Shade { light, stood, scene, alone, aims })
    }
}

impl Shade<'_> {
    /// At a point of an instance's model.
    ///
    /// # Panics
    /// If there is no such instance.
    pub fn at(&self, instance: u32, point_model_m: [f32; 3]) -> Shares {
        let index = instance as usize;
        let stood = &self.stood[index];
        let Some(species) = stood.species else { return Shares::ALL };
        let point = point_model_m.map(f64::from);
        let world = world_m(stood, point);
        let coarse = &self.light.alone[species].1;
        let sky = Share::of(self.light.scene.sky.at(world), coarse.sky.at(point), coarse.sky.mean);
        let Some(scene) = &self.scene else { return Shares { sun: Share::ALL, sky } };
        let Aim { volumes, weights } = self.aims[index];
        let parts = || volumes.iter().zip(weights).filter(|(_, weight)| *weight > 0.0);
        let sum = |sum: f32, (volume, weight): (&usize, f32)| {
            self.alone[*volume].at(point).map(|value| sum + weight * value)
        };
        let alone = parts().try_fold(0.0, sum);
        let mean = parts().map(|(volume, weight)| weight * self.alone[*volume].mean).sum();
        Shares { sun: Share::of(scene.at(world), alone, mean), sky }
    }

    /// Memory that it takes beside the library's.
    pub fn size_bytes(&self) -> usize {
        let volumes: usize = self.scene.iter().chain(&self.alone).map(Volume::size_bytes).sum();
        volumes + size_of_val(&self.aims[..])
    }
}

/// Three at once.
fn each<T, E>(of: [T; 3], mut make: impl FnMut(T) -> Result<usize, E>) -> Result<[usize; 3], E> {
    let [first, second, third] = of;
    Ok([make(first)?, make(second)?, make(third)?])
}

/// What was made for a key, at most once.
fn once<K: Ord, E>(
    made: &mut BTreeMap<K, usize>,
    key: K,
    make: impl FnOnce() -> Result<usize, E>,
) -> Result<usize, E> {
    Ok(match made.entry(key) {
        Entry::Occupied(known) => *known.get(),
        Entry::Vacant(place) => *place.insert(make()?),
    })
}

/// A direction of the world in the frame of a model so turned.
fn in_model(rotation: &[[f64; 3]; 3], direction: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|column| (0..3).map(|row| rotation[row][column] * direction[row]).sum())
}

fn world_m(stood: &Stood, point_m: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|row| {
        let along = stood.rotation[row];
        let turned = along[0] * point_m[0] + along[1] * point_m[1] + along[2] * point_m[2];
        stood.position_m[row] + turned * stood.scale
    })
}

/// The turn below a rotation about the vertical, and how far it is from it to the next.
fn turn(rotation: &[[f64; 3]; 3]) -> (usize, f32) {
    let yaw = libm::atan2(rotation[2][0], rotation[0][0]);
    let turns = if yaw < 0.0 { yaw + TAU } else { yaw } / TAU * TURNS as f64;
    let first = libm::floor(turns);
    (first as usize % TURNS, (turns - first) as f32)
}

/// World from model of a turn.
fn turned(turn: usize) -> [[f64; 3]; 3] {
    let (sin, cos) = match turn {
        0 => (0.0, 1.0),
        _ => libm::sincos(TAU * turn as f64 / TURNS as f64),
    };
    [[cos, 0.0, -sin], [0.0, 1.0, 0.0], [sin, 0.0, cos]]
}

//! Scene light under one sun: what others leave and add at points of instances.

use std::f64::consts::TAU;

use super::flat::{FLOOR, LUMINANCE};
use super::volume::Volume;
use super::{SceneLight, Shades, alike};
use crate::RuntimeError;

/// Turns about the vertical for which a species alone is lit, where many instances share them.
pub const TURNS: usize = 32;

/// Most tilted plants of a species that are lit each by itself; where there are more, those that are turned alike share it.
pub const TILTS: usize = 256;

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

/// Which volumes the light of an instance alone lies between, and where.
#[derive(Debug, Clone, Copy)]
pub(super) struct Aim {
    pub between: [usize; 2],
    pub share: f32,
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
        let mut aims = vec![Aim { between: [0; 2], share: 0.0 }; stood.len()];
        for (species, (_, coarse)) in light.alone.iter().enumerate() {
            let mut lit = |rotation: &[[f64; 3]; 3]| {
                alone.push(coarse.under(self.alone[species].as_ref(), in_model(rotation, sun))?);
                Ok::<usize, RuntimeError>(alone.len() - 1)
            };
            let mine: Vec<usize> =
                (0..stood.len()).filter(|&index| stood[index].species == Some(species)).collect();
            let is_many = mine.len() > TURNS;
            let shares_turns = |index: &usize| is_many && stood[*index].rotation[1] == [0.0, 1.0, 0.0];
            let (upright, own): (Vec<usize>, Vec<usize>) = mine.into_iter().partition(shares_turns);
            let mut turns = [None; TURNS];
            for index in upright {
                let (first, share) = turn(&stood[index].rotation);
                aims[index].share = share;
                for (end, turn) in [first, (first + 1) % TURNS].into_iter().enumerate() {
                    let volume = match turns[turn] {
                        Some(volume) => volume,
                        None => lit(&turned(turn))?,
                    };
                    turns[turn] = Some(volume);
                    aims[index].between[end] = volume;
                }
            }
            let rotations: Vec<_> = own.iter().map(|index| stood[*index].rotation).collect();
            let leaders = alike::leaders(&rotations, TILTS);
            let is_leader = |(at, leader): (usize, &usize)| (at == *leader).then_some(at);
            for at in leaders.iter().enumerate().filter_map(is_leader) {
                aims[own[at]].between = [lit(&rotations[at])?; 2];
            }
            for (index, leader) in own.iter().zip(&leaders) {
                aims[*index].between = aims[own[*leader]].between;
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
        let Aim { between, share } = self.aims[index];
        let [from, to] = between.map(|volume| &self.alone[volume]);
        let mix = |from: f32, to: f32| from + (to - from) * share;
        let alone = match share > 0.0 {
            true => from.at(point).zip(to.at(point)).map(|(from, to)| mix(from, to)),
            false => from.at(point),
        };
        Shares { sun: Share::of(scene.at(world), alone, mix(from.mean, to.mean)), sky }
    }

    /// Memory that it takes beside the library's.
    pub fn size_bytes(&self) -> usize {
        self.scene.iter().chain(&self.alone).map(Volume::size_bytes).sum()
    }
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

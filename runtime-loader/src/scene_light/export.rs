//! A shade as plain lists, for renderers on other processors, so that there is one that evaluates scene light and one
//! rule by which two lights become one: [`super::SceneLightAtSun::at`] says what comes of them.

use flb_format::{Grid, Placement};

use super::{SceneFactor, SceneLightAtSun};

/// Share of the mean light of a species alone that is added to both sides of a quotient: deep in a crown there is next
/// to no light, and what noise would make of a quotient there is of no use.
pub const FLOOR: f32 = 0.02;
/// Weights of red, green and blue in luminance.
pub const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];

pub(crate) fn luminance(light: [f32; 3]) -> f32 {
    let [red, green, blue] = LUMINANCE;
    red * light[0] + green * light[1] + blue * light[2]
}

/// Light on a lattice. At a point it is the mean of the known ones of the eight values around it by their trilinear
/// weights, the point moved into the lattice if it lies outside.
#[derive(Debug, Clone, Copy)]
pub struct FlatVolume<'s> {
    /// Grid of the sites; values are of their middles.
    pub grid: &'s Grid,
    /// Values at the sites, `[z][y][x]`; NaN where nothing is known.
    pub values: &'s [f32],
    /// Mean of what is known.
    pub mean: f32,
}

/// Volumes that the light of one instance is made of, as indices into [`FlatSceneLight::volumes`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlatVolumeBlend {
    /// Volume of the sky, of the species alone.
    pub sky: usize,
    /// Volumes of the sun, of the species alone; those that do not count are the same as others. `None` without a sun,
    /// and where the scene is compared with an empty one.
    pub sun: Option<[usize; 3]>,
    /// Weights of the sun's volumes, together 1.
    pub weights: [f32; 3],
}

/// Scene light under one sun.
#[derive(Debug, Clone)]
pub struct FlatSceneLight<'s> {
    /// Volumes of the scene in its frame, and of species alone in their models' frames.
    pub volumes: Vec<FlatVolume<'s>>,
    /// The scene's sky, as an index.
    pub scene_sky: usize,
    /// Volume of the scene's sun, as an index; `None` without one.
    pub scene_sun: Option<usize>,
    /// Light of the sun and of the sky of an empty scene, where that is what the scene's is compared with: what it
    /// leaves is then the quotient, it adds nothing, and volumes of species alone do not count.
    pub empty: Option<[f32; 2]>,
    /// Placement of each plant, by number; `None` for the aim of one whose light others do not change.
    pub plants: Vec<(Placement, Option<FlatVolumeBlend>)>,
}

impl SceneLightAtSun<'_> {
    /// Returns the scene light as flat volumes.
    pub fn flat(&self) -> FlatSceneLight<'_> {
        let alone = &self.light.alone;
        let skies = alone.iter().map(|(_, coarse)| &coarse.sky);
        let volumes =
            std::iter::once(&self.light.scene.sky).chain(skies).chain(&self.scene).chain(&self.alone);
        let empty = (self.light.factor == SceneFactor::Empty).then_some([1.0, self.light.scene.open_sky]);
        let scene_sun = self.scene.as_ref().map(|_| 1 + alone.len());
        let blend = |(index, placed): (usize, &Placement)| {
            let blend = self.number(placed).map(|species| {
                let alone = scene_sun.filter(|_| empty.is_none());
                let sun = alone.map(|scene| self.blends[index].volumes.map(|volume| scene + 1 + volume));
                let weights = self.blends.get(index).map_or([0.0; 3], |blend| blend.weights);
                FlatVolumeBlend { sky: 1 + species, sun, weights }
            });
            (*placed, blend)
        };
        FlatSceneLight {
            volumes: volumes.map(|volume| volume.flat()).collect(),
            scene_sky: 0,
            scene_sun,
            empty,
            plants: self.placed.iter().enumerate().map(blend).collect(),
        }
    }
}

//! The light of a forest as a frame left it.

use std::sync::Arc;

use flb_format::container::records::MAX_BANDS;

use super::plants::{Plant, PlantId, find};
use super::volumes::Volumes;
use crate::light::LightVolume;

/// The light of all plants as a frame left it ([`super::Forest::snapshot`]). It holds what it needs.
#[derive(Debug, Default)]
pub struct Snapshot {
    pub(super) plants: Arc<Vec<Plant>>,
    pub(super) species: Vec<Shown>,
}

/// Light of a plant: `sum of factor x volume + rest`.
#[derive(Debug)]
pub struct Parts<'s> {
    /// Eight at most, four of an upright plant. Plants and snapshots share them: the same `Arc` is the same light.
    pub volumes: Vec<(&'s Arc<LightVolume>, f32)>,
    /// Light per band, the same at all points.
    pub rest: Vec<f32>,
}

/// What is shown of a species.
#[derive(Debug)]
pub(super) struct Shown {
    /// Each with a factor.
    pub now: Option<(Arc<Volumes>, f32)>,
    pub before: Option<(Arc<Volumes>, f32)>,
    /// Share of `now`.
    pub share: f32,
    /// In the place of what is not there.
    pub mean: Vec<f32>,
    pub yaws: u32,
}

impl Snapshot {
    /// Values per point of a plant; `None` where there is no such plant.
    pub fn bands(&self, plant: PlantId) -> Option<usize> {
        Some(self.species[find(&self.plants, plant)?.species as usize].mean.len())
    }

    /// Light per band at a point of a plant's model at rest, metres. Whether there is such a plant; without, `out` is
    /// left as it was.
    ///
    /// # Panics
    /// If `out` is shorter than the bands.
    pub fn at(&self, plant: PlantId, point_m: [f32; 3], out: &mut [f32]) -> bool {
        let Some(plant) = find(&self.plants, plant) else { return false };
        let shown = &self.species[plant.species as usize];
        let mut sum = Sum::new(&mut out[..shown.mean.len()]);
        let rest = shown.tell(plant, |volume, factor| sum.add(volume, factor, point_m));
        out.iter_mut().zip(&shown.mean).for_each(|(out, mean)| *out += rest * mean);
        true
    }

    /// Light of a plant as a sum of volumes: for many points of it, or for a GPU that holds volumes. `None` where there
    /// is no such plant.
    pub fn parts(&self, plant: PlantId) -> Option<Parts<'_>> {
        let plant = find(&self.plants, plant)?;
        let shown = &self.species[plant.species as usize];
        let mut volumes = Vec::new();
        let rest = shown.tell(plant, |volume, factor| volumes.push((volume, factor)));
        Some(Parts { volumes, rest: shown.mean.iter().map(|mean| rest * mean).collect() })
    }
}

impl Parts<'_> {
    /// Light per band at a point, as [`Snapshot::at`].
    ///
    /// # Panics
    /// If `out` is shorter than the bands.
    pub fn at(&self, point_m: [f32; 3], out: &mut [f32]) {
        let mut sum = Sum::new(&mut out[..self.rest.len()]);
        self.volumes.iter().for_each(|(volume, factor)| sum.add(volume, *factor, point_m));
        out.iter_mut().zip(&self.rest).for_each(|(out, rest)| *out += rest);
    }
}

/// Light of volumes, added up.
struct Sum<'o> {
    out: &'o mut [f32],
    light: [f32; MAX_BANDS as usize],
}

impl<'o> Sum<'o> {
    fn new(out: &'o mut [f32]) -> Sum<'o> {
        out.fill(0.0);
        Sum { out, light: [0.0; MAX_BANDS as usize] }
    }

    fn add(&mut self, volume: &LightVolume, factor: f32, point_m: [f32; 3]) {
        let light = &mut self.light[..self.out.len()];
        volume.at(point_m, light);
        self.out.iter_mut().zip(light).for_each(|(out, light)| *out += factor * *light);
    }
}

impl Shown {
    /// Volumes that are shown with their factor, and those before them while these still count.
    pub(super) fn both(&self) -> [Option<(&Volumes, f32)>; 2] {
        fn part(light: Option<&(Arc<Volumes>, f32)>, share: f32) -> Option<(&Volumes, f32)> {
            light.map(|(volumes, scale)| (&**volumes, scale * share))
        }
        let before = self.before.as_ref().filter(|_| self.is_fading());
        [part(self.now.as_ref(), self.share), part(before, 1.0 - self.share)]
    }

    /// Whether the light of before still counts.
    pub(super) fn is_fading(&self) -> bool {
        self.now.is_some() && self.before.is_some() && self.share < 1.0
    }

    /// Share of the mean light beside the volumes.
    pub(super) fn rest(&self) -> f32 {
        match (&self.now, &self.before) {
            (None, _) => 1.0,
            (Some(_), Some(_)) => 0.0,
            (Some(_), None) => 1.0 - self.share,
        }
    }

    /// Tells the volumes of a plant with their factors; the share of the mean light beside them.
    fn tell<'s>(&'s self, plant: &Plant, mut tell: impl FnMut(&'s Arc<LightVolume>, f32)) -> f32 {
        for (volumes, factor) in self.both().into_iter().flatten() {
            volumes.tell(plant, factor, &mut tell);
        }
        self.rest()
    }
}

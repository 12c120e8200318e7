//! The light of a forest as a frame left it.

use std::sync::Arc;

use super::plants::{Plant, PlantId, find};
use super::volumes::Volumes;

/// The light of all plants as a frame left it ([`super::Forest::snapshot`]). It holds what it needs.
#[derive(Debug, Default)]
pub struct Snapshot {
    pub(super) plants: Arc<Vec<Plant>>,
    pub(super) species: Vec<Shown>,
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
        let out = &mut out[..shown.mean.len()];
        let Some((now, scale)) = &shown.now else {
            out.copy_from_slice(&shown.mean);
            return true;
        };
        let mut light = [0.0; flb_format::container::records::MAX_BANDS as usize];
        let light = &mut light[..out.len()];
        out.fill(0.0);
        now.add(plant, scale * shown.share, point_m, light, out);
        if shown.share < 1.0 {
            match &shown.before {
                Some((before, scale)) => before.add(plant, scale * (1.0 - shown.share), point_m, light, out),
                None => {
                    out.iter_mut().zip(&shown.mean).for_each(|(out, mean)| *out += (1.0 - shown.share) * mean)
                }
            }
        }
        true
    }
}

//! Where errors are measured, and how: two samples in each non-empty site, each base to its own largest one.

use std::sync::Arc;

use flb_format::Field;
use flb_format::blocks::{BlockMap, Classes, CodedBase, Coding, Shared};
use flb_format::sample::{site_of, trilinear};
use flb_packer::rate::{BasePayloads, SpeciesPayloads};
use flb_packer::surface::{POINTS_PER_SITE, surface_point};
use rayon::prelude::*;

use crate::plant::Plant;

/// Error over all bases.
#[derive(Clone, Copy)]
pub(crate) struct Error {
    /// Of all bases pooled.
    pub psnr_db: f64,
    /// Of the worst base: 99th percentile of the relative error over the darkest tenth of its samples.
    pub dark: f64,
}

pub(crate) struct Surface {
    /// Non-empty sites.
    pub sites: Vec<u32>,
    points: Vec<[f64; 3]>,
    /// `[z][y][x]` blocks of 4^3 texels that hold a texel within one site of a non-empty one.
    pub is_near: Vec<bool>,
    pub near_blocks: usize,
    /// `[base]` samples of the fields, `[point][band]`, and the largest magnitude.
    truth: Vec<(Vec<f32>, f64)>,
}

impl Surface {
    pub(crate) fn new(plant: &Plant) -> Surface {
        let n = plant.lattice as usize;
        let sites: Vec<u32> =
            (0u32..).zip(&plant.non_empty).filter(|(_, full)| **full).map(|(i, _)| i).collect();
        let of_site = |site: &u32| {
            (0..POINTS_PER_SITE).map(|k| surface_point(*site, k, plant.lattice)).collect::<Vec<_>>()
        };
        let points: Vec<[f64; 3]> = sites.iter().flat_map(of_site).collect();
        let blocks = n / 4;
        let mut is_near = vec![false; blocks * blocks * blocks];
        for site in &sites {
            let at = site_of(*site as usize, plant.lattice).map(|c| c as usize);
            let range = at.map(|c| [c.saturating_sub(1) / 4, (c + 1).min(n - 1) / 4]);
            for corner in 0..8 {
                let [x, y, z] = [0, 1, 2].map(|a| range[a][corner >> a & 1]);
                is_near[(z * blocks + y) * blocks + x] = true;
            }
        }
        let near_blocks = is_near.iter().filter(|near| **near).count();
        let mut surface = Surface { sites, points, is_near, near_blocks, truth: Vec::new() };
        surface.truth = plant
            .bases()
            .par_iter()
            .map(|(_, field)| {
                let samples = surface.samples(field.bands, |point, out| trilinear(field, point, out));
                let peak = samples.iter().fold(0.0f64, |peak, value| peak.max(f64::from(value.abs())));
                (samples, peak)
            })
            .collect();
        surface
    }

    fn samples(&self, bands: u32, mut sample: impl FnMut([f64; 3], &mut [f32])) -> Vec<f32> {
        let mut samples = vec![0.0; self.points.len() * bands as usize];
        for (point, out) in self.points.iter().zip(samples.chunks_exact_mut(bands as usize)) {
            sample(*point, out);
        }
        samples
    }

    /// Mean square of the error of a base, in squares of its peak, and the dark error.
    pub(crate) fn of_base(
        &self,
        base: usize,
        bands: u32,
        sample: impl FnMut([f64; 3], &mut [f32]),
    ) -> [f64; 2] {
        let (truth, peak) = &self.truth[base];
        let found = self.samples(bands, sample);
        let length = |a: &[f32]| a.iter().map(|v| square(f64::from(*v))).sum::<f64>();
        let mut sum = 0.0;
        let mut pairs: Vec<(f64, f64)> = Vec::with_capacity(self.points.len());
        for (a, b) in truth.chunks_exact(bands as usize).zip(found.chunks_exact(bands as usize)) {
            let error = a.iter().zip(b).map(|(a, b)| square(f64::from(*a) - f64::from(*b))).sum::<f64>();
            sum += error;
            pairs.push((length(a), error));
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        pairs.truncate(pairs.len() / 10);
        let mut relative: Vec<f64> =
            pairs.iter().map(|(light, error)| (error / light.max(1e-24)).sqrt()).collect();
        relative.sort_by(f64::total_cmp);
        let dark = relative[(relative.len() * 99 / 100).min(relative.len() - 1)];
        [sum / truth.len() as f64 / (peak * peak), dark]
    }

    /// Of all bases.
    pub(crate) fn pool(&self, bases: &[[f64; 2]]) -> Error {
        let mean = bases.iter().map(|base| base[0]).sum::<f64>() / bases.len() as f64;
        Error {
            psnr_db: -10.0 * libm::log10(mean),
            dark: bases.iter().map(|base| base[1]).fold(0.0, f64::max),
        }
    }

    /// Of fields that stand in for the plant's.
    pub(crate) fn of_fields(&self, plant: &Plant, stored: impl Fn(&Field) -> Field + Sync) -> Error {
        let bases = plant.bases().par_iter().enumerate().map(|(i, (_, field))| {
            let other = stored(field);
            self.of_base(i, field.bands, |point, out| trilinear(&other, point, out))
        });
        self.pool(&bases.collect::<Vec<_>>())
    }

    /// Of bases as a reader has them.
    pub(crate) fn of_coded(&self, plant: &Plant, coded: &SpeciesPayloads) -> Option<Error> {
        self.of_coded_at(plant, coded, |point| point)
    }

    /// The same where points lie elsewhere.
    pub(crate) fn of_coded_at(
        &self,
        plant: &Plant,
        coded: &SpeciesPayloads,
        place: impl Fn([f64; 3]) -> [f64; 3] + Sync,
    ) -> Option<Error> {
        let shared = shared(plant, coded);
        let bases = coded.bases.par_iter().enumerate().map(|(i, payloads)| {
            let base = read(&shared, payloads);
            self.of_base(i, payloads.head.bands, |point, out| base.sample(place(point), out))
        });
        Some(self.pool(&bases.collect::<Vec<_>>()))
    }
}

/// What the bases share.
pub(crate) fn shared(plant: &Plant, coded: &SpeciesPayloads) -> Arc<Shared> {
    let map = BlockMap::from_bytes(&coded.map, plant.lattice).expect("a sound map");
    let coding = match &coded.classes {
        Some(classes) => Coding::Classed(Classes::from_bytes(classes).expect("sound tables")),
        None => Coding::Haar,
    };
    Arc::new(Shared { map, coding })
}

/// A base, ready to be sampled.
pub(crate) fn read(shared: &Arc<Shared>, payloads: &BasePayloads) -> CodedBase {
    let mut bytes = payloads.head.to_bytes();
    bytes.extend(&payloads.averages);
    let mut base = CodedBase::from_bytes(shared, payloads.head.bands, &bytes).expect("a sound base");
    for page in &payloads.pages {
        base.add(page.first, page.count, &page.payload).expect("a sound page");
    }
    base
}

fn square(value: f64) -> f64 {
    value * value
}

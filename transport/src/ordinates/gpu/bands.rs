//! From the beams of many suns to the light that the plant scatters, in several bands: [`super::super::scatter`] with
//! marches on the GPU, band after band, as many suns side by side as fit.

use std::sync::{Mutex, PoisonError};

use flb_format::beam::Beam;
use flb_format::progress::{Cancelled, Progress};
use rayon::prelude::*;

use super::super::band::Band;
use super::super::error::OrdinatesError;
use super::super::lanes::LANES;
use super::super::moments::Moments;
use super::super::scatter::{Group, Lit, Part, Scattering, firsts_of, lane_of, lanes_of, sizes_of};
use super::device::Gpu;
use super::rays::Rays;
use super::relax::{End, relax};
use super::work::Work;
use crate::gpu::{GpuError, share::share};

/// Scattered light of all suns, and of the sky where that is wanted, in each band: see [`Scattering::scatter`]. GPUs
/// share the bands.
pub(in crate::ordinates) fn scatter(
    gpus: &[Gpu],
    scattering: &Scattering,
    bands: &[Band],
    progress: &Progress<'_>,
) -> Result<Vec<Lit>, OrdinatesError> {
    if scattering.march.escape.is_empty() {
        // Nothing to march through, and buffers without bytes cannot be bound.
        return Ok(scattering.scatter(bands, progress)?);
    }
    let groups = scattering.groups();
    let (done, all) = (Mutex::new(0), bands.len() * groups.len());
    let made = |groups: usize| {
        // Told in order: progress never falls.
        let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
        *done += groups;
        progress(*done as f64 / all as f64)
    };
    let begin = |gpu: &Gpu| -> Result<Rays, OrdinatesError> {
        Ok(Rays::upload(&gpu.opened, scattering.march, gpu.buffer_bytes)?)
    };
    share(gpus, bands.iter(), begin, |gpu, rays, band: &Band| {
        let scatter = Scatter { gpu, rays, scattering, groups: &groups, made: &made };
        match band.moments {
            1 => scatter.of_band::<1>(band),
            4 => scatter.of_band::<4>(band),
            _ => scatter.of_band::<9>(band),
        }
    })
}

/// What all bands on a GPU share.
struct Scatter<'a> {
    gpu: &'a Gpu,
    rays: &'a Rays,
    scattering: &'a Scattering<'a>,
    groups: &'a [Group<'a>],
    /// Called with the number of groups that were made.
    made: &'a dyn Fn(usize) -> Result<(), Cancelled>,
}

impl Scatter<'_> {
    fn of_band<const M: usize>(&self, band: &Band) -> Result<Lit, OrdinatesError> {
        let (smooth, sky) = (self.scattering.smooth(band), self.scattering.sky::<M>());
        let lanes = self.rays.lanes_that_fit(&self.gpu.opened, M, self.gpu.buffer_bytes)?;
        let sky_of = |group: &Group| sky.as_ref().filter(|_| group.sky);
        let mut part = Part::<M>::default();
        for groups in self.groups.chunks(lanes / LANES) {
            let work = self.work::<M>(band, groups.len() * LANES)?;
            let beams: Vec<&[&Beam]> = groups.iter().map(|group| group.beams).collect();
            let mut firsts: Vec<Moments<M>> =
                work.first_scattering(self.scattering.march, &band.matter, &beams)?;
            let parts: Vec<Part<M>> = match &smooth {
                Some(smooth) => {
                    for (group, first) in groups.iter().zip(&mut firsts) {
                        sky_of(group).iter().for_each(|sky| group.set_sky(first, sky));
                    }
                    let nexts = work.arrives(&firsts.iter().collect::<Vec<_>>())?;
                    let of_groups = groups.par_iter().zip(firsts).zip(nexts);
                    let begun = |((group, first), next): ((&Group, _), _)| {
                        self.scattering.begun(smooth, group, first, sky_of(group), |_| next)
                    };
                    of_groups.map(begun).collect()
                }
                None => {
                    for (group, first) in groups.iter().zip(&mut firsts) {
                        if let Some(sky) = sky_of(group) {
                            let once = work.arrives(&[&lanes_of(&[sky])])?;
                            group.set_sky(first, &lane_of(&once[0], 0));
                        }
                    }
                    let sizes = vec![[0.0; LANES]; groups.len()];
                    let of_groups = groups.iter().zip(&firsts);
                    let guesses: Vec<_> = of_groups.map(|(group, first)| group.start(band, first)).collect();
                    let starts =
                        guesses.iter().zip(&firsts).map(|(guess, first)| guess.as_ref().unwrap_or(first));
                    let (firsts, starts): (Vec<_>, Vec<_>) = firsts.iter().zip(starts).unzip();
                    let solved = relax(&work, &band.gains, &firsts, &starts, &sizes, self.end())?;
                    groups.iter().zip(solved).map(|(group, solved)| Part::solved(group, solved)).collect()
                }
            };
            parts.into_iter().for_each(|of_group| part.add(of_group));
            (self.made)(groups.len())?;
        }
        part.joined(smooth.as_ref(), |wanted| {
            let mut solved = Vec::new();
            for some in wanted.chunks(lanes) {
                let firsts: Vec<Moments<M>> = some.chunks(LANES).map(firsts_of).collect();
                let sizes: Vec<[f64; LANES]> = some.chunks(LANES).map(sizes_of).collect();
                let work = self.work::<M>(band, firsts.len() * LANES)?;
                let firsts: Vec<_> = firsts.iter().collect();
                solved.extend(relax(&work, &band.gains, &firsts, &firsts, &sizes, self.end())?);
            }
            Ok(solved)
        })
    }

    fn work<const M: usize>(&self, band: &Band, lanes: usize) -> Result<Work<'_>, GpuError> {
        Work::new(self.gpu, self.rays, &self.scattering.march.escape, &band.gains, M, lanes)
    }

    fn end(&self) -> End {
        let settings = self.scattering.settings;
        End { tolerance: settings.tolerance, most: settings.max_passes }
    }
}

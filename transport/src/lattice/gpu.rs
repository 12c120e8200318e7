//! The solver for machines that have a GPU: iteration over the non-empty sites, f32, all solves that fit at a time.
//!
//! The links are those of the sweep solver. An iteration computes what every site sends from what the sites sent in the
//! iteration before, so that all sites can go at once, in any order, to the same result; sweeps, in which a site sees
//! what others sent just now, need about half as many passes, but one site after the other. Echoes between neighbouring
//! wood sites are summed exactly (collide.wgsl).
//!
//! ```text
//! Sites + Optics -> buffers -(collide, measure) x 8-> residuals -...-settle-> rows -dense::write-> Field
//! ```

mod device;
mod layout;
mod relax;
mod stages;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod twin;

use flb_format::matter::Optics;
use flb_format::progress::Progress;
use flb_format::{Field, Medium};
use rayon::prelude::*;

use super::dense::{self, Output};
use super::error::SolveError;
use super::groups::Target;
use super::kernel::{LANES, Lanes};
use super::sites::{self, Sites};
use super::sweep::{self, LANES_WRITTEN, Meter};
use super::{BaseReport, Solution, SolveSettings, SolverKind, finish, solved_bases};
use crate::gpu::share::share;
use device::Gpu;
use relax::{Light, SharedBuffers};

/// All bases of all bands. Input as [`solve`](super::solve) has checked it. An iteration counts as a sweep.
pub(super) fn solve(
    medium: &Medium,
    optics: &Optics,
    settings: &SolveSettings,
    progress: &Progress<'_>,
) -> Result<Solution, SolveError> {
    let SolverKind::Gpu { most } = settings.solver else { unreachable!("asked for by that solver") };
    let gpus = device::open(most)?;
    let buffer_bytes = gpus.iter().map(|gpu| gpu.opened.largest_buffer_bytes()).min();
    solve_on(&gpus, buffer_bytes.unwrap_or(0), medium, optics, settings, progress)
}

/// The same with buffers of `buffer_bytes` at most.
fn solve_on(
    gpus: &[Gpu],
    buffer_bytes: u64,
    medium: &Medium,
    optics: &Optics,
    settings: &SolveSettings,
    progress: &Progress<'_>,
) -> Result<Solution, SolveError> {
    let bands = optics.bands.len() as u32;
    // One domain: cuts serve threads of a CPU.
    let sites = sites::find(medium, usize::MAX);
    let fit = relax::lanes_that_fit(&gpus[0], sites.count, buffer_bytes)?;
    let mut fields: Vec<(u8, Field)> =
        solved_bases(settings).iter().map(|base| (base, Field::zeros(medium.grid.lattice, bands))).collect();
    let mut targets = sweep::targets(&mut fields, medium.grid.sites());
    // One for each GPU at least, of a run of lanes at least.
    let groups = targets.len().div_ceil(fit).max(gpus.len().min(targets.len().div_ceil(LANES)));
    let meter = Meter::new(groups, settings.tolerance, progress);
    let per_group = targets.len().div_ceil(groups);
    let of_group = |gpu: &Gpu, matter: &SharedBuffers, (group, targets): (usize, &mut [Target<'_>])| {
        let tick = |residual: f64, iterations: u32| {
            meter.tick(group, residual, f64::from(iterations) / f64::from(settings.max_sweeps))
        };
        let lanes: Vec<(u8, u32)> = targets.iter().map(|target| (target.base, target.band)).collect();
        let (light, courses) = relax::relax(gpu, matter, &sites, optics, &lanes, settings, &tick)?;
        let outputs: Vec<&mut [f32]> = targets.iter_mut().map(|target| &mut *target.output).collect();
        write(&sites, &light, &lanes, outputs);
        let of_lane = lanes.iter().zip(courses);
        Ok(of_lane.map(|(&(base, band), course)| course.report(base, band, settings)).collect())
    };
    let begin = |gpu: &Gpu| -> Result<SharedBuffers, SolveError> { Ok(relax::upload(gpu, &sites)?) };
    let items = targets.chunks_mut(per_group).enumerate();
    let reports: Vec<Vec<BaseReport>> = share(gpus, items, begin, of_group)?;
    Ok(finish(medium, bands, settings, fields, reports.concat()))
}

/// The dense fields of a group.
fn write(sites: &Sites, light: &Light, lanes: &[(u8, u32)], outputs: Vec<&mut [f32]>) {
    let mut outputs: Vec<Output> = outputs
        .into_iter()
        .zip(lanes)
        .enumerate()
        .map(|(at, (phi, &(base, _)))| Output { lane: at % LANES, base: usize::from(base), phi })
        .collect();
    // A run of LANES lanes lies in one array.
    let runs = outputs.par_chunks_mut(LANES).zip(light);
    runs.for_each(|(outputs, rows)| {
        let rows: &[&[Lanes]] = if sites.count == 0 { &[] } else { &[rows] };
        outputs.par_chunks_mut(LANES_WRITTEN).for_each(|outputs| dense::write(sites, rows, outputs));
    });
}

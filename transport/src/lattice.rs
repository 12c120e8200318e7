//! Light transport on the lattice: medium and optics -> the 19 base fields of the `paper` model.
//!
//! The model is that of Steele (2009, sections 2.2 and 4.1; project lighting model, sections 1
//! to 6). Its steady state is a linear system; [`SolverKind`] lists the ways to reach it:
//!
//! * [`literal`] iterates the papers' update in f64 on the whole lattice. Slow and simple: the oracle.
//! * [`sweep`] works only on the sites that hold matter. Production.
//! * [`explicit`] iterates the same update in f32 on the whole lattice, as fast as memory allows: the second
//!   implementation.
//! * `gpu` iterates over the sites that hold matter on a GPU, with the feature of that name.
//!
//! ```text
//! Medium + Optics -check-> -collision-> 18x18 per class and band -solve-> Field x 19 + reports
//! ```

pub mod balance;
mod check;
pub mod collision;
mod course;
mod dense;
mod error;
pub mod explicit;
pub mod extremes;
#[cfg(feature = "gpu")]
mod gpu;
mod groups;
mod kernel;
pub mod literal;
pub mod media;
mod mixing;
pub mod reference;
mod sites;
pub mod sweep;

pub use error::SolveError;

pub use crate::gpu::GpuError;

use flb_format::bases::BaseSet;
use flb_format::direction::MOVING;
use flb_format::matter::Optics;
use flb_format::progress::Progress;
use flb_format::{Field, Medium};

/// Method by which the steady state is reached.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SolverKind {
    /// Gauss-Seidel sweeps over the non-empty sites, f32. Stops on its residual.
    #[default]
    Sweep,
    /// The papers' iteration over all sites, f32, on all cores; stops on its residual, which falls more slowly than
    /// that of sweeps. Bound by memory bandwidth; for comparing.
    Explicit,
    /// The papers' iteration over all sites, f64, for a fixed count (2 x the longest edge). It is
    /// not at its own limit by then: expect 1e-3 rms, several per cent at single sites, and
    /// much more at wood of small density (lighting model, section 4).
    Literal,
    /// Iteration over the non-empty sites on a GPU, f32; stops on its residual, which falls more slowly than that of
    /// sweeps. Its bytes may differ from one kind of GPU to another, within rounding. Needs the feature `gpu`.
    Gpu {
        /// Most GPUs of one kind that share the bases of a solve ([`find_gpus`](crate::gpu::find_gpus)); they change no
        /// bit of it.
        most: usize,
    },
}

impl SolverKind {
    /// The GPU that is ranked highest.
    pub const GPU: SolverKind = SolverKind::Gpu { most: 1 };

    /// Whether a GPU solves.
    pub fn is_gpu(self) -> bool {
        matches!(self, SolverKind::Gpu { .. })
    }
}

/// Number of iterations that a solve does, whatever its error is by then.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Steps {
    /// So many.
    Count(u32),
    /// So many for each site along an edge of the lattice.
    PerEdge(u32),
}

impl Steps {
    /// The papers': twice the longest edge of the lattice (P 5, D 6).
    pub const PAPERS: Steps = Steps::PerEdge(2);

    /// Iterations on a lattice.
    pub fn count(self, lattice: u32) -> u32 {
        match self {
            Steps::Count(count) => count,
            Steps::PerEdge(count) => count.saturating_mul(lattice),
        }
    }
}

/// Solver, bases, and the limits of error and work of a solve.
#[derive(Debug, Clone, PartialEq)]
pub struct SolveSettings {
    /// Solver to use.
    pub solver: SolverKind,
    /// Iterations of the explicit or the literal solver, after which a base counts as converged; `None`: the explicit
    /// solver goes on until the tolerance is met, and the literal one does [`Steps::PAPERS`].
    pub steps: Option<Steps>,
    /// The error at which a base has converged, as estimated: see [`BaseReport::error_estimate`].
    pub tolerance: f64,
    /// Sweeps after which a base is given up as not converged; it is given up sooner if at its pace of the last
    /// sweeps it would not converge within them. The literal solver ignores it.
    pub max_sweeps: u32,
    /// Bases to solve; not none.
    pub bases: BaseSet,
}

/// The default [`SolveSettings::tolerance`]; docs/measurements/paper-bake.md says what error it buys, and how to
/// measure it.
pub const DEFAULT_TOLERANCE: f64 = 1e-4;

/// The default [`SolveSettings::max_sweeps`].
pub const DEFAULT_MAX_SWEEPS: u32 = 300;

impl Default for SolveSettings {
    fn default() -> SolveSettings {
        SolveSettings {
            solver: SolverKind::default(),
            steps: None,
            tolerance: DEFAULT_TOLERANCE,
            max_sweeps: DEFAULT_MAX_SWEEPS,
            bases: BaseSet::ALL,
        }
    }
}

/// The 19 base fields and how each was reached.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// The bases asked for, ascending. Base j > 0 is lit by the boundary f_i = `[i = j]`; base 0 (ambient) by f_i = 1:
    /// it is the sum of the others where all of them are asked for, and else solved like them.
    pub bases: Vec<(u8, Field)>,
    /// Reports, one per base and band: bases in order, bands inside.
    pub reports: Vec<BaseReport>,
}

/// Result of the solve of one base in one band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BaseReport {
    /// Index of the base, 0..=18.
    pub base: u8,
    /// Index of the band in [`Optics::bands`].
    pub band: u32,
    /// Sweeps (or literal iterations) done. Base 0: the most of any other base.
    pub sweeps: u32,
    /// `||phi_k - phi_(k-1)||_2 / ||phi_k||_2` over the non-empty sites, k the last sweep: the residual
    /// of the fixed-point equation as the sweep sees it. 0 for an empty medium. Base 0: the largest
    /// of the others.
    pub residual: f64,
    /// Estimate of the true relative L2 error of phi over the non-empty sites: `residual / (1 - r)`, with r the worst
    /// rate (quotient of residuals, its root over two sweeps) among the last four. No bound: modes slower than r that
    /// are still hidden add to it. Rounding (about 3e-7) is not in it. Base 0: the largest of the others.
    pub error_estimate: f64,
    /// Whether `error_estimate` reached the tolerance.
    pub converged: bool,
}

/// Solves the bases that `settings` names in all bands of `optics`. `progress` is called with 0..=1, never falling,
/// from any thread. The result's bytes do not depend on the number of threads.
///
/// # Errors
/// A lattice that is no power of two in 16..=256, arrays of the wrong length, density that is not
/// finite or outside 0..=1, class `Empty` where density is above 0 or the reverse, matter in the outer two
/// layers, no bands or more than 64, optics outside the region where the operator is non-negative
/// (lighting model, section 4), a tolerance outside (0, 1), zero sweeps, zero steps or steps of a solver that counts
/// none, no bases; of the solver on the GPU,
/// [`GpuError`]; [`SolveError::Cancelled`].
pub fn solve(
    medium: &Medium,
    optics: &Optics,
    settings: &SolveSettings,
    progress: &Progress<'_>,
) -> Result<Solution, SolveError> {
    check::medium(medium)?;
    check::optics(optics)?;
    check::settings(settings)?;
    progress(0.0)?;
    let solution = match settings.solver {
        SolverKind::Sweep => sweep::solve(medium, optics, settings, sites::DOMAIN_SITES, progress)?,
        SolverKind::Explicit => explicit::solve(medium, optics, settings, progress)?,
        SolverKind::Literal => literal::solve(medium, optics, settings, progress)?,
        #[cfg(feature = "gpu")]
        SolverKind::Gpu { .. } => gpu::solve(medium, optics, settings, progress)?,
        #[cfg(not(feature = "gpu"))]
        SolverKind::Gpu { .. } => return Err(GpuError::NotBuilt.into()),
    };
    progress(1.0)?;
    Ok(solution)
}

/// Name of the GPU on which [`SolverKind::Gpu`] will solve.
///
/// # Errors
/// [`GpuError::NotBuilt`], [`GpuError::NoAdapter`].
pub fn find_gpu() -> Result<String, SolveError> {
    Ok(crate::gpu::find_gpu()?)
}

/// The bases that a solver must solve for: base 0 is the sum of the others where all of them are solved anyhow.
fn solved_bases(settings: &SolveSettings) -> BaseSet {
    if has_sum(settings) { BaseSet::ALL.intersection((1..=MOVING as u8).collect()) } else { settings.bases }
}

fn has_sum(settings: &SolveSettings) -> bool {
    settings.bases == BaseSet::ALL
}

/// What was solved, and base 0 if it is the sum of the others, in order.
fn finish(
    medium: &Medium,
    bands: u32,
    settings: &SolveSettings,
    mut bases: Vec<(u8, Field)>,
    mut reports: Vec<BaseReport>,
) -> Solution {
    if has_sum(settings) {
        bases.insert(0, (0, sum(medium, bands, &bases)));
        for band in 0..bands {
            let of_band = || reports.iter().filter(|r| r.band == band && r.base > 0);
            let report = BaseReport {
                base: 0,
                band,
                sweeps: of_band().map(|r| r.sweeps).max().unwrap_or(0),
                residual: of_band().map(|r| r.residual).fold(0.0, f64::max),
                error_estimate: of_band().map(|r| r.error_estimate).fold(0.0, f64::max),
                converged: of_band().all(|r| r.converged),
            };
            reports.push(report);
        }
    }
    reports.sort_by_key(|r| (r.base, r.band));
    Solution { bases, reports }
}

/// Sum of fields, in their order.
fn sum(medium: &Medium, bands: u32, fields: &[(u8, Field)]) -> Field {
    use rayon::prelude::*;
    let mut total = Field::zeros(medium.grid.lattice, bands);
    let part = medium.grid.sites() / medium.grid.lattice as usize;
    total.values_mut().par_chunks_mut(part).enumerate().for_each(|(at, values)| {
        for (_, field) in fields {
            for (sum, value) in values.iter_mut().zip(&field.values()[at * part..]) {
                *sum += value;
            }
        }
    });
    total
}

#[cfg(test)]
mod tests;

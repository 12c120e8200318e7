//! The solve stage of a bake: solved, or taken from the cache; and what is said of it.

use flb_baker::artefact::{self, BaseArtefact};
use flb_format::{Field, Medium, Optics};
use flb_transport::lattice::{BaseReport, solve};
use flb_transport::{SolveSettings, SolverKind};
use serde::Serialize;

use crate::cache::Cache;
use crate::exit::Failure;
use crate::print::say;
use crate::stages::Stages;

/// How the solves of one species ended. Numbers are the worst of all bases and bands, null where the fields came from the cache.
#[derive(Serialize, Debug, Clone)]
pub struct SolveSummary {
    pub species: String,
    /// sweep, explicit, literal, gpu.
    pub solver: &'static str,
    /// Whether an earlier bake solved it.
    pub cached: bool,
    /// Bases times bands.
    pub solves: usize,
    /// Solves whose estimated error reached the tolerance.
    pub converged: usize,
    /// Sweeps or iterations.
    pub sweeps: Option<u32>,
    /// Relative L2 change of phi in the last sweep.
    pub residual: Option<f64>,
    /// Estimated relative L2 error of phi over the non-empty sites.
    pub error_estimate: Option<f64>,
}

/// The name of a solver in files and reports.
pub fn solver_name(solver: SolverKind) -> &'static str {
    match solver {
        SolverKind::Sweep => "sweep",
        SolverKind::Explicit => "explicit",
        SolverKind::Literal => "literal",
        SolverKind::Gpu => "gpu",
    }
}

/// Solve, or what an earlier bake kept of it. Only converged fields are kept. The flag: whether all converged.
pub fn fields(
    name: &str,
    medium: &Medium,
    optics: &Optics,
    settings: &SolveSettings,
    (medium_digest, settings_text): (&[u8; 32], &str),
    cache: &Cache,
    stages: &mut Stages,
) -> Result<(Vec<(u8, Field)>, bool), Failure> {
    let key = |base: u8| artefact::key("field", &[medium_digest, &[base]], settings_text);
    let keys = settings.bases.iter().map(&key);
    let (bases, report) = stages.run("solve", name, |progress| -> Result<_, Failure> {
        if let Some(bases) = cache.read_all::<BaseArtefact>("field", keys, |_| Ok(())) {
            return Ok((bases, cached(name, settings, optics)));
        }
        let solution = solve(medium, optics, settings, progress)?;
        warn(name, &solution.reports, settings);
        if solution.reports.iter().all(|report| report.converged) {
            for base in &solution.bases {
                cache.keep("field", &key(base.0), base)?;
            }
        }
        Ok((solution.bases, summary(name, settings.solver, &solution.reports)))
    })?;
    let converged = report.converged == report.solves;
    stages.add_solve(report);
    Ok((bases, converged))
}

fn warn(name: &str, reports: &[BaseReport], settings: &SolveSettings) {
    let open: Vec<_> = reports.iter().filter(|report| !report.converged).collect();
    if let Some(worst) = open.iter().max_by(|a, b| a.error_estimate.total_cmp(&b.error_estimate)) {
        say!(
            "warning: {name}: {} of {} solves did not converge; the worst is base {} band {}: estimated error {:.1e} after {} sweeps, tolerance {:.1e}",
            open.len(),
            reports.len(),
            worst.base,
            worst.band,
            worst.error_estimate,
            worst.sweeps,
            settings.tolerance
        );
    }
}

fn summary(name: &str, solver: SolverKind, reports: &[BaseReport]) -> SolveSummary {
    let largest = |of: fn(&BaseReport) -> f64| reports.iter().map(of).fold(0.0, f64::max);
    SolveSummary {
        species: name.to_owned(),
        solver: solver_name(solver),
        cached: false,
        solves: reports.len(),
        converged: reports.iter().filter(|report| report.converged).count(),
        sweeps: reports.iter().map(|report| report.sweeps).max(),
        residual: Some(largest(|report| report.residual)),
        error_estimate: Some(largest(|report| report.error_estimate)),
    }
}

fn cached(name: &str, settings: &SolveSettings, optics: &Optics) -> SolveSummary {
    let solves = settings.bases.iter().count() * optics.bands.len();
    SolveSummary {
        species: name.to_owned(),
        solver: solver_name(settings.solver),
        cached: true,
        solves,
        converged: solves,
        sweeps: None,
        residual: None,
        error_estimate: None,
    }
}

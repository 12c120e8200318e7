//! A bake with the `paper` model.

use flb_format::bases::BaseSet;
use flb_format::light::SunBasis;
use flb_format::matter::Optics;
use flb_format::model::Model;
use flb_format::{Field, Medium, SpeciesFields, SpeciesMeta, provenance};
use flb_scene::Step;
use flb_transport::lattice::{BaseReport, SolveSettings, SolverKind, find_gpu, solve};
use serde_json::json;

use super::job::{Start, check_storable, describe, hold_medium};
use super::key::{Key, hex, of_lattice};
use super::observer::{Event, SolveSummary};
use super::store::{self, digest};
use super::{BakeError, BakeSettings, Baked, PaperSettings, Work};
use crate::artefact::BaseArtefact;
use crate::mean_light::set_means;

/// From a plant to its fields.
pub(super) fn bake(
    start: Start,
    settings: &BakeSettings,
    paper: &PaperSettings,
    work: &Work,
) -> Result<Baked, BakeError> {
    let Start { plant, voxels, shape } = start;
    let all = &plant.optics;
    let names: Vec<&str> = all.bands.iter().map(|band| band.name.as_str()).collect();
    let bands = names.len();
    let (kept, left_out) = settings.wanted.choose(&names, work.species)?;
    let optics = Optics { bands: kept.into_iter().map(|band| all.bands[band].clone()).collect() };
    let solve = paper.solve(settings.wanted.bases);
    let gpu = solve.solver.is_gpu().then(find_gpu).transpose()?;
    let mut meta = describe(&plant, &voxels, Model::Paper { optics: optics.clone() });
    record(&mut meta, &solve, settings.lattice);
    meta.leave_out(solve.bases.missing(), &left_out, &settings.wanted.reason);
    check_storable(&meta)?;
    let classed = plant.classed;
    let medium = hold_medium(work, &classed, &voxels, &shape)?;
    drop(classed);
    meta.grid = medium.grid;

    let Light { bases, converged, .. } = light(work, &medium, &optics, &solve, gpu.as_deref())?;
    meta.record(&provenance::CONVERGED, converged);
    let weighed = |(site, density): (u32, &f32)| (*density > 0.0).then_some((site, f64::from(*density)));
    let matter: Vec<_> = (0..).zip(&medium.density).filter_map(weighed).collect();
    set_means(&mut meta, &bases, &SunBasis::Lattice18, &matter, &[]);
    let solves =
        [paper_solves(solve.bases) * optics.bands.len() as u32, paper_solves(BaseSet::ALL) * bands as u32];
    let fields = SpeciesFields { meta, medium, turbid: None, bases };
    Ok(Baked { fields, converged, bands, solves, cloud: None })
}

/// Solves per band: one for each base, but that base 0 is the sum of the others where all of them are there.
pub fn paper_solves(bases: BaseSet) -> u32 {
    if bases == BaseSet::ALL { 18 } else { bases.len() as u32 }
}

/// The name of a solver in files and reports.
pub fn solver_name(solver: SolverKind) -> &'static str {
    match solver {
        SolverKind::Sweep => "sweep",
        SolverKind::Explicit => "explicit",
        SolverKind::Literal => "literal",
        SolverKind::Gpu { .. } => "gpu",
    }
}

/// Records how a medium on a lattice is solved.
pub(super) fn record(meta: &mut SpeciesMeta, solve: &SolveSettings, lattice: u32) {
    meta.record(&provenance::SOLVER, solver_name(solve.solver).to_owned());
    if let Some(steps) = solve.steps {
        meta.record(&provenance::STEPS, steps.count(lattice));
    }
    meta.record(&provenance::TOLERANCE, solve.tolerance);
    meta.record(&provenance::MAX_SWEEPS, solve.max_sweeps);
}

/// Solved fields of a medium.
pub(super) struct Light {
    /// Base and field.
    pub bases: Vec<(u8, Field)>,
    /// Whether all of them converged.
    pub converged: bool,
    /// Whether the store had them.
    pub cached: bool,
}

/// Solve, or what an earlier bake kept of it. Only converged fields are kept. `gpu` is the one that solves.
pub(super) fn light(
    work: &Work,
    medium: &Medium,
    optics: &Optics,
    settings: &SolveSettings,
    gpu: Option<&str>,
) -> Result<Light, BakeError> {
    let key = &Key::new("light")
        .with("medium", hex(digest(work.store, medium)?))
        .with("optics", json!(optics))
        .with_all(of_lattice(settings, medium.grid.lattice, gpu));
    let key_of = |base: u8| Key::new("field").with("light", key.digest().into()).with("item", base.into());
    let (bases, report) = work.run(Step::Solve, |progress| {
        let read = |base: u8| store::read::<BaseArtefact>(work.store, &key_of(base), |_| Ok(()));
        if let Some(bases) = settings.bases.iter().map(read).collect::<Option<Vec<_>>>() {
            work.hear(Event::Reused { step: Step::Solve, species: work.species.to_owned() });
            return Ok((bases, cached(work.species, settings, optics)));
        }
        store::tell_what_changed(work, Step::Solve, key);
        let solution = solve(medium, optics, settings, progress)?;
        tell_open(work, &solution.reports, settings);
        if solution.reports.iter().all(|report| report.converged) {
            for base in &solution.bases {
                store::keep(work.store, &key_of(base.0), base)?;
            }
            store::remember(work, key);
        }
        Ok((solution.bases, summary(work.species, settings.solver, &solution.reports)))
    })?;
    let (converged, cached) = (report.converged == report.solves, report.cached);
    work.hear(Event::Solved(report));
    Ok(Light { bases, converged, cached })
}

fn tell_open(work: &Work, reports: &[BaseReport], settings: &SolveSettings) {
    let open: Vec<_> = reports.iter().filter(|report| !report.converged).collect();
    if let Some(worst) = open.iter().max_by(|a, b| a.error_estimate.total_cmp(&b.error_estimate)) {
        let what = format!(
            "{} of {} solves did not converge; the worst is base {} band {}: estimated error {:.1e} after {} sweeps, tolerance {:.1e}",
            open.len(),
            reports.len(),
            worst.base,
            worst.band,
            worst.error_estimate,
            worst.sweeps,
            settings.tolerance
        );
        work.hear(Event::NotConverged { species: work.species.to_owned(), what });
    }
}

fn summary(species: &str, solver: SolverKind, reports: &[BaseReport]) -> SolveSummary {
    let largest = |of: fn(&BaseReport) -> f64| reports.iter().map(of).fold(0.0, f64::max);
    SolveSummary {
        species: species.to_owned(),
        solver: solver_name(solver),
        cached: false,
        solves: reports.len(),
        converged: reports.iter().filter(|report| report.converged).count(),
        sweeps: reports.iter().map(|report| report.sweeps).max(),
        residual: Some(largest(|report| report.residual)),
        error_estimate: Some(largest(|report| report.error_estimate)),
    }
}

fn cached(species: &str, settings: &SolveSettings, optics: &Optics) -> SolveSummary {
    let solves = settings.bases.iter().count() * optics.bands.len();
    SolveSummary {
        species: species.to_owned(),
        solver: solver_name(settings.solver),
        cached: true,
        solves,
        converged: solves,
        sweeps: None,
        residual: None,
        error_estimate: None,
    }
}

//! Solving the light of a turbid medium, or taking it from the store: of a species, and of a scene.

use flb_format::light::LightError;
use flb_format::matter::TurbidMedium;
use flb_scene::Step;
use flb_transport::gpu::find_gpu;
use flb_transport::ordinates::{
    self, Backend, BandReport, OrdinatesError, OrdinatesSettings, OrdinatesSolution, Surroundings,
};
use flb_transport::turbid::BandScatter;

use super::key::{Key, hex, of_bands, of_ordinates};
use super::observer::{Event, SolveSummary};
use super::store::{self, fits};
use super::{BakeError, Work};
use crate::artefact::{BaseArtefact, LightArtefact};

/// Medium and surroundings in which light is solved.
#[derive(Debug, Clone, Copy)]
pub struct LightSource<'a> {
    /// The medium.
    pub turbid: &'a TurbidMedium,
    /// Digest of all that the solve depends on, besides bands and settings: what tells one medium from another in the
    /// store.
    pub digest: [u8; 32],
    /// Surroundings of the medium; `None`: nothing, and the sky all around.
    pub surroundings: Option<Surroundings<'a>>,
}

/// The fields of a medium, solved or taken from the store, which is given only what converged; and whether they were
/// taken.
///
/// # Errors
/// As [`ordinates::solve_among`].
pub(super) fn solve(
    work: &Work,
    source: &LightSource,
    bands: &[BandScatter],
    settings: &OrdinatesSettings,
) -> Result<(OrdinatesSolution, bool), BakeError> {
    let kept = StoredSolution { work, key: key(source, bands, settings, gpu_of(settings)?) };
    let (solution, cached) = work.run(Step::Solve, |progress| {
        if let Some(solution) = kept.read(source.turbid, bands.len(), settings) {
            work.hear(Event::Reused { step: Step::Solve, species: work.species.to_owned() });
            return Ok((solution, true));
        }
        store::tell_what_changed(work, Step::Solve, &kept.key);
        let surroundings = source.surroundings.unwrap_or(Surroundings::NONE);
        let solution = ordinates::solve_among(source.turbid, bands, &surroundings, settings, progress)?;
        tell_open(work, &solution.reports, settings);
        if converged(&solution) {
            kept.keep(&solution)?;
        }
        Ok((solution, false))
    })?;
    work.hear(Event::Solved(summary(work.species, &solution.reports, settings, cached)));
    Ok((solution, cached))
}

/// Whether every band met its tolerance.
pub fn converged(solution: &OrdinatesSolution) -> bool {
    solution.reports.iter().all(|report| report.converged)
}

/// Computes the error of a light as far as it is known, without Monte Carlo.
pub fn error_of(solution: &OrdinatesSolution) -> LightError {
    let worst = |of: &dyn Fn(&BandReport) -> f64| solution.reports.iter().map(of).fold(0.0, f64::max);
    LightError {
        suns_rms: worst(&|report| report.suns_rms.unwrap_or(0.0)),
        held_out: solution.held_out,
        solver: worst(&|report| report.error_estimate),
        monte_carlo: None,
    }
}

/// Name of the GPU that solves, where one does.
///
/// # Errors
/// No GPU.
pub(super) fn gpu_of(settings: &OrdinatesSettings) -> Result<Option<String>, BakeError> {
    let gpu = settings.backend.is_gpu().then(find_gpu).transpose();
    Ok(gpu.map_err(OrdinatesError::Gpu)?)
}

/// The name of the solver in files and reports.
pub(super) fn solver_name(settings: &OrdinatesSettings) -> &'static str {
    match settings.backend {
        Backend::Cpu => "ordinates",
        Backend::Gpu { .. } => "ordinates-gpu",
    }
}

/// Light of another GPU may differ in its last digits: its name is a part of the key. Light of the CPU has no such
/// part.
fn key(
    source: &LightSource,
    bands: &[BandScatter],
    settings: &OrdinatesSettings,
    gpu: Option<String>,
) -> Key {
    Key::new("light")
        .with("medium", hex(source.digest))
        .with("surfaces", of_bands(bands))
        .with_all(of_ordinates(settings))
        .with_all(gpu.map(|name| ("gpu", name.into())))
}

/// Where the store has the light of a medium.
struct StoredSolution<'a> {
    work: &'a Work<'a>,
    key: Key,
}

impl StoredSolution<'_> {
    fn field_key(&self, item: u8) -> Key {
        Key::new("field").with("light", self.key.digest().into()).with("item", item.into())
    }

    fn read(
        &self,
        medium: &TurbidMedium,
        bands: usize,
        settings: &OrdinatesSettings,
    ) -> Option<OrdinatesSolution> {
        let items = settings.items();
        let sites = medium.sites().len();
        let check = |light: &LightArtefact| {
            fits("bands", &light.reports.len(), &bands)?;
            let of_sites =
                light.total.values.iter().chain(&light.total.near).flatten().chain(&light.total.beyond);
            let count = of_sites.map(Vec::len).find(|count| *count != sites);
            fits("sites", &count.unwrap_or(sites), &sites)
        };
        let check_field = |(_, field): &BaseArtefact| {
            fits("lattice", &field.lattice, &medium.grid.lattice)?;
            fits("bands", &(field.bands as usize), &bands)
        };
        let store = self.work.store;
        let LightArtefact { reports, held_out, total } = store::read(store, &self.key, check)?;
        let fields = items.iter().map(|&item| store::read(store, &self.field_key(item), check_field));
        let fields: Vec<BaseArtefact> = fields.collect::<Option<_>>()?;
        let found: Vec<u8> = fields.iter().map(|(item, _)| *item).collect();
        (found == items).then_some(OrdinatesSolution { fields, reports, held_out, total })
    }

    fn keep(&self, solution: &OrdinatesSolution) -> Result<(), BakeError> {
        for base in &solution.fields {
            store::keep(self.work.store, &self.field_key(base.0), base)?;
        }
        let light = LightArtefact {
            reports: solution.reports.clone(),
            held_out: solution.held_out,
            total: solution.total.clone(),
        };
        store::keep(self.work.store, &self.key, &light)?;
        store::remember(self.work, &self.key);
        Ok(())
    }
}

fn tell_open(work: &Work, reports: &[BandReport], settings: &OrdinatesSettings) {
    let open: Vec<&BandReport> = reports.iter().filter(|report| !report.converged).collect();
    if let Some(worst) = open.iter().max_by(|a, b| a.error_estimate.total_cmp(&b.error_estimate)) {
        let what = format!(
            "the light of {} of {} bands did not converge; the worst is band {}: estimated error {:.1e} after {} passes, tolerance {:.1e}",
            open.len(),
            reports.len(),
            worst.band,
            worst.error_estimate,
            worst.passes,
            settings.tolerance
        );
        work.hear(Event::NotConverged { species: work.species.to_owned(), what });
    }
}

fn summary(
    species: &str,
    reports: &[BandReport],
    settings: &OrdinatesSettings,
    cached: bool,
) -> SolveSummary {
    let solves = |of: &dyn Fn(&&BandReport) -> bool| -> usize {
        reports.iter().filter(of).map(|report| report.solves as usize).sum()
    };
    let passes = reports.iter().map(|report| report.passes).max();
    let error = reports.iter().map(|report| report.error_estimate).fold(0.0, f64::max);
    SolveSummary {
        species: species.to_owned(),
        solver: solver_name(settings),
        cached,
        solves: solves(&|_| true),
        converged: solves(&|report| report.converged),
        sweeps: passes.filter(|_| !cached),
        residual: None,
        error_estimate: (!cached).then_some(error),
    }
}

//! A bake with the `physical` model.

use std::path::Path;

use flb_baker::crown::{Crown, CrownSettings, measure_crown};
use flb_baker::{artefact, artefact::BaseArtefact, artefact::LightArtefact};
use flb_format::{BaseSet, Light, LightError, Medium, Model, Surfaces};
use flb_packer::SpeciesFields;
use flb_packer::leave_out::record;
use flb_scene::leaf::knapp_carter;
use flb_transport::ordinates::{self, BandReport, OrdinatesSettings, OrdinatesSolution, Suns, Surroundings};
use flb_transport::turbid::{BandScatter, Turbid, scatter};
use serde_json::json;

use super::checks::check_storable;
use super::job::{Baked, Job, Start, medium, shape};
use super::judge::judge;
use crate::cache::Cache;
use crate::classes::ClassedMesh;
use crate::exit::{Failure, INPUT_OUTPUT};
use crate::physical::Physical;
use crate::print::say;
use crate::saving::{base_list, why_whole};
use crate::solving::SolveSummary;
use crate::stages::Stages;

/// Import to solve for one mesh.
pub fn bake(path: &Path, job: &Job, physical: &Physical, stages: &mut Stages) -> Result<Baked, Failure> {
    let at_mesh = |failure: Failure| failure.at(path);
    let (name, share) = job.planned(path)?;
    let all = job.reader.species.as_ref().and_then(|s| s.surfaces.clone()).unwrap_or_else(knapp_carter);
    let names: Vec<&str> = all.bands.iter().map(|band| band.name.as_str()).collect();
    let (kept, bands_left_out) = job.bands(&names, &name).map_err(|error| at_mesh(error.into()))?;
    let surfaces = Surfaces { bands: kept.into_iter().map(|band| all.bands[band].clone()).collect() };
    let wanted = share.map_or(BaseSet::ALL, |share| share.bases);
    let solve = physical.solve(job.lattice(share));
    let settings = OrdinatesSettings { bases: bases_of(&name, &solve.suns, wanted), ..solve };
    let model = Model::Physical { surfaces: surfaces.clone(), light: Physical::light(&settings) };
    let Start { classed, mut meta, voxels } = job.start(path, name, share, model, stages)?;
    meta.settings.insert("solve.tolerance".to_owned(), json!(settings.tolerance));
    meta.settings.insert("solve.max_sweeps".to_owned(), json!(settings.max_passes));
    meta.settings.insert("solve.parts".to_owned(), json!(settings.parts));
    if let Some(plan) = job.plan {
        record(&mut meta, settings.bases.missing(), &bands_left_out, &plan.reason);
    }
    check_storable(&meta).map_err(at_mesh)?;
    let shape = shape(&meta);
    let medium = medium(&classed, &voxels, &shape, job.cache, stages).map_err(at_mesh)?;
    meta.grid = medium.grid;

    let crown_settings = CrownSettings { ignore_alpha: voxels.ignore_alpha, angles: physical.angles };
    let crown =
        crown(&meta.name, &classed, &medium, &crown_settings, &shape, job.cache, stages).map_err(at_mesh)?;
    drop(classed);
    let scatter: Vec<BandScatter> = surfaces.bands.iter().map(scatter).collect();
    let source = Source { turbid: &crown.turbid, digest: job.cache.digest(&crown)?, surroundings: None };
    let (solution, _) =
        light(&meta.name, &source, &scatter, &settings, job.cache, stages).map_err(at_mesh)?;
    let suns = job.args.model.monte_carlo.into();
    let monte_carlo =
        judge((&meta.name, suns), &crown.turbid, &scatter, &solution, &settings, stages).map_err(at_mesh)?;
    let reports = &solution.reports;
    let error = LightError { monte_carlo, ..error_of(&solution) };
    let converged = reports.iter().all(|report| report.converged);
    let light = Light { leaf_angles: crown.turbid.angles.clone(), error, ..Physical::light(&settings) };
    meta.model = Model::Physical { surfaces, light };
    meta.settings.insert("crown.factor".to_owned(), json!(crown.factor));
    meta.settings.insert("crown.gap".to_owned(), json!(crown.gap));
    meta.settings.insert("solve.converged".to_owned(), json!(converged));
    let whole = OrdinatesSettings { bases: BaseSet::ALL, ..settings.clone() };
    let solves = [settings.solves() * reports.len() as u32, whole.solves() * all.bands.len() as u32];
    let fields = SpeciesFields { meta, medium, turbid: Some(crown.turbid), bases: solution.fields };
    Ok(Baked { fields, converged, bands: all.bands.len(), solves })
}

/// How far off light is known to be; without Monte Carlo.
pub fn error_of(solution: &OrdinatesSolution) -> LightError {
    let worst = |of: &dyn Fn(&BandReport) -> f64| solution.reports.iter().map(of).fold(0.0, f64::max);
    LightError {
        suns_rms: worst(&|report| report.suns_rms.unwrap_or(0.0)),
        held_out: solution.held_out,
        solver: worst(&|report| report.error_estimate),
        monte_carlo: None,
    }
}

/// The bases to solve, of those that a plan wants. Says where a plan can leave out none.
fn bases_of(name: &str, suns: &Suns, wanted: BaseSet) -> BaseSet {
    if *suns == Suns::Lattice18 || wanted == BaseSet::ALL {
        return wanted;
    }
    say!(
        "{name}: {}, so all are baked; with --suns lattice18 this plan would leave out bases {}",
        why_whole(suns),
        base_list(wanted.missing())
    );
    BaseSet::ALL
}

/// The extinction, measured or taken from the cache.
fn crown(
    name: &str,
    classed: &ClassedMesh,
    medium: &Medium,
    settings: &CrownSettings,
    shape: &[Vec<u8>; 2],
    cache: &Cache,
    stages: &mut Stages,
) -> Result<Crown, Failure> {
    let digest = cache.digest(medium)?;
    let inputs = [digest.as_slice(), shape[0].as_slice(), &shape[1]];
    let key = artefact::key("crown", &inputs, &format!("{settings:?}"));
    stages.run("crown", name, |progress| {
        let make = || Ok(measure_crown(&classed.mesh, &classed.classes, medium, settings, progress)?);
        let check = |crown: &Crown| fits("grid", &crown.turbid.grid, &medium.grid);
        cache.reuse_or_make("crown", &key, check, make)
    })
}

/// What light is solved in.
pub struct Source<'a> {
    pub turbid: &'a Turbid,
    /// Of all that the solve depends on, besides bands and settings.
    pub digest: [u8; 32],
    pub surroundings: Option<Surroundings<'a>>,
}

/// The fields, solved or taken from the cache, which keeps only what converged; and whether they were taken.
pub fn light(
    name: &str,
    source: &Source,
    bands: &[BandScatter],
    settings: &OrdinatesSettings,
    cache: &Cache,
    stages: &mut Stages,
) -> Result<(OrdinatesSolution, bool), Failure> {
    let kept = Kept { cache, crown: source.digest, settings: format!("{bands:?} {settings:?}") };
    let (solution, cached) = stages.run("solve", name, |progress| -> Result<_, Failure> {
        if let Some(solution) = kept.read(source.turbid, bands.len(), settings) {
            return Ok((solution, true));
        }
        let surroundings = source.surroundings.unwrap_or(Surroundings::NONE);
        let solution = ordinates::solve_among(source.turbid, bands, &surroundings, settings, progress)?;
        warn(name, &solution.reports, settings);
        if solution.reports.iter().all(|report| report.converged) {
            kept.keep(&solution)?;
        }
        Ok((solution, false))
    })?;
    stages.add_solve(summary(name, &solution.reports, cached));
    Ok((solution, cached))
}

/// Where the cache has the light of a crown with certain surfaces and settings.
struct Kept<'a> {
    cache: &'a Cache,
    crown: [u8; 32],
    settings: String,
}

impl Kept<'_> {
    fn key(&self, item: Option<u8>) -> String {
        let item: Vec<u8> = item.into_iter().collect();
        artefact::key("light", &[&self.crown, &item], &self.settings)
    }

    fn read(&self, medium: &Turbid, bands: usize, settings: &OrdinatesSettings) -> Option<OrdinatesSolution> {
        let items = settings.items();
        let reports = |light: &LightArtefact| fits("bands", &light.reports.len(), &bands);
        let field = |(_, field): &BaseArtefact| {
            fits("lattice", &field.lattice, &medium.grid.lattice)?;
            fits("bands", &(field.bands as usize), &bands)
        };
        let LightArtefact { reports, held_out } = self.cache.read("light", &self.key(None), reports)?;
        let keys = items.iter().map(|&item| self.key(Some(item)));
        let fields: Vec<BaseArtefact> = self.cache.read_all("field", keys, field)?;
        let found: Vec<u8> = fields.iter().map(|(item, _)| *item).collect();
        (found == items).then_some(OrdinatesSolution { fields, reports, held_out })
    }

    fn keep(&self, solution: &OrdinatesSolution) -> Result<(), Failure> {
        for base in &solution.fields {
            self.cache.keep("field", &self.key(Some(base.0)), base)?;
        }
        let light = LightArtefact { reports: solution.reports.clone(), held_out: solution.held_out };
        self.cache.keep("light", &self.key(None), &light)
    }
}

/// Refuses an artefact of something else.
fn fits<T: PartialEq + std::fmt::Debug>(what: &str, found: &T, expected: &T) -> Result<(), Failure> {
    if found == expected {
        return Ok(());
    }
    Err(Failure::new(INPUT_OUTPUT, format!("artefact of {what} {found:?}, expected {expected:?}")))
}

fn warn(name: &str, reports: &[BandReport], settings: &OrdinatesSettings) {
    let open: Vec<&BandReport> = reports.iter().filter(|report| !report.converged).collect();
    if let Some(worst) = open.iter().max_by(|a, b| a.error_estimate.total_cmp(&b.error_estimate)) {
        say!(
            "warning: {name}: the light of {} of {} bands did not converge; the worst is band {}: estimated error {:.1e} after {} passes, tolerance {:.1e}",
            open.len(),
            reports.len(),
            worst.band,
            worst.error_estimate,
            worst.passes,
            settings.tolerance
        );
    }
}

fn summary(name: &str, reports: &[BandReport], cached: bool) -> SolveSummary {
    let solves = |of: &dyn Fn(&&BandReport) -> bool| -> usize {
        reports.iter().filter(of).map(|report| report.solves as usize).sum()
    };
    let passes = reports.iter().map(|report| report.passes).max();
    let error = reports.iter().map(|report| report.error_estimate).fold(0.0, f64::max);
    SolveSummary {
        species: name.to_owned(),
        solver: "ordinates",
        cached,
        solves: solves(&|_| true),
        converged: solves(&|report| report.converged),
        sweeps: passes.filter(|_| !cached),
        residual: None,
        error_estimate: (!cached).then_some(error),
    }
}

//! A bake with the `paper` model.

use std::path::Path;

use flb_format::{BaseSet, Model, Optics};
use flb_packer::SpeciesFields;
use flb_packer::leave_out::record;
use flb_transport::{SolveSettings, SolverKind};
use serde_json::json;

use super::checks::check_storable;
use super::job::{Baked, Job, Start, medium, shape};
use crate::args::SolverArg;
use crate::exit::Failure;
use crate::saving::solves;
use crate::solving::{fields, solver_name};
use crate::stages::Stages;

/// Import to solve for one mesh; on the GPU of this name, if any.
pub fn bake(path: &Path, job: &Job, gpu: Option<&str>, stages: &mut Stages) -> Result<Baked, Failure> {
    let at_mesh = |failure: Failure| failure.at(path);
    let args = job.args;
    let (name, share) = job.planned(path)?;
    let all = job.reader.species.as_ref().and_then(|s| s.optics.clone()).unwrap_or_else(Optics::paper);
    let names: Vec<&str> = all.bands.iter().map(|band| band.name.as_str()).collect();
    let (kept, bands_left_out) = job.bands(&names, &name).map_err(|error| at_mesh(error.into()))?;
    let optics = Optics { bands: kept.into_iter().map(|band| all.bands[band].clone()).collect() };
    let settings = SolveSettings {
        solver: match args.solver {
            SolverArg::Auto if gpu.is_some() => SolverKind::Gpu,
            SolverArg::Auto | SolverArg::Sweep => SolverKind::Sweep,
            SolverArg::Explicit => SolverKind::Explicit,
            SolverArg::Literal => SolverKind::Literal,
        },
        tolerance: args.tolerance.unwrap_or(args.preset().paper_tolerance),
        max_sweeps: args.max_sweeps,
        bases: share.map_or(BaseSet::ALL, |share| share.bases),
    };
    let model = Model::Paper { optics: optics.clone() };
    let Start { classed, mut meta, voxels } = job.start(path, name, share, model, stages)?;
    meta.settings.insert("solve.solver".to_owned(), json!(solver_name(settings.solver)));
    meta.settings.insert("solve.tolerance".to_owned(), json!(settings.tolerance));
    meta.settings.insert("solve.max_sweeps".to_owned(), json!(settings.max_sweeps));
    if let Some(plan) = job.plan {
        record(&mut meta, settings.bases.missing(), &bands_left_out, &plan.reason);
    }
    check_storable(&meta).map_err(at_mesh)?;
    let medium = medium(&classed, &voxels, &shape(&meta), job.cache, stages).map_err(at_mesh)?;
    drop(classed);
    meta.grid = medium.grid;

    let digest = job.cache.digest(&medium)?;
    let text = json!([
        optics,
        meta.settings["solve.solver"],
        settings.tolerance,
        args.max_sweeps,
        gpu,
        settings.bases
    ])
    .to_string();
    let key = (&digest, text.as_str());
    let (bases, converged) =
        fields(&meta.name, &medium, &optics, &settings, key, job.cache, stages).map_err(at_mesh)?;
    meta.settings.insert("solve.converged".to_owned(), json!(converged));
    let solves =
        [solves(settings.bases) * optics.bands.len() as u32, solves(BaseSet::ALL) * all.bands.len() as u32];
    Ok(Baked {
        fields: SpeciesFields { meta, medium, turbid: None, bases },
        converged,
        bands: all.bands.len(),
        solves,
    })
}

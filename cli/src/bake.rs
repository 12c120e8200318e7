//! `flb bake`: from mesh files to one published library.

pub mod checks;
pub mod job;
mod judge;
pub mod paper;
pub mod physical;

use flb_baker::plan::Plan;
use flb_format::Codec;
use flb_packer::{EncodeSettings, encode_species, write_library};
use flb_transport::lattice::find_gpu;
use serde::Serialize;

use crate::args::{BackendArg, BakeArgs};
use crate::cache::Cache;
use crate::classes::MeshReader;
use crate::exit::{Failure, LOSS};
use crate::physical::Physical;
use crate::print::{self, line, say};
use crate::saving::{Saving, saving_lines};
use crate::stages::{Stage, Stages};
use crate::summary::{SpeciesSummary, misses_its_error, sites_nonempty, species_table, stage_table};
use checks::{check_names, check_plan, check_settings, say_other_model};
use job::Job;

/// The summary of a bake; `--json` prints it (cli/schema/bake.json).
#[derive(Serialize)]
struct Summary {
    output: String,
    bytes: u64,
    /// Whether every solve reached its tolerance.
    converged: bool,
    stages: Vec<Stage>,
    species: Vec<SpeciesSummary>,
}

/// Checks, bakes every mesh, writes the library (and the fields, if they are kept), prints the summary.
pub fn run(args: &BakeArgs) -> Result<u8, Failure> {
    check_settings(args)?;
    let settings = &args.coding.settings(args.quality)?;
    let physical = Physical::of(args)?;
    let mut reader = MeshReader::new(&args.mesh)?;
    let names = check_names(args, &reader)?;
    let plan = args.plan.as_deref().map(Plan::read).transpose()?;
    check_plan(args, plan.as_ref(), &names)?;
    if args.meshes.len() > 1 {
        reader.rehearse(&args.meshes)?;
    }
    let gpu = match args.backend {
        BackendArg::Cpu => None,
        BackendArg::Gpu => Some(find_gpu()?),
    };
    if let Some(name) = &gpu {
        say!("solving on {name}");
    }
    let cache = Cache::open(args.cache.as_deref());
    say_other_model(args, &reader);
    let job = Job { args, reader: &reader, plan: plan.as_ref(), cache: &cache };
    let mut stages = Stages::default();
    let mut coded = Vec::new();
    let mut kept = Vec::new();
    let mut summaries = Vec::new();
    let mut converged = true;
    for path in &args.meshes {
        let baked = match &physical {
            Some(physical) => physical::bake(path, &job, physical, &mut stages)?,
            None => paper::bake(path, &job, gpu.as_deref(), &mut stages)?,
        };
        converged &= baked.converged;
        let name = baked.fields.meta.name.clone();
        let species =
            stages.run("encode", &name, |progress| encode_species(&baked.fields, settings, progress))?;
        let saving = plan.is_some().then(|| Saving::of_bake(&species, baked.bands, baked.solves));
        summaries.push(SpeciesSummary::new(&species, sites_nonempty(&baked.fields.medium), saving));
        coded.push(species);
        if args.keep_fields.is_some() {
            let compress = args.coding.compress == Some(true);
            let raw = EncodeSettings { codec: Codec::RawF32, threshold: 0.0, compress, ..settings.clone() };
            kept.push(stages.run("encode", &name, |progress| encode_species(&baked.fields, &raw, progress))?);
        }
    }
    let bytes = stages.run("write", &args.output.display().to_string(), |_| -> Result<u64, Failure> {
        if let Some(fields) = &args.keep_fields {
            write_library(fields, &kept.iter().collect::<Vec<_>>(), args.force)?;
        }
        Ok(write_library(&args.output, &coded.iter().collect::<Vec<_>>(), args.force)?)
    })?;
    let summary = Summary {
        output: args.output.display().to_string(),
        bytes,
        converged,
        stages: stages.list().to_vec(),
        species: summaries,
    };
    match args.json {
        true => print::json(&summary)?,
        false => print::out(&format!(
            "{}\n{}{}\n{}",
            stage_table(&summary.stages),
            species_table(&summary.species),
            saving_lines(&summary.species),
            line!("{}: {}", summary.output, print::bytes(summary.bytes))
        ))?,
    }
    summary.species.iter().for_each(SpeciesSummary::say_missed);
    let missed = args.coding.asks_for_error() && coded.iter().any(misses_its_error);
    Ok(if converged && !missed { 0 } else { LOSS })
}

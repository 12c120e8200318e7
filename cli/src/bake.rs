//! `flb bake`: from mesh files to one published library.

pub(crate) mod checks;
pub(crate) mod model;
pub(crate) mod settings;

use std::path::Path;

use flb_baker::bake::{BakeSettings, Baked, bake};
use flb_baker::plan::Plan;
use flb_eval::{JudgeSettings, judge_coded};
use flb_farm::cache::Cache;
use flb_files::check_unread;
use flb_format::Codec;
use flb_packer::{EncodeSettings, encode_species, write_library};
use flb_scene::color::words;
use flb_scene::{ClassedMesh, Step};
use serde::Serialize;

use crate::args::BakeArgs;
use crate::classes::MeshReader;
use crate::colors::{self, ColorRow};
use crate::exit::{Failure, LOSS};
use crate::print::{self, line, say};
use crate::saving::PlanSavings;
use crate::size::{Areas, Measured};
use crate::stages::{Stage, Stages};
use crate::summary::{SpeciesSummary, misses_its_error, saving_lines, species_table, stage_table};
use checks::{check_judge, check_names, check_settings};
use model::{say_device, say_other_end, say_other_model};
use settings::settings_of;

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
pub(crate) fn run(args: &BakeArgs) -> Result<u8, Failure> {
    check_settings(args)?;
    let recipe = model::recipe(args);
    let coding = &recipe.encode_settings()?;
    recipe.model_settings(model::machine(args))?;
    let mut reader = MeshReader::new(&args.mesh)?;
    check_judge(args, &reader)?;
    let names = check_names(args, &reader)?;
    let plan = args.plan.as_deref().map(Plan::read).transpose()?;
    let settings = settings_of(args, plan.as_ref(), &names)?;
    if args.meshes.len() > 1 {
        reader.rehearse(&args.meshes)?;
        if args.strict {
            // All meshes before the long work on the first; what is said of them is said here.
            for path in &args.meshes {
                measure(path, &reader.read_classed(path)?, args, &reader)?;
            }
            reader.quiet = true;
        }
    }
    say_device(args)?;
    say_other_end(args);
    let tell = |told: &str| say!("{told}");
    let cache = Cache::open(args.cache.as_ref(), &tell)?;
    say_other_model(args, &reader);
    let stages = Stages::default();
    let mut coded = Vec::new();
    let mut kept = Vec::new();
    let mut summaries = Vec::new();
    let mut converged = true;
    for ((path, name), settings) in args.meshes.iter().zip(&names).zip(&settings) {
        let One { baked, measured, areas, colours, mesh } =
            bake_one((path, name), args, settings, &reader, &cache, &stages)?;
        converged &= baked.converged;
        let mut species =
            stages.run(Step::Encode, name, |progress| encode_species(&baked.fields, coding, progress))?;
        if let Some(mesh) = mesh {
            let error = judge_coded(&mut species, mesh, coding, JudgeSettings::default(), &stages)
                .map_err(|error| Failure::from(error).at(path))?;
            say!("{name}: on the mesh: {}", print::mesh_error(&error));
        }
        let saving = plan.is_some().then(|| PlanSavings::of_bake(&species, baked.bands, baked.solves));
        let summary = SpeciesSummary::new(&species, baked.fields.medium.nonempty_sites(), saving);
        summaries.push(SpeciesSummary {
            areas: Some(areas),
            doubts: Some(measured.doubts),
            colours: Some(colours),
            ..summary
        });
        coded.push(species);
        if args.keep_fields.is_some() {
            let compress = args.coding.compress == Some(true);
            let raw = EncodeSettings { codec: Codec::RawF32, threshold: 0.0, compress, ..coding.clone() };
            kept.push(
                stages.run(Step::Encode, name, |progress| encode_species(&baked.fields, &raw, progress))?,
            );
        }
    }
    let bytes = stages.run(Step::Write, &args.output.display().to_string(), |_| -> Result<u64, Failure> {
        if let Some(fields) = &args.keep_fields {
            write_library(fields, &kept.iter().collect::<Vec<_>>(), args.existing)?;
        }
        Ok(write_library(&args.output, &coded.iter().collect::<Vec<_>>(), args.existing)?)
    })?;
    let summary = Summary {
        output: args.output.display().to_string(),
        bytes,
        converged,
        stages: stages.list(),
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
    let missed = recipe.asks_for_error() && coded.iter().any(misses_its_error);
    Ok(if converged && !missed { 0 } else { LOSS })
}

/// A baked mesh.
struct One {
    baked: Baked,
    measured: Measured,
    areas: Areas,
    colours: Vec<ColorRow>,
    /// If its light is to be judged.
    mesh: Option<ClassedMesh>,
}

/// Imports and bakes one mesh, and says how large it is before the long work.
fn bake_one(
    (path, name): (&Path, &str),
    args: &BakeArgs,
    settings: &BakeSettings,
    reader: &MeshReader,
    cache: &Cache,
    stages: &Stages,
) -> Result<One, Failure> {
    let classed = stages.run(Step::Import, name, |_| reader.read_classed(path))?;
    // Textures, buffers and material libraries are known by now.
    check_unread(&args.output)?;
    args.keep_fields.as_deref().map_or(Ok(()), check_unread)?;
    let measured = measure(path, &classed, args, reader)?;
    say!("{}: the plant is {} (x, y up, z)", path.display(), measured.text());
    let areas = Areas::of(&classed);
    let mesh = args.judge.then(|| classed.clone());
    let plant = reader.plants.plant(name.to_owned(), classed);
    let colours = colors::of_plant(&plant);
    if model::recipe(args).follows_colors() {
        colors::say_colors(path, &plant);
        if args.strict {
            measured.strict(&words::warnings(&plant), path)?;
        }
    }
    let baked = bake(plant, settings, cache, stages).map_err(|error| Failure::from(error).at(path))?;
    let areas = areas.left(&baked.fields.medium);
    areas.say(path);
    Ok(One { baked, measured, areas, colours, mesh })
}

/// How large a mesh is and what is doubted of it, which `--strict` refuses.
fn measure(
    path: &Path,
    classed: &ClassedMesh,
    args: &BakeArgs,
    reader: &MeshReader,
) -> Result<Measured, Failure> {
    let measured = reader.measure(path, classed);
    if args.strict {
        measured.strict(&classed.mesh.warnings, path)?;
    }
    Ok(measured)
}

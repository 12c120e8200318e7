//! `flb library`: species of a manifest, baked as far as they changed.

mod diff;
mod report;
mod shown;

use std::path::Path;

use flb_farm::build::{BuildSettings, OnFailure, build, no_species};
use flb_farm::cache::{Cache, Place, Traffic};
use flb_farm::digests::Trust;
use flb_farm::init::{self, survey};
use flb_farm::manifest::OUTPUT;
use flb_farm::outcome::{Outcome, Summary};
use flb_farm::output::Output;
use flb_farm::plan::State;
use flb_farm::{FarmError, Manifest, Plan};
use flb_files::publish;
use flb_scene::Unobserved;

use crate::args::{BuildArgs, InitArgs, LibraryArgs, LibraryCommand, ManifestArgs, ProgressArg, WhyArgs};
use crate::exit::{Failure, LOSS, USAGE, VERDICT};
use crate::inputs::check_output;
use crate::print::{self, line, say};
use report::Report;
pub(crate) use report::SpeciesReport;
pub(crate) use shown::Shown;

/// Name of a manifest.
const MANIFEST: &str = "library.toml";

pub(crate) fn run(args: &LibraryArgs) -> Result<u8, Failure> {
    match &args.command {
        LibraryCommand::Init(args) => init(args),
        LibraryCommand::Check(args) => check(args),
        LibraryCommand::Build(args) => run_build(args),
        LibraryCommand::Why(args) => why(args),
        LibraryCommand::Diff(args) => diff::run(args),
    }
}

/// Opens the cache of a manifest; what is amiss with it is said on stderr.
pub(crate) fn cache(args: &ManifestArgs) -> Result<(Cache<'static>, Trust), Failure> {
    let trust = if args.paranoid { Trust::Nothing } else { Trust::SizeAndTime };
    Ok((Cache::open(Some(&place(args)), &say_told)?, trust))
}

/// Says what a cache tells.
pub(crate) fn say_told(told: &str) {
    say!("{told}");
}

/// Place of the cache of a manifest.
pub(crate) fn place(args: &ManifestArgs) -> Place {
    args.cache.clone().unwrap_or_else(|| Place::beside(&args.manifest))
}

/// Writes a manifest of the meshes in a folder.
fn init(args: &InitArgs) -> Result<u8, Failure> {
    let output = args.output.clone().unwrap_or_else(|| args.folder.join(MANIFEST));
    check_output(&output, &[], args.existing)?;
    let all = survey(&args.folder).map_err(FarmError::from)?;
    let folder = output.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
    let text = init::text(&all, folder);
    publish(&output, args.existing, |file| file.write_all(text.as_bytes()))?;
    let species: Vec<SpeciesReport> = all.into_iter().map(SpeciesReport::of_survey).collect();
    species.iter().for_each(SpeciesReport::say_faults);
    let report = Report::of(&output, &folder.join(OUTPUT), species);
    let (undecided, failed) = (report.count("undecided"), report.count("failed"));
    let total = report.species.len() - failed;
    match args.json {
        true => print::json(&report)?,
        false => print::out(&line!(
            "{}: {total} species, {undecided} with undecided materials; meshes that cannot be read: {failed}",
            output.display()
        ))?,
    }
    Ok(if undecided + failed > 0 { LOSS } else { 0 })
}

/// Reads every mesh and classes its materials; says every error and every doubt.
fn check(args: &ManifestArgs) -> Result<u8, Failure> {
    let manifest = Manifest::read(&args.manifest)?;
    Output::of(&manifest).check()?;
    let (cache, trust) = cache(args)?;
    let checked = Plan::with_kept_digests(&manifest, &cache, trust).species.into_iter().map(|planned| {
        let read = match (planned.state, planned.job) {
            (State::Failed(error), _) => Err(error),
            (_, Some(job)) => job.read(&Unobserved).map(|read| read.warnings),
            (_, None) => Ok(Vec::new()),
        };
        let one = SpeciesReport::of_check(&planned.entry.name, read.map_err(Failure::from));
        one.say_faults();
        one
    });
    let report = Report::new(&manifest, checked.collect());
    let errors = report.count("failed");
    let total = report.species.len();
    match args.json {
        true => print::json(&report)?,
        false => {
            let file = args.manifest.display();
            print::out(&line!("{file}: {total} species, {errors} that cannot be baked"))?;
        }
    }
    Ok(if errors > 0 { VERDICT } else { 0 })
}

fn why(args: &WhyArgs) -> Result<u8, Failure> {
    show_plan(&args.manifest, std::slice::from_ref(&args.species))
}

/// Says what has to be done for species, and why; of all where none is named.
fn show_plan(args: &ManifestArgs, only: &[String]) -> Result<u8, Failure> {
    let manifest = Manifest::read(&args.manifest)?;
    if let Some(unknown) = only.iter().find(|name| manifest.find(name).is_none()) {
        return Err(no_species(&manifest, unknown).into());
    }
    let is_asked = |entry: &&flb_farm::manifest::Entry| only.is_empty() || only.contains(&entry.name);
    let asked = manifest.species.iter().filter(is_asked).cloned().collect();
    let some = Manifest { species: asked, ..manifest.clone() };
    let (cache, trust) = cache(args)?;
    let planned = Plan::with_kept_digests(&some, &cache, trust).species;
    let report = Report::new(&manifest, planned.into_iter().map(SpeciesReport::of_planned).collect());
    match args.json {
        true => print::json(&report)?,
        false => report.species.iter().try_for_each(|one| print::out(&line!("{}", one.line())))?,
    }
    Ok(if report.count("failed") > 0 { VERDICT } else { 0 })
}

fn run_build(args: &BuildArgs) -> Result<u8, Failure> {
    if args.dry_run {
        return show_plan(&args.manifest, &args.only);
    }
    let manifest = Manifest::read(&args.manifest.manifest)?;
    let (cache, trust) = cache(&args.manifest)?;
    let settings = settings(args)?;
    let is_for_machines = matches!(args.progress, ProgressArg::Json | ProgressArg::Openjd);
    if args.manifest.json && is_for_machines {
        return Err(Failure::new(USAGE, "--json and --progress both write to stdout, expected one of them"));
    }
    let shown = Shown::new(args.progress, &settings, None);
    let summary = build(&manifest, &settings, (&cache, trust), &shown)?;
    end(args, &manifest, summary, cache.traffic())
}

fn settings(args: &BuildArgs) -> Result<BuildSettings, Failure> {
    if !(args.memory.is_finite() && args.memory > 0.0) {
        return Err(Failure::new(USAGE, format!("--memory is {}, expected a number above 0", args.memory)));
    }
    let threads = rayon::current_num_threads();
    Ok(BuildSettings {
        jobs: args.jobs.map_or(threads.div_ceil(2), |jobs| jobs as usize),
        threads,
        memory_bytes: (args.memory * 1e9) as u64,
        only: args.only.clone(),
        on_failure: if args.keep_going { OnFailure::KeepGoing } else { OnFailure::Stop },
    })
}

/// What is said at the end, and the exit code.
fn end(args: &BuildArgs, manifest: &Manifest, summary: Summary, traffic: Traffic) -> Result<u8, Failure> {
    let report = Report::of_build(manifest, &summary, traffic);
    let output = manifest.output.display();
    for name in &summary.left_over {
        say!("{output}: {name}.flb is of no species of the manifest; it is left there");
    }
    for built in &summary.species {
        built.over.iter().for_each(|over| say!("warning: {}: {over}", built.name));
    }
    let [made, stored, current, failed, skipped] =
        ["made", "stored", "current", "failed", "skipped"].map(|state| report.count(state));
    match args.manifest.json {
        true => print::json(&report)?,
        false => print::out(&line!(
            "{output}: {made} baked, {stored} from the cache, {current} as they were, {failed} failed, {skipped} not begun"
        ))?,
    }
    if failed == 0 {
        return Ok(if summary.is_whole() { 0 } else { LOSS });
    }
    for (built, _) in summary.failed() {
        say!("again: flb library build {} --only {}", args.manifest.manifest.display(), built.name);
    }
    if args.keep_going {
        return Ok(LOSS);
    }
    let first = summary.species.into_iter().find_map(|built| match built.outcome {
        Outcome::Failed(error) => Some((built.name, error)),
        _ => None,
    });
    let (name, error) = first.expect("one has failed");
    let failure = Failure::from(error);
    Err(Failure { message: format!("{name}: {}", failure.message), ..failure })
}

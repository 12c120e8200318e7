//! `flb farm`: the work of a library for an engine; `flb task`: a part of it, on one machine of many.

mod status;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use flb_farm::build::{BuildSettings, OnFailure};
use flb_farm::cache::Cache;
use flb_farm::emit::{EmitSettings, Engine, PLAN, files};
use flb_farm::outcome::Outcome;
use flb_farm::tasks::TaskPlan;
use flb_farm::{Manifest, Plan, slurm};
use flb_files::{Existing, publish};
use serde::Serialize;

use crate::args::{
    EmitArgs, EngineArg, FarmArgs, FarmCommand, ManifestArgs, SubmitArgs, TaskArgs, TaskCommand, TaskRunArgs,
    WorkArgs,
};
use crate::exit::{AGAIN, Failure, LOSS};
use crate::inputs::check_output;
use crate::library::{self, Shown, SpeciesReport};
use crate::print::{self, line, say};

/// Folder of plan, scripts and logs beside a manifest.
const FOLDER: &str = ".flb-farm";
/// Seconds before the end of a task's time at which it stops by itself, at most.
const MARGIN_S: u64 = 120;

/// What `flb farm --json` prints (cli/schema/farm.json).
#[derive(Serialize, Default)]
struct Report {
    output: String,
    /// Of `emit` and `submit`.
    files: Option<Vec<String>>,
    species: Option<usize>,
    tasks: Option<usize>,
    memory_bytes: Option<u64>,
    seconds: Option<f64>,
    /// Of `submit`.
    jobs: Option<Vec<u64>>,
    /// Of the others: species whose files are there, and names of those that wait to be made or cannot be.
    done: Option<usize>,
    missing: Option<Vec<String>>,
    failed: Option<Vec<String>>,
    /// Tasks in the queue by Slurm's word.
    queue: Option<BTreeMap<String, u64>>,
}

/// What `flb task --json` prints (cli/schema/task.json).
#[derive(Serialize)]
struct Ran {
    plan: String,
    species: Vec<SpeciesReport>,
}

pub(crate) fn run(args: &FarmArgs) -> Result<u8, Failure> {
    match &args.command {
        FarmCommand::Emit(args) => emit(args),
        FarmCommand::Submit(args) => submit(args),
        FarmCommand::Status(args) => status::show(args),
        FarmCommand::Wait(args) => status::wait(args),
        FarmCommand::Cancel(args) => status::cancel(args),
        FarmCommand::Logs(args) => status::logs(args),
    }
}

pub(crate) fn run_task(args: &TaskArgs) -> Result<u8, Failure> {
    match &args.command {
        TaskCommand::Run(args) => work(args),
    }
}

fn emit(args: &EmitArgs) -> Result<u8, Failure> {
    let emitted = write(&args.manifest, &args.work, args.format.engine(), (&args.output, args.existing))?;
    emitted.print(args.manifest.json)
}

/// Writes the scripts of Slurm, and submits them.
fn submit(args: &SubmitArgs) -> Result<u8, Failure> {
    let folder = args.output.clone().unwrap_or_else(|| args.manifest.manifest.with_file_name(FOLDER));
    let EngineArg::Slurm = args.engine;
    // Before files that jobs in the queue read are written over.
    slurm::check_free(&folder)?;
    let mut emitted = write(&args.manifest, &args.work, Engine::Slurm, (&folder, Existing::Replace))?;
    if !args.dry_run {
        emitted.jobs = Some(slurm::submit(&folder)?);
    }
    emitted.print(args.manifest.json)
}

/// Writes a plan and the files of an engine.
fn write(
    manifest: &ManifestArgs,
    work: &WorkArgs,
    engine: Engine,
    (output, existing): (&Path, Existing),
) -> Result<Report, Failure> {
    let read = Manifest::read(&manifest.manifest)?;
    let (cache, trust) = library::cache(manifest)?;
    let plan = Plan::with_kept_digests(&read, &cache, trust);
    let plan = TaskPlan::of(&read, plan, &library::place(manifest), work.chunk)?;
    let folder = std::path::absolute(output).unwrap_or_else(|_| output.to_owned());
    let this = || std::env::current_exe().unwrap_or_else(|_| PathBuf::from("flb"));
    let limit_s = work.time.as_deref().and_then(slurm::seconds);
    let settings = EmitSettings {
        program: work.program.clone().unwrap_or_else(this),
        folder: folder.clone(),
        cores: work.cores,
        partition: work.partition.clone(),
        time: work.time.clone(),
        time_limit_s: limit_s.map(|seconds| seconds - (seconds / 10).min(MARGIN_S)),
    };
    let files = files(&plan, engine, &settings)?;
    let refuse = |source| flb_files::FileError::Write { path: folder.clone(), source };
    std::fs::create_dir_all(&folder).map_err(refuse)?;
    let names = files.iter().map(|(name, _)| name.as_str()).chain([PLAN]);
    let mut names: Vec<String> = names.map(str::to_owned).collect();
    names.sort();
    names.iter().try_for_each(|name| check_output(&folder.join(name), &[], existing))?;
    plan.write(&folder.join(PLAN), existing)?;
    for (name, text) in &files {
        publish(&folder.join(name), existing, |file| file.write_all(text.as_bytes()))?;
    }
    Ok(Report {
        output: output.display().to_string(),
        files: Some(names),
        species: Some(plan.tasks.iter().map(|task| task.species.len()).sum()),
        tasks: Some(plan.tasks.len()),
        memory_bytes: plan.tasks.iter().map(|task| task.memory_bytes).max().or(Some(0)),
        seconds: Some(plan.tasks.iter().map(|task| task.seconds).sum()),
        ..Report::default()
    })
}

impl Report {
    fn print(&self, is_json: bool) -> Result<u8, Failure> {
        if is_json {
            print::json(self)?;
            return Ok(0);
        }
        let (species, tasks) = (self.species.unwrap_or(0), self.tasks.unwrap_or(0));
        let (memory, seconds) = (print::bytes(self.memory_bytes.unwrap_or(0)), self.seconds.unwrap_or(0.0));
        print::out(&line!(
            "{}: {species} species in {tasks} tasks, {memory} at most each, {seconds:.0} s expected on one core",
            self.output
        ))?;
        if let Some(jobs) = &self.jobs {
            let jobs: Vec<String> = jobs.iter().map(u64::to_string).collect();
            print::out(&line!("submitted as jobs {}", jobs.join(", ")))?;
        }
        Ok(0)
    }
}

/// Makes the species of tasks.
fn work(args: &TaskRunArgs) -> Result<u8, Failure> {
    let start = Instant::now();
    let plan = TaskPlan::read(&args.plan)?;
    let cache = Cache::open(Some(&plan.cache()?), &library::say_told)?;
    let threads = rayon::current_num_threads();
    let settings = BuildSettings {
        jobs: 1,
        threads,
        memory_bytes: u64::MAX,
        only: Vec::new(),
        on_failure: OnFailure::KeepGoing,
    };
    let numbers = args.range.clone();
    let deadline = args.time_limit.map(|seconds| start + Duration::from_secs_f64(seconds));
    let observer = Shown::new(args.progress, &settings, deadline);
    let built = plan.run(numbers, &settings, &cache, &observer)?;
    let is = |of: fn(&Outcome) -> bool| built.iter().any(|one| of(&one.outcome));
    let (has_failed, is_cut) = (
        is(|outcome| matches!(outcome, Outcome::Failed(_))),
        is(|outcome| matches!(outcome, Outcome::Skipped)),
    );
    if args.json {
        let species = built.iter().map(SpeciesReport::of_built).collect();
        print::json(&Ran { plan: args.plan.display().to_string(), species })?;
    }
    Ok(if is_cut {
        say!("the time was not enough: run the task again");
        AGAIN
    } else if has_failed {
        LOSS
    } else {
        0
    })
}

//! `flb farm`: the work of a library for an engine; `flb task`: a part of it, on one machine of many.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use flb_farm::build::{BuildObserver, BuildSettings, OnFailure};
use flb_farm::emit::{EmitSettings, PLAN, files};
use flb_farm::outcome::{Built, Outcome};
use flb_farm::store::Folder;
use flb_farm::tasks::TaskPlan;
use flb_farm::{Manifest, Plan};
use flb_files::publish;
use flb_scene::Step;
use serde::Serialize;

use crate::args::{EmitArgs, FarmArgs, FarmCommand, ProgressArg, TaskArgs, TaskCommand, TaskRunArgs};
use crate::exit::{AGAIN, Failure, LOSS};
use crate::inputs::check_output;
use crate::library::{self, SpeciesReport};
use crate::print::{self, line, say};

/// What `flb farm --json` prints (cli/schema/farm.json).
#[derive(Serialize)]
struct Emitted {
    output: String,
    files: Vec<String>,
    species: usize,
    tasks: usize,
    memory_bytes: u64,
    seconds: f64,
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
    }
}

pub(crate) fn run_task(args: &TaskArgs) -> Result<u8, Failure> {
    match &args.command {
        TaskCommand::Run(args) => work(args),
    }
}

/// Writes a plan and the files of an engine.
fn emit(args: &EmitArgs) -> Result<u8, Failure> {
    let manifest = Manifest::read(&args.manifest.manifest)?;
    let tell = |told: &str| say!("{told}");
    let (store, trust) = library::store(&args.manifest, &tell);
    let plan: Plan = library::plan(&manifest, (&store, trust));
    let plan = TaskPlan::of(&manifest, plan, &library::cache_of(&args.manifest), args.chunk)?;
    let folder = std::path::absolute(&args.output).unwrap_or_else(|_| args.output.clone());
    let settings = EmitSettings {
        program: args.program.clone(),
        folder: folder.clone(),
        cores: args.cores,
        partition: args.partition.clone(),
        time: args.time.clone(),
    };
    let files = files(&plan, args.format.engine(), &settings);
    let refuse = |source| flb_files::FileError::Write { path: folder.clone(), source };
    std::fs::create_dir_all(&folder).map_err(refuse)?;
    let names = files.iter().map(|(name, _)| name.as_str()).chain([PLAN]);
    let mut names: Vec<String> = names.map(str::to_owned).collect();
    names.sort();
    names.iter().try_for_each(|name| check_output(&folder.join(name), &[], args.existing))?;
    plan.write(&folder.join(PLAN), args.existing)?;
    for (name, text) in &files {
        publish(&folder.join(name), args.existing, |file| file.write_all(text.as_bytes()))?;
    }
    let emitted = Emitted {
        output: args.output.display().to_string(),
        files: names,
        species: plan.tasks.iter().map(|task| task.species.len()).sum(),
        tasks: plan.tasks.len(),
        memory_bytes: plan.tasks.iter().map(|task| task.memory_bytes).max().unwrap_or(0),
        seconds: plan.tasks.iter().map(|task| task.seconds).sum(),
    };
    if args.manifest.json {
        print::json(&emitted)?;
        return Ok(0);
    }
    let Emitted { output, species, tasks, memory_bytes, seconds, .. } = &emitted;
    let memory = print::bytes(*memory_bytes);
    print::out(&line!(
        "{output}: {species} species in {tasks} tasks, {memory} at most each, {seconds:.0} s expected on one core"
    ))?;
    Ok(0)
}

/// Makes the species of tasks.
fn work(args: &TaskRunArgs) -> Result<u8, Failure> {
    let start = Instant::now();
    let plan = TaskPlan::read(&args.plan)?;
    let tell = |told: &str| say!("{told}");
    let store = Folder::open(Some(&plan.cache), &tell);
    let threads = rayon::current_num_threads();
    let settings = BuildSettings {
        jobs: 1,
        threads,
        memory_bytes: u64::MAX,
        only: Vec::new(),
        on_failure: OnFailure::KeepGoing,
    };
    let numbers = args.range.clone();
    let of_task = |number: usize| plan.tasks.get(number.wrapping_sub(1)).map_or(0, |task| task.species.len());
    let observer = Told {
        deadline: args.time_limit.map(|seconds| start + Duration::from_secs_f64(seconds)),
        is_openjd: args.progress == ProgressArg::Openjd,
        total: numbers.clone().take(plan.tasks.len()).map(of_task).sum(),
        ended: AtomicUsize::new(0),
    };
    let built = plan.run(numbers, &settings, &store, &observer)?;
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

/// Tells how far a task is.
struct Told {
    deadline: Option<Instant>,
    is_openjd: bool,
    total: usize,
    ended: AtomicUsize,
}

impl Told {
    fn openjd(&self, name: &str, value: &dyn std::fmt::Display) {
        if self.is_openjd {
            // A runner that reads no more is no reason to stop.
            let _ = print::out(&line!("openjd_{name}: {value}"));
        }
    }
}

impl BuildObserver for Told {
    fn at(&self, species: &str, step: Step, share: f64) {
        if share == 0.0 {
            self.openjd("status", &format!("{species}: {}", step.name()));
        }
    }

    fn ended(&self, built: &Built) {
        let ended = self.ended.fetch_add(1, Ordering::Relaxed) + 1;
        library::say_built(built, ended, self.total);
        self.openjd("progress", &(100 * ended / self.total.max(1)));
    }

    fn is_stopped(&self) -> bool {
        self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }
}

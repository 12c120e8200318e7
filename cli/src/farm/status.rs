//! What became of work that was submitted: species by the output, jobs by the queue.

use std::collections::BTreeMap;
use std::path::Path;
use std::thread;
use std::time::Duration;

use flb_farm::cache::Cache;
use flb_farm::digests::Trust;
use flb_farm::emit::PLAN;
use flb_farm::plan::State;
use flb_farm::slurm::{self, Queued};
use flb_farm::tasks::TaskPlan;
use flb_farm::{Manifest, Plan};

use super::Report;
use crate::args::{LogsArgs, WaitArgs, WorkFolder};
use crate::exit::{Failure, INPUT_OUTPUT, LOSS, USAGE};
use crate::library::say_told;
use crate::print::{self, line, say};

/// What became of the work of a folder.
struct Status {
    output: String,
    done: usize,
    /// Names of species that wait to be made, and of those that cannot be.
    missing: Vec<String>,
    failed: Vec<String>,
    queue: BTreeMap<String, u64>,
}

fn status(folder: &Path, queued: &[Queued]) -> Result<Status, Failure> {
    let plan = TaskPlan::read(&folder.join(PLAN))?;
    let manifest = Manifest::read(&plan.manifest)?;
    let cache = Cache::open(Some(&plan.cache()?), &say_told)?;
    let planned = Plan::with_kept_digests(&manifest, &cache, Trust::SizeAndTime);
    let mut status = Status {
        output: manifest.output.display().to_string(),
        done: 0,
        missing: Vec::new(),
        failed: Vec::new(),
        queue: BTreeMap::new(),
    };
    for one in planned.species {
        match one.state {
            State::Current(_) | State::Stored(_) => status.done += 1,
            State::Due(_) => status.missing.push(one.entry.name),
            State::Failed(_) => status.failed.push(one.entry.name),
        }
    }
    queued.iter().for_each(|one| *status.queue.entry(one.state.clone()).or_default() += one.tasks);
    Ok(status)
}

impl Status {
    /// Species that are not there.
    fn not_made(&self) -> impl Iterator<Item = &String> {
        self.missing.iter().chain(&self.failed)
    }

    fn print(self, is_json: bool) -> Result<(), Failure> {
        let not_made = self.not_made().count();
        let Status { output, done, missing, failed, queue } = self;
        if is_json {
            let (done, missing) = (Some(done), Some(missing));
            let report = Report {
                output,
                done,
                missing,
                failed: Some(failed),
                queue: Some(queue),
                ..Report::default()
            };
            return print::json(&report);
        }
        let tasks: Vec<String> =
            queue.iter().map(|(state, tasks)| format!("{tasks} {}", state.to_lowercase())).collect();
        let queue = if tasks.is_empty() { "nothing".to_owned() } else { tasks.join(", ") };
        print::out(&line!("{output}: {done} species there, {not_made} missing; in the queue: {queue}"))
    }
}

pub(super) fn show(args: &WorkFolder) -> Result<u8, Failure> {
    let queued = slurm::queued(&args.folder)?;
    status(&args.folder, &queued)?.print(args.json)?;
    if !args.json {
        for one in queued {
            print::out(&line!("  {} {} {}", one.id, one.state.to_lowercase(), one.reason))?;
        }
    }
    Ok(0)
}

/// Waits for the end of all jobs.
pub(super) fn wait(args: &WaitArgs) -> Result<u8, Failure> {
    let folder = &args.folder.folder;
    // Refused at once where there is no plan.
    TaskPlan::read(&folder.join(PLAN))?;
    let mut before = None;
    loop {
        let queued = slurm::queued(folder)?;
        if queued.is_empty() {
            break;
        }
        let tasks: u64 = queued.iter().map(|one| one.tasks).sum();
        if before.replace(tasks) != Some(tasks) {
            say!("{tasks} tasks in the queue");
        }
        thread::sleep(Duration::from_secs_f64(args.interval));
    }
    let status = status(folder, &[])?;
    let not_made = status.not_made();
    not_made.for_each(|name| say!("{name}: not made; flb farm logs {name} {}", folder.display()));
    let code = if status.not_made().count() > 0 { LOSS } else { 0 };
    status.print(args.folder.json)?;
    Ok(code)
}

pub(super) fn cancel(args: &WorkFolder) -> Result<u8, Failure> {
    let jobs = slurm::cancel(&args.folder)?;
    if !args.json {
        print::out(&line!("{jobs} jobs taken out of the queue"))?;
        return Ok(0);
    }
    status(&args.folder, &[])?.print(true)?;
    Ok(0)
}

/// Prints the log of the task of a species.
pub(super) fn logs(args: &LogsArgs) -> Result<u8, Failure> {
    let plan = TaskPlan::read(&args.folder.join(PLAN))?;
    let name = &args.species;
    if !plan.tasks.iter().any(|task| task.species.iter().any(|(species, _)| species == name)) {
        let folder = args.folder.display();
        return Err(Failure::new(USAGE, format!("{folder}: no task makes {name:?}")));
    }
    let Some(log) = slurm::log_of(&args.folder, &plan, name) else {
        let folder = args.folder.display();
        return Err(Failure::new(INPUT_OUTPUT, format!("{folder}: the task of {name:?} has no log yet")));
    };
    let text = std::fs::read(&log).map_err(|error| Failure::new(INPUT_OUTPUT, error).at(&log))?;
    let text = String::from_utf8_lossy(&text);
    text.lines().try_for_each(|text| print::out(&line!("{text}")))?;
    Ok(0)
}

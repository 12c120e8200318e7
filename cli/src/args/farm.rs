//! Arguments of `flb farm` and `flb task`.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use clap::{ArgAction, Args, Subcommand, ValueEnum};
use flb_farm::emit::Engine;
use flb_files::Existing;

use super::values::{above_0, existing};
use super::{ManifestArgs, ProgressArg};

#[derive(Args)]
#[command(after_help = "Schema of what --json prints: cli/schema/farm.json")]
pub(crate) struct FarmArgs {
    #[command(subcommand)]
    pub command: FarmCommand,
}

#[derive(Subcommand)]
pub(crate) enum FarmCommand {
    /// Write what is due of a library as tasks for an engine: a plan, and the files that the engine's own commands take
    Emit(EmitArgs),
    /// Write the same for an engine, and submit it; what is there already is not submitted again
    Submit(SubmitArgs),
    /// Say which species are there, and which jobs are in the queue
    Status(WorkFolder),
    /// Wait until no job is in the queue; exit 3 where a species is missing then
    Wait(WaitArgs),
    /// Take the jobs out of the queue; what they finished stays
    Cancel(WorkFolder),
    /// Print the log of the task that makes a species
    Logs(LogsArgs),
}

#[derive(Args)]
pub(crate) struct EmitArgs {
    #[command(flatten)]
    pub manifest: ManifestArgs,
    /// The engine
    #[arg(long, value_name = "FORMAT")]
    pub format: Format,
    /// Folder for the files; every machine of the farm must see it under this name, as it must the manifest, what that
    /// names, and the cache
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Overwrite files that are there
    #[arg(long = "force", action = ArgAction::SetTrue, value_parser = existing())]
    pub existing: Existing,
    #[command(flatten)]
    pub work: WorkArgs,
}

#[derive(Args)]
pub(crate) struct SubmitArgs {
    #[command(flatten)]
    pub manifest: ManifestArgs,
    /// The engine
    #[arg(long, value_name = "ENGINE")]
    pub engine: EngineArg,
    /// Folder for plan, scripts and logs; every machine of the farm must see it under this name, as it must the
    /// manifest, what that names, and the cache [default: .flb-farm beside the manifest]
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Write the scripts, and submit nothing
    #[arg(long)]
    pub dry_run: bool,
    #[command(flatten)]
    pub work: WorkArgs,
}

/// Size of tasks, and what scripts ask for.
#[derive(Args)]
pub(crate) struct WorkArgs {
    /// Seconds that a task is expected to take at least, where there are species enough: an engine needs time of its
    /// own for each task
    #[arg(long, default_value_t = 30.0, value_parser = above_0, value_name = "SECONDS")]
    pub chunk: f64,
    /// Cores of a task
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1024), value_name = "N")]
    pub cores: u32,
    /// The program on the machines of the farm [default: this one, by its path]
    #[arg(long, value_name = "FILE")]
    pub program: Option<PathBuf>,
    /// Partition of Slurm
    #[arg(long, value_name = "NAME")]
    pub partition: Option<String>,
    /// Limit of time of a task of Slurm, as sbatch takes it: 60 (minutes), 2:00:00, 1-12:00; a task stops by itself
    /// before that, and asks to be run again
    #[arg(long, value_name = "TIME", value_parser = time)]
    pub time: Option<String>,
}

#[derive(Args)]
pub(crate) struct WorkFolder {
    /// Folder that work was submitted from
    #[arg(default_value = ".flb-farm", value_name = "DIR")]
    pub folder: PathBuf,
    /// Print what was found as JSON (schema: cli/schema/farm.json)
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
pub(crate) struct WaitArgs {
    #[command(flatten)]
    pub folder: WorkFolder,
    /// Seconds between two looks at the queue
    #[arg(long, default_value_t = 10.0, value_parser = above_0, value_name = "SECONDS")]
    pub interval: f64,
}

#[derive(Args)]
pub(crate) struct LogsArgs {
    /// Name of the species
    #[arg(value_name = "SPECIES")]
    pub species: String,
    /// Folder that work was submitted from
    #[arg(default_value = ".flb-farm", value_name = "DIR")]
    pub folder: PathBuf,
}

#[derive(ValueEnum, Clone, Copy)]
pub(crate) enum EngineArg {
    /// Slurm, through its own commands
    Slurm,
}

/// A limit of time in Slurm's words.
fn time(text: &str) -> Result<String, String> {
    match flb_farm::slurm::seconds(text) {
        Some(_) => Ok(text.to_owned()),
        None => Err(format!("found {text:?}, expected minutes, hours:minutes:seconds or days-hours:minutes")),
    }
}

#[derive(ValueEnum, Clone, Copy)]
pub(crate) enum Format {
    /// A line for each task, with what goes before it: commands.txt
    Commands,
    /// Open Job Description: job.json
    Openjd,
    /// Batch scripts, and submit.sh, which submits them
    Slurm,
}

impl Format {
    pub(crate) fn engine(self) -> Engine {
        match self {
            Format::Commands => Engine::Commands,
            Format::Openjd => Engine::OpenJd,
            Format::Slurm => Engine::Slurm,
        }
    }
}

#[derive(Args)]
#[command(after_help = "Schema of what --json prints: cli/schema/task.json")]
pub(crate) struct TaskArgs {
    #[command(subcommand)]
    pub command: TaskCommand,
}

#[derive(Subcommand)]
pub(crate) enum TaskCommand {
    /// Make the species of tasks of a plan; what is there is not made again. Exit 3 where one cannot be made, 75 where
    /// the time was not enough and the task should be run again
    Run(TaskRunArgs),
}

#[derive(Args)]
pub(crate) struct TaskRunArgs {
    /// Plan that `flb farm emit` wrote
    #[arg(value_name = "PLAN")]
    pub plan: PathBuf,
    /// Number of the task, or numbers: 3, 3-5
    #[arg(value_name = "RANGE", value_parser = range)]
    pub range: RangeInclusive<usize>,
    /// Form of what is told on the way
    #[arg(long, default_value = "auto", value_name = "FORM")]
    pub progress: ProgressArg,
    /// Seconds after which the work stops, with exit code 75; what stages made is kept
    #[arg(long, value_parser = above_0, value_name = "SECONDS")]
    pub time_limit: Option<f64>,
    /// Print what became of each species as JSON (schema: cli/schema/task.json)
    #[arg(long, conflicts_with = "progress")]
    pub json: bool,
}

/// "3" or "3-5".
fn range(text: &str) -> Result<RangeInclusive<usize>, String> {
    let number = |word: &str| {
        word.parse().map_err(|_| format!("found {text:?}, expected a number, or two with - between: 3, 3-5"))
    };
    match text.split_once('-') {
        Some((first, last)) => Ok(number(first)?..=number(last)?),
        None => number(text).map(|only| only..=only),
    }
}

//! A plan of tasks in the words of an engine: files that its own commands take, readable and kept.

mod commands;
mod openjd;
mod slurm;

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use crate::FarmError;
use crate::tasks::{TaskPlan, text_of};

/// Name of the plan beside the files of an engine.
pub const PLAN: &str = "plan.json";
/// Name of the list of the numbers of jobs that were submitted.
pub const JOBS: &str = "jobs.txt";

/// An engine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Engine {
    /// A line for each task, for any engine: `commands.txt`.
    Commands,
    /// Open Job Description, as Deadline Cloud and others read it: `job.json`.
    OpenJd,
    /// Batch scripts of Slurm: `bake-1.sbatch` and so on, `finish.sbatch`, `submit.sh`.
    Slurm,
}

/// Words of an engine that a plan does not have.
#[derive(Debug, Clone, PartialEq)]
pub struct EmitSettings {
    /// The program `flb` on the machines of the farm.
    pub program: PathBuf,
    /// Folder that the files will lie in.
    pub folder: PathBuf,
    /// Cores of a task.
    pub cores: u32,
    /// Partition of Slurm.
    pub partition: Option<String>,
    /// Limit of time of a task of Slurm, in Slurm's words: "60", "2:00:00".
    pub time: Option<String>,
    /// Seconds after which a task stops by itself.
    pub time_limit_s: Option<u64>,
}

/// The files of an engine, by name; the plan itself is not among them.
///
/// # Errors
/// [`FarmError::NotText`].
pub fn files(
    plan: &TaskPlan,
    engine: Engine,
    settings: &EmitSettings,
) -> Result<Vec<(String, String)>, FarmError> {
    text_of(&settings.program)?;
    text_of(&settings.folder)?;
    Ok(match engine {
        Engine::Commands => vec![("commands.txt".to_owned(), commands::text(plan, settings))],
        Engine::OpenJd => vec![("job.json".to_owned(), openjd::text(plan, settings))],
        Engine::Slurm => slurm::scripts(plan, settings),
    })
}

/// Tasks of each array of Slurm, numbers from 1, in the order in which they are submitted.
pub(crate) fn arrays(plan: &TaskPlan) -> Vec<RangeInclusive<usize>> {
    slurm::arrays(plan)
}

impl EmitSettings {
    /// The command of a task: program and arguments. `number` is a number or what an engine puts one in place of.
    fn task(&self, number: &str) -> Vec<String> {
        let plan = shown(&self.folder.join(PLAN));
        let cores = self.cores.to_string();
        let mut words = vec![shown(&self.program), "--threads".to_owned(), cores];
        words.extend(["task", "run"].map(str::to_owned));
        let limit = self.time_limit_s.map(|seconds| ["--time-limit".to_owned(), seconds.to_string()]);
        words.extend(limit.into_iter().flatten());
        words.extend([plan, number.to_owned()]);
        words
    }

    /// The command that ends the work: what tasks left is made, then the file of all, index and page.
    fn finish(&self, plan: &TaskPlan) -> Vec<String> {
        let (manifest, cache) = (shown(&plan.manifest), plan.cache.clone());
        let cores = self.cores.to_string();
        let head = [&shown(&self.program), "--threads", &cores, "library", "build", &manifest];
        let end = ["--cache", &cache, "--keep-going"];
        head.into_iter().chain(end).map(str::to_owned).collect()
    }
}

fn shown(path: &Path) -> String {
    path.display().to_string()
}

/// A command as a shell reads it.
fn shell(words: &[String]) -> String {
    let quote = |word: &String| {
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "/._-+=:,@%".contains(c);
        match !word.is_empty() && word.chars().all(is_plain) {
            true => word.clone(),
            false => format!("'{}'", word.replace('\'', r"'\''")),
        }
    };
    words.iter().map(quote).collect::<Vec<_>>().join(" ")
}

/// Mebibytes, rounded up.
fn mebibytes(bytes: u64) -> u64 {
    bytes.div_ceil(1 << 20)
}

#[cfg(test)]
mod tests;

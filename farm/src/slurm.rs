//! Slurm through its own commands: submits the scripts of a folder, and asks what became of their jobs. Which species
//! are there is told by the output alone.

use std::path::{Path, PathBuf};
use std::process::Command;

use flb_scene::import::read_text;

use crate::FarmError;
use crate::emit::JOBS;
use crate::tasks::TaskPlan;

/// Bytes of the list of jobs.
const MAX_JOBS_BYTES: u64 = 1 << 20;
/// Characters of an answer that a message shows.
const MAX_SHOWN: usize = 200;

/// A job, or tasks of an array, in the queue.
#[derive(Debug, Clone, PartialEq)]
pub struct Queued {
    /// Number of the job.
    pub job: u64,
    /// Name to Slurm: "12_3", "12_[4-9]", "13".
    pub id: String,
    /// Tasks of it.
    pub tasks: u64,
    /// Slurm's word: RUNNING, PENDING and so on.
    pub state: String,
    /// Why it waits, or the node it runs on.
    pub reason: String,
}

/// Submits the scripts of a folder; returns the numbers of the jobs.
///
/// # Errors
/// [`FarmError::Engine`] where Slurm's commands are missing, refuse, or answer something else;
/// [`FarmError::InQueue`] where jobs of this folder are in the queue.
pub fn submit(folder: &Path) -> Result<Vec<u64>, FarmError> {
    check_free(folder)?;
    ask(Command::new("sbatch").arg("--version"))?;
    ask(Command::new("sh").arg(folder.join("submit.sh")))?;
    jobs(folder)
}

/// Refuses a folder whose jobs are in the queue.
///
/// # Errors
/// [`FarmError::InQueue`]; as [`queued`].
pub fn check_free(folder: &Path) -> Result<(), FarmError> {
    match queued(folder)?.first() {
        Some(first) => Err(FarmError::InQueue { folder: folder.to_owned(), job: first.id.clone() }),
        None => Ok(()),
    }
}

/// Numbers of the jobs that were submitted from a folder; none where nothing was.
///
/// # Errors
/// [`FarmError::Engine`] for a list that is none.
pub fn jobs(folder: &Path) -> Result<Vec<u64>, FarmError> {
    let path = folder.join(JOBS);
    if !path.exists() {
        return Ok(Vec::new());
    }
    let (_, text) = read_text(&path, MAX_JOBS_BYTES)?;
    let number = |line: &str| {
        let refuse = || nonsense(&path.display().to_string(), line, "the number of a job in each line");
        line.trim().parse().map_err(|_| refuse())
    };
    text.lines().filter(|line| !line.trim().is_empty()).map(number).collect()
}

/// The jobs of a folder that are in the queue.
///
/// # Errors
/// As [`jobs`].
pub fn queued(folder: &Path) -> Result<Vec<Queued>, FarmError> {
    let jobs = jobs(folder)?;
    if jobs.is_empty() {
        return Ok(Vec::new());
    }
    let format = "%F|%i|%T|%R";
    let answer = ask(Command::new("squeue").args(["--noheader", "--array", "--format", format]))?;
    let all: Vec<Queued> = answer.lines().map(parse).collect::<Result<_, _>>()?;
    Ok(all.into_iter().filter(|one| jobs.contains(&one.job)).collect())
}

/// A line of squeue: "12|12_[4-9]|PENDING|(Resources)".
fn parse(line: &str) -> Result<Queued, FarmError> {
    let refuse = || nonsense("squeue", line, "number|name|state|reason");
    let cells: Vec<&str> = line.splitn(4, '|').collect();
    let [job, id, state, reason] = cells[..] else { return Err(refuse()) };
    let job = job.trim().parse().map_err(|_| refuse())?;
    let tasks = id.split_once('[').map_or(Ok(1), |(_, list)| count(list).ok_or_else(refuse))?;
    Ok(Queued { job, id: id.to_owned(), tasks, state: state.to_owned(), reason: reason.to_owned() })
}

/// Tasks of a list such as "0,4-9]" or "4-9%2]".
fn count(list: &str) -> Option<u64> {
    let list = list.strip_suffix(']')?;
    let list = list.split_once('%').map_or(list, |(list, _)| list);
    let of_range = |range: &str| match range.split_once('-') {
        Some((first, last)) => {
            let (first, last) = (first.parse::<u64>().ok()?, last.parse::<u64>().ok()?);
            last.checked_sub(first)?.checked_add(1)
        }
        None => range.parse::<u64>().ok().map(|_| 1),
    };
    list.split(',').map(of_range).try_fold(0u64, |sum, one| sum.checked_add(one?))
}

/// Takes the jobs of a folder out of the queue; returns how many were in it.
///
/// # Errors
/// As [`queued`].
pub fn cancel(folder: &Path) -> Result<usize, FarmError> {
    let mut found: Vec<u64> = queued(folder)?.into_iter().map(|one| one.job).collect();
    found.dedup();
    if !found.is_empty() {
        ask(Command::new("scancel").args(found.iter().map(u64::to_string)))?;
    }
    Ok(found.len())
}

/// Log of the task that makes a species, once Slurm has begun it.
pub fn log_of(folder: &Path, plan: &TaskPlan, species: &str) -> Option<PathBuf> {
    let at = plan.tasks.iter().position(|task| task.species.iter().any(|(name, _)| name == species))?;
    let arrays = crate::emit::arrays(plan);
    let array = arrays.iter().position(|tasks| tasks.contains(&(at + 1)))?;
    let job = *jobs(folder).ok()?.get(array)?;
    let index = at + 1 - arrays[array].start();
    Some(folder.join(format!("flb-bake-{job}_{index}.log"))).filter(|path| path.is_file())
}

/// What a command answers.
fn ask(command: &mut Command) -> Result<String, FarmError> {
    let name = command.get_program().to_string_lossy().into_owned();
    let failed = |found: String| FarmError::Engine { command: name.clone(), found };
    let output = command.output().map_err(|error| {
        failed(format!("{error}; expected Slurm's commands in PATH, as on a machine that submits jobs"))
    })?;
    if !output.status.success() {
        let said = shortened(&String::from_utf8_lossy(&output.stderr));
        return Err(failed(format!("{}: {said}", output.status)));
    }
    String::from_utf8(output.stdout).map_err(|_| failed("bytes that are no text".to_owned()))
}

fn nonsense(command: &str, found: &str, expected: &str) -> FarmError {
    let found = format!("found {:?}, expected {expected}", shortened(found));
    FarmError::Engine { command: command.to_owned(), found }
}

fn shortened(text: &str) -> String {
    let text = text.trim();
    match text.char_indices().nth(MAX_SHOWN) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

/// Seconds of a limit of time in Slurm's words: minutes, minutes:seconds, hours:minutes:seconds, days-hours,
/// days-hours:minutes, days-hours:minutes:seconds. `None` for anything else.
pub fn seconds(time: &str) -> Option<u64> {
    let number = |word: &str| {
        let is_plain = !word.is_empty() && word.len() <= 6 && word.bytes().all(|byte| byte.is_ascii_digit());
        is_plain.then(|| word.parse::<u64>().ok()).flatten()
    };
    let (days, clock) = match time.split_once('-') {
        Some((days, clock)) => (Some(number(days)?), clock),
        None => (None, time),
    };
    let parts: Vec<u64> = clock.split(':').map(number).collect::<Option<_>>()?;
    let units: &[u64] = match (days.is_some(), parts.len()) {
        (true, 1..=3) => &[3600, 60, 1],
        (false, 1 | 2) => &[60, 1],
        (false, 3) => &[3600, 60, 1],
        _ => return None,
    };
    let clock: u64 = parts.iter().zip(units).map(|(part, unit)| part * unit).sum();
    let total = days.unwrap_or(0) * 86_400 + clock;
    (total > 0).then_some(total)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_the_queue_are_read_and_nonsense_is_refused() {
        let one = parse("12|12_[0,4-9%2]|PENDING|(Resources)").expect("a line");
        assert_eq!((one.job, one.tasks, one.state.as_str()), (12, 7, "PENDING"));
        let one = parse("13|13|RUNNING|n1").expect("a line");
        assert_eq!((one.job, one.tasks, one.reason.as_str()), (13, 1, "n1"));
        for bad in ["", "x|1|RUNNING|n1", "12|12|RUNNING", "12|12_[9-4]|PENDING|", "slurm_load_jobs error"] {
            let error = parse(bad).expect_err("no line of a queue").to_string();
            assert!(
                error.contains("squeue: found ") && error.contains("number|name|state|reason"),
                "{error}"
            );
        }
    }

    #[test]
    fn limits_of_time_are_those_of_slurm() {
        let good = [
            ("60", 3600),
            ("1:30", 90),
            ("2:00:00", 7200),
            ("1-0", 86_400),
            ("1-2:30", 95_400),
            ("0-0:0:5", 5),
        ];
        for (text, expected) in good {
            assert_eq!(seconds(text), Some(expected), "{text}");
        }
        for bad in ["", "0", "x", "1:2:3:4", "-1", "1-", "99999999", "1h"] {
            assert_eq!(seconds(bad), None, "{bad}");
        }
    }
}

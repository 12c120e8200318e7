//! The work of a library as tasks that an engine runs, each on any machine that sees the manifest, the cache and the
//! output: what is due, a few species a task, with the memory and the seconds that are expected.
//!
//! A task may be run again at any time: what is there is not made again.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use flb_files::{Existing, publish};
use flb_scene::import::read_text;
use serde::{Deserialize, Serialize};

use crate::FarmError;
use crate::build::{BuildObserver, BuildSettings, bring};
use crate::cache::{Cache, Place};
use crate::digests::Trust;
use crate::manifest::Manifest;
use crate::outcome::Built;
use crate::plan::{Plan, Planned, State};

/// Version of the text of a plan.
const SCHEMA: u32 = 1;
/// Bytes of the text of a plan.
const MAX_PLAN_BYTES: u64 = 1 << 30;
/// Memory of a task is a multiple of this, so that few kinds of tasks differ in it.
const MEMORY_STEP_BYTES: u64 = 512 << 20;

/// A plan for an engine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TaskPlan {
    schema: u32,
    /// Program that made it.
    pub tool: String,
    /// The manifest.
    pub manifest: PathBuf,
    /// The cache: a folder or a URL.
    pub cache: String,
    /// Tasks; the first is number 1. Those that take most memory come first, and of these the longest.
    pub tasks: Vec<Task>,
}

/// Species that are made one after the other.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Task {
    /// Names of the species, and the keys of what they are made of.
    pub species: Vec<(String, String)>,
    /// Memory that is expected, rounded up.
    pub memory_bytes: u64,
    /// Seconds that are expected on one core.
    pub seconds: f64,
}

impl TaskPlan {
    /// Makes tasks of what a plan finds due. A task takes `chunk_s` seconds or more where there are species enough.
    ///
    /// # Errors
    /// The error of the first species that cannot be made; [`FarmError::NotText`].
    pub fn of(manifest: &Manifest, plan: Plan, cache: &Place, chunk_s: f64) -> Result<TaskPlan, FarmError> {
        let mut due: Vec<(Planned, String)> = Vec::new();
        for planned in plan.species {
            match (planned.state, &planned.job) {
                (State::Failed(error), _) => return Err(error),
                (State::Due(why), Some(job)) => {
                    let key = job.key.clone();
                    due.push((Planned { state: State::Due(why), ..planned }, key));
                }
                _ => {}
            }
        }
        let memory = |planned: &Planned| planned.memory_bytes.next_multiple_of(MEMORY_STEP_BYTES);
        due.sort_by(|(a, _), (b, _)| memory(b).cmp(&memory(a)).then_with(|| b.seconds.total_cmp(&a.seconds)));
        let mut tasks: Vec<Task> = Vec::new();
        for (planned, key) in due {
            let (memory_bytes, seconds) = (memory(&planned), planned.seconds);
            match tasks.last_mut().filter(|last| last.memory_bytes == memory_bytes && last.seconds < chunk_s)
            {
                Some(last) => {
                    last.species.push((planned.entry.name, key));
                    last.seconds += seconds;
                }
                None => {
                    let species = vec![(planned.entry.name, key)];
                    tasks.push(Task { species, memory_bytes, seconds });
                }
            }
        }
        TaskPlan::of_tasks(&manifest.path, cache, tasks)
    }

    /// Makes a plan of these tasks. Paths become whole ones.
    pub(crate) fn of_tasks(manifest: &Path, cache: &Place, tasks: Vec<Task>) -> Result<TaskPlan, FarmError> {
        let manifest = std::path::absolute(manifest).unwrap_or_else(|_| manifest.to_owned());
        text_of(&manifest)?;
        let cache = cache.absolute();
        cache.folder().map(text_of).transpose()?;
        let tool = concat!("flb ", env!("CARGO_PKG_VERSION")).to_owned();
        Ok(TaskPlan { schema: SCHEMA, tool, manifest, cache: cache.to_string(), tasks })
    }

    /// Place of the cache.
    ///
    /// # Errors
    /// [`FarmError::Location`] for a URL that this program cannot read.
    pub fn cache(&self) -> Result<Place, FarmError> {
        Ok(Place::parse(&self.cache)?)
    }

    /// Reads a plan.
    ///
    /// # Errors
    /// [`FarmError::Import`] for a file that cannot be read; [`FarmError::TaskPlan`] for what is no plan, or is of
    /// another version.
    pub fn read(path: &Path) -> Result<TaskPlan, FarmError> {
        let refuse = |found: String| FarmError::TaskPlan { plan: path.to_owned(), found };
        let (_, text) = read_text(path, MAX_PLAN_BYTES)?;
        let plan: TaskPlan = serde_json::from_str(&text).map_err(|error| refuse(error.to_string()))?;
        match plan.schema {
            SCHEMA => Ok(plan),
            other => Err(refuse(format!("version {other}"))),
        }
    }

    /// Writes the plan.
    ///
    /// # Errors
    /// [`flb_files::FileError`].
    pub fn write(&self, path: &Path, existing: Existing) -> Result<(), FarmError> {
        let text = serde_json::to_vec_pretty(self).expect("numbers, names and lists are JSON");
        Ok(publish(path, existing, |file| file.write_all(&text).and_then(|()| file.write_all(b"\n")))?)
    }

    /// Tasks of the same memory, as ranges of numbers from 1.
    pub fn classes(&self) -> Vec<RangeInclusive<usize>> {
        let mut classes: Vec<RangeInclusive<usize>> = Vec::new();
        for (at, task) in self.tasks.iter().enumerate() {
            match classes.last_mut() {
                Some(last) if self.tasks[last.start() - 1].memory_bytes == task.memory_bytes => {
                    *last = *last.start()..=at + 1;
                }
                _ => classes.push(at + 1..=at + 1),
            }
        }
        classes
    }

    /// Makes the species of some tasks, numbers from 1. Neither the file of all nor index nor page is written.
    ///
    /// # Errors
    /// [`FarmError::TaskRange`]; [`FarmError::Older`] where a species is made of other parts than the plan says; an
    /// output that cannot be written. A species that cannot be made is in the answer.
    pub fn run(
        &self,
        tasks: RangeInclusive<usize>,
        settings: &BuildSettings,
        cache: &Cache,
        observer: &dyn BuildObserver,
    ) -> Result<Vec<Built>, FarmError> {
        let (first, last) = (*tasks.start(), *tasks.end());
        if first == 0 || first > last || last > self.tasks.len() {
            return Err(FarmError::TaskRange { first, last, tasks: self.tasks.len() });
        }
        let manifest = Manifest::read(&self.manifest)?;
        let wanted: Vec<&(String, String)> =
            self.tasks[first - 1..last].iter().flat_map(|task| &task.species).collect();
        let older =
            |species: &str| FarmError::Older { manifest: self.manifest.clone(), species: species.to_owned() };
        let find = |(name, _): &&(String, String)| manifest.find(name).cloned().ok_or_else(|| older(name));
        let species = wanted.iter().map(find).collect::<Result<_, _>>()?;
        let some = Manifest { species, ..manifest.clone() };
        let plan = Plan::with_kept_digests(&some, cache, Trust::SizeAndTime);
        for (planned, (name, key)) in plan.species.iter().zip(wanted) {
            if planned.job.as_ref().is_some_and(|job| job.key != *key) {
                return Err(older(name));
            }
        }
        observer.planned(&plan);
        bring(&some, plan, settings, cache, observer)
    }
}

/// A path as files of engines hold it.
///
/// # Errors
/// [`FarmError::NotText`].
pub fn text_of(path: &Path) -> Result<&str, FarmError> {
    path.to_str().ok_or_else(|| FarmError::NotText { path: path.to_owned() })
}

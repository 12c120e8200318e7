//! The build of a library: what has to be made, as many species at once as cores and memory allow.

mod schedule;
#[cfg(test)]
pub(crate) mod tests;

use std::sync::atomic::{AtomicBool, Ordering};

use flb_scene::Step;

use crate::FarmError;
use crate::cache::Cache;
use crate::digests::Trust;
use crate::index::Index;
use crate::job::Job;
use crate::make::{Listener, Made, make};
use crate::manifest::Manifest;
use crate::manifest::nearest::nearest;
use crate::outcome::{Built, Outcome, Summary};
use crate::output::{self, Output};
use crate::plan::{Plan, Planned, State, Why};
use crate::predict;
use crate::publish::write_all;
use crate::record::Record;

/// Consequence of a species that cannot be made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum OnFailure {
    /// No other is begun, and those that are being made are stopped.
    #[default]
    Stop,
    /// The others are made.
    KeepGoing,
}

/// Settings of a build.
#[derive(Debug, Clone, PartialEq)]
pub struct BuildSettings {
    /// Species that are made at once, at most; at least 1.
    pub jobs: usize,
    /// Threads of all species together; at least 1.
    pub threads: usize,
    /// Memory of all species that are made at once, as it is predicted, in bytes. A species that needs more by itself
    /// is made alone.
    pub memory_bytes: u64,
    /// Names of the species to build; none: all.
    pub only: Vec<String>,
    /// Consequence of one that cannot be made.
    pub on_failure: OnFailure,
}

/// Follower of a build. Every method may do nothing.
pub trait BuildObserver: Sync {
    /// Called once, before any work, with the species that are asked for.
    fn planned(&self, plan: &Plan) {
        let _ = plan;
    }

    /// Called when a stage of a species begins and goes on, with the share that is done; from any thread.
    fn at(&self, species: &str, step: Step, share: f64) {
        let _ = (species, step, share);
    }

    /// Called when a species has an outcome.
    fn ended(&self, species: &Built) {
        let _ = species;
    }

    /// Whether to stop.
    fn is_stopped(&self) -> bool {
        false
    }
}

/// Builds a library: makes the species whose parts changed, takes the others from where they are, and writes index,
/// page and the file of all species. Building again changes no byte.
///
/// # Errors
/// An output that cannot be written; a name that no species has. A species that cannot be made is told in the
/// summary.
pub fn build(
    manifest: &Manifest,
    settings: &BuildSettings,
    cache: (&Cache, Trust),
    observer: &dyn BuildObserver,
) -> Result<Summary, FarmError> {
    let (cache, trust) = cache;
    let output = Output::of(manifest);
    for name in &settings.only {
        if manifest.find(name).is_none() {
            return Err(no_species(manifest, name));
        }
    }
    let mut plan = Plan::with_kept_digests(manifest, cache, trust);
    plan.species.retain(|planned| settings.only.is_empty() || settings.only.contains(&planned.entry.name));
    observer.planned(&plan);
    let species = bring(manifest, plan, settings, cache, observer)?;
    let (index, old) = (Index::of(manifest, &output, &species), Index::read(&output));
    let library_bytes = write_all(manifest, &output, index, old, &species)?;
    let left_over = output.built().into_iter().filter(|name| manifest.find(name).is_none()).collect();
    Ok(Summary { species, library_bytes, left_over })
}

/// Brings the species of a plan to their places; neither the file of all nor index nor page is written.
pub(crate) fn bring(
    manifest: &Manifest,
    plan: Plan,
    settings: &BuildSettings,
    cache: &Cache,
    observer: &dyn BuildObserver,
) -> Result<Vec<Built>, FarmError> {
    let output = Output::of(manifest);
    output.prepare()?;
    let work = Work { output: &output, cache, observer, has_failed: AtomicBool::new(false) };
    schedule::run(plan.species, settings, &work)
}

/// The error for a name that no species has.
pub fn no_species(manifest: &Manifest, name: &str) -> FarmError {
    let names = manifest.species.iter().map(|entry| entry.name.as_str());
    let nearest = nearest(name, names).map(str::to_owned);
    FarmError::NoSpecies { manifest: manifest.path.clone(), name: name.to_owned(), nearest }
}

/// What every species of a build is given.
struct Work<'a> {
    output: &'a Output,
    cache: &'a Cache<'a>,
    observer: &'a dyn BuildObserver,
    /// Whether one has failed that stops the others.
    has_failed: AtomicBool,
}

impl Work<'_> {
    /// Whether no other species is begun, and those that are being made end.
    fn is_stopped(&self) -> bool {
        self.has_failed.load(Ordering::Relaxed) || self.observer.is_stopped()
    }

    /// Brings a species to its place. `weigh` is told how much memory it will take once that is known better, and
    /// may wait.
    fn one(&self, planned: Planned, weigh: &(dyn Fn(u64) + Sync)) -> Built {
        let Planned { entry, job, state, .. } = planned;
        let name = entry.name.clone();
        let done = match (state, job) {
            (State::Failed(error), _) => Err(error),
            (State::Current(record), _) => Ok((Outcome::Current, *record)),
            (State::Stored(record), Some(job)) => self.stored(&job, *record, weigh),
            (State::Due(why), Some(job)) => self.made(&job, why, weigh),
            (_, None) => unreachable!("a species without a job has failed"),
        };
        let built = match done {
            Ok((outcome, record)) => {
                let over = record.facts.over(&entry.budget);
                Built { name, outcome, record: Some(record), over }
            }
            Err(FarmError::Stopped) => {
                Built { name, outcome: Outcome::Skipped, record: None, over: Vec::new() }
            }
            Err(error) => Built { name, outcome: Outcome::Failed(error), record: None, over: Vec::new() },
        };
        self.observer.ended(&built);
        built
    }

    /// Copies a species from the cache, or makes it where the cache's copy is damaged.
    fn stored(
        &self,
        job: &Job,
        record: Record,
        weigh: &(dyn Fn(u64) + Sync),
    ) -> Result<(Outcome, Record), FarmError> {
        let entry = format!("species-{}.flb", job.key);
        let file = self.cache.read(&entry);
        let is_sound = |file: &Vec<u8>| blake3::hash(file).to_hex().as_str() == record.facts.blake3;
        let Some(file) = file.filter(|file| {
            let sound = is_sound(file);
            if !sound {
                self.cache.damaged(&entry, "has other bytes than were kept");
            }
            sound
        }) else {
            return self.made(job, Why::Lost, weigh);
        };
        let read = |kind: &str| self.cache.read(&format!("species-{}.{kind}", job.key)).unwrap_or_default();
        let log = String::from_utf8_lossy(&read("log")).into_owned();
        self.publish(&Made { file, record: record.clone(), picture: read("png"), log })?;
        Ok((Outcome::Stored, record))
    }

    fn made(
        &self,
        job: &Job,
        why: Why,
        weigh: &(dyn Fn(u64) + Sync),
    ) -> Result<(Outcome, Record), FarmError> {
        let listener = Followed { work: self, job, weigh };
        let made = make(job, self.cache, &listener)?;
        let keep = |kind: &str, bytes: &[u8]| self.cache.write(&format!("species-{}.{kind}", job.key), bytes);
        keep("flb", &made.file);
        keep("png", &made.picture);
        keep("log", made.log.as_bytes());
        // The record comes last: with it the species is whole.
        keep("json", &record_text(&made.record));
        self.publish(&made)?;
        Ok((Outcome::Made(why), made.record))
    }

    /// Writes the files of a species; the record comes last.
    fn publish(&self, made: &Made) -> Result<(), FarmError> {
        let name = &made.record.name;
        output::write(&self.output.species(name), &made.file)?;
        if !made.picture.is_empty() {
            output::write(&self.output.picture(name), &made.picture)?;
        }
        output::write(&self.output.log(name), made.log.as_bytes())?;
        output::write(&self.output.record_file(name), &record_text(&made.record))?;
        Ok(())
    }
}

/// Follows the stages of a species.
struct Followed<'a> {
    work: &'a Work<'a>,
    job: &'a Job,
    weigh: &'a (dyn Fn(u64) + Sync),
}

impl Listener for Followed<'_> {
    fn at(&self, step: Step, share: f64) {
        self.work.observer.at(&self.job.entry.name, step, share);
    }

    fn matter(&self, sites: u64) {
        (self.weigh)(predict::memory_bytes(&self.job.bake, self.job.bands(), Some(sites)));
    }

    fn is_stopped(&self) -> bool {
        self.work.is_stopped()
    }
}

fn record_text(record: &Record) -> Vec<u8> {
    let mut text = serde_json::to_vec_pretty(record).expect("numbers, names and lists are JSON");
    text.push(b'\n');
    text
}

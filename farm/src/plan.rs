//! Plan of a build: for each species whether its file is there, is kept in the cache, or has to be made, and why.

use std::path::PathBuf;

use rayon::prelude::*;

use crate::FarmError;
use crate::cache::Cache;
use crate::digests::{Digests, Trust};
use crate::job::Job;
use crate::manifest::{Entry, Manifest};
use crate::output::Output;
use crate::parts::{Change, redone};
use crate::predict;
use crate::record::Record;

/// Work that is due for a species.
#[derive(Debug)]
pub enum State {
    /// The file is there, made of these very parts.
    Current(Box<Record>),
    /// The cache has the file.
    Stored(Box<Record>),
    /// The species has to be made.
    Due(Why),
    /// The species cannot be made.
    Failed(FarmError),
}

/// Why a species has to be made.
#[derive(Debug, Clone, PartialEq)]
pub enum Why {
    /// The species was never built here.
    New,
    /// Parts are others than those of the file that is there.
    Changed(Vec<Change>),
    /// The file is gone or has other bytes than were written, and the cache does not have it either.
    Lost,
}

/// A species of a plan.
#[derive(Debug)]
pub struct Planned {
    /// The species as the manifest has it.
    pub entry: Entry,
    /// Settings of its bake, unless it cannot be made.
    pub job: Option<Job>,
    /// Work that is due.
    pub state: State,
    /// Memory that its bake is expected to take, in bytes.
    pub memory_bytes: u64,
    /// Seconds that its bake is expected to take: by what such bakes took before, where there are any.
    pub seconds: f64,
}

/// Plan of a build.
#[derive(Debug)]
pub struct Plan {
    /// File of the manifest.
    pub manifest: PathBuf,
    /// Every species, in the order of the manifest.
    pub species: Vec<Planned>,
}

impl Plan {
    /// Looks at every species: reads species files, and digests of meshes as far as they are not known.
    pub fn of(manifest: &Manifest, cache: &Cache, digests: &Digests) -> Plan {
        let output = Output::of(manifest);
        let plan = |entry: &Entry| {
            let (job, state) = match Job::new(entry, digests) {
                Ok(job) => {
                    let state = state(&job, &output, cache, digests);
                    (Some(job), state)
                }
                Err(error) => (None, State::Failed(error)),
            };
            let expected = job.as_ref().map(|job| {
                // The plant's own sites, where it was baked on this lattice before.
                let of = |record: &Record| (record.facts.lattice == job.bake.lattice).then_some(record.sites);
                let sites = match &state {
                    State::Current(record) | State::Stored(record) => of(record),
                    _ => output.record(&entry.name).as_ref().and_then(of),
                };
                let bands = job.bands();
                (predict::memory_bytes(&job.bake, bands, sites), predict::seconds(&job.bake, bands, sites))
            });
            let (memory_bytes, seconds) = expected.unwrap_or_default();
            Planned { entry: entry.clone(), job, state, memory_bytes, seconds }
        };
        let mut species: Vec<Planned> = manifest.species.par_iter().map(plan).collect();
        let known = species.iter().filter_map(|planned| match &planned.state {
            State::Current(record) | State::Stored(record) => Some((record.facts.seconds, planned.seconds)),
            State::Due(_) | State::Failed(_) => None,
        });
        let (took, expected) = known.fold((0.0, 0.0), |sum, one| (sum.0 + one.0, sum.1 + one.1));
        if expected > 0.0 {
            species.iter_mut().for_each(|planned| planned.seconds *= took / expected);
        }
        Plan { manifest: manifest.path.clone(), species }
    }

    /// Looks at every species, with the digests of files that are kept; those that were found are kept.
    pub fn with_kept_digests(manifest: &Manifest, cache: &Cache, trust: Trust) -> Plan {
        let own = cache.of_machine(&manifest.path);
        let of_files = own.as_ref().unwrap_or(cache);
        let digests = Digests::open(of_files, trust);
        let plan = Plan::of(manifest, cache, &digests);
        digests.keep(of_files);
        plan
    }

    /// The species of a name.
    pub fn find(&self, name: &str) -> Option<&Planned> {
        self.species.iter().find(|planned| planned.entry.name == name)
    }
}

/// The record of a key, if the cache has one that is sound.
pub(crate) fn stored_record(cache: &Cache, key: &str) -> Option<Record> {
    let entry = format!("species-{key}.json");
    let bytes = cache.read(&entry)?;
    sound_record(&bytes, key).inspect_err(|fault| cache.damaged(&entry, fault)).ok()
}

/// The record of a key, in bytes that may be anything.
pub(crate) fn sound_record(bytes: &[u8], key: &str) -> Result<Record, String> {
    let record: Record = serde_json::from_slice(bytes).map_err(|error| error.to_string())?;
    match record.facts.key == key && record.parts.key() == key {
        true => Ok(record),
        false => Err("is of other parts than its name says".to_owned()),
    }
}

fn state(job: &Job, output: &Output, cache: &Cache, digests: &Digests) -> State {
    let name = &job.entry.name;
    let built = output.record(name);
    if let Some(record) = &built
        && record.facts.key == job.key
        && digests.is(&output.species(name), &record.facts.blake3)
    {
        return State::Current(Box::new(record.clone()));
    }
    if let Some(record) =
        stored_record(cache, &job.key).filter(|_| cache.has(&format!("species-{}.flb", job.key)))
    {
        return State::Stored(Box::new(record));
    }
    State::Due(match built {
        None => Why::New,
        Some(record) if record.facts.key == job.key => Why::Lost,
        Some(record) => Why::Changed(job.parts.changes(&record.parts)),
    })
}

/// One sentence: "plant.surfaces.G.leaf.reflectance 0.125 -> 0.14: solve, encode, write; import, voxelise, crown
/// reused".
impl std::fmt::Display for Why {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Why::New => f.write_str("it was never built here"),
            Why::Lost => f.write_str("its file is gone or has other bytes than were written"),
            Why::Changed(changes) => {
                let told: Vec<String> = changes.iter().map(Change::to_string).collect();
                let (again, reused) = redone(changes);
                let names = |steps: &[flb_scene::Step]| {
                    steps.iter().map(|step| step.name()).collect::<Vec<_>>().join(", ")
                };
                write!(f, "{}: {}", told.join("; "), names(again))?;
                match reused.is_empty() {
                    true => Ok(()),
                    false => write!(f, "; {} reused", names(reused)),
                }
            }
        }
    }
}

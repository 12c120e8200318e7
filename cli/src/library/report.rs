//! What `flb library --json` prints (cli/schema/library.json).

use std::path::Path;

use flb_farm::Manifest;
use flb_farm::cache::Traffic;
use flb_farm::init::Surveyed;
use flb_farm::outcome::{Built, Outcome, Summary};
use flb_farm::parts::redone;
use flb_farm::plan::{Planned, State, Why};
use flb_farm::record::Record;
use flb_scene::Step;
use serde::Serialize;
use serde_json::Value;

use crate::exit::Failure;
use crate::print::say;

#[derive(Serialize)]
pub(super) struct Report {
    manifest: String,
    output: String,
    pub(super) species: Vec<SpeciesReport>,
    library_bytes: Option<u64>,
    left_over: Option<Vec<String>>,
    cache: Option<Traffic>,
}

#[derive(Serialize)]
pub(crate) struct SpeciesReport {
    pub(super) name: String,
    pub(super) state: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    why: Option<String>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    changes: Vec<ChangeReport>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    again: Vec<&'static str>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    reused: Vec<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) error: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    memory_bytes: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    bytes: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    seconds: Option<f64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    undecided: Vec<String>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    warnings: Vec<String>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    over_budget: Vec<String>,
}

#[derive(Serialize)]
struct ChangeReport {
    part: String,
    was: Option<Value>,
    is: Option<Value>,
}

impl Report {
    pub(super) fn new(manifest: &Manifest, species: Vec<SpeciesReport>) -> Report {
        Report::of(&manifest.path, &manifest.output, species)
    }

    pub(super) fn of(manifest: &Path, output: &Path, species: Vec<SpeciesReport>) -> Report {
        let [manifest, output] = [manifest, output].map(|path| path.display().to_string());
        Report { manifest, output, species, library_bytes: None, left_over: None, cache: None }
    }

    /// Of a build.
    pub(super) fn of_build(manifest: &Manifest, summary: &Summary, traffic: Traffic) -> Report {
        Report {
            cache: Some(traffic),
            library_bytes: summary.library_bytes,
            left_over: Some(summary.left_over.clone()),
            ..Report::new(manifest, summary.species.iter().map(SpeciesReport::of_built).collect())
        }
    }

    /// Number of species in a state.
    pub(super) fn count(&self, state: &str) -> usize {
        self.species.iter().filter(|one| one.state == state).count()
    }
}

impl SpeciesReport {
    fn new(name: &str, state: &'static str) -> SpeciesReport {
        SpeciesReport {
            name: name.to_owned(),
            state,
            why: None,
            changes: Vec::new(),
            again: Vec::new(),
            reused: Vec::new(),
            error: None,
            memory_bytes: None,
            bytes: None,
            seconds: None,
            undecided: Vec::new(),
            warnings: Vec::new(),
            over_budget: Vec::new(),
        }
    }

    /// A species that was looked at before any work.
    pub(super) fn of_check(name: &str, read: Result<Vec<String>, Failure>) -> SpeciesReport {
        match read {
            Ok(warnings) => SpeciesReport { warnings, ..SpeciesReport::new(name, "sound") },
            Err(error) => SpeciesReport { error: Some(error.message), ..SpeciesReport::new(name, "failed") },
        }
    }

    /// A mesh that a manifest is made of.
    pub(super) fn of_survey(one: Surveyed) -> SpeciesReport {
        let open = match one.undecided {
            Ok(open) => open,
            Err(error) => return SpeciesReport::of_check(&one.name, Err(error.into())),
        };
        let state = if open.is_empty() { "sound" } else { "undecided" };
        let undecided = open.into_iter().map(|material| material.name).collect();
        SpeciesReport { undecided, warnings: one.doubts, ..SpeciesReport::new(&one.name, state) }
    }

    /// Says on stderr what is wrong, undecided or doubted.
    pub(super) fn say_faults(&self) {
        let name = &self.name;
        self.error.iter().for_each(|error| say!("{name}: {error}"));
        if !self.undecided.is_empty() {
            let list: Vec<String> = self.undecided.iter().map(|material| format!("{material:?}")).collect();
            say!("{name}: leaf or wood? {}", list.join(", "));
        }
        self.warnings.iter().for_each(|warning| say!("warning: {name}: {warning}"));
    }

    /// A species of a plan.
    pub(super) fn of_planned(planned: Planned) -> SpeciesReport {
        let Planned { entry, state, memory_bytes, .. } = planned;
        let new = |state| SpeciesReport::new(&entry.name, state);
        match state {
            State::Failed(error) => SpeciesReport::of_check(&entry.name, Err(error.into())),
            State::Current(record) => new("current").with_record(&record),
            State::Stored(record) => new("stored").with_record(&record),
            State::Due(why) => {
                SpeciesReport { memory_bytes: Some(memory_bytes), ..new("due") }.with_why(&why)
            }
        }
    }

    pub(crate) fn of_built(built: &Built) -> SpeciesReport {
        let new = |state| SpeciesReport::new(&built.name, state);
        let one = match &built.outcome {
            Outcome::Current => new("current"),
            Outcome::Stored => new("stored"),
            Outcome::Made(why) => new("made").with_why(why),
            Outcome::Failed(error) => SpeciesReport { error: Some(error.to_string()), ..new("failed") },
            Outcome::Skipped => new("skipped"),
        };
        let one = SpeciesReport { over_budget: built.over.clone(), ..one };
        match &built.record {
            Some(record) => one.with_record(record),
            None => one,
        }
    }

    fn with_record(self, record: &Record) -> SpeciesReport {
        let facts = &record.facts;
        let (bytes, seconds) = (Some(facts.bytes), Some(facts.seconds));
        SpeciesReport { bytes, seconds, warnings: facts.warnings.clone(), ..self }
    }

    fn with_why(self, why: &Why) -> SpeciesReport {
        let names = |steps: &'static [Step]| steps.iter().map(|step| step.name()).collect();
        let (changes, again, reused) = match why {
            Why::Changed(changes) => {
                let (again, reused) = redone(changes);
                let change = |change: &flb_farm::parts::Change| ChangeReport {
                    part: change.part.clone(),
                    was: change.was.clone(),
                    is: change.is.clone(),
                };
                (changes.iter().map(change).collect(), names(again), names(reused))
            }
            Why::New | Why::Lost => Default::default(),
        };
        SpeciesReport { why: Some(why.to_string()), changes, again, reused, ..self }
    }

    /// The line of a plan.
    pub(super) fn line(&self) -> String {
        let name = &self.name;
        match self.state {
            "current" => format!("{name}: nothing to do: its file is of these very inputs and settings"),
            "stored" => format!("{name}: from the cache"),
            "due" => format!("{name}: to bake: {}", self.why.as_deref().unwrap_or_default()),
            _ => format!("{name}: cannot be baked: {}", self.error.as_deref().unwrap_or_default()),
        }
    }
}

//! Results of a build.

use crate::FarmError;
use crate::plan::Why;
use crate::record::Record;

/// Outcome of a species.
#[derive(Debug)]
pub enum Outcome {
    /// The file was there already.
    Current,
    /// The file came from the store.
    Stored,
    /// The species was made, for a reason.
    Made(Why),
    /// The species could not be made.
    Failed(FarmError),
    /// The species was not begun.
    Skipped,
}

/// A species that was built, or not.
#[derive(Debug)]
pub struct Built {
    /// Name of the species.
    pub name: String,
    /// Outcome.
    pub outcome: Outcome,
    /// Record, if the species is there.
    pub record: Option<Record>,
    /// Sentences on what goes over its budget.
    pub over: Vec<String>,
}

/// Result of a build.
#[derive(Debug)]
pub struct Summary {
    /// Every species that was asked for, in the order of the manifest.
    pub species: Vec<Built>,
    /// Bytes of the file of all species, if it is there.
    pub library_bytes: Option<u64>,
    /// Names of files of species that the manifest does not have.
    pub left_over: Vec<String>,
}

impl Summary {
    /// Species that could not be made.
    pub fn failed(&self) -> impl Iterator<Item = (&Built, &FarmError)> {
        self.species.iter().filter_map(|built| match &built.outcome {
            Outcome::Failed(error) => Some((built, error)),
            _ => None,
        })
    }

    /// Whether every species is there, converged and within its budget.
    pub fn is_whole(&self) -> bool {
        let is_there = |built: &Built| built.record.as_ref().is_some_and(|record| record.facts.is_converged);
        self.species.iter().all(|built| is_there(built) && built.over.is_empty())
    }
}

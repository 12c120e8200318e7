//! Work that a frame hands out, and what comes back of it.

use std::collections::VecDeque;
use std::io;
use std::sync::{Arc, Mutex, PoisonError};

use flb_format::FormatError;
use flb_format::error::Place;

use super::volumes::{Made, Wanted, make};
use crate::Library;
use crate::residency::{UnitId, Units};
use crate::resident::{Payload, ResidentSpecies};
use crate::stream::{self, Job};

/// What came of work.
pub(super) enum Done {
    Read(Vec<(UnitId, Result<Payload, FormatError>)>),
    /// Some of the volumes of a species, before the others.
    Some(usize, Made),
    /// All of them; `None` where they were not made.
    Light(usize, Option<Made>),
}

/// Outcomes of work, until a frame takes them.
#[derive(Default)]
pub(super) struct Inbox(Mutex<VecDeque<Done>>);

impl Inbox {
    pub(super) fn next(&self) -> Option<Done> {
        // The lock is never held where anything could panic.
        self.0.lock().unwrap_or_else(PoisonError::into_inner).pop_front()
    }

    fn push(&self, done: Done) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push_back(done);
    }
}

/// A piece of work, to be run once on any thread. Reads wait for the file, light takes some tenths of a second to
/// some seconds.
pub struct Work {
    task: Option<Task>,
    inbox: Arc<Inbox>,
}

enum Task {
    Read { library: Arc<Library>, units: Arc<Units>, job: Job },
    Light { number: usize, species: Arc<ResidentSpecies>, wanted: Wanted },
}

impl Work {
    pub(super) fn read(library: Arc<Library>, units: &Arc<Units>, job: Job, inbox: &Arc<Inbox>) -> Work {
        let task = Task::Read { library, units: Arc::clone(units), job };
        Work { task: Some(task), inbox: Arc::clone(inbox) }
    }

    pub(super) fn light(
        number: usize,
        species: Arc<ResidentSpecies>,
        wanted: Wanted,
        inbox: &Arc<Inbox>,
    ) -> Work {
        let task = Task::Light { number, species, wanted };
        Work { task: Some(task), inbox: Arc::clone(inbox) }
    }

    /// True of work that computes rather than waits for a file: one thread of an engine may be enough for such work.
    pub fn is_light(&self) -> bool {
        matches!(self.task, Some(Task::Light { .. }))
    }

    /// Does it.
    pub fn run(mut self) {
        let Some(task) = &self.task else { return };
        let done = match task {
            Task::Read { library, units, job } => Done::Read(stream::read(library, units, job)),
            Task::Light { number, species, wanted } => {
                let some = |made| self.inbox.push(Done::Some(*number, made));
                Done::Light(*number, Some(make(species, wanted, some)))
            }
        };
        self.task = None;
        self.inbox.push(done);
    }
}

impl Drop for Work {
    /// Work that was not done is told as such.
    fn drop(&mut self) {
        let done = match self.task.take() {
            None => return,
            Some(Task::Read { job, .. }) => {
                Done::Read(job.units.into_iter().map(|(unit, _)| not_read(unit)).collect())
            }
            Some(Task::Light { number, .. }) => Done::Light(number, None),
        };
        self.inbox.push(done);
    }
}

fn not_read(unit: UnitId) -> (UnitId, Result<Payload, FormatError>) {
    let source = io::Error::new(io::ErrorKind::Interrupted, "the work was dropped");
    (unit, Err(FormatError::Read { place: Place::file(0), bytes: 0, source }))
}

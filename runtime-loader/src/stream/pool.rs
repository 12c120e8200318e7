//! Threads that take jobs in order and send back what they read.

use std::collections::VecDeque;
use std::io;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use flb_format::FormatError;

use super::job::{Job, read};
use crate::Library;
use crate::residency::{UnitId, Units};
use crate::resident::Payload;

type Outcome = (UnitId, Result<Payload, FormatError>);

/// Jobs that wait; `None` when the workers are to end.
#[derive(Default)]
struct Queue {
    jobs: Mutex<Option<VecDeque<Job>>>,
    changed: Condvar,
}

impl Queue {
    /// The next job, once there is one; `None` at the end.
    fn next(&self) -> Option<Job> {
        // The lock is never held where anything could panic.
        let mut jobs = self.jobs.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            if let Some(job) = jobs.as_mut()?.pop_front() {
                return Some(job);
            }
            jobs = self.changed.wait(jobs).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

/// The threads. Dropped, they end by themselves, each when the read that it is at returns: a disk that hangs keeps
/// no caller waiting.
pub(super) struct Pool {
    queue: Arc<Queue>,
    /// Never locked: what is within makes a streamer that threads share.
    results: Mutex<Receiver<Outcome>>,
}

impl Pool {
    pub(super) fn new(library: &Arc<Library>, units: &Arc<Units>, workers: usize) -> io::Result<Pool> {
        let queue = Arc::new(Queue { jobs: Mutex::new(Some(VecDeque::new())), changed: Condvar::new() });
        let (sender, results) = channel();
        // Made first, so that threads that did start end if another one does not.
        let pool = Pool { queue, results: Mutex::new(results) };
        for _ in 0..workers {
            let (queue, sender) = (Arc::clone(&pool.queue), Sender::clone(&sender));
            let (library, units) = (Arc::clone(library), Arc::clone(units));
            thread::Builder::new().name("flb-stream".to_owned()).spawn(move || {
                while let Some(job) = queue.next() {
                    for outcome in read(&library, &units, &job) {
                        // The receiver is gone when the streamer was dropped; then the queue says so, too.
                        let _ = sender.send(outcome);
                    }
                }
            })?;
        }
        Ok(pool)
    }

    pub(super) fn send(&self, job: Job) {
        let mut jobs = self.queue.jobs.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(jobs) = jobs.as_mut() {
            jobs.push_back(job);
        }
        drop(jobs);
        self.queue.changed.notify_one();
    }

    /// What came since the last time.
    pub(super) fn came(&mut self) -> impl Iterator<Item = Outcome> {
        self.results().try_iter()
    }

    /// The same, after waiting for the first.
    pub(super) fn wait(&mut self, most: Duration) -> impl Iterator<Item = Outcome> {
        let results = self.results();
        results.recv_timeout(most).ok().into_iter().chain(results.try_iter())
    }

    fn results(&mut self) -> &Receiver<Outcome> {
        self.results.get_mut().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Pool {
    fn drop(&mut self) {
        *self.queue.jobs.lock().unwrap_or_else(PoisonError::into_inner) = None;
        self.queue.changed.notify_all();
    }
}

//! Which species is made when: the heaviest first, as long as cores and memory are free.

use std::sync::atomic::Ordering;
use std::sync::{Condvar, Mutex, PoisonError};

use rayon::ThreadPoolBuilder;

use super::{BuildSettings, Built, OnFailure, Outcome, Work};
use crate::FarmError;
use crate::plan::{Planned, State};

/// Species that wait, and what those that are being made take.
struct Queue {
    /// Place in the answer, and the species; the lightest first.
    waiting: Vec<(usize, Planned)>,
    memory_bytes: u64,
    running: usize,
}

/// Brings every species to its place; answers in the order given.
pub(super) fn run(
    species: Vec<Planned>,
    settings: &BuildSettings,
    work: &Work,
) -> Result<Vec<Built>, FarmError> {
    let names: Vec<String> = species.iter().map(|planned| planned.entry.name.clone()).collect();
    let is_due = |planned: &Planned| matches!(planned.state, State::Due(_));
    let due = species.iter().filter(|planned| is_due(planned)).count();
    let jobs = settings.jobs.clamp(1, due.max(1));
    let threads = (settings.threads / jobs).max(1);
    let mut waiting: Vec<(usize, Planned)> = species.into_iter().enumerate().collect();
    // What is there already comes last in the list, which is taken from its end.
    waiting.sort_by_key(|(at, planned)| (!is_due(planned), planned.memory_bytes, std::cmp::Reverse(*at)));
    let queue = Mutex::new(Queue { waiting, memory_bytes: 0, running: 0 });
    let freed = Condvar::new();
    let built: Mutex<Vec<(usize, Built)>> = Mutex::default();
    let pools = (0..jobs).map(|_| ThreadPoolBuilder::new().num_threads(threads).build());
    let pools =
        pools.collect::<Result<Vec<_>, _>>().map_err(|error| FarmError::Threads(error.to_string()))?;
    std::thread::scope(|scope| {
        for pool in &pools {
            scope.spawn(|| {
                while let Some((at, planned)) = next(&queue, &freed, settings.memory_bytes, work) {
                    let bytes = planned.memory_bytes;
                    let one = pool.install(|| work.one(planned));
                    if matches!(one.outcome, Outcome::Failed(_)) && settings.on_failure == OnFailure::Stop {
                        work.has_failed.store(true, Ordering::Relaxed);
                    }
                    let mut queue = queue.lock().unwrap_or_else(PoisonError::into_inner);
                    (queue.memory_bytes, queue.running) = (queue.memory_bytes - bytes, queue.running - 1);
                    freed.notify_all();
                    drop(queue);
                    built.lock().unwrap_or_else(PoisonError::into_inner).push((at, one));
                }
            });
        }
    });
    let mut all: Vec<Option<Built>> = names.iter().map(|_| None).collect();
    for (at, one) in built.into_inner().unwrap_or_else(PoisonError::into_inner) {
        all[at] = Some(one);
    }
    let skipped = |name: &String| Built {
        name: name.clone(),
        outcome: Outcome::Skipped,
        record: None,
        over: Vec::new(),
    };
    Ok(all.into_iter().zip(&names).map(|(one, name)| one.unwrap_or_else(|| skipped(name))).collect())
}

/// The heaviest species that fits, or any where none is being made; `None` where none waits.
fn next(queue: &Mutex<Queue>, freed: &Condvar, memory_bytes: u64, work: &Work) -> Option<(usize, Planned)> {
    let mut queue = queue.lock().unwrap_or_else(PoisonError::into_inner);
    loop {
        if queue.waiting.is_empty() || work.is_stopped() {
            return None;
        }
        let free = memory_bytes.saturating_sub(queue.memory_bytes);
        let fits = queue.waiting.iter().rposition(|(_, planned)| planned.memory_bytes <= free);
        if let Some(at) = fits.or((queue.running == 0).then(|| queue.waiting.len() - 1)) {
            let found = queue.waiting.remove(at);
            queue.memory_bytes += found.1.memory_bytes;
            queue.running += 1;
            return Some(found);
        }
        queue = freed.wait(queue).unwrap_or_else(PoisonError::into_inner);
    }
}

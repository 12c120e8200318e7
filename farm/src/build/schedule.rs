//! Which species is made when: the heaviest first, as long as cores and memory are free.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Condvar, Mutex, PoisonError};

use rayon::ThreadPoolBuilder;

use super::{BuildSettings, Built, OnFailure, Outcome, Work};
use crate::FarmError;
use crate::plan::{Planned, State};

/// Species that wait, and what those that are being made take.
struct Queue {
    /// Place in the answer, and the species; the lightest first.
    waiting: Vec<(usize, Planned)>,
    room: Room,
}

/// Memory of what is being made.
#[derive(Default)]
struct Room {
    memory_bytes: u64,
    running: usize,
    /// Those of them that wait until there is memory for what they are known to take.
    held: usize,
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
    let queue = Mutex::new(Queue { waiting, room: Room::default() });
    let freed = Condvar::new();
    let built: Mutex<Vec<(usize, Built)>> = Mutex::default();
    let pools = (0..jobs).map(|_| ThreadPoolBuilder::new().num_threads(threads).build());
    let pools =
        pools.collect::<Result<Vec<_>, _>>().map_err(|error| FarmError::Threads(error.to_string()))?;
    std::thread::scope(|scope| {
        for pool in &pools {
            scope.spawn(|| {
                while let Some((at, planned)) = next(&queue, &freed, settings.memory_bytes, work) {
                    let claim = AtomicU64::new(planned.memory_bytes);
                    let weigh = |bytes| weigh(&queue, &freed, settings.memory_bytes, &claim, bytes);
                    let one = pool.install(|| work.one(planned, &weigh));
                    if matches!(one.outcome, Outcome::Failed(_)) && settings.on_failure == OnFailure::Stop {
                        work.has_failed.store(true, Ordering::Relaxed);
                    }
                    let mut queue = queue.lock().unwrap_or_else(PoisonError::into_inner);
                    queue.room.memory_bytes -= claim.into_inner();
                    queue.room.running -= 1;
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
        let free = memory_bytes.saturating_sub(queue.room.memory_bytes);
        // What becomes free is first for those that wait with their work begun.
        let fits = (queue.room.held == 0)
            .then(|| queue.waiting.iter().rposition(|(_, planned)| planned.memory_bytes <= free))
            .flatten();
        if let Some(at) = fits.or((queue.room.running == 0).then(|| queue.waiting.len() - 1)) {
            let found = queue.waiting.remove(at);
            queue.room.memory_bytes += found.1.memory_bytes;
            queue.room.running += 1;
            return Some(found);
        }
        queue = freed.wait(queue).unwrap_or_else(PoisonError::into_inner);
    }
}

/// Changes the memory that a species claims to what it is known to take. Where there is no room for that, waits until
/// another ends: one of those that are being made never waits, so that there is always an end to wait for.
fn weigh(queue: &Mutex<Queue>, freed: &Condvar, memory_bytes: u64, claim: &AtomicU64, bytes: u64) {
    let mut queue = queue.lock().unwrap_or_else(PoisonError::into_inner);
    let claimed = claim.load(Ordering::Relaxed);
    let fits = |room: &Room| bytes <= claimed || room.memory_bytes - claimed + bytes <= memory_bytes;
    while !fits(&queue.room) && queue.room.running - queue.room.held > 1 {
        queue.room.held += 1;
        queue = freed.wait(queue).unwrap_or_else(PoisonError::into_inner);
        queue.room.held -= 1;
    }
    queue.room.memory_bytes = queue.room.memory_bytes - claimed + bytes;
    claim.store(bytes, Ordering::Relaxed);
    freed.notify_all();
}

#[cfg(test)]
mod tests {
    use std::thread;
    use std::time::Duration;

    use super::*;

    const LIMIT: u64 = 100;

    fn queue(claims: &[u64]) -> Mutex<Queue> {
        let room = Room { memory_bytes: claims.iter().sum(), running: claims.len(), held: 0 };
        Mutex::new(Queue { waiting: Vec::new(), room })
    }

    fn held(queue: &Mutex<Queue>) -> usize {
        queue.lock().expect("no holder panics").room.held
    }

    #[test]
    fn a_species_that_takes_more_than_was_expected_waits_for_another_to_end() {
        let (queue, freed) = (queue(&[40, 40]), Condvar::new());
        let claims = [AtomicU64::new(40), AtomicU64::new(40)];
        weigh(&queue, &freed, LIMIT, &claims[0], 60);
        thread::scope(|scope| {
            let second = scope.spawn(|| weigh(&queue, &freed, LIMIT, &claims[1], 50));
            while held(&queue) == 0 {
                thread::sleep(Duration::from_millis(1));
            }
            assert!(!second.is_finished());
            let mut lock = queue.lock().expect("no holder panics");
            assert_eq!(lock.room.memory_bytes, 100);
            (lock.room.memory_bytes, lock.room.running) = (40, 1);
            drop(lock);
            freed.notify_all();
        });
        assert_eq!(queue.lock().expect("no holder panics").room.memory_bytes, 50);
    }

    #[test]
    fn one_never_waits() {
        let (queue, freed) = (queue(&[40, 40]), Condvar::new());
        let claims = [AtomicU64::new(40), AtomicU64::new(40)];
        thread::scope(|scope| {
            let first = scope.spawn(|| weigh(&queue, &freed, LIMIT, &claims[0], 90));
            while held(&queue) == 0 {
                thread::sleep(Duration::from_millis(1));
            }
            weigh(&queue, &freed, LIMIT, &claims[1], 90);
            assert!(!first.is_finished(), "it waits for the other");
            let mut lock = queue.lock().expect("no holder panics");
            assert_eq!((lock.room.memory_bytes, lock.room.held), (130, 1));
            (lock.room.memory_bytes, lock.room.running) = (40, 1);
            drop(lock);
            freed.notify_all();
        });
        assert_eq!(claims.map(AtomicU64::into_inner), [90, 90]);
        // Less is never waited for.
        let claim = AtomicU64::new(90);
        weigh(&queue, &freed, LIMIT, &claim, 10);
        assert_eq!(queue.lock().expect("no holder panics").room.memory_bytes, 10);
    }
}

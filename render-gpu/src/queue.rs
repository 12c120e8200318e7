//! Pieces of work that are handed out to threads one by one, and come back where a thread fails: what one cannot do
//! another does.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// Pieces, by their numbers.
pub(crate) struct Queue {
    state: Mutex<State>,
    changed: Condvar,
}

struct State {
    /// `[piece]`
    is_open: Vec<bool>,
    at_work: usize,
    is_stopped: bool,
}

/// A piece at work. Dropped unfinished, it is open again.
pub(crate) struct Piece<'q> {
    queue: &'q Queue,
    pub number: usize,
    is_finished: bool,
}

impl Queue {
    pub(crate) fn new(pieces: usize) -> Queue {
        let state = State { is_open: vec![true; pieces], at_work: 0, is_stopped: false };
        Queue { state: Mutex::new(state), changed: Condvar::new() }
    }

    /// The open piece that ranks lowest, after waiting for pieces that may come back; nothing once all are done, or
    /// were stopped.
    pub(crate) fn take(&self, rank: impl Fn(usize) -> usize) -> Option<Piece<'_>> {
        let mut state = self.lock();
        loop {
            if state.is_stopped {
                return None;
            }
            let open = (0..state.is_open.len()).filter(|piece| state.is_open[*piece]);
            if let Some(number) = open.min_by_key(|piece| rank(*piece)) {
                state.is_open[number] = false;
                state.at_work += 1;
                return Some(Piece { queue: self, number, is_finished: false });
            }
            if state.at_work == 0 {
                return None;
            }
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Hands out nothing more.
    pub(crate) fn stop(&self) {
        self.lock().is_stopped = true;
        self.changed.notify_all();
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Piece<'_> {
    pub(crate) fn finish(mut self) {
        self.is_finished = true;
    }
}

impl Drop for Piece<'_> {
    fn drop(&mut self) {
        let mut state = self.queue.lock();
        state.at_work -= 1;
        state.is_open[self.number] = !self.is_finished;
        drop(state);
        self.queue.changed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::thread;

    use super::*;

    #[test]
    fn every_piece_is_finished_once_whichever_gpu_fails() {
        let queue = Queue::new(50);
        let finished: Vec<AtomicUsize> = (0..50).map(|_| AtomicUsize::new(0)).collect();
        thread::scope(|scope| {
            for worker in 0..4 {
                let (queue, finished) = (&queue, &finished);
                scope.spawn(move || {
                    let mut done = 0;
                    while let Some(piece) = queue.take(|piece| (piece + worker) % 50) {
                        // All but one give up on the way, with a piece in hand.
                        if worker > 0 && done == 3 * worker {
                            return;
                        }
                        finished[piece.number].fetch_add(1, Ordering::Relaxed);
                        piece.finish();
                        done += 1;
                    }
                });
            }
        });
        assert!(finished.iter().all(|times| times.load(Ordering::Relaxed) == 1));
    }

    #[test]
    fn the_lowest_rank_is_taken_and_nothing_after_a_stop() {
        let queue = Queue::new(3);
        let first = queue.take(|piece| 3 - piece).unwrap();
        assert_eq!(first.number, 2);
        drop(first);
        assert_eq!(queue.take(|piece| 3 - piece).unwrap().number, 2);
        queue.stop();
        assert!(queue.take(|piece| piece).is_none());
    }
}

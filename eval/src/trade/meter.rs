//! Time and memory of the steps of a bake.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use flb_baker::bake::{BakeObserver, Event};
use flb_scene::{Observer, Step};

use super::heap::Heap;

/// Time and memory of steps.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Cost {
    /// Wall time of all steps.
    pub seconds: f64,
    /// Most bytes of heap in use.
    pub peak_bytes: u64,
}

impl Cost {
    /// Of one after the other.
    pub(super) fn and(&self, other: &Cost) -> Cost {
        Cost { seconds: self.seconds + other.seconds, peak_bytes: self.peak_bytes.max(other.peak_bytes) }
    }
}

/// Observer that measures steps, and tells another.
pub(super) struct Meter<'a> {
    observer: &'a dyn BakeObserver,
    heap: &'a dyn Heap,
    state: Mutex<(Option<Instant>, Cost)>,
}

impl<'a> Meter<'a> {
    pub(super) fn new(observer: &'a dyn BakeObserver, heap: &'a dyn Heap) -> Meter<'a> {
        Meter { observer, heap, state: Mutex::default() }
    }

    /// Returns what was measured; `held` bytes are what is kept beside, which a bake alone does not.
    pub(super) fn cost(&self, held: u64) -> Cost {
        let (_, Cost { seconds, peak_bytes }) = *self.state();
        Cost { seconds, peak_bytes: peak_bytes.saturating_sub(held) }
    }

    fn state(&self) -> MutexGuard<'_, (Option<Instant>, Cost)> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Observer for Meter<'_> {
    fn begin(&self, step: Step, subject: &str) {
        self.observer.begin(step, subject);
        self.heap.reset_peak();
        self.state().0 = Some(Instant::now());
    }

    fn progress(&self, share: f64) {
        self.observer.progress(share);
    }

    fn end(&self, step: Step) {
        {
            let mut state = self.state();
            if let Some(start) = state.0.take() {
                let peak_bytes = self.heap.peak_bytes();
                state.1 = state.1.and(&Cost { seconds: start.elapsed().as_secs_f64(), peak_bytes });
            }
        }
        self.observer.end(step);
    }

    fn note(&self, text: &str) {
        self.observer.note(text);
    }

    fn is_cancelled(&self) -> bool {
        self.observer.is_cancelled()
    }
}

impl BakeObserver for Meter<'_> {
    fn hear(&self, event: &Event) {
        self.observer.hear(event);
    }
}

//! The light of many plants at points that lie near one another, asked from many threads.

use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, TryLockError};
use std::thread::available_parallelism;

use super::{InstanceLight, LightCursor};

/// Cursors that a thread keeps: rays of neighbouring pixels mostly meet the same few plants.
const KEPT: usize = 8;
/// A program may run more threads than there are cores.
const SLOTS_PER_CORE: usize = 4;

/// Cursors over the light of plants, for renderers that shade points from many threads.
///
/// ```
/// # fn main() -> Result<(), flb_runtime::RuntimeError> {
/// # use flb_runtime::{Daylight, Library, SpeciesLight, Transform};
/// # use flb_runtime::light::LightCursors;
/// # let library = Library::open("golden/shrub.flb")?;
/// # let shrub = SpeciesLight::load(&library, 0)?;
/// # let noon = Daylight { towards_sun: [0.0, 1.0, 0.0], sun: 1.0, sky: 0.36 };
/// let plants = [Some(shrub.lit_by(&noon, &Transform::IDENTITY)?), None];
/// let cursors = LightCursors::new(&plants);
/// let (mut rgb, mut dark) = ([0.0; 3], [1.0; 3]);
/// cursors.at(0, [0.5, 3.0, -0.2], &mut rgb); // from any thread
/// cursors.at(1, [0.5, 3.0, -0.2], &mut dark);
/// assert!(rgb[1] > 0.0 && dark == [0.0; 3]);
/// # Ok(())
/// # }
/// ```
///
/// Each thread finds the cursors that it used before: those of the last plants, 8 at most, each as large as
/// [`LightCursor`] says. A thread waits for others only where more than 4 for each core ask at once.
///
/// The number of threads changes no bit of the light. Which cursor answers depends on chance, but a cursor gives a
/// point the same light whatever it was asked before: that of a new [`LightCursor`].
pub struct LightCursors<'a> {
    plants: &'a [Option<InstanceLight<'a>>],
    slots: Box<[Slot<'a>]>,
}

/// The cursors of one thread. Two never share a line of a cache.
#[repr(align(128))]
struct Slot<'a>(Mutex<ByPlant<LightCursor<'a>>>);

/// What belongs to plants. Those whose numbers differ by a multiple of [`KEPT`] take each other's place.
struct ByPlant<T>([Option<(usize, T)>; KEPT]);

impl<'a> LightCursors<'a> {
    /// Makes cursors over plants by number; `None` is a plant without light. Nothing is kept before the first point.
    pub fn new(plants: &'a [Option<InstanceLight<'a>>]) -> LightCursors<'a> {
        let cores = available_parallelism().map_or(1, NonZeroUsize::get);
        LightCursors::with_slots(plants, SLOTS_PER_CORE * cores)
    }

    pub(super) fn with_slots(plants: &'a [Option<InstanceLight<'a>>], slots: usize) -> LightCursors<'a> {
        let slots = (0..slots).map(|_| Slot(Mutex::new(ByPlant::new()))).collect();
        LightCursors { plants, slots }
    }

    /// Light per band at a point of a plant's model at rest, as [`LightCursor::at`] has it; 0 of a plant without light.
    ///
    /// # Panics
    /// If there is no such plant, or `out` is shorter than its bands.
    pub fn at(&self, plant: usize, point_m: [f32; 3], out: &mut [f32]) {
        self.at_facing(plant, point_m, None, out);
    }

    /// Light per band at a point of a plant before a solid, as [`LightCursor::at_facing`] has it; 0 of a plant without
    /// light.
    ///
    /// # Panics
    /// As [`LightCursors::at`].
    pub fn at_facing(&self, plant: usize, point_m: [f32; 3], facing: Option<[f32; 3]>, out: &mut [f32]) {
        match &self.plants[plant] {
            Some(light) => self.slot().of(plant, || light.cursor()).at_facing(point_m, facing, out),
            None => out.fill(0.0),
        }
    }

    /// The thread's own, else the next one that no thread is using.
    fn slot(&self) -> MutexGuard<'_, ByPlant<LightCursor<'a>>> {
        let (before, from) = self.slots.split_at(thread_number() % self.slots.len());
        let free = from.iter().chain(before).find_map(Slot::try_lock);
        free.unwrap_or_else(|| from[0].lock())
    }
}

/// Of this thread, from 0 in the order in which threads first ask.
fn thread_number() -> usize {
    static THREADS: AtomicUsize = AtomicUsize::new(0);
    thread_local!(static NUMBER: usize = THREADS.fetch_add(1, Ordering::Relaxed));
    NUMBER.with(|number| *number)
}

impl<'a> Slot<'a> {
    fn try_lock(&self) -> Option<MutexGuard<'_, ByPlant<LightCursor<'a>>>> {
        match self.0.try_lock() {
            Ok(kept) => Some(kept),
            Err(TryLockError::WouldBlock) => None,
            Err(TryLockError::Poisoned(kept)) => Some(self.emptied(kept.into_inner())),
        }
    }

    fn lock(&self) -> MutexGuard<'_, ByPlant<LightCursor<'a>>> {
        self.0.lock().unwrap_or_else(|kept| self.emptied(kept.into_inner()))
    }

    /// A thread that panicked may have left a block half expanded.
    fn emptied<'k>(
        &self,
        mut kept: MutexGuard<'k, ByPlant<LightCursor<'a>>>,
    ) -> MutexGuard<'k, ByPlant<LightCursor<'a>>> {
        *kept = ByPlant::new();
        self.0.clear_poison();
        kept
    }
}

impl<T> ByPlant<T> {
    fn new() -> ByPlant<T> {
        ByPlant(std::array::from_fn(|_| None))
    }

    /// That of a plant, made if it is not kept.
    fn of(&mut self, plant: usize, make: impl FnOnce() -> T) -> &mut T {
        let kept = &mut self.0[plant % KEPT];
        if kept.as_ref().is_some_and(|(number, _)| *number != plant) {
            *kept = None; // frees its memory for the next one
        }
        &mut kept.get_or_insert_with(|| (plant, make())).1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_plants_as_fit_are_kept_and_the_next_takes_the_place_of_one() {
        let (mut kept, mut made) = (ByPlant::new(), Vec::new());
        let mut ask = |plant: usize| {
            let found = *kept.of(plant, || {
                made.push(plant);
                10 * plant
            });
            assert_eq!(found, 10 * plant);
        };
        (0..KEPT).chain(0..KEPT).for_each(&mut ask);
        ask(KEPT + 3);
        ask(4);
        ask(KEPT + 3);
        ask(3);
        assert_eq!(made[..KEPT], (0..KEPT).collect::<Vec<_>>());
        assert_eq!(made[KEPT..], [KEPT + 3, 3], "4 stayed, 3 was made again");
    }

    #[test]
    fn threads_have_numbers_of_their_own() {
        let mine = thread_number();
        assert_eq!(thread_number(), mine);
        let other = std::thread::spawn(|| [thread_number(), thread_number()]).join().expect("no panic");
        assert!(other[0] == other[1] && other[0] != mine, "{other:?} and {mine}");
    }
}

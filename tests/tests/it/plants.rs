//! The built-in plants with the papers' light, each baked once for all tests of this program, on one thread.

use std::sync::OnceLock;

use flb_fixtures::PlantKind;
use flb_tests::pipeline::{Baked, Recipe, bake};

/// Does work in a pool of so many threads.
pub(crate) fn with_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
    pool.install(work)
}

/// A plant as [`Recipe::small`] has it.
pub(crate) fn baked(kind: PlantKind) -> &'static Baked {
    static PLANTS: [OnceLock<Baked>; PlantKind::ALL.len()] =
        [const { OnceLock::new() }; PlantKind::ALL.len()];
    let place = PlantKind::ALL.iter().position(|one| *one == kind).expect("one of all");
    PLANTS[place].get_or_init(|| with_threads(1, || bake(&Recipe::small(kind))))
}

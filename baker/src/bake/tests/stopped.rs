//! Bakes that their observer stops, and those whose observer panics.

use std::collections::HashSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use flb_format::matter::{LeafAngles, TurbidMedium};
use flb_format::{Grid, Placement, Transform};
use flb_scene::leaf::knapp_carter;
use flb_transport::lattice::SolverKind;

use super::*;

/// Says stop when it is asked for the n-th time, and from then on.
struct Stopper {
    stop_at: usize,
    /// Steps that had begun at each question.
    asked: Mutex<Vec<usize>>,
    begun: Mutex<Vec<Step>>,
    ended: AtomicUsize,
}

impl Observer for Stopper {
    fn begin(&self, step: Step, _: &str) {
        self.begun.lock().expect("no test panics inside").push(step);
    }

    fn end(&self, _: Step) {
        // A step that is stopped returns. One that is unwound does not count.
        self.ended.fetch_add(usize::from(!std::thread::panicking()), Ordering::Relaxed);
    }

    fn is_cancelled(&self) -> bool {
        let begun = self.begun.lock().expect("no test panics inside").len();
        let mut asked = self.asked.lock().expect("no test panics inside");
        asked.push(begun);
        asked.len() >= self.stop_at
    }
}

impl BakeObserver for Stopper {}

impl Stopper {
    fn at(stop_at: usize) -> Stopper {
        Stopper { stop_at, asked: Mutex::default(), begun: Mutex::default(), ended: AtomicUsize::new(0) }
    }

    /// Questions to stop at: before the first step, and in each its second, or else its only one.
    fn stops(self) -> Vec<usize> {
        let asked = self.asked.into_inner().expect("alone");
        let steps = asked.last().map_or(0, |last| last + 1);
        let in_step = |step: usize| (1..).zip(&asked).filter(move |(_, begun)| **begun == step);
        (0..steps).filter_map(|step| in_step(step).take(2).last()).map(|(question, _)| question).collect()
    }
}

/// Settings under which every step runs that a model has.
fn all_steps() -> [(BakeSettings, &'static [Step]); 2] {
    let mut judged = quick();
    let ModelSettings::Physical(physical) = &mut judged.model else { panic!("the other model") };
    physical.monte_carlo_suns = 1;
    let of_physical =
        &[Step::Voxelise, Step::Downsample, Step::Crown, Step::Solve, Step::MonteCarlo, Step::Solids];
    [(judged, of_physical), (paper(), &[Step::Voxelise, Step::Downsample, Step::Solve])]
}

#[test]
fn a_bake_stops_between_stages_and_inside_them_and_leaves_nothing_half_made() {
    for (settings, steps) in all_steps() {
        let alone = bake(plant("fern"), &settings, &NoStore, &Unobserved).expect("a good plant");
        let patient = Stopper::at(usize::MAX);
        bake(plant("fern"), &settings, &NoStore, &patient).expect("nothing stops it");
        assert_eq!(*patient.begun.lock().expect("alone"), steps);
        let mut stopped_in = HashSet::new();
        for stop_at in patient.stops() {
            let (stopper, shelf) = (Stopper::at(stop_at), Shelf::default());
            let ended = bake(plant("fern"), &settings, &shelf, &stopper);
            assert!(matches!(ended, Err(BakeError::Cancelled)), "{stop_at}: {ended:?}");
            let begun = stopper.begun.into_inner().expect("alone");
            assert_eq!(begun.len(), stopper.ended.into_inner(), "{stop_at}");
            stopped_in.extend(begun.last().copied());
            // What was kept before is whole.
            let resumed = bake(plant("fern"), &settings, &shelf, &Unobserved).expect("a good plant");
            assert!(resumed == alone, "{stop_at}");
            assert!(shelf.refused.into_inner().expect("alone").is_empty(), "{stop_at}");
        }
        assert_eq!(stopped_in.len(), steps.len(), "each step is stopped once it has begun");
    }
}

#[test]
fn every_solver_of_the_cpu_stops_soon() {
    /// Stops at a question of the solve.
    struct InSolve {
        stop_at: usize,
        solves: AtomicBool,
        asked: AtomicUsize,
    }
    impl Observer for InSolve {
        fn begin(&self, step: Step, _: &str) {
            self.solves.store(step == Step::Solve, Ordering::Relaxed);
        }
        fn is_cancelled(&self) -> bool {
            self.solves.load(Ordering::Relaxed)
                && self.asked.fetch_add(1, Ordering::Relaxed) + 1 >= self.stop_at
        }
    }
    impl BakeObserver for InSolve {}
    let bake_until = |settings: &BakeSettings, stop_at: usize| {
        let observer = InSolve { stop_at, solves: AtomicBool::new(false), asked: AtomicUsize::new(0) };
        let ended = bake(plant("fern"), settings, &NoStore, &observer);
        (ended, observer.asked.into_inner())
    };
    for solver in [SolverKind::Sweep, SolverKind::Explicit, SolverKind::Literal] {
        let model = ModelSettings::Paper(PaperSettings { solver, ..PaperSettings::default() });
        let settings = BakeSettings { model, ..quick() };
        let (_, all) = bake_until(&settings, usize::MAX);
        let (ended, asked) = bake_until(&settings, 3);
        assert!(matches!(ended, Err(BakeError::Cancelled)), "{solver:?}: {ended:?}");
        // Threads that solve other groups hear of it when they ask.
        assert!(asked < all / 2, "{solver:?} asked {asked} times, and {all} times when it was not stopped");
    }
}

#[test]
fn a_panic_of_the_observer_reaches_who_called() {
    struct Broken;
    impl Observer for Broken {
        fn progress(&self, _: f64) {
            panic!("the bar is broken");
        }
    }
    impl BakeObserver for Broken {}
    let bake = || bake(plant("fern"), &quick(), &NoStore, &Broken);
    let payload = catch_unwind(AssertUnwindSafe(bake)).expect_err("a panic is no cancelling");
    assert_eq!(payload.downcast_ref::<&str>(), Some(&"the bar is broken"));
}

#[test]
fn the_bake_of_a_scene_stops_in_every_step() {
    let grid = Grid { lattice: 16, origin_m: [-1.0; 3], spacing_m: 0.125 };
    let is_bush = |site: usize| grid.site(site).iter().all(|c| (4..12).contains(c));
    let leaf_per_m = (0..grid.sites()).map(|site| if is_bush(site) { 1.0 } else { 0.0 }).collect();
    let wood_per_m = vec![0.0; grid.sites()];
    let bush = TurbidMedium { grid, leaf_per_m, wood_per_m, angles: LeafAngles::spherical() };
    let scene = PlantedScene {
        plants: vec![ScenePlant::new("bush", bush, &knapp_carter(), FieldKind::Scattered).expect("a bush")],
        instances: vec![Placement { species: 0, transform: Transform::IDENTITY }],
        ground: None,
        digest: "a bush".to_owned(),
    };
    let settings = SceneSettings { lattice: 16, ..SceneSettings::default() };
    let patient = Stopper::at(usize::MAX);
    bake_scene(&scene, &settings, &NoStore, &patient).expect("nothing stops it");
    for stop_at in patient.stops() {
        let stopper = Stopper::at(stop_at);
        let ended = bake_scene(&scene, &settings, &NoStore, &stopper).map(drop);
        assert!(matches!(ended, Err(BakeError::Cancelled)), "{stop_at}: {ended:?}");
        assert_eq!(stopper.begun.into_inner().expect("alone").len(), stopper.ended.into_inner(), "{stop_at}");
    }
}

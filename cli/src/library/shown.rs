//! What `flb library build` says while it works.

use std::sync::atomic::{AtomicUsize, Ordering};

use flb_farm::Plan;
use flb_farm::build::BuildObserver;
use flb_farm::outcome::{Built, Outcome};
use flb_farm::plan::{Planned, State};
use flb_scene::Step;

use crate::print::{self, say};

/// Says on stderr what becomes of each species.
#[derive(Default)]
pub(super) struct Shown {
    total: AtomicUsize,
    ended: AtomicUsize,
}

impl BuildObserver for Shown {
    fn planned(&self, plan: &Plan) {
        let is_quiet = |planned: &&Planned| matches!(planned.state, State::Current(_));
        self.total.store(plan.species.iter().filter(|planned| !is_quiet(planned)).count(), Ordering::Relaxed);
    }

    fn at(&self, species: &str, step: Step, share: f64) {
        if share == 0.0 && print::is_terminal() {
            say!("{species}: {}", step.name());
        }
    }

    fn ended(&self, built: &Built) {
        if !matches!(built.outcome, Outcome::Current | Outcome::Skipped) {
            let ended = self.ended.fetch_add(1, Ordering::Relaxed) + 1;
            say_built(built, ended, self.total.load(Ordering::Relaxed));
        }
    }
}

/// Says on stderr what became of a species, the so many-th of all.
pub(crate) fn say_built(built: &Built, ended: usize, total: usize) {
    let record = built.record.as_ref();
    let (bytes, seconds) = record.map_or((0, 0.0), |record| (record.facts.bytes, record.facts.seconds));
    let told = match &built.outcome {
        Outcome::Current => "as it was".to_owned(),
        Outcome::Skipped => "not made".to_owned(),
        Outcome::Stored => format!("from the cache, {}", print::bytes(bytes)),
        Outcome::Made(why) => format!("baked in {seconds:.1} s, {} ({why})", print::bytes(bytes)),
        Outcome::Failed(error) => format!("failed: {error}"),
    };
    say!("[{ended}/{total}] {}: {told}", built.name);
    for warning in record.into_iter().flat_map(|record| &record.facts.warnings) {
        say!("warning: {}: {warning}", built.name);
    }
}

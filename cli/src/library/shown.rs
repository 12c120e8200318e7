//! How far species are: bars on a terminal, sentences elsewhere, lines for engines.

mod bars;
mod left;

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use flb_farm::Plan;
use flb_farm::build::{BuildObserver, BuildSettings};
use flb_farm::outcome::{Built, Outcome};
use flb_farm::plan::State as Due;
use flb_scene::Step;
use serde_json::json;

use super::SpeciesReport;
use crate::args::ProgressArg;
use crate::print::{self, line, say};
use bars::Bars;
use left::Left;

/// Shows the work on species. `flb library build` and `flb task run` are followed by it.
pub(crate) struct Shown {
    form: ProgressArg,
    /// Memory of all that is made at once, bytes.
    memory_bytes: u64,
    /// Moment at which the work stops.
    deadline: Option<Instant>,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    total: usize,
    ended: usize,
    stored: usize,
    failed: usize,
    left: Left,
    bars: Option<Bars>,
}

impl Shown {
    /// For a build with these settings.
    pub(crate) fn new(form: ProgressArg, settings: &BuildSettings, deadline: Option<Instant>) -> Shown {
        let bars = (form == ProgressArg::Auto && print::is_terminal()).then(Bars::new);
        let state = State { left: Left::new(settings.jobs), bars, ..State::default() };
        Shown { form, memory_bytes: settings.memory_bytes, deadline, state: Mutex::new(state) }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Writes a line to stdout for an engine. One that reads no more is no reason to stop.
    fn openjd(&self, name: &str, value: &dyn std::fmt::Display) {
        if self.form == ProgressArg::Openjd {
            let _ = print::out(&line!("openjd_{name}: {value}")); // as said above
        }
    }

    fn json(&self, event: &serde_json::Value) {
        if self.form == ProgressArg::Json {
            let _ = print::json_line(event); // as said above
        }
    }
}

impl BuildObserver for Shown {
    fn planned(&self, plan: &Plan) {
        let mut state = self.state();
        for planned in &plan.species {
            if !matches!(planned.state, Due::Current(_)) {
                state.total += 1;
            }
            if matches!(planned.state, Due::Due(_)) {
                let (name, bytes) = (&planned.entry.name, planned.memory_bytes);
                if bytes > self.memory_bytes {
                    let [bytes, limit] = [bytes, self.memory_bytes].map(print::bytes);
                    say!(
                        "warning: {name}: its bake is expected to take {bytes} of memory, more than {limit} (--memory): it is baked alone"
                    );
                }
                state.left.expect(&planned.entry.name, planned.seconds);
            }
        }
        self.json(&json!({ "event": "planned", "due": state.total, "seconds": state.left.seconds() }));
    }

    fn at(&self, species: &str, step: Step, share: f64) {
        let mut state = self.state();
        state.left.at(species);
        if let Some(bars) = &mut state.bars {
            bars.at(species, step.name(), share);
        }
        if share == 0.0 {
            self.openjd("status", &format!("{species}: {}", step.name()));
            self.json(&json!({ "event": "stage", "species": species, "stage": step.name() }));
        }
        state.draw();
    }

    fn ended(&self, built: &Built) {
        let mut state = self.state();
        state.left.ended(&built.name, built.record.as_ref().map(|record| record.facts.seconds));
        if let Some(bars) = &mut state.bars {
            bars.end(&built.name);
        }
        if matches!(built.outcome, Outcome::Current | Outcome::Skipped) {
            return;
        }
        state.ended += 1;
        state.stored += usize::from(matches!(built.outcome, Outcome::Stored));
        state.failed += usize::from(matches!(built.outcome, Outcome::Failed(_)));
        let (ended, total) = (state.ended, state.total);
        match &state.bars {
            Some(bars) => bars.aside(|| say_built(built, ended, total)),
            None => say_built(built, ended, total),
        }
        self.openjd("progress", &(100 * ended / total.max(1)));
        let seconds = state.left.seconds();
        let species = SpeciesReport::of_built(built);
        self.json(&json!({ "event": "ended", "ended": ended, "due": total, "seconds": seconds, "species": species }));
        state.draw();
    }

    fn is_stopped(&self) -> bool {
        self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }
}

impl State {
    /// The line of all.
    fn draw(&self) {
        let Some(bars) = &self.bars else { return };
        let State { total, ended, stored, failed, .. } = self;
        let running = bars.running();
        let left = print::duration(self.left.seconds());
        bars.all(
            *ended,
            *total,
            format!("{running} running, {stored} from the cache, {failed} failed, about {left} left"),
        );
    }
}

/// Says on stderr what became of a species, the so many-th of all.
fn say_built(built: &Built, ended: usize, total: usize) {
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

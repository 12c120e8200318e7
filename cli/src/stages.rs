//! Times the stages of a job, measures their peak memory, and shows their progress on a terminal.

mod left;

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use flb_baker::bake::{BakeObserver, Event, SolveSummary};
use flb_format::progress::Progress;
use flb_scene::{Observer, Step};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;

use crate::HEAP;
use crate::print::{self, say};

/// One stage of a job; several species add up.
#[derive(Serialize, Debug, Clone)]
pub(crate) struct Stage {
    /// Name of the stage's step.
    pub name: &'static str,
    /// Wall time.
    pub seconds: f64,
    /// Largest heap in use at any moment of the stage, what earlier stages left behind included.
    pub peak_bytes: u64,
    /// Results of the solves of each species, of the solve stage.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub solves: Vec<SolveSummary>,
}

/// The stages so far, in the order in which each first ran. A bake is followed by it as its observer.
#[derive(Default)]
pub(crate) struct Stages {
    state: Mutex<State>,
    /// Whether notes are left out where stderr is no terminal.
    notes_on_terminals: bool,
}

#[derive(Default)]
struct State {
    done: Vec<Stage>,
    running: Option<Running>,
}

/// A step that runs, and on what.
struct Running {
    step: Step,
    subject: String,
    bar: ProgressBar,
    start: Instant,
}

impl Observer for Stages {
    fn begin(&self, step: Step, subject: &str) {
        let bar = progress_bar(step.name(), subject);
        HEAP.reset_peak_usage();
        let subject = print::one_line(subject).into_owned();
        self.state().running = Some(Running { step, subject, bar, start: Instant::now() });
    }

    fn progress(&self, share: f64) {
        let state = self.state();
        let Some(Running { step, subject, bar, start }) = &state.running else { return };
        bar.set_position((share.clamp(0.0, 1.0) * STEPS as f64) as u64);
        if let Some(left_s) = left::of_bake(*step, share, start.elapsed().as_secs_f64()) {
            bar.set_message(format!("{subject}, about {} left", print::duration(left_s)));
        }
    }

    fn end(&self, step: Step) {
        let mut state = self.state();
        let Some(Running { bar, start, .. }) = state.running.take() else { return };
        let seconds = start.elapsed().as_secs_f64();
        let peak_bytes = HEAP.peak_usage() as u64;
        bar.finish_and_clear();
        let name = step.name();
        match state.done.iter_mut().find(|stage| stage.name == name) {
            Some(stage) => {
                stage.seconds += seconds;
                stage.peak_bytes = stage.peak_bytes.max(peak_bytes);
            }
            None => state.done.push(Stage { name, seconds, peak_bytes, solves: Vec::new() }),
        }
    }

    fn note(&self, text: &str) {
        if !self.notes_on_terminals || print::is_terminal() {
            say!("{text}");
        }
    }
}

impl BakeObserver for Stages {
    fn hear(&self, event: &Event) {
        match event {
            Event::Reused { .. } | Event::Matter { .. } => {}
            Event::Solved(summary) => self.add_solve(summary.clone()),
            told => say!("{told}"),
        }
    }
}

impl Stages {
    /// Of many bakes, whose notes tell which of them runs: for a terminal alone. Events of a bake are always said.
    pub(crate) fn noting_on_terminals() -> Stages {
        Stages { notes_on_terminals: true, ..Stages::default() }
    }

    /// Runs `work` as a step; `subject` is shown beside the bar. `work` reports 0..=1.
    pub(crate) fn run<T>(&self, step: Step, subject: &str, work: impl FnOnce(&Progress<'_>) -> T) -> T {
        step.run(self, subject, work)
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds how a species was solved to the stage that solved it.
    fn add_solve(&self, summary: SolveSummary) {
        if let Some(stage) = self.state().done.iter_mut().find(|stage| stage.name == Step::Solve.name()) {
            stage.solves.push(summary);
        }
    }

    /// What ran.
    pub(crate) fn list(&self) -> Vec<Stage> {
        self.state().done.clone()
    }
}

const STEPS: u64 = 1000;
const TICK: Duration = Duration::from_millis(100);

/// A bar on stderr; hidden where stderr is not a terminal.
fn progress_bar(name: &str, subject: &str) -> ProgressBar {
    if !print::is_terminal() {
        return ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::hidden());
    }
    let style = ProgressStyle::with_template("{prefix:>11} [{bar:30}] {percent:>3} % {elapsed:>4} {msg}")
        .expect("the template is a constant")
        .progress_chars("=> ");
    let bar = ProgressBar::new(STEPS)
        .with_style(style)
        .with_prefix(name.to_owned())
        .with_message(print::one_line(subject).into_owned());
    let ticked = bar.downgrade();
    // The clock beside the bar goes on between two steps. Without the thread it stands still, no more.
    let tick = move || {
        while let Some(bar) = ticked.upgrade().filter(|bar| !bar.is_finished()) {
            bar.tick();
            drop(bar);
            thread::sleep(TICK);
        }
    };
    let _ = thread::Builder::new().name("flb-progress".to_owned()).spawn(tick);
    bar
}

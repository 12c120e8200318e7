//! Times the stages of a job, measures their peak memory, and shows their progress on a terminal.

use std::thread;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;

use crate::HEAP;
use crate::print;
use crate::solving::SolveSummary;

/// One stage of a job; several species add up.
#[derive(Serialize, Debug, Clone)]
pub struct Stage {
    /// import, voxelise, downsample, crown, solve, monte carlo, encode, write.
    pub name: &'static str,
    /// Wall time.
    pub seconds: f64,
    /// Largest heap in use at any moment of the stage, what earlier stages left behind included.
    pub peak_bytes: u64,
    /// Of the solve stage: how the solves of each species ended.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub solves: Vec<SolveSummary>,
}

/// The stages so far, in the order in which each first ran.
#[derive(Default)]
pub struct Stages {
    done: Vec<Stage>,
}

impl Stages {
    /// Runs `work` as the stage `name`; `subject` is shown beside the bar. `work` reports 0..=1.
    pub fn run<T>(
        &mut self,
        name: &'static str,
        subject: &str,
        work: impl FnOnce(&(dyn Fn(f64) + Sync)) -> T,
    ) -> T {
        let bar = progress_bar(name, subject);
        HEAP.reset_peak_usage();
        let start = Instant::now();
        let result = work(&|share: f64| bar.set_position((share.clamp(0.0, 1.0) * STEPS as f64) as u64));
        let seconds = start.elapsed().as_secs_f64();
        let peak_bytes = HEAP.peak_usage() as u64;
        bar.finish_and_clear();
        match self.done.iter_mut().find(|stage| stage.name == name) {
            Some(stage) => {
                stage.seconds += seconds;
                stage.peak_bytes = stage.peak_bytes.max(peak_bytes);
            }
            None => self.done.push(Stage { name, seconds, peak_bytes, solves: Vec::new() }),
        }
        result
    }

    /// Adds how a species was solved to the stage that solved it.
    pub fn add_solve(&mut self, summary: SolveSummary) {
        if let Some(stage) = self.done.iter_mut().find(|stage| stage.name == "solve") {
            stage.solves.push(summary);
        }
    }

    /// What ran.
    pub fn list(&self) -> &[Stage] {
        &self.done
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

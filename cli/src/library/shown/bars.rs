//! A bar for each species that is being made, and one for all.

use std::collections::BTreeMap;

use indicatif::{MultiProgress, ProgressBar, ProgressStyle};

use crate::print;

/// Steps of a bar of one species.
const STEPS: u64 = 1000;

pub(super) struct Bars {
    all: ProgressBar,
    multi: MultiProgress,
    running: BTreeMap<String, ProgressBar>,
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).expect("the template is a constant").progress_chars("=> ")
}

impl Bars {
    pub(super) fn new() -> Bars {
        let multi = MultiProgress::new();
        let all = ProgressBar::new(0).with_style(style("[{bar:30}] {pos}/{len} {elapsed:>4} {msg}"));
        let all = multi.add(all);
        Bars { all, multi, running: BTreeMap::new() }
    }

    /// A species is at a share of a stage.
    pub(super) fn at(&mut self, species: &str, stage: &'static str, share: f64) {
        let add = || {
            let bar = ProgressBar::new(STEPS)
                .with_style(style("{prefix:>11} [{bar:30}] {percent:>3} % {msg}"))
                .with_message(print::one_line(species).into_owned());
            self.multi.insert_before(&self.all, bar)
        };
        let bar = self.running.entry(species.to_owned()).or_insert_with(add);
        bar.set_prefix(stage);
        bar.set_position((share.clamp(0.0, 1.0) * STEPS as f64) as u64);
    }

    pub(super) fn end(&mut self, species: &str) {
        if let Some(bar) = self.running.remove(species) {
            bar.finish_and_clear();
            self.multi.remove(&bar);
        }
    }

    pub(super) fn running(&self) -> usize {
        self.running.len()
    }

    pub(super) fn all(&self, ended: usize, total: usize, text: String) {
        self.all.set_length(total as u64);
        self.all.set_position(ended as u64);
        self.all.set_message(text);
    }

    /// Lets something be said above the bars.
    pub(super) fn aside(&self, say: impl FnOnce()) {
        self.multi.suspend(say);
    }
}

impl Drop for Bars {
    fn drop(&mut self) {
        self.all.finish_and_clear();
    }
}

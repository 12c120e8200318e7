//! Time that is left, by what was expected of each species and what those that ended took.

use std::collections::BTreeMap;
use std::time::Instant;

#[derive(Default)]
pub(super) struct Left {
    /// Species that are made at once.
    jobs: usize,
    /// Seconds that are expected of species that have not ended, and the moment at which each began.
    waiting: BTreeMap<String, (f64, Option<Instant>)>,
    /// Seconds that were expected of those that ended, and that they took.
    expected_s: f64,
    took_s: f64,
}

impl Left {
    pub(super) fn new(jobs: usize) -> Left {
        Left { jobs: jobs.max(1), ..Left::default() }
    }

    pub(super) fn expect(&mut self, species: &str, seconds: f64) {
        self.waiting.insert(species.to_owned(), (seconds, None));
    }

    /// A species is being made.
    pub(super) fn at(&mut self, species: &str) {
        if let Some((_, begun)) = self.waiting.get_mut(species) {
            begun.get_or_insert_with(Instant::now);
        }
    }

    /// A species has ended, after so many seconds of work if it was made.
    pub(super) fn ended(&mut self, species: &str, took_s: Option<f64>) {
        if let (Some((expected_s, _)), Some(took_s)) = (self.waiting.remove(species), took_s) {
            self.expected_s += expected_s;
            self.took_s += took_s;
        }
    }

    /// Seconds until all have ended.
    pub(super) fn seconds(&self) -> f64 {
        let pace = if self.expected_s > 0.0 { self.took_s / self.expected_s } else { 1.0 };
        let left = |(expected_s, begun): &(f64, Option<Instant>)| {
            let done_s = begun.map_or(0.0, |begun| begun.elapsed().as_secs_f64());
            (expected_s * pace - done_s).max(0.0)
        };
        let lefts: Vec<f64> = self.waiting.values().map(left).collect();
        let longest = lefts.iter().copied().fold(0.0, f64::max);
        (lefts.iter().sum::<f64>() / self.jobs as f64).max(longest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_follows_what_was_taken() {
        let mut left = Left::new(2);
        for name in ["a", "b", "c", "d"] {
            left.expect(name, 10.0);
        }
        assert!((left.seconds() - 20.0).abs() < 1e-9);
        left.ended("a", Some(30.0));
        assert!((left.seconds() - 45.0).abs() < 1e-9, "three of 30 s, two at once");
        left.ended("b", None);
        left.ended("c", Some(30.0));
        assert!((left.seconds() - 30.0).abs() < 1e-9, "one is not made faster by two");
        left.at("d");
        left.ended("d", Some(1.0));
        left.ended("d", Some(1.0));
        assert_eq!(left.seconds(), 0.0);
    }
}

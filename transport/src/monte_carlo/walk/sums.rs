//! From the tallies of batches to means and their standard errors.

use super::super::{BATCHES, Balance};
use super::{Tally, Walked};

/// Sums over the batches so far.
pub(super) struct Sums {
    /// Photons per batch.
    photons: f64,
    /// Sum of the batches' means per non-empty site, and of their squares.
    means: Vec<[f64; 2]>,
    /// The same of the mean over all sites, and of what escaped.
    overall: [f64; 2],
    escaped: [f64; 2],
    balance: Balance,
}

impl Sums {
    pub(super) fn new(sites: usize, photons: f64) -> Sums {
        let means = vec![[0.0; 2]; sites];
        Sums { photons, means, overall: [0.0; 2], escaped: [0.0; 2], balance: Balance::default() }
    }

    /// Adds a batch; the order of calls decides the last bits.
    pub(super) fn add(&mut self, tally: Tally) {
        for (sums, length) in self.means.iter_mut().zip(&tally.lengths) {
            add(sums, length / self.photons);
        }
        add(&mut self.overall, tally.lengths.iter().sum::<f64>() / self.photons);
        let Balance { intercepted, absorbed, escaped, .. } = tally.balance;
        add(&mut self.escaped, escaped.iter().sum::<f64>() / self.photons);
        self.balance.intercepted += intercepted;
        self.balance.absorbed += absorbed;
        for (sum, side) in self.balance.escaped.iter_mut().zip(escaped) {
            *sum += side;
        }
    }

    pub(super) fn finish(self) -> Walked {
        let sites = self.means.len() as f64;
        let mut balance = self.balance;
        balance.scale(1.0 / (self.photons * BATCHES as f64));
        balance.escaped_error = error(&self.escaped);
        Walked {
            scattered: self.means.iter().map(|sums| sums[0] / BATCHES as f64).collect(),
            error: self.means.iter().map(error).collect(),
            mean_error: error(&self.overall) / sites,
            balance,
        }
    }
}

fn add(sums: &mut [f64; 2], value: f64) {
    *sums = [sums[0] + value, sums[1] + value * value];
}

/// Standard error of the mean of all batches.
fn error([sum, squares]: &[f64; 2]) -> f64 {
    let n = BATCHES as f64;
    let spread = (squares - sum * sum / n).max(0.0) / (n - 1.0);
    (spread / n).sqrt()
}

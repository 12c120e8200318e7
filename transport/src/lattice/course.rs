//! How a solve comes along: residuals -> whether to go on, and an estimate of the true error.

use super::{BaseReport, SolveSettings};

/// The rate of convergence is the worst of so many. Sweeps alternate, so each is taken over two of them.
const RATES: usize = 4;
/// Rates above this are taken for it: a solve that hardly moves says nothing of how far it is.
const SLOWEST: f64 = 0.999;
/// Residuals up to this are rounding errors of f32 going round; no rate can be read from them.
const ROUNDING: f64 = f32::EPSILON as f64 / 4.0;
/// Residuals over which a solve must have come nearer to its tolerance, once it has had time to.
pub(super) const TREND_SPAN: usize = 16;
/// Times that light may cross the lattice before an iteration, which carries it one hop at a time, may give up.
pub(super) const CROSSINGS: usize = 4;
/// Sweeps before a trend is trusted.
const TREND_AFTER: usize = 32;
/// Sweeps before a solve is called slow, and the rate from which it is.
const CREEPS_AFTER: usize = 12;
const CREEPING: f64 = 0.8;

/// The residuals of one base in one band so far.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Course {
    residuals: Vec<f64>,
    /// The rate of plain sweeps, if they are no longer plain.
    plain_rate: f64,
}

impl Course {
    /// Takes the sums of (phi - before)^2 and of phi^2 over the non-empty sites of one sweep.
    pub(crate) fn note(&mut self, change: f64, norm: f64) {
        self.residuals.push(if norm > 0.0 { (change / norm).sqrt() } else { 0.0 });
    }

    /// Takes the first sweep after a mix, whose change is mostly the mix: it tells nothing.
    pub(crate) fn note_mixed(&mut self) {
        self.residuals.push(self.residual());
    }

    /// The last residual; 0 before the first sweep, which is all that an empty medium sees.
    pub(crate) fn residual(&self) -> f64 {
        self.residuals.last().copied().unwrap_or(0.0)
    }

    /// Whether the tolerance is reached.
    pub(crate) fn is_converged(&self, settings: &SolveSettings) -> bool {
        self.error_estimate() <= settings.tolerance
    }

    /// Whether the tolerance is reached, or at the rate of the last sweeps would not be within the sweeps allowed.
    pub(crate) fn is_over(&self, settings: &SolveSettings) -> bool {
        self.is_converged(settings) || self.is_hopeless(settings)
    }

    /// Whether at the rate of the last sweeps the tolerance would not be reached within the sweeps allowed.
    pub(crate) fn is_hopeless(&self, settings: &SolveSettings) -> bool {
        let count = self.residuals.len();
        if count < TREND_AFTER || self.residuals[count - 1 - TREND_SPAN] == 0.0 {
            return false;
        }
        let fallen = libm::log(self.residuals[count - 1 - TREND_SPAN] / self.residual());
        let missing = libm::log(self.error_estimate() / settings.tolerance);
        let left = f64::from(settings.max_sweeps) - count as f64;
        fallen <= 0.0 || missing / fallen * TREND_SPAN as f64 > left
    }

    /// Whether sweeps take away so little that [`Mixing`](super::mixing::Mixing) pays.
    pub(crate) fn creeps(&self, settings: &SolveSettings) -> bool {
        self.residuals.len() >= CREEPS_AFTER && self.rate() > CREEPING && !self.is_converged(settings)
    }

    /// From here on the residual may fall faster than the error that it stands for does by plain sweeps.
    pub(crate) fn quicken(&mut self) {
        self.plain_rate = self.rate();
    }

    /// The worst rate of the last few sweeps, each taken over two of them.
    fn rate(&self) -> f64 {
        let last = &self.residuals[self.residuals.len().saturating_sub(RATES + 2)..];
        let rates = last.windows(3).map(|three| (three[2] / three[0]).sqrt());
        let rate =
            rates.fold(None, |worst: Option<f64>, rate| Some(worst.map_or(rate, |worst| worst.max(rate))));
        rate.unwrap_or(SLOWEST).clamp(self.plain_rate, SLOWEST)
    }

    /// See [`BaseReport::error_estimate`]. If every sweep takes away at least the share that the worst of the last few
    /// did, what is left is at most residual (1 + r + r^2 + ...) with r the quotient of successive residuals.
    pub(crate) fn error_estimate(&self) -> f64 {
        let residual = self.residual();
        if residual <= ROUNDING { residual } else { residual / (1.0 - self.rate()) }
    }

    /// What is said of the solve at its end.
    pub(crate) fn report(&self, base: u8, band: u32, settings: &SolveSettings) -> BaseReport {
        BaseReport {
            base,
            band,
            sweeps: self.residuals.len() as u32,
            residual: self.residual(),
            error_estimate: self.error_estimate(),
            // Steps that were asked for have been done.
            converged: settings.steps.is_some() || self.is_converged(settings),
        }
    }
}

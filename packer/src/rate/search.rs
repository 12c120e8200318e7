//! The search for a step: brackets the target, then closes in. The error need not go evenly with the step, least of all
//! in a small field: where it jumps over the target, the better side of the jump is taken.

/// Decibels per factor of 10 in the step, near enough.
const SLOPE: f64 = 17.0;
/// Passes at most.
const MAX_PASSES: u32 = 20;
/// Passes after which intervals are halved, whatever the error at their ends.
const STRAIGHT_PASSES: u32 = 8;
/// A step at which nothing coarser is to be had: the average of a block of the peak's light is 2 steps.
pub(super) const COARSEST: f32 = 4.0;

/// More than this off the target is as good as this.
const MAX_DB: f64 = 200.0;

/// A bracket narrower than this factor is a jump of the error.
const JUMP: f32 = 1.003;

/// Where the search for a base's step stands.
#[derive(Debug, Clone)]
pub(super) struct Search {
    /// Step to try next.
    pub step: f32,
    /// Finest step that can be had.
    finest: f32,
    /// The coarsest step that was better than the target, and by how many decibels.
    better: Option<(f32, f64)>,
    /// The finest step that was worse, and by how many.
    worse: Option<(f32, f64)>,
    passes: u32,
    /// Whether the step is the better side of a jump.
    is_jump: bool,
}

/// What to do after a pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Next {
    /// The target is met.
    Done,
    /// Try the step of the search.
    Again,
    /// No step meets the target.
    Refused,
}

impl Search {
    /// From a guess.
    pub(super) fn new(guess: f32, finest: f32) -> Search {
        Search {
            step: guess.clamp(finest, COARSEST.max(finest)),
            finest,
            better: None,
            worse: None,
            passes: 0,
            is_jump: false,
        }
    }

    /// A better guess before the first pass, from an estimate that is `off` decibels better than the target.
    pub(super) fn guess(&mut self, off: f64) {
        self.step = self.towards(off);
    }

    fn towards(&self, off: f64) -> f32 {
        let factor = libm::exp10((off / SLOPE).clamp(-0.6, 0.6)) as f32;
        (self.step * factor).clamp(self.finest, COARSEST.max(self.finest))
    }

    /// Forgets the worse end of the bracket: it was found with fewer components.
    pub(super) fn forget_worse(&mut self) {
        self.worse = None;
    }

    /// Takes in that the step was `off` decibels better than the target, of which `slack` either way is met.
    pub(super) fn tried(&mut self, off: f64, slack: f64) -> Next {
        self.passes += 1;
        let off = off.min(MAX_DB); // no error at all is infinitely better
        let is_met = off.abs() <= slack || (off > 0.0 && self.step >= COARSEST);
        if is_met || (self.is_jump && off > 0.0) {
            return Next::Done;
        }
        if self.is_jump || self.passes == MAX_PASSES || (off < 0.0 && self.step <= self.finest) {
            return Next::Refused;
        }
        // The end that stays counts half (the Illinois rule), or it would hold the next step near the other.
        if off > 0.0 {
            self.better = Some((self.step, off));
            self.worse = self.worse.map(|(step, off)| (step, off / 2.0));
        } else {
            self.worse = Some((self.step, off));
            self.better = self.better.map(|(step, off)| (step, off / 2.0));
        }
        self.step = match (self.better, self.worse) {
            (Some((fine, _)), Some((coarse, _))) if libm::fabsf(libm::logf(coarse / fine)) < JUMP - 1.0 => {
                self.is_jump = true;
                fine
            }
            (Some((fine, better)), Some((coarse, worse))) => {
                // Straight line through both in the logarithm of the step, but never near an end.
                let straight = (better / (better - worse)).clamp(0.1, 0.9);
                let share = if self.passes > STRAIGHT_PASSES { 0.5 } else { straight };
                let (fine, coarse) = (libm::log10(f64::from(fine)), libm::log10(f64::from(coarse)));
                libm::exp10(fine + share * (coarse - fine)) as f32
            }
            // Further every time, as the slope is less than was thought.
            _ => self.towards(off * f64::from(self.passes)),
        };
        Next::Again
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps until the search ends, with the error that a step makes in decibels below the peak.
    fn run(level: impl Fn(f32) -> f64, target: f64, guess: f32, finest: f32) -> (Next, f32) {
        let mut search = Search::new(guess, finest);
        loop {
            let step = search.step;
            match search.tried(level(step) - target, 0.1) {
                Next::Again => {}
                end => return (end, step),
            }
        }
    }

    #[test]
    fn a_search_ends_at_the_target_even_where_the_slope_is_wrong() {
        for slope in [4.0, 17.0, 40.0] {
            let level = |step: f32| 35.0 - slope * libm::log10(f64::from(step));
            let (end, step) = run(level, 45.0, 1.0, 1e-9);
            assert_eq!(end, Next::Done);
            assert!((level(step) - 45.0).abs() <= 0.1, "slope {slope}");
        }
    }

    #[test]
    fn a_target_that_no_step_reaches_is_refused() {
        // The error stays, however fine the step.
        assert_eq!(run(|_| 30.0, 45.0, 0.1, 1e-6).0, Next::Refused);
        // Averages do not fit below this step.
        let (end, step) = run(|step| -20.0 * libm::log10(f64::from(step)), 60.0, 0.1, 0.01);
        assert_eq!((end, step), (Next::Refused, 0.01));
    }

    #[test]
    fn of_a_jump_over_the_target_the_better_side_is_taken() {
        let (end, step) = run(|step| if step < 0.01 { 50.0 } else { 40.0 }, 45.0, 0.1, 1e-9);
        assert_eq!(end, Next::Done);
        assert!((0.0099..0.01).contains(&step), "{step}");
    }

    #[test]
    fn a_step_without_any_error_does_not_lead_astray() {
        let level =
            |step: f32| if step < 0.02 { f64::INFINITY } else { 20.0 - 17.0 * libm::log10(f64::from(step)) };
        let (end, step) = run(level, 45.0, 0.001, 1e-9);
        assert_eq!(end, Next::Done);
        assert!((level(step) - 45.0).abs() <= 0.1, "{step}");
    }

    #[test]
    fn a_field_that_the_coarsest_step_keeps_well_is_done() {
        assert_eq!(run(|_| 90.0, 45.0, 0.1, 1e-6), (Next::Done, COARSEST));
    }
}

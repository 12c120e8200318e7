//! Ends that solves at the ends of their ranges must have, and what is measured of them, whichever solver it is.

use std::fmt::Display;

/// Bands that are held against an oracle: so many, evenly over all of them.
const COMPARED_BANDS: usize = 3;

/// End that a solve must have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// Every solve converges.
    Converges,
    /// No solve converges, and the solver says so and ends early.
    GivesUp,
    /// Refused, with these words in the reason.
    Refused(&'static str),
}

/// Errors and work measured on a case: the worst of all its solves, errors of those that were compared.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Measured {
    /// Non-empty sites.
    pub sites: usize,
    /// Solves of which each ends by itself: bases in all bands (`paper`), or bands (`physical`).
    pub solves: usize,
    /// Number of solves that converged.
    pub converged: usize,
    /// Largest number of sweeps (`paper`) or passes (`physical`).
    pub iterations: u32,
    /// Lights that were held against a solution in f64.
    pub compared: usize,
    /// Largest error estimate: of phi, or of the scattered light.
    pub error_estimate: f64,
    /// Largest L2 error of the lights that were compared, relative to all light.
    pub relative_l2: f64,
    /// Largest error at a non-empty site, relative to its light (`paper`) or to the mean light (`physical`).
    pub worst_site: f64,
    /// Largest share of the light that enters (`paper`) or is met (`physical`) and neither leaves nor is absorbed,
    /// without its sign.
    pub imbalance: f64,
    /// Largest error of a fit or blend over suns that were held out, as the solver states it.
    pub suns_rms: Option<f64>,
    /// Smallest and largest light of the fields that are no coefficients; NaN if any is not finite.
    pub range: [f32; 2],
}

/// Limits of what is measured of a case that must converge.
pub(crate) struct Limits {
    /// Largest relative L2 error.
    pub l2: f64,
    /// Largest error at a site.
    pub at_a_site: f64,
    /// Largest energy imbalance.
    pub imbalance: f64,
    /// An error estimate may be too small by this factor ...
    pub underestimate: f64,
    /// ... and by what rounding adds, which is in no estimate.
    pub rounding: f64,
}

/// A case and how it went.
#[derive(Debug)]
pub struct Outcome {
    /// Name of the case.
    pub name: &'static str,
    /// The numbers, or why the input was refused.
    pub measured: Result<Measured, String>,
    /// Faults of the outcome; empty if all is as it must be.
    pub faults: Vec<String>,
}

impl Outcome {
    /// Judges how a case went.
    pub(crate) fn new<E: Display>(
        name: &'static str,
        end: End,
        measured: Result<Measured, E>,
        limits: &Limits,
    ) -> Outcome {
        let measured = measured.map_err(|error| error.to_string());
        Outcome { name, faults: faults(end, &measured, limits), measured }
    }

    /// The faults, or that there are none.
    pub(crate) fn verdict(&self) -> String {
        if self.faults.is_empty() { "as it must".to_owned() } else { self.faults.join("; ") }
    }
}

fn faults(end: End, measured: &Result<Measured, String>, limits: &Limits) -> Vec<String> {
    let mut faults = Vec::new();
    let mut expect = |holds: bool, fault: String| {
        if !holds {
            faults.push(fault);
        }
    };
    match (measured, end) {
        (Err(error), End::Refused(words)) => {
            expect(error.contains(words), format!("refused without \"{words}\": {error}"));
        }
        (Err(error), _) => expect(false, format!("refused: {error}")),
        (Ok(_), End::Refused(words)) => expect(false, format!("not refused (\"{words}\" expected)")),
        (Ok(found), end) => {
            let [low, high] = found.range;
            expect(low >= 0.0 && high.is_finite(), format!("light from {low} to {high}"));
            let expected = if end == End::GivesUp { 0 } else { found.solves };
            expect(
                found.converged == expected,
                format!("{} of {} converged, {expected} expected", found.converged, found.solves),
            );
            if end == End::Converges {
                let estimate = limits.underestimate * found.error_estimate + limits.rounding;
                let limits = [
                    ("L2 error", found.relative_l2, limits.l2),
                    ("L2 error against the estimate", found.relative_l2, estimate),
                    ("error at a site", found.worst_site, limits.at_a_site),
                    ("energy imbalance", found.imbalance, limits.imbalance),
                ];
                for (name, value, most) in limits {
                    expect(value <= most, format!("{name} {value:.1e}, at most {most:.0e} expected"));
                }
            }
        }
    }
    faults
}

/// Indices of the bands, of so many, that are held against an oracle.
pub(crate) fn compared_bands(bands: usize) -> impl Iterator<Item = usize> + Clone {
    let compared = COMPARED_BANDS.min(bands);
    (0..compared).map(move |at| at * (bands - 1) / (compared - 1).max(1))
}

/// The smallest and the largest of some numbers; NaN if any is not finite.
pub(crate) fn range_of(numbers: impl Iterator<Item = f32>) -> [f32; 2] {
    numbers.fold([f32::MAX, f32::MIN], |[low, high], number| match number.is_finite() {
        // A NaN stays: `min` and `max` would drop it.
        true if low.is_finite() => [low.min(number), high.max(number)],
        _ => [f32::NAN; 2],
    })
}

/// A message whose numbers of hundreds of digits are cut: they say nothing.
pub(crate) fn short(message: &str) -> String {
    let word = |word: &str| match word.len() {
        0..=24 => word.to_owned(),
        _ => format!("{}...", &word[..word.floor_char_boundary(12)]),
    };
    message.split(' ').map(word).collect::<Vec<_>>().join(" ")
}

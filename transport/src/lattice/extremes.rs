//! The lattice-Boltzmann solver at the ends of its range: cases, each solved, measured and judged.

mod cases;
mod shapes;
pub mod table;

use flb_format::Medium;
use flb_format::matter::Optics;

pub use cases::cases;

use super::balance;
use super::reference;
use super::{SolveError, SolveSettings, solve};
use crate::ends::{End, Limits, Measured, Outcome, compared_bands, range_of};

/// Limits of the bases that are said to have converged. Rounding of f32 sums is not in the estimate.
pub(crate) const LIMITS: Limits =
    Limits { l2: 2e-4, at_a_site: 3e-2, imbalance: 2e-4, underestimate: 4.0, rounding: 1e-6 };

/// The fixed point is taken for reached at this relative change; see [`reference`].
const REFERENCE_TOLERANCE: f64 = 1e-9;
const REFERENCE_SWEEPS: u32 = 20_000;
/// The bases held against the fixed point: ambient, and one of each kind of direction with and against the sweeps.
const COMPARED_BASES: [u8; 4] = [0, 4, 7, 18];

/// A solve with extreme matter or optics.
pub struct Case {
    /// Name of the extreme, in a few words.
    pub name: &'static str,
    /// The matter.
    pub medium: Medium,
    /// The optics.
    pub optics: Optics,
    /// End that the solve must have.
    pub end: End,
}

/// Solves a case with default settings and holds it against the fixed point in f64.
pub fn run(case: Case) -> Outcome {
    Outcome::new(case.name, case.end, measure(&case), &LIMITS)
}

fn measure(case: &Case) -> Result<Measured, SolveError> {
    let Case { medium, optics, .. } = case;
    let settings = SolveSettings::default();
    let solution = solve(medium, optics, &settings, &|_| Ok(()))?;
    let reports = &solution.reports;
    let largest = |of: &dyn Fn(&super::BaseReport) -> f64| reports.iter().map(of).fold(0.0, f64::max);
    let mut measured = Measured {
        sites: medium.density.iter().filter(|density| **density > 0.0).count(),
        solves: reports.len(),
        converged: reports.iter().filter(|report| report.converged).count(),
        iterations: reports.iter().map(|report| report.sweeps).max().unwrap_or(0),
        error_estimate: largest(&|report| report.error_estimate),
        ..Measured::default()
    };
    let bands = compared_bands(optics.bands.len());
    let of_base = |base: u8| bands.clone().map(move |band| (base, band as u32));
    let converged = |&(base, band): &(u8, u32)| {
        reports.iter().any(|report| (report.base, report.band) == (base, band) && report.converged)
    };
    let wanted: Vec<(u8, u32)> = COMPARED_BASES.into_iter().flat_map(of_base).filter(converged).collect();
    measured.range = range_of(solution.bases.iter().flat_map(|(_, field)| field.values().to_vec()));
    for exact in reference::solve(medium, optics, &wanted, REFERENCE_TOLERANCE, REFERENCE_SWEEPS)? {
        measured.compared += 1;
        let phi = solution.bases[usize::from(exact.base)].1.band(exact.band);
        let distance = exact.distance(medium, &phi);
        measured.relative_l2 = measured.relative_l2.max(distance.relative_l2);
        measured.worst_site = measured.worst_site.max(distance.worst_site);
    }
    for balance in balance::balances(medium, optics, &settings)? {
        measured.imbalance = measured.imbalance.max(balance.imbalance().abs());
    }
    Ok(measured)
}

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
use crate::extremes::{self, End, Outcome, range_of};

/// Largest relative L2 error of a base that is said to have converged, over the non-empty sites.
pub const MAX_L2: f64 = 2e-4;
/// Largest relative error of such a base at any non-empty site.
pub const MAX_AT_A_SITE: f64 = 3e-2;
/// Largest energy imbalance of such a base.
pub const MAX_IMBALANCE: f64 = 2e-4;
/// An error estimate may be too small by this factor.
pub const MAX_UNDERESTIMATE: f64 = 4.0;

/// The fixed point is taken for reached at this relative change; see [`reference`].
const REFERENCE_TOLERANCE: f64 = 1e-9;
const REFERENCE_SWEEPS: u32 = 20_000;
/// The bases held against the fixed point: ambient, and one of each kind of direction with and against the sweeps.
const COMPARED_BASES: [u8; 4] = [0, 4, 7, 18];
/// The bands held against it: so many, evenly over all of them.
const COMPARED_BANDS: usize = 3;

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

/// Errors and work measured on a case: the worst of all bases and bands, errors of those that were compared.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Measured {
    /// Non-empty sites.
    pub sites: usize,
    /// Number of solves.
    pub solves: usize,
    /// Number of solves that converged.
    pub converged: usize,
    /// Largest number of sweeps.
    pub sweeps: u32,
    /// Solves that were held against the fixed point.
    pub compared: usize,
    /// Largest error estimate.
    pub error_estimate: f64,
    /// Largest relative L2 error against the f64 fixed point, of the solves that converged and were compared.
    pub relative_l2: f64,
    /// Largest relative error at a non-empty site.
    pub worst_site: f64,
    /// Largest [`balance::Balance::imbalance`] without its sign.
    pub imbalance: f64,
    /// Smallest and largest phi of all fields; NaN if any is not finite.
    pub range: [f32; 2],
}

/// Solves a case with default settings and holds it against the fixed point in f64.
pub fn run(case: &Case) -> Outcome<Measured, SolveError> {
    let measured = measure(case);
    let faults = judge(case, &measured);
    Outcome { name: case.name, measured, faults }
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
        sweeps: reports.iter().map(|report| report.sweeps).max().unwrap_or(0),
        error_estimate: largest(&|report| report.error_estimate),
        ..Measured::default()
    };
    let bands = optics.bands.len();
    let compared = COMPARED_BANDS.min(bands);
    let band = |at: usize| (at * (bands - 1) / (compared - 1).max(1)) as u32;
    let of_base = |base: u8| (0..compared).map(move |at| (base, band(at)));
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

fn judge(case: &Case, measured: &Result<Measured, SolveError>) -> Vec<String> {
    extremes::faults(case.end, measured, |found, faults| {
        faults.expect_light(found.range);
        faults.expect_converged(case.end, found.converged, found.solves);
        if case.end == End::Converges {
            // Rounding of f32 sums is not in the estimate.
            let estimate = MAX_UNDERESTIMATE * found.error_estimate + 1e-6;
            faults.expect_at_most([
                ("L2 error", found.relative_l2, MAX_L2),
                ("L2 error against the estimate", found.relative_l2, estimate),
                ("error at a site", found.worst_site, MAX_AT_A_SITE),
                ("energy imbalance", found.imbalance, MAX_IMBALANCE),
            ]);
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_end_is_a_fault() {
        let all = cases();
        let of = |name: &str| all.iter().find(|case| case.name == name).expect("a case of this name");
        let tree = of("a tree, the papers' optics");
        let outcome = run(tree);
        assert!(outcome.faults.is_empty());
        let found = outcome.measured.unwrap();
        let spoil = |change: &dyn Fn(&mut Measured)| {
            let mut spoilt = found.clone();
            change(&mut spoilt);
            judge(tree, &Ok(spoilt)).len()
        };
        assert_eq!(spoil(&|_| {}), 0);
        assert_eq!(spoil(&|m| m.range = [f32::NAN; 2]), 1);
        assert_eq!(spoil(&|m| m.range[0] = -1e-9), 1);
        assert_eq!(spoil(&|m| m.converged -= 1), 1);
        assert_eq!(spoil(&|m| m.error_estimate = 0.0), 1);
        assert_eq!(spoil(&|m| m.worst_site = 0.1), 1);
        assert_eq!(spoil(&|m| m.imbalance = 0.1), 1);
        let refused = SolveError::NoBases;
        assert_eq!(judge(tree, &Err(refused)).len(), 1);
        let end = End::Refused("of matter");
        let wrong = Case { end, name: "", medium: tree.medium.clone(), optics: tree.optics.clone() };
        assert_eq!(judge(&wrong, &Ok(found)).len(), 1);
        assert_eq!(judge(&wrong, &Err(SolveError::MaxSweeps)).len(), 1);
    }
}

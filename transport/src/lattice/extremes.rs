//! The solver at the ends of its range: a table of cases, each solved, measured and judged.
//!
//! `flb doctor --extremes` prints the table; docs/extremes.md keeps it. Its numbers are the same on every machine.

mod cases;
mod shapes;
pub mod table;

use flb_format::Medium;
use flb_format::matter::Optics;

pub use cases::cases;

use super::balance;
use super::reference;
use super::{SolveError, SolveSettings, solve};

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

/// End that a solve must have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// Every base converges.
    Converges,
    /// No base converges, and the solver says so and ends early.
    GivesUp,
    /// Refused, with these words in the reason.
    Refused(&'static str),
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
    /// Largest residual.
    pub residual: f64,
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

/// A case and how it went.
pub struct Outcome {
    /// [`Case::name`].
    pub name: &'static str,
    /// The numbers, or why the input was refused.
    pub measured: Result<Measured, SolveError>,
    /// Faults of the outcome; empty if all is as it must be.
    pub faults: Vec<String>,
}

/// Solves a case with default settings and holds it against the fixed point in f64.
pub fn run(case: &Case) -> Outcome {
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
        residual: largest(&|report| report.residual),
        error_estimate: largest(&|report| report.error_estimate),
        range: [f32::MAX, f32::MIN],
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
    for (_, field) in &solution.bases {
        for &phi in field.values().iter() {
            let [low, high] = measured.range;
            measured.range = if phi.is_finite() { [low.min(phi), high.max(phi)] } else { [f32::NAN; 2] };
        }
    }
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
    let mut faults = Vec::new();
    let mut expect = |holds: bool, fault: String| {
        if !holds {
            faults.push(fault);
        }
    };
    match (measured, case.end) {
        (Err(error), End::Refused(words)) => {
            expect(error.to_string().contains(words), format!("refused without \"{words}\": {error}"));
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
                // Rounding of f32 sums is not in the estimate.
                let estimate = MAX_UNDERESTIMATE * found.error_estimate + 1e-6;
                let limits = [
                    ("L2 error", found.relative_l2, MAX_L2),
                    ("L2 error against the estimate", found.relative_l2, estimate),
                    ("error at a site", found.worst_site, MAX_AT_A_SITE),
                    ("energy imbalance", found.imbalance, MAX_IMBALANCE),
                ];
                for (name, value, most) in limits {
                    expect(value <= most, format!("{name} {value:.1e}, at most {most:.0e} expected"));
                }
            }
        }
    }
    faults
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `FLB_WRITE_DOCS=1` writes the table anew.
    #[test]
    fn every_extreme_ends_as_the_docs_say() {
        let outcomes: Vec<Outcome> = cases().iter().map(run).collect();
        let faults: Vec<String> = outcomes
            .iter()
            .filter(|outcome| !outcome.faults.is_empty())
            .map(|outcome| format!("{}: {:?}: {:?}", outcome.name, outcome.faults, outcome.measured))
            .collect();
        assert!(faults.is_empty(), "{}", faults.join("\n"));

        let rows: String = outcomes.iter().map(table::row).collect();
        let text = format!("{DOCS_HEAD}\n{}\n{}{rows}", table::legend(), table::HEADER);
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/extremes.md");
        if std::env::var_os("FLB_WRITE_DOCS").is_some() {
            std::fs::write(path, &text).unwrap();
        }
        let kept = std::fs::read_to_string(path).unwrap_or_default();
        for (line, (kept, found)) in kept.lines().zip(text.lines()).enumerate() {
            assert_eq!(kept, found, "docs/extremes.md, line {}; FLB_WRITE_DOCS=1 writes it anew", line + 1);
        }
        assert_eq!(kept.lines().count(), text.lines().count());
    }

    const DOCS_HEAD: &str =
        "# The solver at the extremes\n\nWritten and checked by a test; `flb doctor --extremes` prints it.\n";

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

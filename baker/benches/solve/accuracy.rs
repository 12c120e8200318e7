//! What a tolerance buys.

use std::time::Instant;

use flb_format::matter::Optics;
use flb_transport::lattice::reference::{self, SolveDistance};
use flb_transport::lattice::{SolveSettings, solve};

use crate::oak;

const TOLERANCES: [f64; 5] = [1e-3, 3e-4, 1e-4, 3e-5, 1e-5];
/// Of the f64 solutions: far below every error that is measured with them.
const EXACT: f64 = 1e-10;
const EXACT_SWEEPS: u32 = 5000;

pub(crate) fn print(lattice: u32) {
    let (medium, optics) = (oak::medium(lattice), Optics::paper());
    let wanted: Vec<(u8, u32)> = (1..=18).flat_map(|base| [0, 1, 2].map(|band| (base, band))).collect();
    let exact = reference::solve(&medium, &optics, &wanted, EXACT, EXACT_SWEEPS).expect("a good medium");
    assert!(exact.iter().all(|exact| exact.residual <= EXACT), "the f64 solutions have not converged");
    println!(
        "\n### Accuracy: oak, lattice {lattice}, {} non-empty sites, 57 solves\n",
        oak::sites_of(&medium)
    );
    println!("| tolerance | sweeps | seconds | largest estimate | largest true L2 | worst site |");
    println!("|---:|---:|---:|---:|---:|---:|");
    for tolerance in TOLERANCES {
        let settings = SolveSettings { tolerance, ..SolveSettings::default() };
        let start = Instant::now();
        let solution = solve(&medium, &optics, &settings, &|_| Ok(())).expect("a good medium");
        let seconds = start.elapsed().as_secs_f64();
        let solved = || solution.reports.iter().filter(|report| report.base > 0);
        let [fewest, most] = [solved().map(|r| r.sweeps).min(), solved().map(|r| r.sweeps).max()]
            .map(|sweeps| sweeps.expect("18 bases"));
        let estimate = solved().map(|report| report.error_estimate).fold(0.0, f64::max);
        let far = exact.iter().fold(SolveDistance::default(), |far, exact| {
            let found = exact.distance(&medium, &solution.bases[usize::from(exact.base)].1.band(exact.band));
            SolveDistance {
                relative_l2: far.relative_l2.max(found.relative_l2),
                worst_site: far.worst_site.max(found.worst_site),
            }
        });
        let converged = if solved().all(|report| report.converged) { "" } else { " (not converged)" };
        println!(
            "| {tolerance:.0e}{converged} | {fewest} to {most} | {seconds:.2} | {estimate:.1e} | {:.1e} | {:.2} % |",
            far.relative_l2,
            100.0 * far.worst_site
        );
    }
}

//! The sweep and the explicit solver side by side, both carried to the same true error.

use std::time::Instant;

use flb_format::Medium;
use flb_format::bases::BaseSet;
use flb_format::matter::Optics;
use flb_transport::lattice::reference::{self, Reference};
use flb_transport::lattice::{Solution, SolveSettings, SolverKind, solve};

use crate::bandwidth::{Memory, iteration_bytes};
use crate::oak;

/// The largest true relative L2 error allowed.
const ERROR: f64 = 2e-4;
/// At which sweeps have that error or less in all 54 solves at lattice 128, as `accuracy` finds.
const SWEEP_TOLERANCE: f64 = 2.5e-4;
/// Tried in turn for the explicit solver, until the error is small enough.
const TOLERANCES: [f64; 8] = [1.6e-3, 8e-4, 4e-4, 2e-4, 1e-4, 5e-5, 2.5e-5, 1.25e-5];
/// What the explicit solver solves: along an axis, and along a diagonal.
const BASES: [u8; 2] = [4, 9];
const BAND: u32 = 1;

pub(crate) fn print(lattice: u32) {
    let (medium, paper) = (oak::medium(lattice), Optics::paper());
    let wanted: Vec<(u8, u32)> = BASES.map(|base| (base, BAND)).to_vec();
    let exact = reference::solve(&medium, &paper, &wanted, 1e-10, 5000).expect("a good medium");
    let mut memory = Memory::new();
    let before = memory.triad();
    let one_band = Optics { bands: vec![paper.bands[BAND as usize].clone()] };
    let some: BaseSet = BASES.into_iter().collect();
    let explicit = find(&medium, &one_band, SolverKind::Explicit, some, |solution| {
        let of = |exact: &Reference| {
            let field = solution.bases.iter().find(|(base, _)| *base == exact.base);
            exact.distance(&medium, &field.expect("a base asked for").1.band(0)).relative_l2
        };
        exact.iter().map(of).fold(0.0, f64::max)
    });
    let bound = before.max(memory.triad());
    let sweep = find(&medium, &paper, SolverKind::Sweep, BaseSet::ALL, |solution| {
        let of = |exact: &Reference| {
            let field = &solution.bases[usize::from(exact.base)].1;
            exact.distance(&medium, &field.band(exact.band)).relative_l2
        };
        exact.iter().map(of).fold(0.0, f64::max)
    });
    println!("\n### Side by side: oak, lattice {lattice}, {} non-empty sites\n", oak::sites_of(&medium));
    println!(
        "Errors are of bases {BASES:?} in band {BAND}. The sweep solver solves all 19 bases in 3 bands, and 57 divides its seconds; the \
         explicit solver those {} solves.\n",
        BASES.len()
    );
    println!("| solver | tolerance | true L2 | sweeps or iterations | seconds per solve |");
    println!("|---|---:|---:|---:|---:|");
    let [per_sweep, per_explicit] = [sweep.seconds / 57.0, explicit.seconds / BASES.len() as f64];
    for (name, run, seconds) in [("sweep", &sweep, per_sweep), ("explicit", &explicit, per_explicit)] {
        let most = run.solution.reports.iter().map(|report| report.sweeps).max().expect("solves");
        println!("| {name} | {:.1e} | {:.1e} | {most} | {seconds:.4} |", run.tolerance, run.error);
    }
    let iterations: u32 = explicit.solution.reports.iter().map(|report| report.sweeps).sum();
    let speed = f64::from(iterations) * iteration_bytes(lattice) / explicit.seconds;
    println!(
        "\nRatio {:.0}. Explicit, everything counted: {:.1} GB/s; triad {:.1} GB/s: {:.0} %.",
        per_explicit / per_sweep,
        speed / 1e9,
        bound / 1e9,
        100.0 * speed / bound
    );
}

/// A run that is good enough.
struct Run {
    tolerance: f64,
    error: f64,
    seconds: f64,
    solution: Solution,
}

/// The first tolerance at which the error is small enough. Every solver gets two timed runs, of which the faster
/// counts.
fn find(
    medium: &Medium,
    optics: &Optics,
    solver: SolverKind,
    bases: BaseSet,
    error: impl Fn(&Solution) -> f64,
) -> Run {
    let mut tried = Vec::new();
    let tolerances = match solver {
        SolverKind::Sweep => vec![SWEEP_TOLERANCE],
        _ => TOLERANCES.to_vec(),
    };
    for tolerance in tolerances {
        let settings = SolveSettings { solver, steps: None, tolerance, max_sweeps: 5000, bases };
        let timed = || {
            let start = Instant::now();
            let solution = solve(medium, optics, &settings, &|_| Ok(())).expect("a good medium");
            (start.elapsed().as_secs_f64(), solution)
        };
        let (first, solution) = timed();
        let error = error(&solution);
        if error <= ERROR {
            return Run { tolerance, error, seconds: first.min(timed().0), solution };
        }
        let sweeps = solution.reports.iter().map(|report| report.sweeps).max().expect("solves");
        tried.push(format!("tolerance {tolerance:.1e}: error {error:.1e} after {sweeps}"));
    }
    panic!("{solver:?}: an error above {ERROR:e} at every tolerance tried: {tried:?}");
}

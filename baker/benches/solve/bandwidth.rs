//! How near the explicit solver comes to what the memory allows.

use std::time::Instant;

use flb_baker::lattice::explicit::SITE_BYTES;
use flb_baker::{SolveSettings, SolverKind, solve};
use flb_format::{Medium, Optics};
use rayon::prelude::*;

use crate::oak;

/// Rounds of triad and iterations in turn; the best of each counts, as others may use the machine.
const ROUNDS: usize = 5;

/// a = b + s c on all cores over arrays far larger than the caches.
pub struct Triad([Vec<f32>; 3]);

impl Triad {
    const VALUES: usize = 32 << 20;

    pub fn new() -> Triad {
        Triad([0.0, 1.0, 2.0].map(|value| vec![value; Self::VALUES]))
    }

    /// Bytes per second, the best of three: two values read, one written and fetched before that.
    pub fn measure(&mut self) -> f64 {
        let [a, b, c] = &mut self.0;
        let part = 1 << 16;
        let mut best: f64 = 0.0;
        for _ in 0..3 {
            let start = Instant::now();
            let parts = a.par_chunks_mut(part).zip(b.par_chunks(part)).zip(c.par_chunks(part));
            parts.for_each(|((a, b), c)| {
                a.iter_mut().zip(b).zip(c).for_each(|((a, b), c)| *a = *b + 0.5 * *c);
            });
            best = best.max((Self::VALUES * 4 * size_of::<f32>()) as f64 / start.elapsed().as_secs_f64());
        }
        best
    }
}

/// Bytes that an iteration of the explicit solver must move.
pub fn iteration_bytes(lattice: u32) -> f64 {
    libm::pow(f64::from(lattice), 3.0) * SITE_BYTES as f64
}

pub fn print(lattices: &[u32]) {
    let mut triad = Triad::new();
    println!("\n### Bandwidth: one base in one band, {SITE_BYTES} bytes per site and iteration\n");
    println!("| lattice | ns per site and iteration | GB/s | triad GB/s | of the bound |");
    println!("|---:|---:|---:|---:|---:|");
    for &lattice in lattices {
        let medium = oak::medium(lattice);
        let (mut seconds, mut bound) = (f64::INFINITY, 0.0_f64);
        for _ in 0..ROUNDS {
            bound = bound.max(triad.measure());
            // The difference of a long and a short solve is iterations and nothing else. Both end by their count,
            // as long as light may not have crossed the lattice.
            let [few, many] = [lattice / 4, lattice + lattice / 4];
            let time = iterate(&medium, many) - iterate(&medium, few);
            seconds = seconds.min(time / f64::from(many - few));
        }
        let (sites, speed) = (libm::pow(f64::from(lattice), 3.0), iteration_bytes(lattice) / seconds);
        println!(
            "| {lattice} | {:.2} | {:.1} | {:.1} | {:.0} % |",
            seconds / sites * 1e9,
            speed / 1e9,
            bound / 1e9,
            100.0 * speed / bound
        );
    }
}

/// Seconds of a solve of so many iterations.
fn iterate(medium: &Medium, iterations: u32) -> f64 {
    let optics = Optics { bands: vec![Optics::paper().bands[0].clone()] };
    let settings = SolveSettings {
        solver: SolverKind::Explicit,
        tolerance: 1e-12,
        max_sweeps: iterations,
        bases: [9].into_iter().collect(),
    };
    let start = Instant::now();
    let solution = solve(medium, &optics, &settings, &|_| {}).expect("a good medium");
    let seconds = start.elapsed().as_secs_f64();
    assert_eq!(solution.reports[0].sweeps, iterations, "the solve ended early");
    seconds
}

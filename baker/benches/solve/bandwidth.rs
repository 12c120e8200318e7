//! How near the explicit solver comes to what the memory allows.

use std::time::Instant;

use flb_format::Medium;
use flb_format::matter::Optics;
use flb_transport::lattice::explicit::SITE_BYTES;
use flb_transport::lattice::{SolveSettings, SolverKind, solve};
use rayon::prelude::*;

use crate::oak;

/// Rounds of triad and iterations in turn; the best of each counts, as others may use the machine.
const ROUNDS: usize = 5;

/// Arrays far larger than the caches.
pub(crate) struct Memory([Vec<f32>; 3]);

impl Memory {
    const VALUES: usize = 32 << 20;
    /// Values that a task takes.
    const PART: usize = 1 << 16;

    pub(crate) fn new() -> Memory {
        Memory([0.0, 1.0, 2.0].map(|value| vec![value; Self::VALUES]))
    }

    /// Bytes per second of a = b + s c on all cores: two values read, one written and fetched before that.
    pub(crate) fn triad(&mut self) -> f64 {
        let [a, b, c] = &mut self.0;
        best(Self::VALUES * 4 * size_of::<f32>(), || {
            let parts =
                a.par_chunks_mut(Self::PART).zip(b.par_chunks(Self::PART)).zip(c.par_chunks(Self::PART));
            parts.for_each(|((a, b), c)| {
                a.iter_mut().zip(b).zip(c).for_each(|((a, b), c)| *a = *b + 0.5 * *c);
            });
        })
    }

    /// Bytes per second of a = s a on all cores: as many bytes written as read, like the explicit solver.
    pub(crate) fn scale(&mut self) -> f64 {
        let a = &mut self.0[0];
        best(Self::VALUES * 2 * size_of::<f32>(), || {
            a.par_chunks_mut(Self::PART).for_each(|a| a.iter_mut().for_each(|a| *a *= 0.5));
        })
    }
}

/// Bytes per second, the best of three.
fn best(bytes: usize, mut run: impl FnMut()) -> f64 {
    let mut seconds = f64::INFINITY;
    for _ in 0..3 {
        let start = Instant::now();
        run();
        seconds = seconds.min(start.elapsed().as_secs_f64());
    }
    bytes as f64 / seconds
}

/// Bytes that an iteration of the explicit solver must move.
pub(crate) fn iteration_bytes(lattice: u32) -> f64 {
    libm::pow(f64::from(lattice), 3.0) * SITE_BYTES as f64
}

pub(crate) fn print(lattices: &[u32]) {
    let mut memory = Memory::new();
    println!("\n### Bandwidth: one base in one band, {SITE_BYTES} bytes per site and iteration\n");
    println!("| lattice | ns per site and iteration | GB/s | triad GB/s | of it | in place GB/s | of it |");
    println!("|---:|---:|---:|---:|---:|---:|---:|");
    for &lattice in lattices {
        let medium = oak::medium(lattice);
        let (mut seconds, mut triad, mut scale) = (f64::INFINITY, 0.0_f64, 0.0_f64);
        for _ in 0..ROUNDS {
            triad = triad.max(memory.triad());
            scale = scale.max(memory.scale());
            // The difference of a long and a short solve is iterations and nothing else. Both end by their count,
            // as long as light may not have crossed the lattice.
            let [few, many] = [lattice / 4, lattice + 16];
            let time = iterate(&medium, many) - iterate(&medium, few);
            seconds = seconds.min(time / f64::from(many - few));
        }
        let (sites, speed) = (libm::pow(f64::from(lattice), 3.0), iteration_bytes(lattice) / seconds);
        println!(
            "| {lattice} | {:.2} | {:.1} | {:.1} | {:.0} % | {:.1} | {:.0} % |",
            seconds / sites * 1e9,
            speed / 1e9,
            triad / 1e9,
            100.0 * speed / triad,
            scale / 1e9,
            100.0 * speed / scale
        );
    }
}

/// Seconds of a solve of so many iterations.
fn iterate(medium: &Medium, iterations: u32) -> f64 {
    let optics = Optics { bands: vec![Optics::paper().bands[0].clone()] };
    let settings = SolveSettings {
        steps: None,
        solver: SolverKind::Explicit,
        tolerance: 1e-12,
        max_sweeps: iterations,
        bases: [9].into_iter().collect(),
    };
    let start = Instant::now();
    let solution = solve(medium, &optics, &settings, &|_| Ok(())).expect("a good medium");
    let seconds = start.elapsed().as_secs_f64();
    assert_eq!(solution.reports[0].sweeps, iterations, "the solve ended early");
    seconds
}

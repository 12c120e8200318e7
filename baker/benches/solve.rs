//! Seconds per solve of all 19 bases in 3 bands, on a crown made by code; and, side by side at lattice 64 in one
//! band, the explicit solver and the memory bandwidth that bounds it.
//!
//! `cargo bench -p flb-baker --bench solve`

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use flb_baker::lattice::media;
use flb_baker::{SolveSettings, SolverKind, solve};
use flb_format::Optics;
use rayon::prelude::*;

fn solve_crowns(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("solve");
    group.sample_size(10);
    for lattice in [32, 64, 128] {
        let medium = media::tree(lattice, 7);
        let (optics, settings) = (Optics::paper(), SolveSettings::default());
        group.bench_function(format!("tree_{lattice}"), |bencher| {
            bencher.iter(|| solve(&medium, &optics, &settings, &|_| {}).expect("the medium is valid"));
        });
    }
    group.finish();
}

/// Both solvers to the same tolerance. Bytes: what the explicit one moves in the iterations that it reports, 18 values
/// read, written, and fetched before writing, per site.
fn solvers_side_by_side(criterion: &mut Criterion) {
    const LATTICE: u32 = 64;
    let medium = media::tree(LATTICE, 7);
    let optics = Optics { bands: vec![Optics::paper().bands[0].clone()] };
    let mut group = criterion.benchmark_group(format!("one_band_{LATTICE}"));
    group.sample_size(10);
    for solver in [SolverKind::Sweep, SolverKind::Explicit] {
        let settings = SolveSettings { solver, max_sweeps: 2000, ..SolveSettings::default() };
        let run = || solve(&medium, &optics, &settings, &|_| {}).expect("the medium is valid");
        if solver == SolverKind::Explicit {
            let iterations: u64 = run().reports[1..].iter().map(|report| u64::from(report.sweeps)).sum();
            group.throughput(Throughput::Bytes(iterations * medium.grid.sites() as u64 * 216));
        }
        group.bench_function(format!("{solver:?}"), |bencher| bencher.iter(run));
    }
    group.finish();
}

/// a = b + s c on all cores over arrays far larger than the caches: the bandwidth that the explicit solver is held to.
fn triad(criterion: &mut Criterion) {
    const VALUES: usize = 32 << 20;
    let (b, c) = (vec![1.0_f32; VALUES], vec![2.0_f32; VALUES]);
    let mut a = vec![0.0_f32; VALUES];
    let mut group = criterion.benchmark_group("bandwidth");
    group.sample_size(10);
    // Two read, one written and fetched before that.
    group.throughput(Throughput::Bytes(VALUES as u64 * 16));
    group.bench_function("triad", |bencher| {
        bencher.iter(|| {
            let part = 1 << 16;
            let parts = a.par_chunks_mut(part).zip(b.par_chunks(part)).zip(c.par_chunks(part));
            parts.for_each(|((a, b), c)| {
                a.iter_mut().zip(b).zip(c).for_each(|((a, b), c)| *a = b + 0.5 * c);
            });
        });
    });
    group.finish();
}

criterion_group!(benches, solve_crowns, solvers_side_by_side, triad);
criterion_main!(benches);

//! Seconds per solve of all 19 bases in 3 bands, on a crown made by code: the GPU and the sweeps of the CPU side by
//! side, to the same tolerance. Prints the GPU, and what error both expect.
//!
//! `cargo bench -p flb-baker --features gpu --bench gpu`; lattice 128 as well with `FLB_BENCH_128=1`, which takes long
//! where software stands in for a GPU.

use criterion::{Criterion, criterion_group, criterion_main};
use flb_format::matter::Optics;
use flb_transport::lattice::{SolveSettings, SolverKind, find_gpu, media, solve};

fn gpu_and_cpu(criterion: &mut Criterion) {
    match find_gpu() {
        Ok(name) => eprintln!("GPU: {name}"),
        Err(error) => panic!("{error}"),
    }
    let largest = std::env::var_os("FLB_BENCH_128").map(|_| 128);
    for lattice in [32, 64].into_iter().chain(largest) {
        let mut group = criterion.benchmark_group(format!("gpu_and_cpu_{lattice}"));
        group.sample_size(10);
        let medium = media::tree(lattice, 7);
        let optics = Optics::paper();
        for solver in [SolverKind::Sweep, SolverKind::GPU] {
            let settings = SolveSettings { solver, ..SolveSettings::default() };
            let run = || solve(&medium, &optics, &settings, &|_| Ok(())).expect("it can be solved");
            let ambient = run().reports[0];
            eprintln!(
                "{solver:?} {lattice}: {} sweeps at most, expected error {:.1e}",
                ambient.sweeps, ambient.error_estimate
            );
            group.bench_function(format!("{solver:?}"), |bencher| bencher.iter(run));
        }
        group.finish();
    }
}

criterion_group!(benches, gpu_and_cpu);
criterion_main!(benches);

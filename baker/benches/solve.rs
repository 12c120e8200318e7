//! Seconds per solve of all 19 bases in 3 bands, on a crown made by code.
//!
//! `cargo bench -p flb-baker --bench solve`

use criterion::{Criterion, criterion_group, criterion_main};
use flb_baker::{SolveSettings, solve};
use flb_format::Optics;

#[path = "../src/lattice/media.rs"]
#[allow(dead_code)]
mod media;

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

criterion_group!(benches, solve_crowns);
criterion_main!(benches);

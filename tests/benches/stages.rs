//! Seconds per stage on the built-in oak.
//!
//! `cargo bench -p flb-tests --bench stages` times lattices 32 and 64; with `FLB_BENCH_128=1` also 128, with
//! the voxels and triangles of a real bake, which takes minutes.

use std::hint::black_box;
use std::time::Duration;

use criterion::{Criterion, criterion_group, criterion_main};
use flb_baker::{downsample, voxelise};
use flb_fixtures::{PlantKind, grow};
use flb_format::matter::Optics;
use flb_format::sun;
use flb_inspector::{Level, validate};
use flb_render::Indirect;
use flb_runtime::Library;
use flb_runtime::samplers::{SpeciesSampler, bases_needed};
use flb_tests::pipeline::{self, Recipe, SEED, bake, encode, import_glb, voxel_settings};
use flb_tests::portrait::{Scene, portrait_of};
use flb_transport::lattice::{SolveSettings, solve};

/// Points of the sampling bench.
const POINTS: u32 = 100_000;

fn recipes() -> Vec<Recipe> {
    let of = |lattice: u32| Recipe {
        kind: PlantKind::Oak,
        triangles: 80_000,
        lattice,
        voxels: lattice * 8,
        threshold: 0.005,
    };
    let large = std::env::var_os("FLB_BENCH_128").is_some();
    [32, 64, 128].into_iter().filter(|lattice| *lattice < 128 || large).map(of).collect()
}

fn stages(criterion: &mut Criterion) {
    for recipe in recipes() {
        let mut group = criterion.benchmark_group(format!("oak_{}", recipe.lattice));
        group
            .sample_size(10)
            .warm_up_time(Duration::from_millis(200))
            .measurement_time(Duration::from_secs(2));
        let baked = bake(&recipe);
        let classes = baked.classes();
        group.bench_function("grow", |b| b.iter(|| grow(recipe.kind, SEED, recipe.triangles)));
        group.bench_function("import", |b| b.iter(|| import_glb("oak", &baked.glb)));
        let settings = voxel_settings(&recipe);
        group.bench_function("voxelise", |b| {
            b.iter(|| voxelise(&baked.mesh, &classes, &settings, &|_| Ok(())))
        });
        group.bench_function("downsample", |b| b.iter(|| downsample(&baked.occupancy)));
        let (optics, settings) = (Optics::paper(), SolveSettings::default());
        group.bench_function("solve", |b| b.iter(|| solve(&baked.medium, &optics, &settings, &|_| Ok(()))));
        group.bench_function("encode", |b| {
            b.iter(|| encode(&recipe, &baked.mesh, &classes, &baked.medium, &baked.solution));
        });
        group.bench_function("write", |b| b.iter(|| pipeline::write(&baked.encoded)));
        group.bench_function("validate", |b| b.iter(|| validate(&baked.file, Level::Decode)));

        let library = Library::from_source("oak", Box::new(baked.file.clone())).expect("a valid file");
        let blend = sun::blend(sun::towards_sun(135.0, 30.0)).expect("angles give a direction");
        let bases = bases_needed(&blend, true);
        group.bench_function("load", |b| b.iter(|| SpeciesSampler::load(&library, 0, &bases)));
        let sampler = SpeciesSampler::load(&library, 0, &bases).expect("the file holds all bases");
        group.bench_function("sample_100k", |b| b.iter(|| black_box(walk(&sampler, &blend))));
        let scene =
            Scene { sun: [135.0, 30.0], indirect: Indirect::On, ambient: 0.02, edge: 256, samples: 4 };
        group.bench_function("render_256", |b| {
            b.iter(|| portrait_of(&library, &baked.mesh, &classes, &scene))
        });
        group.finish();
    }
}

/// Samples all over the lattice.
fn walk(sampler: &SpeciesSampler, blend: &sun::SunBlend) -> f32 {
    let grid = sampler.grid();
    let edge_m = grid.spacing_m * f64::from(grid.lattice);
    let mut sum = 0.0;
    for i in 0..POINTS {
        let hash = |salt: u32| f64::from((i ^ salt).wrapping_mul(0x9e37_79b9)) / f64::from(u32::MAX);
        let point =
            [0, 1, 2].map(|axis| (grid.origin_m[axis as usize] + edge_m * hash(axis * 0x51ed)) as f32);
        let mut phi = [0.0; 3];
        sampler.indirect(blend, 1.0, 0.02, point, &mut phi);
        sum += phi[1];
    }
    sum
}

criterion_group!(benches, stages);
criterion_main!(benches);

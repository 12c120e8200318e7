//! Times of the block codec: `cargo bench -p flb-format`.
//!
//! The field is 64^3 with three bands: 1 outside a ball, and inside it light that falls off from above with
//! one value of noise per site, about as rough as a crown. The kept coefficients per block are printed.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use flb_format::Field;
use flb_format::block::{TEXELS, blocks_per_axis, decode, encode, gather};
use flb_format::sample::{Weights, locate, trilinear};

const N: u32 = 64;
const BANDS: usize = 3;
/// Points per timed pass.
const POINTS: usize = 4096;

fn main_field() -> Field {
    let mut field = Field::zeros(N, BANDS as u32);
    let n = N as usize;
    for (i, value) in field.values_mut().iter_mut().enumerate() {
        let (x, y, z) = (i % n, i / n % n, i / n / n % n);
        let from_center = [x, y, z].map(|c| c as f32 - 31.5).iter().map(|c| c * c).sum::<f32>();
        let noise = (i.wrapping_mul(2_654_435_761) >> 7 & 255) as f32 / 255.0;
        *value = if from_center > 24.0 * 24.0 { 1.0 } else { (0.1 + y as f32 / 80.0) * (0.8 + 0.4 * noise) };
    }
    field
}

/// `[block]` mask and first coefficient, and the coefficients of all.
struct Coded {
    blocks: Vec<(u64, u32)>,
    coefficients: Vec<f32>,
}

fn code(field: &Field, threshold: f32) -> Coded {
    let edge = blocks_per_axis(N);
    let mut coded = Coded { blocks: Vec::new(), coefficients: Vec::new() };
    let mut texels = [0.0; TEXELS * BANDS];
    for b in 0..edge.pow(3) {
        gather(field, [b % edge, b / edge % edge, b / edge / edge], &mut texels);
        let first = (coded.coefficients.len() / BANDS) as u32;
        coded.blocks.push((encode(&texels, BANDS, threshold, &mut coded.coefficients), first));
    }
    coded
}

/// Points in lattice units inside the ball: anywhere, or along a line of short steps.
fn points(coherent: bool) -> Vec<[f64; 3]> {
    let mut state = 1u64;
    let mut unit = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(1u32 << 31)
    };
    (0..POINTS)
        .map(|i| {
            if coherent {
                let (row, step) = (i / 128, i % 128);
                [20.0 + step as f64 * 0.15, 20.0 + row as f64 * 0.2, 31.0 + row as f64 * 0.1]
            } else {
                std::array::from_fn(|_| 18.0 + 28.0 * unit())
            }
        })
        .collect()
}

fn benches(criterion: &mut Criterion) {
    let field = main_field();
    for threshold in [0.01, 0.05] {
        let coded = code(&field, threshold);
        let inside: Vec<_> = coded.blocks.iter().filter(|b| b.0.count_ones() > 1).collect();
        let kept: u32 = inside.iter().map(|b| b.0.count_ones()).sum();
        println!(
            "threshold {threshold}: {:.1} coefficients per non-constant block",
            f64::from(kept) / inside.len() as f64
        );

        let mut group = criterion.benchmark_group(format!("threshold {threshold}"));
        let mut texels = [0.0; TEXELS * BANDS];
        group.throughput(Throughput::Elements(TEXELS as u64));
        gather(&field, [10; 3], &mut texels);
        let mut coefficients = Vec::with_capacity(TEXELS * BANDS);
        group.bench_function("encode a block", |b| {
            b.iter(|| {
                coefficients.clear();
                encode(black_box(&texels), BANDS, threshold, &mut coefficients)
            });
        });
        coefficients.clear();
        let mask = encode(&texels, BANDS, threshold, &mut coefficients);
        group.bench_function("decode a block", |b| {
            b.iter(|| decode(black_box(mask), &coefficients, BANDS, black_box(&mut texels)));
        });

        group.throughput(Throughput::Elements(POINTS as u64));
        for (name, coherent) in [("random", false), ("coherent", true)] {
            let points = points(coherent);
            group.bench_function(format!("sample from coefficients, {name}"), |b| {
                b.iter(|| points.iter().map(|p| sample_coded(&coded, *p)[1]).sum::<f32>());
            });
            group.bench_function(format!("decode and sample, {name}"), |b| {
                b.iter(|| points.iter().map(|p| sample_decoded(&coded, *p)[1]).sum::<f32>());
            });
            group.bench_function(format!("sample raw floats, {name}"), |b| {
                b.iter(|| {
                    let mut out = [0.0; BANDS];
                    points
                        .iter()
                        .map(|p| {
                            trilinear(&field, *p, &mut out);
                            out[1]
                        })
                        .sum::<f32>()
                });
            });
        }
    }
}

fn sample_coded(coded: &Coded, point: [f64; 3]) -> [f32; BANDS] {
    let at = locate(N, point);
    let (mask, first) = coded.blocks[at.block_index(N) as usize];
    let mut out = [0.0; BANDS];
    Weights::at(at.local).add(mask, &coded.coefficients[first as usize * BANDS..], 1.0, &mut out);
    out
}

/// The oracle's way: expand the block, then take eight texels.
fn sample_decoded(coded: &Coded, point: [f64; 3]) -> [f32; BANDS] {
    let at = locate(N, point);
    let (mask, first) = coded.blocks[at.block_index(N) as usize];
    let kept = &coded.coefficients[first as usize * BANDS..][..mask.count_ones() as usize * BANDS];
    let mut texels = [0.0; TEXELS * BANDS];
    decode(mask, kept, BANDS, &mut texels);
    let first = at.local.map(|l| (l as usize).min(2));
    let mut out = [0.0; BANDS];
    for corner in 0..8 {
        let mut weight = 1.0;
        let mut texel = 0;
        for (axis, start) in first.iter().enumerate() {
            let t = at.local[axis] - *start as f32;
            let far = corner >> axis & 1;
            weight *= if far == 1 { t } else { 1.0 - t };
            texel += (start + far) << (2 * axis);
        }
        for band in 0..BANDS {
            out[band] += weight * texels[texel * BANDS + band];
        }
    }
    out
}

criterion_group!(all, benches);
criterion_main!(all);

//! Times of samples, on one core: the best of several passes over the same points.

use std::hint::black_box;
use std::time::Instant;

use flb_format::blocks::Cursor;
use flb_format::sample::{site_of, trilinear};
use flb_packer::rate::SpeciesPayloads;

use crate::overlapped::place;
use crate::plant::Plant;
use crate::surface::{read, shared};

/// Points of a pass, and of them those of a run.
const POINTS: usize = 65_536;
const RUN: usize = 32;
/// Between points of a run, in sites.
const STRIDE: f64 = 0.15;
/// Passes.
const PASSES: usize = 60;
/// Base that is sampled, if there is such.
const BASE: usize = 7;

/// Prints nanoseconds a sample.
pub(crate) fn samples(plant: &Plant, coded: &SpeciesPayloads) {
    let which = BASE.min(plant.bases().len() - 1);
    let base = read(&shared(plant, coded), &coded.bases[which]);
    let field = &plant.bases()[which].1;
    for (name, coherent) in [("random", false), ("coherent", true)] {
        let points = points(plant, coherent);
        let mut cursor = Cursor::new(&base);
        let mut best = [f64::MAX; 3];
        // In turns, so that a machine that is slow for a while is slow for all.
        for _ in 0..PASSES {
            let passes = [
                time(&points, field.bands, |point, out| base.sample(point, out)),
                time(&points, field.bands, |point, out| cursor.sample(point, out)),
                time(&points, field.bands, |point, out| trilinear(field, point, out)),
            ];
            best = std::array::from_fn(|i| best[i].min(passes[i]));
        }
        let [bits, by_cursor, floats] = best;
        println!(
            "a {name} sample of {} bands: {bits:.0} ns from coded bits, {by_cursor:.0} ns by a cursor, {floats:.0} ns from plain floats: {:.2} and {:.2} times as long",
            field.bands,
            bits / floats,
            by_cursor / floats
        );
    }
}

/// Prints nanoseconds a sample of blocks that overlap, beside those of the same points.
pub(crate) fn overlapped(plant: &Plant, wide: &Plant, coded: &SpeciesPayloads) {
    let which = BASE.min(plant.bases().len() - 1);
    let base = read(&shared(wide, coded), &coded.bases[which]);
    let field = &plant.bases()[which].1;
    for (name, coherent) in [("random", false), ("coherent", true)] {
        let points: Vec<_> = points(plant, coherent).into_iter().map(|p| place(plant.lattice, p)).collect();
        let best = (0..PASSES)
            .map(|_| time(&points, field.bands, |point, out| base.sample(point, out)))
            .fold(f64::MAX, f64::min);
        println!("a {name} sample of {} bands: {best:.0} ns from blocks that overlap", field.bands);
    }
}

/// Nanoseconds a sample in one pass over the points.
fn time(points: &[[f64; 3]], bands: u32, mut sample: impl FnMut([f64; 3], &mut [f32])) -> f64 {
    let mut out = vec![0.0; bands as usize];
    let start = Instant::now();
    for point in points {
        sample(*point, &mut out);
        black_box(&out);
    }
    start.elapsed().as_secs_f64() * 1e9 / points.len() as f64
}

/// Points in non-empty sites: anywhere, or in runs of short steps.
fn points(plant: &Plant, coherent: bool) -> Vec<[f64; 3]> {
    let mut unit = random();
    let n = plant.lattice as usize;
    let place = |site: usize| site_of(site, plant.lattice).map(f64::from);
    let is_inside = |point: &[f64; 3]| {
        let at = point.map(|c| c as usize);
        point.iter().all(|c| *c >= 0.0 && *c < n as f64) && plant.non_empty[(at[2] * n + at[1]) * n + at[0]]
    };
    let sites: Vec<usize> = (0..plant.non_empty.len()).filter(|site| plant.non_empty[*site]).collect();
    let mut points = Vec::new();
    while points.len() < POINTS {
        let first = place(sites[(unit() * sites.len() as f64) as usize]).map(|c| c + unit());
        let way = [(); 3].map(|()| unit() - 0.5);
        let length = way.iter().map(|c| c * c).sum::<f64>().sqrt();
        let count = if coherent { RUN } else { 1 };
        let at = |k: usize| std::array::from_fn(|a| first[a] + way[a] / length * STRIDE * k as f64);
        let run: Vec<[f64; 3]> = (0..count).map(at).collect();
        if run.iter().all(is_inside) {
            points.extend(run);
        }
    }
    points
}

/// Numbers in 0..1 by a linear congruence (Knuth's MMIX).
fn random() -> impl FnMut() -> f64 {
    let mut state = 1u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(1u32 << 31)
    }
}

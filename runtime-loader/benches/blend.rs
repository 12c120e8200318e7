//! Price of a blend of four bases, and of all that a file has, on one CPU core, coded and uncoded side by side:
//! `cargo bench -p flb-runtime --bench blend [-- FILE.flb]`.
//!
//! Uncoded fields are floats that lie as a sample needs them; each base is filtered by itself, since no renderer adds
//! up fields of 128^3 for every instance. `Cursor` adds up blocks, which `LightCursor` does for a streamed species. At
//! 262,144 points, as a picture meets them (squares of 8 by 8 neighbours at the first matter along z) and anywhere in
//! the plant. Ways take turns; the best of several rounds counts. Without a file a crown by formula is packed.

mod plant;

use std::hint::black_box;
use std::time::Instant;

use flb_format::blocks::{CodedBase, Cursor, SpeciesPoint};
use plant::{BASES, Plant, interleaved};

const ROUNDS: usize = 9;
/// Between ways, relative to the brightest.
const ALIKE: f32 = 1e-4;
const BANDS: usize = 3;

/// Uncoded fields.
struct Volumes {
    lattice: usize,
    /// `[base][z][y][x][band]`
    texels: Vec<f32>,
}

impl Volumes {
    fn new(bases: &[&CodedBase]) -> Volumes {
        let texels = bases.iter().flat_map(|base| interleaved(base, BANDS)).collect();
        Volumes { lattice: bases[0].shared().map.lattice() as usize, texels }
    }

    /// The point is looked for once, each base is filtered by itself.
    #[inline]
    fn blend(&self, factors: &[f32], point: [f64; 3], out: &mut [f32; BANDS]) {
        let n = self.lattice;
        let place = point.map(|c| (c - 0.5).max(0.0).min((n - 1) as f64));
        let texel = place.map(|c| (c as usize).min(n - 2));
        let part: [f32; 3] = std::array::from_fn(|a| (place[a] - texel[a] as f64) as f32);
        let weight = |axis: usize, upper: usize| if upper == 1 { part[axis] } else { 1.0 - part[axis] };
        let first = (texel[2] * n + texel[1]) * n + texel[0];
        for (base, factor) in factors.iter().enumerate() {
            for (z, y) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                let row = BANDS * (base * n * n * n + first + (z * n + y) * n);
                let along = factor * weight(2, z) * weight(1, y);
                let [left, right] = [along * weight(0, 0), along * weight(0, 1)];
                let texels = &self.texels[row..row + 2 * BANDS];
                for (band, value) in out.iter_mut().enumerate() {
                    *value += left * texels[band] + right * texels[BANDS + band];
                }
            }
        }
    }
}

fn main() {
    let file = std::env::args().skip(1).find(|argument| !argument.starts_with("--"));
    let plant = file.map_or_else(Plant::made, |path| Plant::read(&path));
    let bands = plant.bases[0].head().bands as usize;
    assert_eq!(bands, BANDS, "{}: its bands", plant.name);
    println!("plant: {}, lattice {}", plant.name, plant.grid.lattice);
    println!("times and ratios to uncoded:");
    println!("bases points    uncoded     straight         by cursor");
    let all: Vec<&CodedBase> = plant.bases.iter().chain(plant.rest.iter().map(|(_, base)| base)).collect();
    compare(&plant, &all[..BASES]);
    if all.len() > BASES {
        compare(&plant, &all);
    }
}

fn compare(plant: &Plant, bases: &[&CodedBase]) {
    let volumes = Volumes::new(bases);
    let factor = |i: usize| 0.1 + (i * 7 % 11) as f32 / 20.0;
    let terms: Vec<(&CodedBase, f32)> = (0..).map(factor).zip(bases).map(|(f, base)| (*base, f)).collect();
    let factors: Vec<f32> = terms.iter().map(|(_, factor)| *factor).collect();
    for (name, points) in [("picture", plant.sweep()), ("random", plant.scattered())] {
        let points: Vec<[f64; 3]> =
            points.iter().map(|p| plant.grid.lattice_from_model(p.map(f64::from))).collect();
        let mut cursor = Cursor::of_sums(vec![terms.clone()]);
        let mut best = [f64::MAX; 3];
        for round in 0..ROUNDS {
            let times = [
                time(&points, |point, out| volumes.blend(&factors, point, out)),
                time(&points, |point, out| coded(&terms, point, out)),
                time(&points, |point, out| cursor.sample(point, out)),
            ];
            for (best, (seconds, _)) in best.iter_mut().zip(&times) {
                *best = best.min(*seconds);
            }
            if round == 0 {
                let [expected, straight, expanded] = times.map(|(_, light)| light);
                let peak = expected.iter().flatten().fold(0.0f32, |peak, value| peak.max(value.abs()));
                for found in [straight, expanded] {
                    let pairs = found.iter().flatten().zip(expected.iter().flatten());
                    let worst = pairs.fold(0.0f32, |worst, (a, b)| worst.max((a - b).abs()));
                    assert!(worst <= ALIKE * peak, "{worst} of {peak}");
                }
            }
        }
        let [uncoded, straight, expanded] = best.map(|seconds| 1e9 * seconds / points.len() as f64);
        println!(
            "{:5} {name:8} {uncoded:6.0} ns {straight:6.0} ns {:6.2} {expanded:6.0} ns {:6.2}",
            bases.len(),
            straight / uncoded,
            expanded / uncoded
        );
    }
}

/// Straight from the coded bits.
fn coded(terms: &[(&CodedBase, f32)], point: [f64; 3], out: &mut [f32; BANDS]) {
    let place = SpeciesPoint::new(terms[0].0.shared(), point);
    let mut one = [0.0; BANDS];
    for (base, factor) in terms {
        base.sample_at(&place, &mut one);
        out.iter_mut().zip(one).for_each(|(out, light)| *out += factor * light);
    }
}

/// Seconds, and the light at all points.
fn time(points: &[[f64; 3]], mut light: impl FnMut([f64; 3], &mut [f32; BANDS])) -> (f64, Vec<[f32; BANDS]>) {
    let mut found = vec![[0.0; BANDS]; points.len()];
    let start = Instant::now();
    for (point, found) in points.iter().zip(&mut found) {
        light(*point, black_box(found));
    }
    (start.elapsed().as_secs_f64(), found)
}

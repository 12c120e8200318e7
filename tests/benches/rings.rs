//! The near beam by rings of suns, against marches and against suns that are prepared by themselves:
//!
//! ```text
//! cargo bench -p flb-tests --bench rings                      # the default bake of the built-in oak at lattice 64
//! cargo bench -p flb-tests --bench rings -- FILE.flb          # points all over the sites that hold matter
//! cargo bench -p flb-tests --bench rings -- PLANT TRIANGLES [LATTICE]
//! ```
//!
//! For suns of four heights: how long a ring takes to make on one thread, its bytes, how far a point's light is off
//! (rms, % of the mean), how far the mean is, and the time of a sample by a cursor. At points of the plant's surface,
//! even by area, under suns of odd azimuths, midway between two rings, with 0.36 of sky.

use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use flb_format::sun::towards_sun;
use flb_runtime::light::SunRings;
use flb_runtime::{Daylight, InstanceLight, SpeciesLight, Transform};
use flb_tests::benched::{Benched, benched};

const POINTS: u32 = 2048;
const SUNS: usize = 8;
const ELEVATIONS_DEG: [f64; 4] = [5.0, 21.0, 45.0, 71.0];

/// Light at the points, and seconds a point.
fn light(lit: &InstanceLight, points: &[[f32; 3]]) -> (Vec<f32>, f64) {
    let mut all = vec![0.0; points.len() * lit.bands()];
    let mut cursor = lit.cursor();
    let begin = Instant::now();
    for (point, out) in points.iter().zip(all.chunks_exact_mut(lit.bands())) {
        cursor.at(*point, out);
    }
    let seconds = begin.elapsed().as_secs_f64() / points.len() as f64;
    (black_box(all), seconds)
}

/// Differences from exact light, summed.
#[derive(Default)]
struct Sums {
    square: f64,
    bias: f64,
    whole: f64,
    samples: f64,
    seconds: f64,
}

impl Sums {
    fn add(&mut self, (found, seconds): (Vec<f32>, f64), exact: &[f32]) {
        for (found, exact) in found.iter().zip(exact) {
            let off = f64::from(found - exact);
            self.square += off * off;
            self.bias += off;
            self.whole += f64::from(*exact);
            self.samples += 1.0;
        }
        self.seconds += seconds;
    }

    fn text(&self) -> String {
        let rms = (self.square / self.samples).sqrt() / (self.whole / self.samples);
        let (bias, micros) = (self.bias / self.whole, 1e6 * self.seconds / SUNS as f64);
        format!("{:.2} % | {:+.2} % | {micros:.2}", 100.0 * rms, 100.0 * bias)
    }
}

fn main() {
    let Benched { library, points } = benched(POINTS);
    let species = SpeciesLight::load(&library, 0).expect("a sound file");
    let begin = Instant::now();
    let near = species.near().expect("suns of harmonics");
    println!(
        "lattice {}; sums of all suns: {:.2} s\n",
        species.grid().lattice,
        begin.elapsed().as_secs_f64()
    );
    println!(
        "| sun's height | suns | make, s | MB | rings: rms | mean | us | marched: rms | mean | us | prepared: us |"
    );
    println!("|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
    for elevation_deg in ELEVATIONS_DEG {
        let mut rings = SunRings::default();
        let begin = Instant::now();
        let mut suns = 0;
        for step in SunRings::steps(towards_sun(0.0, elevation_deg)) {
            let ring = species.sun_ring(&near, step).expect("suns of harmonics");
            suns = suns.max(ring.suns());
            rings.insert(step, Arc::new(ring));
        }
        let make_s = begin.elapsed().as_secs_f64() / 2.0;
        let (mut by_rings, mut by_marches, mut prepared_s) = (Sums::default(), Sums::default(), 0.0);
        for number in 0..SUNS {
            let azimuth_deg = 137.508 * number as f64 + 11.0;
            let daylight =
                Daylight { towards_sun: towards_sun(azimuth_deg, elevation_deg), sun: 1.0, sky: 0.36 };
            let lit = || species.lit_by(&daylight, &Transform::IDENTITY).expect("a sun");
            let (exact, seconds) = light(&lit().prepared_by(Some(&near)), &points);
            prepared_s += seconds;
            by_rings.add(light(&lit().with_rings(&rings), &points), &exact);
            by_marches.add(light(&lit(), &points), &exact);
        }
        println!(
            "| {elevation_deg} | {suns} | {make_s:.1} | {:.1} | {} | {} | {:.2} |",
            rings.size_bytes() as f64 / 2e6,
            by_rings.text(),
            by_marches.text(),
            1e6 * prepared_s / SUNS as f64
        );
    }
}

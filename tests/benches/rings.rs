//! The near beam by rings of suns, against marches and against suns that are prepared by themselves:
//!
//! ```text
//! cargo bench -p flb-tests --bench rings                      # the default bake of the built-in oak at lattice 64
//! cargo bench -p flb-tests --bench rings -- FILE.flb          # points all over the sites that hold matter
//! cargo bench -p flb-tests --bench rings -- PLANT TRIANGLES [LATTICE]
//! ```
//!
//! For suns of four heights: how long a ring takes to make on one thread, its bytes, how far a point's light is off
//! (rms, % of the mean), how far the mean is, and the time of a sample by a cursor; the same with expanded fields, and
//! of the whole light as a volume. At points of the plant's surface, even by area, under suns of odd azimuths, midway
//! between two rings, with 0.36 of sky.

use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use flb_format::beam::Near;
use flb_format::sun::towards_sun;
use flb_runtime::light::{FieldVolume, SunRings};
use flb_runtime::{Daylight, InstanceLight, SpeciesLight, Transform};
use flb_tests::benched::{Benched, benched};

const POINTS: u32 = 2048;
const SUNS: usize = 8;
const ELEVATIONS_DEG: [f64; 4] = [5.0, 21.0, 45.0, 71.0];

/// Light at the points by a cursor, and seconds a point.
fn light(lit: &InstanceLight, points: &[[f32; 3]]) -> (Vec<f32>, f64) {
    let mut cursor = lit.cursor();
    asked(points, lit.bands(), |point, out| cursor.at(point, out))
}

fn asked(points: &[[f32; 3]], bands: usize, mut at: impl FnMut([f32; 3], &mut [f32])) -> (Vec<f32>, f64) {
    let mut all = vec![0.0; points.len() * bands];
    let begin = Instant::now();
    for (point, out) in points.iter().zip(all.chunks_exact_mut(bands)) {
        at(*point, out);
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

/// What is asked at the points under each sun.
struct Asked<'a> {
    species: &'a SpeciesLight<'a>,
    near: &'a Near<'a>,
    points: &'a [[f32; 3]],
}

impl Asked<'_> {
    /// Eight suns of a height.
    fn days(elevation_deg: f64) -> impl Iterator<Item = Daylight> {
        (0..SUNS).map(move |number| {
            let azimuth_deg = 137.508 * number as f64 + 11.0;
            Daylight { towards_sun: towards_sun(azimuth_deg, elevation_deg), sun: 1.0, sky: 0.36 }
        })
    }

    fn lit(&self, day: &Daylight) -> InstanceLight<'_> {
        self.species.lit_by(day, &Transform::IDENTITY).expect("a sun")
    }

    fn rings(&self, fields: &FieldVolume, elevation_deg: f64) {
        let mut rings = SunRings::default();
        let begin = Instant::now();
        let mut suns = 0;
        for step in SunRings::steps(towards_sun(0.0, elevation_deg)) {
            let ring = self.species.sun_ring(self.near, step).expect("suns of harmonics");
            suns = suns.max(ring.suns());
            rings.insert(step, Arc::new(ring));
        }
        let make_s = begin.elapsed().as_secs_f64() / 2.0;
        let [mut by_rings, mut by_fields, mut by_marches] = [(); 3].map(|()| Sums::default());
        for day in Asked::days(elevation_deg) {
            let (exact, _) = light(&self.lit(&day).prepared_by(Some(self.near)), self.points);
            by_rings.add(light(&self.lit(&day).with_rings(&rings), self.points), &exact);
            let expanded = self.lit(&day).with_rings(&rings).with_fields(fields);
            by_fields.add(light(&expanded, self.points), &exact);
            by_marches.add(light(&self.lit(&day), self.points), &exact);
        }
        println!(
            "| {elevation_deg} | {suns} | {make_s:.1} | {:.1} | {} | {} | {} |",
            rings.size_bytes() as f64 / 2e6,
            by_rings.text(),
            by_fields.text(),
            by_marches.text(),
        );
    }

    fn volumes(&self, elevation_deg: f64) {
        let ([mut prepare_s, mut exact_s, mut make_s], mut bytes) = ([0.0; 3], 0);
        let mut by_volumes = Sums::default();
        for day in Asked::days(elevation_deg) {
            let begin = Instant::now();
            let prepared = self.lit(&day).prepared_by(Some(self.near));
            prepare_s += begin.elapsed().as_secs_f64();
            let (exact, seconds) = light(&prepared, self.points);
            exact_s += seconds;
            let begin = Instant::now();
            let volume = prepared.volume().expect("blocks near geometry");
            make_s += begin.elapsed().as_secs_f64();
            bytes = volume.size_bytes();
            let found = asked(self.points, volume.bands(), |point, out| volume.at(point, out));
            by_volumes.add(found, &exact);
        }
        let of_one = |seconds: f64| seconds / SUNS as f64;
        println!(
            "| {elevation_deg} | {:.2} | {:.2} | {:.2} | {} | {:.2} |",
            of_one(prepare_s),
            of_one(make_s),
            bytes as f64 / 1e6,
            by_volumes.text(),
            1e6 * of_one(exact_s)
        );
    }
}

fn main() {
    let Benched { library, points } = benched(POINTS);
    let species = SpeciesLight::load(&library, 0).expect("a sound file");
    let begin = Instant::now();
    let near = species.near().expect("suns of harmonics");
    let near_s = begin.elapsed().as_secs_f64();
    let begin = Instant::now();
    let fields = species.field_volume().expect("blocks near geometry");
    println!(
        "lattice {}; sums of all suns: {near_s:.2} s; expanded fields: {:.2} s, {:.1} MB\n",
        species.grid().lattice,
        begin.elapsed().as_secs_f64(),
        fields.size_bytes() as f64 / 1e6
    );
    let asked = Asked { species: &species, near: &near, points: &points };
    println!(
        "| sun's height | suns | make, s | MB | rings: rms | mean | us | and fields: rms | mean | us | marched: rms | mean | us |"
    );
    println!("|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
    ELEVATIONS_DEG.into_iter().for_each(|elevation_deg| asked.rings(&fields, elevation_deg));
    println!("\n| sun's height | prepare, s | make, s | MB | volume: rms | mean | us | prepared: us |");
    println!("|---:|---:|---:|---:|---:|---:|---:|---:|");
    ELEVATIONS_DEG.into_iter().for_each(|elevation_deg| asked.volumes(elevation_deg));
}

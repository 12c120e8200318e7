//! What streaming costs a frame, and opening a file: `cargo bench -p flb-runtime --bench stream`.
//!
//! Prints, for 1,000 to 100,000 plants of five species that turn freely, and that stand upright, the milliseconds to
//! find what a frame shows and to plan it, on one core; then those to make the light of 10,000 plants, of a file and
//! streamed; then those to open libraries of 10 MB and of 1 GiB (written to the temporary folder, and removed).

use std::hint::black_box;
use std::sync::Arc;
use std::time::{Duration, Instant};

use flb_format::light::SunBasis;
use flb_format::{Codec, Placement, Transform};
use flb_packer::{encode_species, write_library_to};
use flb_runtime::residency::{NeedFinder, Placed, Residency, ResidencySettings, Units};
use flb_runtime::stream::{StreamSettings, Streamer};
use flb_runtime::view::Camera;
use flb_runtime::{Daylight, Library, SpeciesLight};
use flb_testkit::plants;

/// A uniform random rotation (Shoemake 1992), or one about the vertical.
fn rotation(i: u32, upright: bool) -> [[f64; 3]; 3] {
    turned(i, upright).map(|row| row.map(f64::from))
}

fn turned(i: u32, upright: bool) -> [[f32; 3]; 3] {
    let turn = |seed: u32| libm::sincosf(plants::noise(i, seed) * std::f32::consts::TAU);
    if upright {
        let (sin, cos) = turn(1);
        return [[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]];
    }
    let share = plants::noise(i, 5);
    let ((s1, c1), (s2, c2)) = (turn(2), turn(3));
    let (a, b) = (libm::sqrtf(1.0 - share), libm::sqrtf(share));
    let [x, y, z, w] = [a * s1, a * c1, b * s2, b * c2];
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
        [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn planning() {
    let harmonics = SunBasis::Harmonics { degree: 2, single: true, leaning: true };
    let plants: Vec<_> = (0..5)
        .map(|i| match i {
            0 | 1 => plants::plant("paper", None, 32, i),
            2 | 3 => plants::plant("directions", Some(&SunBasis::Lattice18), 32, i),
            _ => plants::plant("harmonics", Some(&harmonics), 32, i),
        })
        .enumerate()
        .map(|(i, mut plant)| {
            plant.meta.name = format!("{}{i}", plant.meta.name);
            plant
        })
        .collect();
    let bytes = plants::bytes(&plants, Codec::Classed);
    let library = Arc::new(Library::from_source("plants.flb", Box::new(bytes)).expect("it opens"));
    let units = Arc::new(Units::new(library.container(), library.path()).expect("coded near geometry"));
    println!(
        "| plants | turned | seen, % | find, ms | plan, ms | both, ms |\n|---:|---|---:|---:|---:|---:|"
    );
    for count in [1_000, 10_000, 100_000] {
        for upright in [true, false] {
            let side = libm::sqrtf(count as f32) * 6.0;
            let at = |i: u32| [(plants::noise(i, 8) - 0.5) * side, 0.0, (plants::noise(i, 9) - 0.5) * side];
            let plant = |i: u32| Placement {
                species: i as usize % 5,
                transform: Transform {
                    rotation: rotation(i, upright),
                    position_m: at(i).map(f64::from),
                    scale: (0.8 + 0.4 * plants::noise(i, 10)).into(),
                },
            };
            let placed = Placed::new(library.container(), (0..count).map(plant));
            let mut finder = NeedFinder::new(library.container(), &units);
            let mut residency = Residency::new(Arc::clone(&units), ResidencySettings::default());
            let (mut finding, mut plan, mut seen) = (Vec::new(), Vec::new(), 0.0);
            for frame in 0..60 {
                let (sin, cos) = libm::sincosf(frame as f32 * 0.1);
                // From above a corner of the forest: most of it is seen.
                let camera = Camera {
                    position_m: [0.0, 30.0, side * 0.6],
                    forward: [0.2 * sin, -0.2, -1.0],
                    up: [0.0, 1.0, 0.0],
                    fov_deg: 60.0,
                    width_px: 1920,
                    height_px: 1080,
                };
                let light = Daylight { towards_sun: [cos, 0.6, sin].map(f64::from), sun: 1.0, sky: 0.2 };
                let frustum = camera.frustum();
                let start = Instant::now();
                let need = black_box(finder.find(&placed, &camera, &light));
                let found = start.elapsed();
                let requests = residency.plan(&need).requests;
                let planned = start.elapsed();
                requests.into_iter().for_each(|unit| residency.loaded(unit));
                finding.push(found.as_secs_f64() * 1e3);
                plan.push((planned - found).as_secs_f64() * 1e3);
                let is_seen = |i: &u32| frustum.sees_sphere(at(*i), 3.0);
                seen = (0..count).filter(is_seen).count() as f64 / f64::from(count) * 100.0;
            }
            let (finding, plan) = (median(finding), median(plan));
            let how = if upright { "about the vertical" } else { "freely" };
            println!("| {count} | {how} | {seen:.0} | {finding:.2} | {plan:.2} | {:.2} |", finding + plan);
        }
    }
}

fn opening() {
    println!("\n| file, MB | pages | open, ms |\n|---:|---:|---:|");
    for (lattice, bases) in [(64u32, 3u8), (256, 6)] {
        let mut plant = plants::plant("big", None, 16, 1);
        plant.meta.grid.lattice = lattice;
        plant.medium = flb_format::Medium::empty(plant.meta.grid);
        let mut field = flb_format::Field::zeros(lattice, plants::BANDS as u32);
        plant.bases = (0..bases)
            .map(|base| {
                // No page like another, which would be stored once.
                for (i, value) in field.values_mut().iter_mut().enumerate() {
                    *value = plants::noise(i as u32, u32::from(base));
                }
                (base, field.clone())
            })
            .collect();
        let settings = flb_packer::EncodeSettings { codec: Codec::RawF32, ..Default::default() };
        let coded = encode_species(&plant, &settings, &|_| Ok(())).expect("it encodes");
        drop(plant);
        let path = std::env::temp_dir().join(format!("flb-bench-open-{lattice}.flb"));
        let mut file = std::io::BufWriter::new(std::fs::File::create(&path).expect("a temporary file"));
        write_library_to(&mut file, &[&coded]).expect("the disk takes it");
        drop((file, coded));
        let mut times = Vec::new();
        let mut pages = 0;
        for _ in 0..21 {
            let start = Instant::now();
            let library = Library::open_mapped(&path).expect("it opens");
            times.push(start.elapsed().as_secs_f64() * 1e3);
            let sections = 0..library.container().sections().len();
            pages = sections.map(|section| library.container().pages(section).len()).sum();
        }
        let bytes = std::fs::metadata(&path).expect("it is there").len();
        println!("| {:.0} | {pages} | {:.2} |", bytes as f64 / 1e6, median(times));
        std::fs::remove_file(&path).expect("it was there");
    }
}

/// Light for plants that each stand in their own way: what a frame asks for before the first point.
fn lighting() {
    const PLANTS: u32 = 10_000;
    let harmonics = SunBasis::Harmonics { degree: 2, single: true, leaning: true };
    let bytes = plants::bytes(&[plants::plant("harmonics", Some(&harmonics), 64, 1)], Codec::Classed);
    let library = Arc::new(Library::from_source("plants.flb", Box::new(bytes)).expect("it opens"));
    let file = SpeciesLight::load(&library, 0).expect("a sound file");
    let mut streamer = Streamer::new(Arc::clone(&library), StreamSettings::default()).expect("it starts");
    let units = Arc::clone(streamer.residency().units());
    let stands = |i: u32| Transform { rotation: rotation(i, false), ..Transform::IDENTITY };
    let near =
        Placement { species: 0, transform: Transform { rotation: rotation(0, true), ..Transform::IDENTITY } };
    let camera = Camera {
        position_m: [0.0, 1.0, 8.0],
        forward: [0.0, 0.0, -1.0],
        up: [0.0, 1.0, 0.0],
        fov_deg: 60.0,
        width_px: 1920,
        height_px: 1080,
    };
    let daylight = Daylight { towards_sun: [0.3, 0.8, 0.5], sun: 1.0, sky: 0.2 };
    let placed = Placed::new(library.container(), vec![near]);
    let need = NeedFinder::new(library.container(), &units).find(&placed, &camera, &daylight);
    while !streamer.frame(&need).is_final {
        streamer.wait(Duration::from_millis(50));
    }
    let resident = streamer.resident().species(0);
    let streamed = SpeciesLight::streamed(resident);
    let level = streamed.lit_by_in_model(&daylight).expect("a sun").level();
    let mut times = [Vec::new(), Vec::new()];
    for _ in 0..11 {
        for (light, times) in [&file, &streamed].into_iter().zip(&mut times) {
            let start = Instant::now();
            for i in 0..PLANTS {
                black_box(light.lit_by(&daylight, &stands(i)).expect("a sun"));
            }
            times.push(start.elapsed().as_secs_f64() * 1e3);
        }
    }
    let [file, streamed] = times.map(median);
    println!("\n| light for {PLANTS} plants | ms |\n|---|---:|");
    println!("| of a file | {file:.1} |\n| streamed ({level:?}) | {streamed:.1} |");
}

fn main() {
    planning();
    lighting();
    opening();
}

//! A day in a forest as an engine has it: plants come and go, the sun moves, threads of the engine do the work, and
//! another one asks for light while the next frame goes on.
//!
//! `cargo run -p flb-examples --bin forest_of_an_engine [FILE.flb]`; without a file it takes the shrub of the tests.
#![forbid(unsafe_code)]

use std::error::Error;
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

use flb_format::sun::towards_sun;
use flb_runtime::forest::{Forest, ForestSettings, PlantId, Snapshot, Work};
use flb_runtime::view::Camera;
use flb_runtime::{Daylight, Library, Placement, Transform};

const SHRUB: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../runtime-loader/golden/shrub.flb");

/// Plants stand at so many yaws: the light of each is then exact.
const YAWS: u32 = 8;
const PLANTS: u32 = 60;
const FRAMES: u32 = 240;
/// Frames from report to report.
const HOUR: u32 = 40;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).unwrap_or_else(|| SHRUB.to_owned());
    let library = Arc::new(Library::open(&path)?);
    let settings = ForestSettings { yaws: YAWS, blend_frames: 20, ..ForestSettings::default() };
    let mut forest = Forest::new(library, settings)?;
    let mut plants = (0..PLANTS).map(|number| forest.add(&stands(number))).collect::<Result<Vec<_>, _>>()?;

    // The engine's own threads: here two, which take what frames hand out.
    let (hand_out, handed_out) = channel::<Work>();
    let handed_out = Arc::new(Mutex::new(handed_out));
    let workers = [0, 1].map(|_| thread::spawn(worker(Arc::clone(&handed_out))));

    for frame in 0..FRAMES {
        // A plant goes, another comes.
        let oldest = (frame / 4) as usize % plants.len();
        if frame % 4 == 0 && forest.remove(plants[oldest]) {
            plants[oldest] = forest.add(&stands(PLANTS + frame))?;
        }
        let day = morning(frame);
        let report = forest.frame(&camera(frame), &day, |work| {
            // Where the workers are gone, the forest asks again.
            let _ = hand_out.send(work);
        });
        for failure in &report.failures {
            eprintln!("frame {frame}: {}", failure.error);
        }
        // A thread that draws holds the light of its frame, whatever comes next.
        let (snapshot, asked) = (forest.snapshot(), plants.clone());
        let drawn = thread::spawn(move || mean_light(&snapshot, &asked));
        if frame % HOUR == HOUR - 1 {
            let light = drawn.join().map_err(|_| "the thread that draws")?;
            let state = if report.is_final { "all is there" } else { "more is coming" };
            println!(
                "frame {frame}: {} plants, {:.1} MB of volumes, {state}, light {light:.3?}",
                forest.len(),
                report.volume_bytes as f64 / 1e6
            );
        }
        // The rest of a frame of a sixtieth of a second.
        thread::sleep(Duration::from_millis(4));
    }
    drop(hand_out);
    workers.into_iter().for_each(|worker| worker.join().expect("work does not panic"));
    Ok(())
}

/// A thread of the engine.
fn worker(queue: Arc<Mutex<Receiver<Work>>>) -> impl FnOnce() {
    move || {
        loop {
            let next = queue.lock().expect("nothing panics in here").recv();
            match next {
                Ok(work) => work.run(),
                Err(_) => return,
            }
        }
    }
}

/// A place in the forest, at one of the yaws.
fn stands(number: u32) -> Placement {
    let (angle, away_m) = (2.4 * f64::from(number), 1.5 * f64::from(number % PLANTS).sqrt());
    let (sin, cos) = libm::sincos(angle);
    let yaw_deg = 360.0 * f64::from(number % YAWS) / f64::from(YAWS);
    let transform = Transform::from_yaw([away_m * cos, 0.0, away_m * sin], yaw_deg, 1.0);
    Placement { species: 0, transform }
}

/// The sun rises.
fn morning(frame: u32) -> Daylight {
    let part = f64::from(frame) / f64::from(FRAMES);
    let up = 0.2 + 0.8 * part as f32;
    Daylight { towards_sun: towards_sun(90.0 + 60.0 * part, 5.0 + 40.0 * part), sun: up, sky: 0.4 * up }
}

fn camera(frame: u32) -> Camera {
    let forward = towards_sun(f64::from(frame), 0.0).map(|c| c as f32);
    Camera {
        position_m: [0.0, 1.7, 0.0],
        forward,
        up: [0.0, 1.0, 0.0],
        fov_deg: 60.0,
        width_px: 1280,
        height_px: 720,
    }
}

/// Light on some points of all plants, as a renderer asks for it at each vertex or pixel.
fn mean_light(snapshot: &Snapshot, plants: &[PlantId]) -> [f32; 3] {
    let (mut sum, mut count) = ([0.0; 3], 0);
    for plant in plants {
        for height in 0..8 {
            let mut rgb = [0.0; 3];
            // A plant that has gone meanwhile has no light.
            if snapshot.at(*plant, [0.2, 0.2 * height as f32, 0.1], &mut rgb) {
                sum.iter_mut().zip(rgb).for_each(|(sum, light)| *sum += light);
                count += 1;
            }
        }
    }
    sum.map(|sum| sum / count as f32)
}

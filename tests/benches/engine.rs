//! Frames of an engine with a forest:
//!
//! ```text
//! cargo bench -p flb-tests --bench engine                     # the default bake of the built-in oak
//! cargo bench -p flb-tests --bench engine -- FILE.flb
//! cargo bench -p flb-tests --bench engine -- PLANT TRIANGLES [LATTICE]
//! ```
//!
//! 2,000 plants, turned freely, at 8 yaws, and tilted by up to 20 degrees; a camera that turns and a sun that moves
//! over 300 frames; 8 points of each of 819 plants a frame. One thread does the engine's frames and points, two do the
//! work that frames hand out. *rms* is against suns that are prepared by themselves. Beside it, the same points as an
//! engine without a forest asks them: `SpeciesLight::lit_by` for each plant, and marches. Last 100,000 plants, 100 of
//! which move each frame, whose light follows into a buffer of a GPU (here memory): frame and buffer apart, and the
//! bytes that are written.

use std::hint::black_box;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Instant;

use flb_format::sun::towards_sun;
use flb_runtime::forest::{BufferSettings, Forest, ForestBuffer, ForestSettings, PlantId, Work};
use flb_runtime::view::Camera;
use flb_runtime::{Daylight, Library, Placement, SpeciesLight, Transform};
use flb_tests::benched::{Benched, benched};

const PLANTS: usize = 2000;
const FRAMES: usize = 300;
/// Plants that a frame asks points of, and points of each.
const ASKED: usize = 819;
const POINTS: usize = 8;
/// Plants of a buffer that move each frame.
const MOVED: usize = 100;
/// Metres between plants.
const APART_M: f64 = 6.0;
/// Time of a frame of the engine beside this, so that work has time to be done: 60 frames a second.
const FRAME_S: f64 = 1.0 / 60.0;

fn day(frame: usize) -> Daylight {
    let part = frame as f64 / FRAMES as f64;
    Daylight { towards_sun: towards_sun(120.0 + 15.0 * part, 30.0 + 4.0 * part), sun: 1.0, sky: 0.36 }
}

fn camera(frame: usize) -> Camera {
    let turned = towards_sun(360.0 * frame as f64 / FRAMES as f64, 0.0).map(|c| c as f32);
    let eye = [0.0, 3.0, 0.0];
    Camera {
        position_m: eye,
        forward: turned,
        up: [0.0, 1.0, 0.0],
        fov_deg: 50.0,
        width_px: 1920,
        height_px: 1080,
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Stands {
    /// At so many yaws.
    Yaws(u32),
    Free,
    /// Free, on slopes that differ from plant to plant.
    Slopes,
}

/// Steepest slope.
const SLOPE_DEG: f64 = 20.0;

fn plants(count: usize, stand: Stands) -> Vec<Placement> {
    let edge = (count as f64).sqrt();
    let stands = |number: usize| {
        let number = number as f64;
        let (x, z) =
            (APART_M * (number % edge - edge / 2.0), APART_M * ((number / edge).floor() - edge / 2.0));
        let yaw_deg = match stand {
            Stands::Yaws(yaws) => 360.0 * number / f64::from(yaws),
            _ => 137.508 * number,
        };
        let upright = Transform::from_yaw([x, 0.0, z], yaw_deg % 360.0, 1.0);
        let transform = if stand == Stands::Slopes { on_slope(&upright, number) } else { upright };
        Placement { species: 0, transform }
    };
    (0..count).map(stands).collect()
}

/// A plant tilted towards some side.
fn on_slope(upright: &Transform, number: f64) -> Transform {
    let slope = (SLOPE_DEG * (0.618 * number).fract()).to_radians();
    let ((sin, cos), (x, z)) = (libm::sincos(slope), libm::sincos(2.4 * number));
    // The turn about the level axis (x, 0, z).
    let more = 1.0 - cos;
    let turn = [
        [cos + x * x * more, -z * sin, x * z * more],
        [z * sin, cos, -x * sin],
        [x * z * more, x * sin, cos + z * z * more],
    ];
    let at = |row: usize, column: usize| (0..3).map(|k| turn[row][k] * upright.rotation[k][column]).sum();
    let rotation = [0, 1, 2].map(|row| [0, 1, 2].map(|column| at(row, column)));
    Transform { rotation, ..*upright }
}

fn worker(queue: Arc<Mutex<Receiver<Work>>>) {
    loop {
        let next = queue.lock().expect("no panic").recv();
        match next {
            Ok(work) => work.run(),
            Err(_) => return,
        }
    }
}

/// Two threads that do what comes.
fn two_workers() -> (Sender<Work>, [thread::JoinHandle<()>; 2]) {
    let (sender, queue) = channel();
    let queue = Arc::new(Mutex::new(queue));
    let workers = [0, 1].map(|_| {
        let queue = Arc::clone(&queue);
        thread::spawn(move || worker(queue))
    });
    (sender, workers)
}

fn wait_for_the_next(begin: Instant) {
    let left = FRAME_S - begin.elapsed().as_secs_f64();
    if left > 0.0 {
        thread::sleep(std::time::Duration::from_secs_f64(left));
    }
}

fn median_and_worst(mut all: Vec<f64>) -> String {
    all.sort_unstable_by(f64::total_cmp);
    format!("{:.2} | {:.2}", all[all.len() / 2], all[all.len() - 1])
}

/// Rms of the light of some plants against that of suns that are prepared by themselves, % of the mean; for tilted
/// plants, also that of the light which they would have if they stood upright.
fn error(forest: &mut Forest, ids: &[PlantId], plants: &[Placement], points: &[[f32; 3]]) -> [f64; 2] {
    let library = Arc::clone(forest.library());
    let species = SpeciesLight::load(&library, 0).expect("a sound file");
    let near = species.near();
    while !forest.frame(&camera(0), &day(0), Work::run).is_final {}
    let snapshot = forest.snapshot();
    let (mut squares, mut sum, mut count) = ([0.0; 2], 0.0, 0.0);
    for number in (0..PLANTS).step_by(PLANTS / 16) {
        let stands = plants[number].transform;
        let upright = Transform::from_yaw([0.0; 3], stands.yaw_deg(), 1.0);
        let [lit, upright] = [stands, upright]
            .map(|stands| species.lit_by(&day(0), &stands).expect("a sun").prepared_by(near.as_ref()));
        for point in points.iter().step_by(11) {
            let [mut found, mut exact, mut other] = [[0.0; 3]; 3];
            snapshot.at(ids[number], *point, &mut found);
            lit.at(*point, &mut exact);
            upright.at(*point, &mut other);
            for band in 0..3 {
                for (squares, light) in squares.iter_mut().zip([found, other]) {
                    let off = f64::from(light[band] - exact[band]);
                    *squares += off * off;
                }
                (sum, count) = (sum + f64::from(exact[band]), count + 1.0);
            }
        }
    }
    squares.map(|squares| 100.0 * (squares / count).sqrt() / (sum / count))
}

fn by_forest(library: &Arc<Library>, points: &[[f32; 3]], yaws: u32, stand: Stands) {
    let settings = ForestSettings { yaws, ..ForestSettings::default() };
    let plants = plants(PLANTS, stand);
    let mut forest = Forest::new(Arc::clone(library), settings).expect("coded near geometry");
    let ids: Vec<PlantId> = plants.iter().map(|plant| forest.add(plant).expect("a species")).collect();
    let (sender, workers) = two_workers();
    let (mut frames, mut samples, mut lit, mut bytes) = (Vec::new(), Vec::new(), None, 0);
    let mut rgb = [0.0; 3];
    for frame in 0..FRAMES {
        let begin = Instant::now();
        let report = forest.frame(&camera(frame), &day(frame), |work| sender.send(work).expect("workers"));
        frames.push(1e3 * begin.elapsed().as_secs_f64());
        let snapshot = forest.snapshot();
        let asked = Instant::now();
        for number in 0..ASKED {
            let id = ids[(number * 7 + frame) % PLANTS];
            let parts = snapshot.parts(id).expect("a plant");
            for point in 0..POINTS {
                parts.at(points[(number * POINTS + point) % points.len()], &mut rgb);
                black_box(rgb);
            }
        }
        samples.push(1e3 * asked.elapsed().as_secs_f64());
        if report.volume_bytes > 0 {
            lit.get_or_insert(frame);
        }
        bytes = bytes.max(report.volume_bytes);
        wait_for_the_next(begin);
    }
    drop(sender);
    workers.into_iter().for_each(|worker| worker.join().expect("no panic"));
    let all: Vec<f64> = frames.iter().zip(&samples).map(|(frame, samples)| frame + samples).collect();
    let blends = match stand {
        Stands::Yaws(_) => "",
        Stands::Free => "free, blends of ",
        Stands::Slopes => "tilted by up to 20 degrees, blends of ",
    };
    let [found, upright] = error(&mut forest, &ids, &plants, points);
    let upright = if stand == Stands::Slopes { format!("{upright:.2} %") } else { String::new() };
    println!(
        "| forest, {blends}{yaws} yaws | {} | {} | {} | {} | {:.1} | {found:.2} % | {upright} |",
        median_and_worst(frames),
        median_and_worst(samples),
        median_and_worst(all),
        lit.map_or("-".to_owned(), |frame: usize| frame.to_string()),
        bytes as f64 / 1e6
    );
}

fn in_a_buffer(library: &Arc<Library>, count: usize) {
    let settings = ForestSettings { yaws: 8, ..ForestSettings::default() };
    let mut plants = plants(count, Stands::Free);
    let mut forest = Forest::new(Arc::clone(library), settings).expect("coded near geometry");
    let ids: Vec<PlantId> = plants.iter().map(|plant| forest.add(plant).expect("a species")).collect();
    let sizes = BufferSettings { bytes: 128 << 20, max_plants: count as u32, ..BufferSettings::default() };
    let mut buffer = ForestBuffer::new(sizes);
    let mut memory = vec![0_u32; sizes.bytes as usize / 4];
    let (sender, workers) = two_workers();
    let [mut frames, mut follows, mut written] = [(); 3].map(|()| Vec::new());
    for frame in 0..FRAMES {
        for moved in 0..MOVED {
            let at = (frame * MOVED + moved) * 37 % count;
            plants[at].transform.position_m[0] += 0.1;
            plants[at].transform = Transform::from_yaw(plants[at].transform.position_m, moved as f64, 1.0);
            forest.set(ids[at], &plants[at]).expect("a species");
        }
        let begin = Instant::now();
        forest.frame(&camera(frame), &day(frame), |work| sender.send(work).expect("workers"));
        frames.push(1e3 * begin.elapsed().as_secs_f64());
        let follow = Instant::now();
        let followed = buffer.follow(&forest.snapshot(), |offset_bytes, words| {
            let first = offset_bytes as usize / 4;
            memory[first..first + words.len()].copy_from_slice(words);
        });
        follows.push(1e3 * follow.elapsed().as_secs_f64());
        written.push(followed.written_bytes as f64 / 1e3);
        assert_eq!((followed.lacking_bytes, followed.plants_left_out), (0, 0));
        wait_for_the_next(begin);
    }
    drop(sender);
    workers.into_iter().for_each(|worker| worker.join().expect("no panic"));
    // The first frame writes all plants.
    let first = (frames.remove(0), follows.remove(0), written.remove(0));
    black_box((first, &memory));
    let [frames, follows, written] = [frames, follows, written].map(median_and_worst);
    println!("| {count} | {frames} | {follows} | {written} |");
}

fn by_marches(library: &Library, points: &[[f32; 3]]) {
    let species = SpeciesLight::load(library, 0).expect("a sound file");
    let plants = plants(PLANTS, Stands::Free);
    let (mut samples, mut rgb) = (Vec::new(), [0.0; 3]);
    for frame in 0..FRAMES / 30 {
        let day = day(30 * frame);
        let asked = Instant::now();
        for number in 0..ASKED {
            let lit = species.lit_by(&day, &plants[(number * 7 + frame) % PLANTS].transform).expect("a sun");
            for point in 0..POINTS {
                lit.at(points[(number * POINTS + point) % points.len()], &mut rgb);
                black_box(rgb);
            }
        }
        samples.push(1e3 * asked.elapsed().as_secs_f64());
    }
    println!("| marches | | | {} | | | | | | |", median_and_worst(samples));
}

fn main() {
    let Benched { library, points } = benched(4096);
    let library = Arc::new(library);
    println!(
        "{PLANTS} plants, {FRAMES} frames, {} points a frame; milliseconds of one thread\n",
        ASKED * POINTS
    );
    println!(
        "| light | frame: median | worst | points: median | worst | both: median | worst | first volumes in frame | volumes, MB | rms | rms if upright |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
    by_forest(&library, &points, 8, Stands::Yaws(8));
    by_forest(&library, &points, 16, Stands::Free);
    by_forest(&library, &points, 32, Stands::Free);
    by_forest(&library, &points, 16, Stands::Slopes);
    by_forest(&library, &points, 32, Stands::Slopes);
    by_marches(&library, &points);
    println!("\n| plants | frame: median | worst | buffer: median | worst | KB a frame: median | worst |");
    println!("|---|---:|---:|---:|---:|---:|---:|");
    [2_000, 10_000, 100_000].into_iter().for_each(|count| in_a_buffer(&library, count));
}

use std::collections::HashSet;
use std::io;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use flb_format::{Codec, Placement, Source, Transform};

use super::*;
use crate::Daylight;
use crate::plants::{bytes, bytes_of_three, noise, plant};
use crate::residency::{NeedFinder, Placed};
use crate::resident::LightLevel;
use crate::view::Camera;

static BYTES: LazyLock<Vec<u8>> = LazyLock::new(|| bytes_of_three(Codec::Classed));

/// A disk with faults: some reads fail, some bring a wrong bit, all fail while the file is gone.
struct Faulty {
    bytes: Vec<u8>,
    reads: AtomicU64,
    /// Of 1000 reads.
    failing: u64,
    /// Of 1000 reads.
    wrong: u64,
    is_gone: Arc<AtomicBool>,
}

impl Faulty {
    fn new(failing: u64, wrong: u64) -> Faulty {
        Faulty {
            bytes: BYTES.clone(),
            reads: AtomicU64::new(0),
            failing,
            wrong,
            is_gone: Arc::new(AtomicBool::new(false)),
        }
    }
}

impl Source for Faulty {
    fn len_bytes(&self) -> io::Result<u64> {
        self.bytes.len_bytes()
    }

    fn read_exact_at(&self, offset_bytes: u64, buffer: &mut [u8]) -> io::Result<()> {
        self.bytes.read_exact_at(offset_bytes, buffer)
    }

    /// What streaming reads by.
    fn read_once_at(&self, offset_bytes: u64, buffer: &mut [u8]) -> io::Result<()> {
        let read = self.reads.fetch_add(1, Ordering::Relaxed);
        let draw = (noise(read as u32, 5) * 1000.0) as u64;
        if self.is_gone.load(Ordering::Relaxed) {
            return Err(io::Error::new(io::ErrorKind::NotFound, "the file is gone"));
        }
        if draw < self.failing {
            return Err(io::Error::other("the disk fails"));
        }
        self.bytes.read_exact_at(offset_bytes, buffer)?;
        if draw < self.failing + self.wrong {
            let at = (noise(read as u32, 6) * buffer.len() as f32) as usize;
            buffer[at] ^= 16;
        }
        Ok(())
    }
}

fn camera_at(frame: u32, frames: u32) -> Camera {
    let turn = frame as f32 / frames as f32 * 20.0;
    let (sin, cos) = libm::sincosf(turn);
    let (across, _) = libm::sincosf(turn / 3.0);
    Camera {
        position_m: [60.0 * across, 6.0, 60.0 * cos],
        forward: [-sin, -0.1, -cos],
        up: [0.0, 1.0, 0.0],
        fov_deg: 55.0,
        width_px: 1280,
        height_px: 720,
    }
}

fn daylight_at(frame: u32, frames: u32) -> Daylight {
    let (sin, cos) = libm::sincosf(frame as f32 / frames as f32 * 30.0);
    let towards_sun = [cos, sin.abs() + 0.05, 0.3 * sin].map(f64::from);
    Daylight { towards_sun, sun: 1.0, sky: 0.1 }
}

fn forest(count: u32) -> Vec<Placement> {
    let instance = |i: u32| {
        let (sin, cos) = libm::sincosf(noise(i, 1) * 6.3);
        let [x, z] = [noise(i, 2), noise(i, 3)].map(|share| f64::from(share * 160.0 - 80.0));
        let rotation = [[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]].map(|row| row.map(f64::from));
        let scale = f64::from(0.7 + 0.6 * noise(i, 4));
        let transform = Transform { rotation, position_m: [x, 0.0, z], scale };
        Placement { species: i as usize % 3, transform }
    };
    (0..count).map(instance).collect()
}

fn full_bytes(library: &Library) -> u64 {
    let units = Units::new(library.container(), library.path()).expect("coded near geometry");
    units.all().map(|unit| units.get(unit).memory_bytes).sum()
}

fn open(source: Faulty) -> Arc<Library> {
    Arc::new(Library::from_source("forest.flb", Box::new(source)).expect("it opens"))
}

/// Runs frames until nothing is left to do.
fn settle(streamer: &mut Streamer, need: &Need) -> Vec<Frame> {
    let mut frames = Vec::new();
    for _ in 0..100_000 {
        frames.push(streamer.frame(need));
        if frames.last().is_some_and(|frame| frame.is_final) {
            return frames;
        }
        if streamer.residency().requested() > 0 {
            streamer.wait(Duration::from_millis(50));
        }
    }
    panic!("it does not settle");
}

fn need_of(library: &Library, instances: Vec<Placement>) -> Need {
    let units = Units::new(library.container(), library.path()).expect("coded near geometry");
    let placed = Placed::new(library.container(), instances);
    NeedFinder::new(library.container(), &units).find(&placed, &camera_at(0, 100), &daylight_at(7, 100))
}

#[test]
fn a_still_view_is_loaded_whole_each_unit_once() {
    let library = open(Faulty::new(0, 0));
    let need = need_of(&library, forest(300));
    let mut streamer = Streamer::new(Arc::clone(&library), StreamSettings::default()).expect("it starts");
    let frames = settle(&mut streamer, &need);
    let asked: Vec<UnitId> = frames.iter().flat_map(|frame| frame.requests.clone()).collect();
    assert_eq!(asked.iter().collect::<HashSet<_>>().len(), asked.len());
    let last = frames.last().expect("a frame");
    assert!(last.is_complete && last.quality > 0.999);
    for instance in forest(300) {
        let species = streamer.resident().species(instance.species);
        let sun = instance.transform.model_from_world_direction(daylight_at(7, 100).towards_sun);
        if need.species[instance.species].pixels > 0.0 {
            assert!(species.terms(sun, 1.0, 0.1).level >= LightLevel::Averages);
        }
    }
}

/// A camera and a sun fly for 10,000 frames through 1,000 plants, a tenth of the data fits, and the disk is bad.
#[test]
fn a_long_flight_over_a_bad_disk_keeps_every_promise() {
    let source = Faulty::new(20, 1);
    let is_gone = Arc::clone(&source.is_gone);
    let library = open(source);
    let weak = Arc::downgrade(&library);
    let full = full_bytes(&library);
    let residency = ResidencySettings { budget_bytes: full / 10, ..ResidencySettings::default() };
    let settings =
        StreamSettings { residency, workers: 3, frame_time: Duration::from_millis(4), blend_frames: 4 };
    let mut streamer = Streamer::new(Arc::clone(&library), settings).expect("it starts");
    let placed = Placed::new(library.container(), forest(1000));
    let units = Arc::clone(streamer.residency().units());
    let mut finder = NeedFinder::new(library.container(), &units);
    let (frames, mut given_up, mut drawn) = (10_000, HashSet::new(), 0);
    let (mut requests, mut evictions, mut loaded) = (0, 0, 0);
    // It may take more rounds than one.
    for index in (0..10 * frames).map(|index| index % frames) {
        if index == 0 && requests > 200 && evictions > 100 && loaded > 200 {
            break;
        }
        // For a while the file is not there at all.
        is_gone.store((4000..4050).contains(&index), Ordering::Relaxed);
        let light = daylight_at(index, frames);
        let need = finder.find(&placed, &camera_at(index, frames), &light);
        let frame = streamer.frame(&need);
        for failure in &frame.failures {
            assert!(given_up.insert(failure.unit), "{:?} was reported before", failure.unit);
        }
        requests += frame.requests.len();
        evictions += frame.evictions.len();
        loaded += frame.loaded.len();
        // Frames alone leave the disk's threads little time where other work takes it.
        if index % 25 == 0 && streamer.residency().requested() > 0 {
            streamer.wait(Duration::from_millis(10));
        }
        assert!(streamer.residency().loaded_bytes() <= residency.budget_bytes);
        let held = streamer.resident().size_bytes() as u64;
        assert!(held <= streamer.residency().loaded_bytes(), "{held} in frame {index}");
        if index % 50 == 0 {
            // Any plant can be drawn at any time.
            for instance in forest(1000).iter().step_by(37) {
                let species = streamer.resident().species(instance.species);
                let sun = instance.transform.model_from_world_direction(light.towards_sun);
                let terms = species.terms(sun, 1.0, 0.1);
                let point = [noise(index, 8) * 3.0 - 1.5, 1.5, 0.2];
                let mut out = [f32::NAN; 3];
                species.light(&terms, species.near(point, sun, &[]), point, &mut out);
                // The harmonics of the test are of no light, and may cancel.
                let least = if instance.species == 2 { 0.0 } else { 0.01 };
                assert!(out.iter().all(|value| value.is_finite() && *value >= least), "{out:?}");
                drawn += 1;
            }
        }
    }
    assert!(
        requests > 200 && evictions > 100 && loaded > 200 && drawn > 5000,
        "{requests} {evictions} {loaded}"
    );
    assert!(!given_up.is_empty(), "wrong bits were seen");
    let known: HashSet<UnitId> = streamer.residency().given_up().collect();
    assert_eq!(known, given_up);
    drop((streamer, library));
    for _ in 0..200 {
        if weak.strong_count() == 0 {
            return;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    panic!("the workers hold on to the library");
}

#[test]
fn a_file_that_vanishes_leaves_what_is_loaded_and_is_reported_in_the_end() {
    let source = Faulty::new(0, 0);
    let is_gone = Arc::clone(&source.is_gone);
    let library = open(source);
    let mut streamer = Streamer::new(Arc::clone(&library), StreamSettings::default()).expect("it starts");
    let oaks: Vec<Placement> = forest(300).into_iter().filter(|instance| instance.species == 0).collect();
    let need = need_of(&library, oaks);
    settle(&mut streamer, &need);
    let before = streamer.residency().loaded_bytes();
    is_gone.store(true, Ordering::Relaxed);
    let frames = settle(&mut streamer, &need_of(&library, forest(300)));
    // Told at once, and once more seconds later.
    let first_told =
        |told: fn(&Frame) -> &Vec<Failure>| frames.iter().position(|frame| !told(frame).is_empty());
    let [retried, given_up] = [first_told(|frame| &frame.retries), first_told(|frame| &frame.failures)];
    assert!(retried.is_some_and(|frame| frame < 60) && given_up > retried, "{retried:?} {given_up:?}");
    let failures: Vec<&Failure> = frames.iter().flat_map(|frame| &frame.failures).collect();
    assert!(
        !failures.is_empty() && failures.len() <= 4,
        "what stands on them was never asked for: {failures:?}"
    );
    assert!(failures[0].error.to_string().contains("the file is gone"), "{}", failures[0].error);
    assert_eq!(streamer.residency().loaded_bytes(), before);
    assert!(streamer.resident().species(0).terms([0.0, 1.0, 0.0], 1.0, 0.1).level >= LightLevel::Averages);
}

#[test]
fn a_wrong_page_is_reported_once_and_the_rest_is_loaded() {
    let library = open(Faulty::new(0, 0));
    let base = library.container().find_base(0, 4).expect("a base");
    let page = library.container().pages(base.detail.expect("detail"))[1];
    let mut source = Faulty::new(0, 0);
    source.bytes[page.offset as usize + 10] ^= 1;
    let broken = open(source);
    let mut streamer = Streamer::new(Arc::clone(&broken), StreamSettings::default()).expect("it starts");
    let mut need = need_of(&broken, forest(300));
    for seen in &mut need.species {
        seen.pixels = 100.0;
        seen.bases.fill(1.0);
        seen.detail.fill(1.0);
        seen.windows = None;
    }
    let frames = settle(&mut streamer, &need);
    let failures: Vec<&Failure> = frames.iter().flat_map(|frame| &frame.failures).collect();
    let [failure] = failures[..] else { panic!("{failures:?}") };
    assert!(failure.error.to_string().contains("page 1"), "{}", failure.error);
    let units = streamer.residency().units();
    let loaded = units.all().filter(|unit| streamer.residency().is_loaded(*unit)).count();
    assert_eq!(loaded, units.len() - 1);
}

#[test]
fn units_that_lie_together_are_read_together_and_no_read_is_too_long() {
    let library = open(Faulty::new(0, 0));
    let container = library.container();
    let units = Units::new(container, library.path()).expect("coded near geometry");
    let resident = Resident::new(container, &units);
    let all: Vec<UnitId> = units.all().collect();
    let found = jobs(container, &units, &resident, &all);
    assert_eq!(found.iter().map(|job| job.units.len()).sum::<usize>(), all.len());
    assert!(found.len() * 4 < all.len(), "{} reads for {} units", found.len(), all.len());
    for job in &found {
        for (unit, _) in &job.units {
            for (section, pages) in units.pages_of(container, *unit) {
                for page in &container.pages(section)[pages.start as usize..pages.end as usize] {
                    let holds = |(start, bytes): &(u64, u64)| {
                        *start <= page.offset && page.offset + u64::from(page.stored_bytes) <= start + bytes
                    };
                    assert!(job.ranges.iter().any(holds));
                }
            }
        }
        assert!(job.ranges.iter().all(|(_, bytes)| *bytes <= 1 << 20));
    }
    // The most urgent unit's job goes first.
    let mut backwards = all.clone();
    backwards.reverse();
    let first = &jobs(container, &units, &resident, &backwards)[0];
    assert!(first.units.iter().any(|(unit, _)| *unit == backwards[0]));
}

#[test]
fn a_library_of_whole_bases_is_refused() {
    let bytes = bytes(&[plant("oak", None, 16, 1)], Codec::RawF32);
    let library = Arc::new(Library::from_source("oak.flb", Box::new(bytes)).expect("it opens"));
    let error = Streamer::new(library, StreamSettings::default()).err().expect("refused").to_string();
    assert!(error.contains("is coded as raw-f32, expected classed or haar"), "{error}");
}

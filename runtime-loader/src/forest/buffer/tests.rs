use flb_format::Transform;
use flb_format::sun::towards_sun;

use super::*;
use crate::forest::tests::tilted::tilted;
use crate::forest::tests::{camera, forest, plant, point, quick};
use crate::forest::{Forest, ForestSettings, Work};
use crate::light::volume_words::tests::on_gpu;
use crate::{Daylight, Placement};

/// Most frames until all is there.
const PATIENCE: usize = 400;

/// A buffer as a GPU has it: words that were never written are no number.
struct Memory {
    buffer: ForestBuffer,
    words: Vec<u32>,
}

impl Memory {
    fn new(settings: BufferSettings) -> Memory {
        Memory { buffer: ForestBuffer::new(settings), words: vec![u32::MAX; settings.bytes as usize / 4] }
    }

    fn follow(&mut self, forest: &Forest) -> Followed {
        let words = &mut self.words;
        self.buffer.follow(&forest.snapshot(), |offset_bytes, written| {
            let first = offset_bytes as usize / 4;
            words[first..first + written.len()].copy_from_slice(written);
        })
    }
}

fn sun(azimuth_deg: f64) -> Daylight {
    Daylight { towards_sun: towards_sun(azimuth_deg, 35.0), sun: 1.1, sky: 0.3 }
}

fn settings() -> BufferSettings {
    BufferSettings { bytes: 8 << 20, max_plants: 64, ..BufferSettings::default() }
}

/// Compares the light of a GPU with that of the snapshot.
fn assert_same(memory: &Memory, forest: &Forest, plants: &[PlantId]) {
    let (snapshot, mut asked, mut expected) = (forest.snapshot(), Vec::new(), Vec::new());
    // The buffer of the GPU may hold something else before it.
    let before = 3;
    let words = [&vec![7; before][..], &memory.words].concat();
    for plant in plants {
        for seed in 0..100 {
            let [x, y, z] = point(seed);
            asked.push([x, y, z, f32::from_bits(plant.number())]);
            let mut rgb = [0.0; 3];
            assert!(snapshot.at(*plant, [x, y, z], &mut rgb));
            expected.push(rgb);
        }
    }
    let found = on_gpu(&words, &asked, &format!("flb_light({before}u, number, point)"));
    for ((found, expected), asked) in found.iter().flatten().zip(expected.iter().flatten()).zip(0..) {
        let off = (found - expected).abs();
        assert!(off < 2e-3 * (1.0 + expected.abs()), "{}: {found} {expected}", plants[asked / 300].number());
    }
}

#[test]
fn a_gpu_has_the_light_of_the_snapshot_while_the_sun_moves_and_plants_come_and_go() {
    let mut forest = forest(quick());
    let mut memory = Memory::new(BufferSettings { bytes: 32 << 20, ..settings() });
    let stands = [(0, 90.0), (0, 101.0), (1, 10.0), (2, 359.99), (2, 200.0)];
    let mut plants: Vec<PlantId> =
        stands.iter().map(|(species, yaw)| forest.add(&plant(*species, *yaw)).expect("a species")).collect();
    // Tilted, and upside down.
    let rotations = [[0.1, 0.2, -0.05, 1.0], [-0.4, 0.6, 0.5, 0.3], [1.0, 0.0, 0.0, 0.0]];
    plants.splice(0..0, rotations.map(|rotation| forest.add(&tilted(0, rotation)).expect("a species")));
    // Before the first frame there is nothing to follow, and at first the mean light alone.
    assert_eq!(memory.follow(&forest), Followed::default());
    forest.frame(&camera(), &sun(100.0), Work::run);
    assert!(memory.follow(&forest).is_complete);
    assert_same(&memory, &forest, &plants);
    let (mut states, mut volumes) = (0, 0);
    for frame in 0..PATIENCE {
        let report = forest.frame(&camera(), &sun(if frame < 20 { 100.0 } else { 140.0 }), Work::run);
        let followed = memory.follow(&forest);
        assert_eq!((followed.lacking_bytes, followed.plants_left_out), (0, 0));
        if frame == 30 {
            assert!(forest.remove(plants[4]));
            plants[4] = forest.add(&plant(1, 77.0)).expect("a species");
            assert!(forest.set(plants[6], &plant(0, 45.0)).expect("a species"));
            assert!(forest.set(plants[0], &tilted(1, [0.2, -0.3, 0.4, 0.9])).expect("a species"));
            assert!(forest.remove(plants.pop().expect("eight")));
        } else if followed.is_complete && frame % 7 == 0 {
            assert_same(&memory, &forest, &plants);
            states += 1;
        }
        volumes = volumes.max(memory.buffer.volume_bytes());
        if report.is_final && frame > 40 {
            break;
        }
    }
    assert!(states >= 4 && volumes > 0, "{states} {volumes}");
    // What is written once stays; what has gone has no light.
    for _ in 0..4 {
        forest.frame(&camera(), &sun(140.0), Work::run);
        memory.follow(&forest);
    }
    assert_eq!(memory.follow(&forest), Followed { is_complete: true, ..Followed::default() });
    assert_same(&memory, &forest, &plants);
    let gone = [[0.0, 2.0, 0.0, f32::from_bits(4)], [0.0, 2.0, 0.0, f32::from_bits(64)]];
    assert_eq!(on_gpu(&memory.words, &gone, "flb_light(0u, number, point)"), [[0.0; 3]; 2]);
}

/// Frames until the buffer has all, or so many.
fn settle(forest: &mut Forest, memory: &mut Memory, day: &Daylight) -> Vec<Followed> {
    let mut all = Vec::new();
    for _ in 0..PATIENCE {
        let report = forest.frame(&camera(), day, Work::run);
        all.push(memory.follow(forest));
        if report.is_final && all[all.len() - 1].is_complete {
            break;
        }
    }
    all
}

#[test]
fn a_frame_writes_no_more_than_it_may_and_what_is_read_is_not_written_over() {
    let mut forest = forest(ForestSettings { yaws: 4, ..quick() });
    let plants = [0.0, 90.0, 180.0, 270.0].map(|yaw| forest.add(&plant(0, yaw)).expect("a species"));
    let small = BufferSettings { max_upload_bytes: 1, frames_in_flight: 2, ..settings() };
    let mut memory = Memory::new(small);
    let frames = settle(&mut forest, &mut memory, &sun(100.0));
    let one = memory.buffer.volume_bytes() / 4;
    let tables = 4 * (u64::from(HEAD + PLANT * 64) + words_of(4) as u64);
    // One volume a frame.
    assert!(frames.iter().skip(1).all(|frame| frame.written_bytes <= one + tables), "{frames:?}");
    assert!(frames.iter().filter(|frame| !frame.is_complete).count() >= 3);
    assert!(frames[frames.len() - 1].is_complete);
    assert_same(&memory, &forest, &plants);
    // The light of another sun goes to other places until that of the first is no longer read.
    let places =
        |memory: &Memory| -> Vec<u32> { memory.buffer.places.values().map(|place| place.first).collect() };
    let before = places(&memory);
    let mut both = false;
    for _ in 0..PATIENCE {
        let report = forest.frame(&camera(), &sun(150.0), Work::run);
        memory.follow(&forest);
        both |= places(&memory).len() == 8;
        if report.is_final {
            break;
        }
    }
    assert!(both, "two suns' volumes at a time");
    // Places are taken again once others are needed.
    settle(&mut forest, &mut memory, &sun(200.0));
    settle(&mut forest, &mut memory, &sun(250.0));
    assert!(places(&memory).iter().any(|first| before.contains(first)));
    assert_same(&memory, &forest, &plants);
}

#[test]
fn a_buffer_too_small_for_two_suns_shows_the_mean_light_between_them_and_never_old_light() {
    let mut forest = forest(ForestSettings { yaws: 4, ..quick() });
    let plants = [0.0, 90.0, 180.0, 270.0].map(|yaw| forest.add(&plant(0, yaw)).expect("a species"));
    settle(&mut forest, &mut Memory::new(settings()), &sun(100.0));
    let snapshot = forest.snapshot();
    let parts = snapshot.parts(plants[0]).expect("a plant");
    let all = 4 * 4 * parts.volumes[0].0.word_count() as u64;
    let tables = 4 * (u64::from(HEAD + PLANT * 64) + 3 * words_of(4) as u64);
    let mut memory = Memory::new(BufferSettings { bytes: tables + all * 3 / 2, ..settings() });
    for azimuth_deg in [100.0, 150.0, 200.0] {
        let frames = settle(&mut forest, &mut memory, &sun(azimuth_deg));
        assert!(azimuth_deg == 100.0 || frames.iter().any(|frame| frame.lacking_bytes > 0));
        assert!(frames[frames.len() - 1].is_complete, "{azimuth_deg}: {:?}", frames[frames.len() - 1]);
        assert_same(&memory, &forest, &plants);
    }
}

#[test]
fn a_buffer_without_room_for_its_tables_is_not_written_and_frames_in_flight_are_one_at_least() {
    let mut forest = forest(quick());
    let ids = [0, 1, 2].map(|species| forest.add(&plant(species, 0.0)).expect("a species"));
    forest.frame(&camera(), &sun(100.0), Work::run);
    for (bytes, max_plants) in
        [(0, 4), (100, 4), (1 << 20, u32::MAX), (4 * (u64::from(u32::MAX) + 9), u32::MAX)]
    {
        let mut buffer = ForestBuffer::new(BufferSettings { bytes, max_plants, ..settings() });
        let followed = buffer.follow(&forest.snapshot(), |_, _| panic!("nothing is written"));
        assert!(!followed.is_complete && followed.lacking_bytes > 0 && followed.plants_left_out == 3);
    }
    let mut memory = Memory::new(BufferSettings { frames_in_flight: 0, ..settings() });
    for azimuth_deg in [100.0, 140.0, 180.0] {
        settle(&mut forest, &mut memory, &sun(azimuth_deg));
        assert_same(&memory, &forest, &ids);
    }
}

#[test]
fn without_room_plants_keep_the_light_that_they_had_and_the_lack_is_told() {
    let mut forest = forest(ForestSettings { yaws: 4, ..quick() });
    let id = forest.add(&plant(0, 0.0)).expect("a species");
    let other = forest.add(&Placement { species: 1, transform: Transform::IDENTITY }).expect("a species");
    let tables = 4 * (u64::from(HEAD + PLANT) + 3 * words_of(4) as u64);
    let mut memory = Memory::new(BufferSettings { bytes: tables + 400, max_plants: 1, ..settings() });
    let frames = settle(&mut forest, &mut memory, &sun(100.0));
    let last = frames[frames.len() - 1];
    assert!(!last.is_complete && last.lacking_bytes > 400 && last.plants_left_out == 1, "{last:?}");
    let asked = [id, other].map(|plant| [0.1, 2.0, 0.2, f32::from_bits(plant.number())]);
    let found = on_gpu(&memory.words, &asked, "flb_light(0u, number, point)");
    // Its species' mean light, as it is under this sun.
    assert!(found[0].iter().all(|band| *band > 0.01 && *band < 10.0), "{found:?}");
    assert_eq!(found[1], [0.0; 3]);
}

#[test]
fn with_fewer_volumes_plants_blend_those_that_there_are() {
    let stands = [plant(0, 101.0), plant(0, 290.0), tilted(0, [0.1, 0.2, -0.05, 1.0])];
    let settled = |max_volume_bytes: u64| {
        let mut forest = forest(ForestSettings { max_volume_bytes, ..quick() });
        let ids = stands.map(|stands| forest.add(&stands).expect("a species"));
        let mut memory = Memory::new(BufferSettings { bytes: 32 << 20, ..settings() });
        settle(&mut forest, &mut memory, &sun(100.0));
        assert_same(&memory, &forest, &ids);
        let report = forest.frame(&camera(), &sun(100.0), drop);
        let parts = ids.map(|id| forest.snapshot().parts(id).expect("a plant").volumes.len());
        (report.yaws, report.volume_bytes as u64, parts)
    };
    let (yaws, all, parts) = settled(u64::MAX);
    assert_eq!((yaws, parts), (8, [2, 2, 4]));
    let (yaws, some, parts) = settled(2 * all - 1);
    assert!((2..8).contains(&yaws) && some < all, "{yaws} {some} {all}");
    assert!(parts.iter().all(|count| *count >= 2), "{parts:?}");
}

use std::sync::mpsc;

use flb_format::sun::towards_sun;
use flb_format::{Codec, Transform};

use super::snapshot::Shown;
use super::*;
use crate::SpeciesLight;
use crate::plants::{library_of_three, noise};

pub(super) mod tilted;

const SHRUB: usize = 2;
const DAY: Daylight = Daylight { towards_sun: [0.6, 0.5, -0.62], sun: 1.2, sky: 0.3 };
/// Most frames until all is there.
const PATIENCE: usize = 400;

pub(super) fn forest(settings: ForestSettings) -> Forest {
    Forest::new(library_of_three(Codec::Classed), settings).expect("coded near geometry")
}

pub(super) fn quick() -> ForestSettings {
    ForestSettings { yaws: 8, blend_frames: 4, ..ForestSettings::default() }
}

pub(super) fn camera() -> Camera {
    Camera {
        position_m: [0.0, 2.0, 12.0],
        forward: [0.0, 0.0, -1.0],
        up: [0.0, 1.0, 0.0],
        fov_deg: 60.0,
        width_px: 640,
        height_px: 480,
    }
}

pub(super) fn plant(species: usize, yaw_deg: f64) -> Placement {
    Placement { species, transform: Transform::from_yaw([0.0; 3], yaw_deg, 1.0) }
}

pub(super) fn point(seed: u32) -> [f32; 3] {
    let along = |axis: u32| 2.0 * noise(seed * 3 + axis, 5) - 1.0;
    [along(0), 2.0 + along(1), along(2)]
}

fn light(snapshot: &Snapshot, id: PlantId) -> Vec<[f32; 3]> {
    let at = |seed| {
        let mut rgb = [f32::NAN; 3];
        assert!(snapshot.at(id, point(seed), &mut rgb));
        rgb
    };
    (0..300).map(at).collect()
}

/// Frames with their work until all is there; how often light was made.
fn settle(forest: &mut Forest, day: &Daylight) -> usize {
    let mut made = 0;
    for _ in 0..PATIENCE {
        let report = forest.frame(&camera(), day, |work| {
            made += usize::from(work.is_light());
            work.run();
        });
        if report.is_final {
            return made;
        }
    }
    panic!("not final after {PATIENCE} frames");
}

/// Root of the mean square difference over the mean.
fn error(found: &[[f32; 3]], expected: &[[f32; 3]]) -> f64 {
    let (mut squares, mut sum) = (0.0, 0.0);
    for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
        let off = f64::from(found - expected);
        squares += off * off;
        sum += f64::from(*expected);
    }
    let count = (3 * expected.len()) as f64;
    libm::sqrt(squares / count) / (sum / count)
}

fn exact(plant: &Placement, day: &Daylight) -> Vec<[f32; 3]> {
    let library = library_of_three(Codec::Classed);
    let species = SpeciesLight::load(&library, plant.species).expect("a sound file");
    let lit = species.lit_by(day, &plant.transform).expect("a sun").prepared();
    let at = |seed| {
        let mut rgb = [0.0; 3];
        lit.at(point(seed), &mut rgb);
        rgb
    };
    (0..300).map(at).collect()
}

#[test]
fn plants_have_their_mean_light_at_once_and_their_own_after_some_frames() {
    let mut forest = forest(quick());
    let stands: Vec<Placement> =
        (0..3).flat_map(|species| [plant(species, 90.0), plant(species, 101.0)]).collect();
    let ids: Vec<PlantId> = stands.iter().map(|plant| forest.add(plant).expect("a species")).collect();
    let first = forest.frame(&camera(), &DAY, Work::run);
    assert!(!first.is_final && first.in_flight > 0 && first.volume_bytes == 0, "{first:?}");
    for id in &ids {
        let at_once = light(&forest.snapshot(), *id);
        assert!(at_once.iter().flatten().all(|band| *band > 0.0));
        assert!(at_once.iter().all(|rgb| *rgb == at_once[0]), "one mean light");
    }
    assert!(settle(&mut forest, &DAY) >= 3);
    let report = forest.frame(&camera(), &DAY, |_| panic!("nothing is left to do"));
    assert!(report.is_final && report.in_flight == 0 && report.volume_bytes > 0, "{report:?}");
    let snapshot = forest.snapshot();
    for (id, plant) in ids.iter().zip(&stands) {
        // A plant that stands at one of the yaws has its own light, others a blend: the fields are noise, whose product
        // with a near beam is not linear between sites.
        let found = error(&light(&snapshot, *id), &exact(plant, &DAY));
        let is_one = plant.transform.yaw_deg() == 90.0;
        assert!(found < if is_one { 0.04 } else { 0.25 }, "{plant:?}: {found}");
        assert_eq!(snapshot.bands(*id), Some(3));
    }
}

#[test]
fn a_sun_that_moves_on_is_followed_by_steps_and_its_strength_at_once() {
    let mut forest = forest(quick());
    let stands = plant(SHRUB, 45.0);
    let id = forest.add(&stands).expect("a species");
    settle(&mut forest, &DAY);
    let sun = |azimuth_deg: f64| Daylight { towards_sun: towards_sun(azimuth_deg, 35.0), ..DAY };
    settle(&mut forest, &sun(100.0));
    let before = light(&forest.snapshot(), id);
    // Within a step nothing is made.
    assert_eq!(settle(&mut forest, &sun(100.5)), 0);
    assert_eq!(light(&forest.snapshot(), id), before);
    // Twice the light of all is a factor.
    let bright = Daylight { sun: 2.0 * DAY.sun, sky: 2.0 * DAY.sky, ..sun(100.0) };
    assert_eq!(settle(&mut forest, &bright), 0);
    let twice = light(&forest.snapshot(), id);
    assert!(twice.iter().flatten().zip(before.iter().flatten()).all(|(two, one)| *two == 2.0 * one));
    // Another share of the sky is another light, and so is a sun farther on; both are faded to.
    let noon = Daylight { sky: 0.9, ..sun(140.0) };
    let mut seen = Vec::new();
    for _ in 0..PATIENCE {
        let report = forest.frame(&camera(), &noon, Work::run);
        let snapshot = forest.snapshot();
        seen.push(light(&snapshot, id));
        // The parts of it add up to the same.
        let parts = snapshot.parts(id).expect("a plant");
        let mut rgb = [f32::NAN; 3];
        parts.at(point(0), &mut rgb);
        assert!(rgb == seen[seen.len() - 1][0] && (1..=2).contains(&parts.volumes.len()));
        if report.is_final {
            break;
        }
    }
    let last = seen.last().expect("frames");
    assert!(error(last, &exact(&stands, &noon)) < 0.04);
    let whole = error(last, &seen[0]);
    let steps: Vec<f64> = seen.windows(2).map(|pair| error(&pair[1], &pair[0]) / whole).collect();
    assert!(whole > 0.1 && steps.iter().all(|step| *step < 0.6), "{whole}: {steps:?}");
    assert!(steps.iter().filter(|step| **step > 0.1).count() >= 4, "faded over four frames: {steps:?}");
    assert!(seen.iter().flatten().flatten().all(|band| *band > 0.0));
    // By night there is no sun to be followed.
    let night = Daylight { sun: 0.0, sky: 0.1, towards_sun: [0.0; 3] };
    settle(&mut forest, &night);
    assert!(
        error(
            &light(&forest.snapshot(), id),
            &exact(&stands, &Daylight { towards_sun: [0.0, 1.0, 0.0], ..night })
        ) < 0.01
    );
    // In the dark nothing is made, and the first light after it is not black.
    let dark = Daylight { sky: 0.0, ..night };
    assert_eq!(settle(&mut forest, &dark), 0);
    assert!(light(&forest.snapshot(), id).iter().flatten().all(|band| *band == 0.0));
    forest.frame(&camera(), &DAY, Work::run);
    assert!(light(&forest.snapshot(), id).iter().flatten().all(|band| *band > 0.0));
    let none = Daylight { sun: f32::NAN, sky: f32::INFINITY, towards_sun: [f64::NAN; 3] };
    forest.frame(&camera(), &none, Work::run);
    assert!(light(&forest.snapshot(), id).iter().flatten().all(|band| band.is_finite()));
}

#[test]
fn a_snapshot_stays_as_it_is_while_plants_come_and_go() {
    let mut forest = forest(quick());
    let [first, second] = [0.0, 90.0].map(|yaw| forest.add(&plant(SHRUB, yaw)).expect("a species"));
    settle(&mut forest, &DAY);
    let held = forest.snapshot();
    let before = [first, second].map(|id| light(&held, id));
    assert!(forest.remove(first) && !forest.remove(first));
    let third = forest.add(&plant(1, 10.0)).expect("a species");
    assert!(forest.set(second, &plant(SHRUB, 200.0)).expect("a species"));
    assert!(!forest.set(first, &plant(SHRUB, 0.0)).expect("a species"));
    assert_eq!(forest.len(), 2);
    settle(&mut forest, &Daylight { sky: 3.0, ..DAY });
    assert_eq!([first, second].map(|id| light(&held, id)), before);
    let now = forest.snapshot();
    let mut rgb = [7.0; 3];
    assert!(!now.at(first, point(0), &mut rgb) && rgb == [7.0; 3] && now.bands(first).is_none());
    assert!(now.at(third, point(0), &mut rgb) && rgb != [7.0; 3]);
    assert!(light(&now, second) != before[1] && third != first);
    let gone = forest.add(&plant(9, 0.0)).expect_err("three species").to_string();
    assert!(gone.contains("species 9, the library holds 3"), "{gone}");
    assert!(forest.set(second, &plant(3, 0.0)).is_err());
}

#[test]
fn work_runs_on_any_thread_in_any_order_and_what_is_dropped_is_asked_for_again() {
    let mut forest = forest(quick());
    let stands = plant(SHRUB, 0.0);
    let id = forest.add(&stands).expect("a species");
    forest.add(&plant(0, 0.0)).expect("a species");
    let (sender, receiver) = mpsc::channel::<Work>();
    let worker = std::thread::spawn(move || {
        let mut waiting = Vec::new();
        for work in receiver {
            waiting.push(work);
            // The last first.
            if waiting.len() > 2 {
                waiting.pop().expect("three").run();
            }
        }
    });
    // Every third piece is lost; those that still wait at the end, too.
    let mut number = 0;
    for _ in 0..50 {
        forest.frame(&camera(), &DAY, |work| {
            number += 1;
            if number % 3 > 0 {
                sender.send(work).expect("a worker");
            }
        });
        std::thread::yield_now();
    }
    drop(sender);
    worker.join().expect("no panic");
    settle(&mut forest, &DAY);
    assert!(error(&light(&forest.snapshot(), id), &exact(&stands, &DAY)) < 0.04);
}

#[test]
fn in_too_little_memory_plants_keep_their_mean_light_and_the_lack_is_told() {
    let residency = ResidencySettings { budget_bytes: 1 << 10, ..ResidencySettings::default() };
    let mut forest = forest(ForestSettings { residency, ..quick() });
    let id = forest.add(&plant(SHRUB, 0.0)).expect("a species");
    assert_eq!(settle(&mut forest, &DAY), 0);
    let report = forest.frame(&camera(), &DAY, Work::run);
    assert!(!report.lacks.is_empty() && report.loaded_bytes <= 1 << 10, "{report:?}");
    assert!(light(&forest.snapshot(), id).iter().flatten().all(|band| *band > 0.0));
}

#[test]
fn without_room_for_all_volumes_fewer_yaws_have_one_and_then_fewer_species() {
    let stands: Vec<Placement> =
        (0..24).map(|number| plant(number % 3, 45.0 * f64::from(number as u32))).collect();
    let frames = |max_volume_bytes: u64| {
        let mut forest = forest(ForestSettings { max_volume_bytes, ..quick() });
        let ids: Vec<PlantId> = stands.iter().map(|plant| forest.add(plant).expect("a species")).collect();
        let mut most = 0;
        for day in [DAY, Daylight { towards_sun: towards_sun(190.0, 40.0), ..DAY }] {
            for _ in 0..PATIENCE {
                let report = forest.frame(&camera(), &day, Work::run);
                most = most.max(report.volume_bytes as u64);
                if report.is_final {
                    break;
                }
            }
        }
        let report = forest.frame(&camera(), &DAY, drop);
        let snapshot = forest.snapshot();
        assert!(ids.iter().all(|id| light(&snapshot, *id).iter().flatten().all(|band| *band > 0.0)));
        (report.yaws, report.species_left_out, most)
    };
    let (yaws, left_out, all) = frames(u64::MAX);
    assert_eq!((yaws, left_out), (8, 0));
    for (share, expected) in [(2, [4, 2]), (4, [2, 1])] {
        let (yaws, left_out, most) = frames(all / share);
        assert!(
            expected.contains(&yaws) && left_out == 0 && most <= all / share,
            "{yaws} {left_out} {most} {all}"
        );
    }
    let (yaws, left_out, most) = frames(all / 12);
    assert!(
        yaws == 1 && (1..3).contains(&left_out) && most > 0 && most <= all / 12,
        "{left_out} {most} {all}"
    );
    assert_eq!(frames(0), (1, 3, 0));
}

#[test]
fn volumes_stay_while_a_camera_turns_to_and_fro() {
    // Two species, one on each side: room for all yaws of one, and for half of those of both.
    let stands = |number: u32, species: usize| {
        let x = if species == 0 { -20.0 } else { 20.0 };
        let transform = Transform::from_yaw([x, 0.0, 2.0 * f64::from(number)], 45.0 * f64::from(number), 1.0);
        Placement { species, transform }
    };
    let turned = |frame: u32| {
        // Both are seen in every fourth part of the time.
        let x = [-1.0, 0.0, 1.0, 0.0][frame as usize / 10 % 4];
        let up = libm::sqrtf(1.0 - x * x);
        Camera { position_m: [0.0, 2.0, 40.0], forward: [x, 0.0, -up], fov_deg: 80.0, ..camera() }
    };
    let run = |max_volume_bytes: u64| {
        let mut forest = forest(ForestSettings { max_volume_bytes, ..quick() });
        for number in 0..8 {
            forest.add(&stands(number, 0)).expect("a species");
            forest.add(&stands(number, 1)).expect("a species");
        }
        let (mut early, mut late, mut most) = (0, 0, 0);
        for frame in 0..600 {
            let report = forest.frame(&turned(frame), &DAY, |work| {
                *if frame < 200 { &mut early } else { &mut late } += usize::from(work.is_light());
                work.run();
            });
            most = most.max(report.volume_bytes as u64);
        }
        (early, late, most)
    };
    let (early, late, all) = run(u64::MAX);
    assert!(early > 0 && late == 0, "{early} {late}");
    for room in [all, all + all / 2, 2 * all, all / 3] {
        let (early, late, most) = run(room);
        assert!(early > 0 && late == 0 && most <= room, "{room} of {all}: {early} {late} {most}");
    }
}

#[test]
fn light_of_before_counts_beside_that_of_now_alone() {
    let mut forest = forest(quick());
    let id = forest.add(&plant(0, 45.0)).expect("a species");
    settle(&mut forest, &DAY);
    let snapshot = forest.snapshot();
    let Shown { now, mean, yaws, .. } = &snapshot.species[0];
    assert!(now.is_some() && mean.iter().all(|band| *band > 0.0));
    // Volumes of now that were dropped leave the mean light, however far the light of before was faded.
    let shown = Shown { now: None, before: now.clone(), share: 0.3, mean: mean.clone(), yaws: *yaws };
    let dropped = Snapshot { plants: Arc::clone(&snapshot.plants), species: vec![shown] };
    assert!(light(&dropped, id).iter().all(|rgb| rgb[..] == mean[..]));
    assert!(dropped.parts(id).expect("a plant").volumes.is_empty());
}

/// A camera and a sun fly through 200 plants that come and go, within memory of all sizes.
#[test]
fn a_flight_keeps_its_promises_at_every_budget() {
    let stands = |number: u32| {
        let [x, z, yaw] = [1, 2, 3].map(|what| f64::from(noise(number, what)));
        let position_m = [80.0 * x - 40.0, 0.0, 80.0 * z - 40.0];
        // Every fourth one is tilted.
        let upright = Transform::from_yaw(position_m, 360.0 * yaw, 1.0);
        let tilt = Transform::from_quaternion(position_m, [x - 0.5, yaw - 0.5, 0.5 - z, 0.9], 1.0);
        let transform = if number.is_multiple_of(4) { tilt.expect("a rotation") } else { upright };
        Placement { species: number as usize % 3, transform }
    };
    let mut levels = Vec::new();
    for budget_bytes in [4 << 10, 32 << 10, 128 << 10, 8 << 20] {
        let residency = ResidencySettings { budget_bytes, ..ResidencySettings::default() };
        let max_volume_bytes = 4 * budget_bytes;
        let settings = ForestSettings { residency, max_volume_bytes, yaws: 4, keep_frames: 5, ..quick() };
        let mut forest = forest(settings);
        let mut plants: Vec<PlantId> =
            (0..200).map(|number| forest.add(&stands(number)).expect("a species")).collect();
        let mut volumes = 0;
        for frame in 0..600_u32 {
            let one = (frame as usize * 7) % plants.len();
            assert!(forest.remove(plants[one]));
            plants[one] = forest.add(&stands(200 + frame)).expect("a species");
            let (sin, cos) = libm::sincosf(frame as f32 * 0.05);
            let eye = Camera { position_m: [30.0 * sin, 2.0, 30.0 * cos], ..camera() };
            let eye = Camera { forward: [sin, 0.0, cos], ..eye };
            let day = Daylight { towards_sun: towards_sun(90.0 + f64::from(frame) * 0.05, 40.0), ..DAY };
            // Of 50 frames' work nothing is done.
            let is_idle = frame % 200 < 50;
            let report = forest.frame(&eye, &day, |work| if is_idle { drop(work) } else { work.run() });
            assert!(report.loaded_bytes as u64 <= budget_bytes, "{report:?}");
            assert!(report.volume_bytes as u64 <= max_volume_bytes, "{report:?}");
            assert!(
                report.failures.is_empty() && report.retries.len() <= report.in_flight + 64,
                "{report:?}"
            );
            volumes = volumes.max(report.volume_bytes);
            let (snapshot, mut rgb) = (forest.snapshot(), [f32::NAN; 3]);
            for plant in plants.iter().skip(frame as usize % 20).step_by(20) {
                assert!(snapshot.at(*plant, point(frame), &mut rgb));
                assert!(rgb.iter().all(|band| *band > 0.0 && band.is_finite()), "frame {frame}: {rgb:?}");
            }
        }
        levels.push(volumes);
    }
    assert!(levels[0] == 0 && levels[3] > levels[1], "{levels:?}");
}

#[test]
fn any_step_of_the_sun_ends_in_light_that_stays() {
    for step_deg in [0.0, -3.0, 1e-9, f64::NAN, f64::INFINITY] {
        let mut forest = forest(ForestSettings { step_deg, ..quick() });
        let stands = plant(0, 45.0);
        let id = forest.add(&stands).expect("a species");
        settle(&mut forest, &DAY);
        assert_eq!(settle(&mut forest, &DAY), 0, "{step_deg}");
        assert!(error(&light(&forest.snapshot(), id), &exact(&stands, &DAY)) < 0.02);
    }
}

#[test]
fn what_is_not_seen_for_long_is_dropped() {
    let mut forest = forest(ForestSettings { keep_frames: 3, ..quick() });
    forest.add(&plant(SHRUB, 0.0)).expect("a species");
    settle(&mut forest, &DAY);
    let away = Camera { forward: [0.0, 0.0, 1.0], ..camera() };
    let bytes: Vec<usize> = (0..5).map(|_| forest.frame(&away, &DAY, Work::run).volume_bytes).collect();
    assert!(bytes[0] > 0 && bytes[4] == 0, "{bytes:?}");
}

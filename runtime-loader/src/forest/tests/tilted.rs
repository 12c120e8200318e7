//! Plants that are tilted: on slopes, leaning, lying, upside down.

use super::*;

/// A plant turned by a quaternion.
pub(in crate::forest) fn tilted(species: usize, quaternion: [f64; 4]) -> Placement {
    let transform = Transform::from_quaternion([0.0; 3], quaternion, 1.0).expect("a rotation");
    Placement { species, transform }
}

/// The shortest turn that brings a direction of the model to one of the world.
fn turned(species: usize, model: [f64; 3], world: [f64; 3]) -> Placement {
    let [a, b] = [model, world].map(|direction| unit(direction).expect("a direction"));
    let cross = |i: usize, j: usize| a[i] * b[j] - a[j] * b[i];
    let dot: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
    tilted(species, [cross(1, 2), cross(2, 0), cross(0, 1), 1.0 + dot])
}

#[test]
fn a_tilted_plant_has_the_light_of_the_sun_that_it_sees() {
    for (yaws, step_deg, most) in [(8, 15.0, 0.02), (32, 11.25, 0.002)] {
        let mut forest = forest(ForestSettings { yaws, ..quick() });
        let [x, y, z] = unit(DAY.towards_sun).expect("a sun");
        let [azimuth_deg, elevation_deg] = [libm::atan2(x, -z), libm::asin(y)].map(f64::to_degrees);
        // On a slope, far from upright, lying, and upside down.
        let some =
            [[0.1, 0.2, -0.05, 1.0], [0.3, -0.5, 0.3, 0.6], [1.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.1, 0.0]];
        let mut stands = some.map(|quaternion| tilted(0, quaternion)).to_vec();
        // Under the first sun this one sees a sun that has a volume: two yaws and a row on.
        let cell = towards_sun(azimuth_deg - 720.0 / f64::from(yaws), elevation_deg + step_deg);
        stands.push(turned(SHRUB, cell, DAY.towards_sun));
        let ids: Vec<PlantId> = stands.iter().map(|plant| forest.add(plant).expect("a species")).collect();
        let evening = Daylight { towards_sun: towards_sun(250.0, 10.0), ..DAY };
        for day in [DAY, evening, DAY] {
            settle(&mut forest, &day);
            let snapshot = forest.snapshot();
            let mut off = [0.0; 2];
            for (id, plant) in ids.iter().zip(&stands) {
                let exact_light = exact(plant, &day);
                let found = error(&light(&snapshot, *id), &exact_light);
                if plant.species != SHRUB {
                    let upright = super::plant(0, plant.transform.yaw_deg());
                    off[0] += found;
                    off[1] += error(&exact(&upright, &day), &exact_light);
                } else if day == DAY {
                    assert!(found < 0.04, "{plant:?}: {found}");
                }
            }
            assert!(off[0] < most && off[0] < 0.5 * off[1], "of yaws {yaws}: {off:?}");
        }
    }
}

#[test]
fn tilted_plants_keep_within_the_memory_of_volumes_and_are_counted_as_they_come_and_go() {
    let number = |seed: u32, axis: u32| 2.0 * f64::from(noise(seed, axis)) - 1.0;
    let stands: Vec<Placement> =
        (0..60).map(|seed| tilted(seed as usize % 3, [1, 2, 3, 4].map(|axis| number(seed, axis)))).collect();
    let mut whole = 0;
    for share in [1, 2, 5, 20] {
        let max_volume_bytes = if share == 1 { u64::MAX } else { whole / share };
        let mut forest = forest(ForestSettings { max_volume_bytes, ..quick() });
        let mut ids: Vec<PlantId> = Vec::new();
        for frame in 0..120_u32 {
            // The sun moves on at every twentieth frame, by more and more.
            let azimuth_deg = 90.0 + f64::from(frame / 20 * (frame / 20)) * 5.0;
            let day = Daylight { towards_sun: towards_sun(azimuth_deg, 30.0), ..DAY };
            if let Some(plant) = stands.get(frame as usize) {
                ids.push(forest.add(plant).expect("a species"));
            } else if frame.is_multiple_of(5) {
                assert!(forest.remove(ids.pop().expect("more plants than frames")));
            }
            let report = forest.frame(&camera(), &day, Work::run);
            whole = whole.max(if share == 1 { report.volume_bytes as u64 } else { 0 });
            assert!(report.volume_bytes as u64 <= max_volume_bytes, "{frame} {share}: {report:?}");
        }
        assert!(share > 5 || forest.frame(&camera(), &DAY, drop).volume_bytes > 0);
        // Once all have gone nothing is asked for.
        for id in ids {
            assert!(forest.remove(id));
        }
        assert!(forest.species.iter().all(|lit| lit.cells().count() == 0));
    }
}

#[test]
fn without_a_sun_one_volume_serves_all_plants_of_a_species() {
    let mut forest = forest(quick());
    let night = Daylight { sun: 0.0, ..DAY };
    let stands = [plant(0, 10.0), plant(0, 200.0), tilted(0, [0.3, 0.1, 0.2, 0.5])];
    let ids = stands.map(|plant| forest.add(&plant).expect("a species"));
    settle(&mut forest, &night);
    let report = forest.frame(&camera(), &night, Work::run);
    let snapshot = forest.snapshot();
    let volumes: Vec<_> = ids.map(|id| snapshot.parts(id).expect("a plant").volumes[0].0).to_vec();
    assert_eq!(report.volume_bytes, volumes[0].size_bytes());
    assert!(volumes.iter().all(|volume| Arc::ptr_eq(volume, volumes[0])));
    // At dawn each has its own again, and the night fades.
    settle(&mut forest, &DAY);
    for (id, plant) in ids.iter().zip(&stands) {
        assert!(error(&light(&forest.snapshot(), *id), &exact(plant, &DAY)) < 0.02);
    }
}

#[test]
fn once_there_is_room_again_finer_volumes_come_and_stay() {
    // Slopes to 10 degrees, and a second species that is seen for a while only.
    let slope = |number: u32| {
        let half = f64::from(noise(number, 7)) * libm::sin(5.0_f64.to_radians());
        let (sin, cos) = libm::sincos(2.4 * f64::from(number));
        let (turn_sin, turn_cos) = libm::sincos(0.7 * f64::from(number));
        // A yaw, then a tilt to some side.
        tilted(
            0,
            [
                half * (cos * turn_cos + sin * turn_sin),
                turn_sin,
                half * (sin * turn_cos - cos * turn_sin),
                turn_cos,
            ],
        )
    };
    let fresh = |max_volume_bytes: u64| {
        let mut forest = forest(ForestSettings { max_volume_bytes, ..quick() });
        (0..40).for_each(|number| _ = forest.add(&slope(number)).expect("a species"));
        forest
    };
    let settled = |mut forest: Forest| {
        settle(&mut forest, &DAY);
        forest.frame(&camera(), &DAY, drop)
    };
    let all = settled(fresh(u64::MAX)).volume_bytes as u64;
    for share in [10, 14, 19, 21, 26, 40] {
        let room = all * share / 10;
        let expected = settled(fresh(room));
        let mut forest = fresh(room);
        let others: Vec<PlantId> = (0..8)
            .map(|number| forest.add(&plant(1, 45.0 * f64::from(number))).expect("a species"))
            .collect();
        let mut made = Vec::new();
        for frame in 0..900 {
            if frame == 60 {
                others.iter().for_each(|id| assert!(forest.remove(*id)));
            }
            let mut works = 0;
            let report = forest.frame(&camera(), &DAY, |work| {
                works += usize::from(work.is_light());
                work.run();
            });
            assert!(report.volume_bytes as u64 <= room, "{frame}: {report:?}");
            made.push(works);
        }
        let last = forest.frame(&camera(), &DAY, drop);
        assert_eq!((last.yaws, last.volume_bytes), (expected.yaws, expected.volume_bytes), "{share}");
        assert!(
            last.is_final && made[450..].iter().all(|works| *works == 0),
            "{share}: made again and again"
        );
    }
}

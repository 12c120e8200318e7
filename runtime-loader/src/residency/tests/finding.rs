//! What frames show, against counting by hand.

use super::*;

fn camera() -> Camera {
    Camera {
        position_m: [0.0, 2.0, 20.0],
        forward: [0.0, 0.0, -1.0],
        up: [0.0, 1.0, 0.0],
        fov_deg: 60.0,
        width_px: 800,
        height_px: 600,
    }
}

const NOON: Daylight = Daylight { towards_sun: [0.1, 0.9, 0.3], sun: 1.0, sky: 0.2 };

fn yaw(degrees: f32) -> [[f32; 3]; 3] {
    let (sin, cos) = libm::sincosf(degrees.to_radians());
    [[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]]
}

fn at(species: usize, position_m: [f32; 3], rotation: [[f32; 3]; 3]) -> Placement {
    let rotation = rotation.map(|row| row.map(f64::from));
    let transform = Transform { rotation, position_m: position_m.map(f64::from), scale: 1.0 };
    Placement { species, transform }
}

fn find(instances: Vec<Placement>, camera: &Camera, light: &Daylight) -> Need {
    let placed = Placed::new(LIBRARY.container(), instances);
    NeedFinder::new(LIBRARY.container(), &UNITS).find(&placed, camera, light)
}

#[test]
fn plants_that_are_not_seen_need_nothing() {
    let behind = at(0, [0.0, 0.0, 40.0], NO_ROTATION);
    let beside = at(1, [60.0, 0.0, 0.0], NO_ROTATION);
    let seen = at(2, [0.0, 0.0, 0.0], NO_ROTATION);
    let need = find(vec![behind, beside, seen], &camera(), &NOON);
    assert_eq!((need.species[0].pixels, need.species[1].pixels), (0.0, 0.0));
    assert!(need.species[2].pixels > 1000.0);
    let moved = {
        let mut placed = Placed::new(LIBRARY.container(), vec![behind]);
        placed.set(LIBRARY.container(), 0, &at(0, [0.0; 3], NO_ROTATION));
        NeedFinder::new(LIBRARY.container(), &UNITS).find(&placed, &camera(), &NOON)
    };
    assert!(moved.species[0].pixels > 1000.0, "moved before the camera");
}

const POND: Option<WaterPlane> = Some(WaterPlane { height_m: 0.0, spread_deg: 0.0 });

#[test]
fn plants_seen_in_water_alone_are_needed_as_from_the_other_side_of_it() {
    // Down at a pond, over which a plant stands on a rock.
    let down = Camera { position_m: [0.0, 6.0, 20.0], forward: [0.0, -0.8, -1.0], fov_deg: 40.0, ..camera() };
    let plant = at(0, [0.0, 8.0, 2.0], yaw(20.0));
    let placed = Placed::new(LIBRARY.container(), vec![plant]);
    let mut finder = NeedFinder::new(LIBRARY.container(), &UNITS);
    assert_eq!(finder.find_over_water(&placed, &down, None, &NOON).species[0].pixels, 0.0);
    let seen = finder.find_over_water(&placed, &down, POND, &NOON).species.remove(0);
    let image = Camera { position_m: [0.0, -6.0, 20.0], forward: [0.0, 0.8, -1.0], ..down };
    let expected = finder.find(&placed, &image, &NOON).species.remove(0);
    assert!(seen.pixels > 1000.0);
    assert_eq!((seen.pixels, &seen.bases), (expected.pixels, &expected.bases));
    assert_eq!(seen.windows.as_ref().map(Vec::len), Some(1));
    // Seen twice, it counts twice.
    let level = |water| finder.find_over_water(&placed, &camera(), water, &NOON).species.remove(0).pixels;
    let [alone, with_image] = [None, POND].map(level);
    assert!(alone > 0.0 && with_image > 1.1 * alone, "{alone} {with_image}");
    // Five plants are few, though each is seen twice.
    let few = (0..5).map(|i| at(0, [2.0 * i as f32 - 4.0, 0.5, 0.0], NO_ROTATION));
    let placed = Placed::new(LIBRARY.container(), few);
    let seen = finder.find_over_water(&placed, &camera(), POND, &NOON).species.remove(0);
    assert_eq!(seen.windows.map(|windows| windows.len()), Some(10));
}

#[test]
fn bases_with_weight_are_needed_in_every_frame_of_an_instance() {
    // Each turn of the plant asks for other bases; the blend's are always among those that are needed.
    for degrees in 0..360 {
        let rotation = yaw(degrees as f32);
        let instance = at(1, [0.0; 3], rotation);
        let need = find(vec![instance], &camera(), &NOON);
        let sun = instance.transform.model_from_world_direction(NOON.towards_sun);
        let blend = flb_format::sun::blend(sun).expect("a direction");
        let seen = &need.species[1];
        for (base, weight) in blend.bases.into_iter().zip(blend.weights).filter(|(_, w)| *w > 1e-6) {
            let need = seen.bases[usize::from(base)] / seen.pixels;
            assert!(
                need > 0.0 && need >= 0.04 * weight * weight,
                "base {base} of {weight} at {degrees}: {need}"
            );
        }
        assert!((seen.bases[0] / seen.pixels - 0.04).abs() < 1e-6, "the sky's factor squared");
        let few = seen.bases[1..].iter().filter(|need| **need > 0.1 * seen.pixels).count();
        assert!((1..=4).contains(&few), "{few} bases of much weight");
        let none = seen.bases[1..].iter().filter(|need| **need == 0.0).count();
        let now = seen.is_now[1..].iter().filter(|now| **now).count();
        assert!(seen.is_now[0] && (1..=6).contains(&now), "{now} bases of weight now");
        assert!(none >= 8, "bases on the other side are not needed: {:?}", seen.bases);
    }
}

#[test]
fn harmonics_need_all_their_bases_and_no_sun_needs_the_sky_alone() {
    let night = Daylight { sun: 0.0, ..NOON };
    let nowhere = Daylight { towards_sun: [0.0; 3], ..NOON };
    for light in [night, nowhere] {
        let need = find(vec![at(2, [0.0; 3], NO_ROTATION)], &camera(), &light);
        assert!(need.species[2].bases[0] > 0.0 && need.species[2].bases[1..].iter().all(|need| *need == 0.0));
    }
    let day = Daylight { sky: 0.0, ..NOON };
    let need = find(vec![at(2, [0.0; 3], yaw(33.0))], &camera(), &day);
    assert_eq!(need.species[2].bases[0], 0.0);
    assert!(need.species[2].bases[1..].iter().all(|need| *need > 0.0), "{:?}", need.species[2].bases);
}

#[test]
fn detail_is_needed_near_by_and_only_where_it_is_seen() {
    let near = find(vec![at(0, [0.0; 3], NO_ROTATION)], &camera(), &NOON);
    let far = Camera { position_m: [0.0, 2.0, 1200.0], ..camera() };
    let far = find(vec![at(0, [0.0; 3], NO_ROTATION)], &far, &NOON);
    assert!(near.species[0].detail.iter().any(|need| *need > 0.0));
    assert!(far.species[0].pixels > 0.0 && far.species[0].detail.iter().all(|need| *need == 0.0));
    assert_eq!(far.species[0].windows.as_ref().map(Vec::len), Some(0));

    // Close to the plant, looking at its right side only: pages of its left are left for later.
    let close = Camera { position_m: [1.2, 2.0, 2.5], forward: [0.6, 0.0, -1.0], fov_deg: 30.0, ..camera() };
    let need = find(vec![at(0, [0.0; 3], NO_ROTATION)], &close, &NOON);
    let mut residency = residency(PLENTY);
    settle(&mut residency, &need);
    let pages = |residency: &Residency| {
        loaded(residency).filter(|unit| matches!(UNITS.get(*unit).kind, UnitKind::Detail { .. })).count()
    };
    let without_boxes = pages(&residency);
    let shared = LIBRARY.container().read_shared(LIBRARY.source(), 0).expect("it reads");
    let mut residency = self::residency(PLENTY);
    residency.set_runs(0, Runs::of(&shared.map));
    settle(&mut residency, &need);
    assert!(
        0 < pages(&residency) && pages(&residency) < without_boxes,
        "{} of {without_boxes}",
        pages(&residency)
    );
    // Whatever is not loaded lies outside the view.
    let window = &need.species[0].windows.as_ref().expect("one plant")[0];
    for unit in UNITS.of_species(0) {
        let UnitKind::Detail { base, .. } = UNITS.get(unit).kind else { continue };
        if need.species[0].detail[base as usize] > 0.0 && !residency.is_loaded(unit) {
            let [first, count] = UNITS.get(unit).blocks;
            for rank in first..first + count {
                let block = shared.map.block(rank as usize).map(|b| b as f32 * 0.25);
                let (min, max) = ([block[0] - 2.0, block[1], block[2] - 2.0], block.map(|b| b + 0.25));
                assert!(!window.sees_box(min, [max[0] - 2.0, max[1], max[2] - 2.0]), "block {rank}");
            }
        }
    }
}

#[test]
fn many_plants_need_what_they_need_one_by_one() {
    let instances: Vec<Placement> = (0..50)
        .map(|i| {
            at(i % 3, [(i % 10) as f32 * 4.0 - 20.0, 0.0, -((i / 10) as f32) * 5.0], yaw(i as f32 * 37.0))
        })
        .collect();
    let all = find(instances.clone(), &camera(), &NOON);
    let mut sums: Vec<Vec<f32>> = (0..3).map(|species| vec![0.0; UNITS.bases(species).len()]).collect();
    for instance in &instances {
        let one = find(vec![*instance], &camera(), &NOON);
        for (sum, one) in sums.iter_mut().zip(&one.species) {
            sum.iter_mut().zip(&one.bases).for_each(|(sum, need)| *sum += need);
        }
    }
    for (species, sums) in sums.iter().enumerate() {
        assert!(all.species[species].windows.is_none(), "more than a few");
        for (sum, need) in sums.iter().zip(&all.species[species].bases) {
            assert!((sum - need).abs() <= 1e-4 * sum.max(1.0), "{sum} for {need}");
        }
    }
    // A second frame is not told of the first.
    let placed = Placed::new(LIBRARY.container(), instances);
    let mut finder = NeedFinder::new(LIBRARY.container(), &UNITS);
    finder.find(&placed, &camera(), &NOON);
    let again = finder.find(&placed, &camera(), &NOON);
    assert_eq!(again.species[1].bases, all.species[1].bases);
}

#[test]
fn every_direction_has_a_cell_and_its_blend_is_in_the_table() {
    let suns = SunBasis::Lattice18;
    let table = super::super::need::squares_by_cell(&suns);
    for i in 0..20_000u32 {
        let d = crate::view::unit([0, 1, 2].map(|axis| crate::plants::noise(i * 3 + axis, 9) - 0.5));
        let blend = suns.blend(d.map(f64::from)).expect("a direction");
        for (base, weight) in blend.bases.into_iter().zip(blend.weights) {
            let square = table(d)[usize::from(base)];
            // A cell is 6 degrees wide, a triangle 45.
            assert!(weight < 1e-3 || square > 0.0, "{d:?}: base {base} of {weight}");
            assert!(square >= weight * weight - 0.2, "{d:?}: base {base} of {weight}: {square}");
        }
    }
}

use proptest::prelude::*;

use super::*;
use crate::sun::blend;

/// A kept base is reached by a sun this near the set: the guard, a patch of its size beside the set, and what
/// the search below leaves.
const MARGIN_DEG: f64 = 0.05;
/// Directions nearer a face than this may fall on either side of it by rounding.
const ROUNDING: f64 = 1e-12;

const IDENTITY: Rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Bases with weight under a sun, by the blend itself.
fn weighted(towards_sun: [f64; 3]) -> BaseSet {
    let blend = blend(towards_sun).expect("a direction");
    let pairs = blend.bases.into_iter().zip(blend.weights);
    pairs.filter(|(_, weight)| *weight != 0.0).map(|(base, _)| base).collect()
}

/// The sun as a plant of this rotation sees it, as a renderer in f32 has it.
fn in_model(rotation: &Rotation, sun: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|column| {
        (0..3).map(|row| rotation[row][column] as f32 * sun[row] as f32).sum::<f32>().into()
    })
}

/// From any quaternion but 0.
fn rotation([x, y, z, w]: [f64; 4]) -> Rotation {
    let length = (x * x + y * y + z * z + w * w).sqrt();
    let [x, y, z, w] = [x, y, z, w].map(|c| c / length);
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
        [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

fn yaw(degrees: f64) -> Rotation {
    let half = degrees.to_radians() / 2.0;
    rotation([0.0, -libm::sin(half), 0.0, libm::cos(half)])
}

fn reached(suns: &SunSet, rotation: &Rotation) -> BaseSet {
    let mut reached = BaseSet::NONE;
    Reach::new(suns).add_rotated(rotation, &mut reached);
    reached
}

fn fixed(suns: &[[f64; 2]]) -> SunSet {
    SunSet { fixed_deg: suns.to_vec(), zones: Vec::new() }
}

fn zone(latitude_deg: f64, declination_deg: [f64; 2]) -> SunSet {
    SunSet { fixed_deg: Vec::new(), zones: vec![Zone { latitude_deg, declination_deg }] }
}

fn set(bases: &[u8]) -> BaseSet {
    bases.iter().copied().collect()
}

#[test]
fn upright_plants_under_the_whole_sky_need_no_base_that_travels_upwards() {
    let found = Reach::new(&SunSet { fixed_deg: vec![], zones: vec![Zone::SKY] }).any_yaw();
    let upwards = (1..=18).filter(|base| DIRECTIONS[*base as usize][1] > 0);
    assert_eq!(found, upwards.collect::<BaseSet>().with(0).missing());
    assert_eq!(found.len(), 13);
}

#[test]
fn a_low_sun_spares_the_base_straight_down() {
    // At the winter solstice in Berlin the sun rises to 90 - 52.5 - 23.44 = 14 degrees.
    let found = Reach::new(&zone(52.5, [-23.44, -23.0])).any_yaw();
    assert_eq!(found, set(&[1, 2, 5, 6, 8, 9, 11, 12, 13, 14, 16, 18]));
    let summer = Reach::new(&zone(52.5, [23.0, 23.44])).any_yaw();
    assert_eq!(summer, found.with(4));
}

#[test]
fn horizon_and_zenith_are_exact_for_upright_plants() {
    let horizontal = set(&[1, 2, 5, 6, 11, 12, 13, 14]);
    assert_eq!(Reach::new(&fixed(&[[30.0, 0.0]])).any_yaw(), horizontal);
    assert_eq!(Reach::new(&fixed(&[[30.0, 90.0]])).any_yaw(), set(&[4]));
    assert_eq!(Reach::new(&fixed(&[[30.0, -90.0]])).any_yaw(), set(&[3]));
    assert_eq!(reached(&fixed(&[[30.0, 90.0]]), &yaw(17.0)), set(&[4]));
    assert!(reached(&fixed(&[[30.0, 0.0]]), &yaw(17.0)).missing().intersection(horizontal).len() == 6);
}

#[test]
fn a_polar_night_has_no_sun_and_a_polar_day_no_horizon() {
    let night = Reach::new(&zone(80.0, [-23.0, -20.0]));
    assert!(night.is_dark());
    let tilted = rotation([0.3, 0.1, 0.5, 0.2]);
    assert_eq!(reached(&zone(80.0, [-23.0, -20.0]), &tilted), BaseSet::NONE);
    // Not even where it stays below the horizon by less than the guard.
    assert_eq!(reached(&zone(80.0, [-23.0, -10.005]), &tilted), BaseSet::NONE);
    assert_eq!(reached(&zone(80.0, [-23.0, -9.9]), &tilted).len(), 3);
    assert_eq!(Zone { latitude_deg: 80.0, declination_deg: [-23.0, -20.0] }.elevations_deg(), None);
    for sign in [1.0, -1.0] {
        let declination_deg = if sign > 0.0 { [20.0, 23.0] } else { [-23.0, -20.0] };
        let day = Zone { latitude_deg: sign * 80.0, declination_deg }.elevations_deg().expect("it is up");
        assert_eq!(day, [10.0, 33.0]);
    }
}

#[test]
fn a_single_sun_takes_the_three_bases_of_its_blend() {
    let sun = [123.0, 31.0];
    let found = reached(&fixed(&[sun]), &IDENTITY);
    assert_eq!(found, weighted(towards_sun(sun[0], sun[1])));
    assert_eq!(found.len(), 3);
    // A plant turned with the sun sees it where it was.
    assert_eq!(reached(&fixed(&[[sun[0] + 77.0, sun[1]]]), &yaw(77.0)), found);
    assert_ne!(reached(&fixed(&[[sun[0] + 77.0, sun[1]]]), &IDENTITY), found);
}

#[test]
fn a_sun_within_the_guard_of_a_base_keeps_it() {
    // Straight down starts at elevation 45, where the light runs along one axis; its faces lean, so that 0.015 degrees
    // short of it is more than the guard.
    for (elevation, kept) in [(44.995, true), (44.985, false), (44.9, false)] {
        let band = Zone { latitude_deg: 90.0, declination_deg: [10.0, elevation] };
        let band = SunSet { fixed_deg: vec![], zones: vec![band] };
        assert_eq!(reached(&fixed(&[[0.0, elevation]]), &IDENTITY).contains(4), kept, "{elevation}");
        assert_eq!(Reach::new(&band).any_yaw().contains(4), elevation > 44.99, "{elevation}");
        // Patches of a zone end at the guard's size, which may keep a little more.
        if kept || elevation < 44.95 {
            assert_eq!(reached(&band, &IDENTITY).contains(4), kept, "{elevation}");
        }
    }
}

#[test]
fn every_sun_of_a_sphere_needs_every_base() {
    let tilted = rotation([0.2, 0.4, 0.7, 0.5]);
    let upside_down = rotation([1.0, 0.0, 0.0, 0.0]);
    let sky = SunSet { fixed_deg: vec![], zones: vec![Zone::SKY] };
    let both = reached(&sky, &IDENTITY).union(reached(&sky, &upside_down));
    assert_eq!(both, BaseSet::ALL.intersection((1..=18).collect()));
    assert!(reached(&sky, &tilted).len() > 13);
}

#[test]
fn a_base_taken_away_is_missed_by_some_sun() {
    let suns = zone(52.5, [-23.44, 23.44]);
    let found = reached(&suns, &IDENTITY);
    let mut seen = BaseSet::NONE;
    for declination in 0..=40 {
        for hour in 0..720 {
            let sun = suns.zones[0].sun(-23.4 + 1.17 * f64::from(declination), 0.5 * f64::from(hour));
            if sun[1] >= 0.0 {
                seen = seen.union(weighted(sun));
            }
        }
    }
    assert_eq!(seen, found);
}

/// The deepest that a sun near the set comes into the cone of a base: a grid, then ever smaller steps.
fn deepest(suns: &SunSet, rotation: &Rotation, base: u8) -> f64 {
    let zone = &suns.zones[0];
    let ([low, high], faces) = (zone.declination_deg, faces(base));
    let depth = |declination: f64, hour: f64| {
        let sun = zone.sun(declination.clamp(low, high), hour);
        if sun[1] < -ROUNDING {
            return sun[1] - 2.0;
        }
        let light = in_model(rotation, sun).map(|c| -c);
        faces.iter().map(|face| dot(*face, light)).fold(f64::INFINITY, f64::min)
    };
    let mut best: Vec<[f64; 3]> = Vec::new();
    for i in 0..=24 {
        for j in 0..180 {
            let (declination, hour) = (low + (high - low) * f64::from(i) / 24.0, 2.0 * f64::from(j));
            best.push([depth(declination, hour), declination, hour]);
        }
    }
    best.sort_by(|a, b| b[0].total_cmp(&a[0]));
    best.truncate(12);
    for start in &mut best {
        let mut step = 2.0;
        while step > 1e-4 {
            let around = (0..16).map(|turn| {
                let angle = std::f64::consts::TAU * f64::from(turn) / 16.0;
                let (d, h) = (start[1] + step * libm::sin(angle), start[2] + step * libm::cos(angle));
                [depth(d, h), d.clamp(low, high), h]
            });
            let next = around.max_by(|a, b| a[0].total_cmp(&b[0])).expect("sixteen");
            if next[0] > start[0] { *start = next } else { step *= 0.5 }
        }
    }
    best.iter().map(|b| b[0]).fold(f64::NEG_INFINITY, f64::max)
}

fn any_zone() -> impl Strategy<Value = SunSet> {
    let latitude = prop_oneof![-90.0f64..90.0, Just(0.0), Just(90.0), Just(-66.56), Just(23.44)];
    let width = prop_oneof![0.0f64..50.0, Just(0.0), 0.0f64..0.5];
    (latitude, -24.0f64..24.0, width).prop_map(|(l, d, width)| zone(l, [d, (d + width).min(24.0)]))
}

fn any_rotation() -> impl Strategy<Value = Rotation> {
    let tilted =
        prop::array::uniform4(-1.0f64..1.0).prop_filter("a turn", |q| q.iter().any(|c| c.abs() > 0.1));
    prop_oneof![tilted.prop_map(rotation), (-360.0f64..360.0).prop_map(yaw)]
}

fn direction() -> impl Strategy<Value = [f64; 3]> {
    let edge = (-1.0f64..1.0, 0.0f64..1.0, -1e-9f64..1e-9).prop_map(|(a, b, e)| [a.abs() + b + e, -a, b]);
    prop_oneof![prop::array::uniform3(-1.0f64..1.0), edge]
        .prop_filter("a direction", |d| d.iter().any(|c| c.abs() > 0.01))
}

fn suns() -> impl Strategy<Value = Vec<[f64; 2]>> {
    let near = (-180.0f64..180.0, -80.0f64..80.0, prop::collection::vec((0.0f64..9.0, 0.0f64..9.0), 1..60))
        .prop_map(|(a, e, more)| more.iter().map(|(da, de)| [a + da, e + de]).collect());
    prop_oneof![
        prop::collection::vec((-360.0f64..360.0, -90.0f64..=90.0).prop_map(|(a, e)| [a, e]), 1..20),
        near
    ]
}

proptest! {
    #[test]
    fn fixed_suns_need_together_what_each_needs_alone(suns in suns(), rotation in any_rotation()) {
        let alone = suns.iter().map(|sun| reached(&fixed(&[*sun]), &rotation));
        let alone = alone.fold(BaseSet::NONE, BaseSet::union);
        let together = reached(&fixed(&suns), &rotation);
        prop_assert_eq!(together.intersection(alone), alone);
        // Suns nearer to each other than the guard are asked for as one.
        for base in together.intersection(alone.missing()).iter() {
            let depth = |sun: &[f64; 2]| {
                let light = in_model(&rotation, towards_sun(sun[0], sun[1])).map(|c| -c);
                faces(base).iter().map(|face| dot(*face, light)).fold(f64::INFINITY, f64::min)
            };
            let deepest = suns.iter().map(depth).fold(f64::NEG_INFINITY, f64::max);
            prop_assert!(deepest > -MARGIN_DEG.to_radians(), "base {base} is {deepest} away");
        }
        for sun in &suns {
            let needed = weighted(in_model(&rotation, towards_sun(sun[0], sun[1])));
            prop_assert!(needed.intersection(together.missing()).is_empty(), "{needed:?}, kept {together:?}");
        }
    }

    #[test]
    fn a_base_has_weight_exactly_inside_the_four_faces_of_its_star(light in direction()) {
        let weighted = weighted(light.map(|c| -c));
        for base in 1..=18u8 {
            let depth = faces(base).iter().map(|face| dot(*face, light)).fold(f64::INFINITY, f64::min);
            if depth.abs() > ROUNDING {
                prop_assert_eq!(weighted.contains(base), depth > 0.0, "base {}, depth {}", base, depth);
            }
        }
    }

    #[test]
    fn no_sun_of_a_zone_gives_weight_to_a_base_left_out(
        suns in any_zone(), rotation in any_rotation(), at in prop::collection::vec((0.0f64..=1.0, 0.0f64..360.0), 64),
    ) {
        let kept = reached(&suns, &rotation);
        let [low, high] = suns.zones[0].declination_deg;
        for (share, hour) in at {
            let sun = suns.zones[0].sun(low + share * (high - low), hour);
            if sun[1] >= 0.0 {
                let needed = weighted(in_model(&rotation, sun));
                prop_assert!(needed.intersection(kept.missing()).is_empty(), "{needed:?}, kept {kept:?}");
            }
        }
    }

    #[test]
    fn no_upright_plant_needs_a_base_that_any_yaw_leaves_out(
        suns in any_zone(), more in prop::collection::vec((-360.0f64..360.0, -90.0f64..=90.0), 0..4),
        at in prop::collection::vec((0.0f64..=1.0, 0.0f64..360.0, -360.0f64..360.0), 64),
    ) {
        let suns = SunSet { fixed_deg: more.iter().map(|(a, e)| [*a, *e]).collect(), ..suns };
        let kept = Reach::new(&suns).any_yaw();
        let [low, high] = suns.zones[0].declination_deg;
        for (share, hour, degrees) in at {
            let sun = suns.zones[0].sun(low + share * (high - low), hour);
            let fixed = suns.fixed_deg.iter().map(|[a, e]| towards_sun(*a, *e));
            for sun in fixed.chain((sun[1] >= 0.0).then_some(sun)) {
                let needed = weighted(in_model(&yaw(degrees), sun));
                prop_assert!(needed.intersection(kept.missing()).is_empty(), "{needed:?}, kept {kept:?}");
            }
        }
    }

    #[test]
    fn any_yaw_keeps_only_bases_that_some_yaw_reaches(elevations in prop::array::uniform2(-90.0f64..=90.0)) {
        let [low, high] = [elevations[0].min(elevations[1]), elevations[0].max(elevations[1])];
        for base in of_elevations([low, high]).iter() {
            let [x, _, z] = DIRECTIONS[base as usize].map(f64::from);
            let reached = (0..=4000).any(|i| {
                let from = low - MARGIN_DEG;
                let elevation = from + (high + MARGIN_DEG - from) * f64::from(i) / 4000.0;
                // The best yaw has the light travel the base's way; straight up or down any yaw serves.
                let azimuth = if x == 0.0 && z == 0.0 { 0.0 } else { libm::atan2(-x, z).to_degrees() };
                weighted(towards_sun(azimuth, elevation.clamp(-90.0, 90.0))).contains(base)
            });
            prop_assert!(reached, "base {base} for {low} to {high}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn every_base_kept_is_reached_within_the_margin(suns in any_zone(), rotation in any_rotation()) {
        for base in reached(&suns, &rotation).iter() {
            let depth = deepest(&suns, &rotation, base);
            prop_assert!(depth > -MARGIN_DEG.to_radians(), "base {base} is {depth} away");
        }
    }
}

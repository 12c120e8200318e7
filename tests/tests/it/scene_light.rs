//! Laws of scene light, from the plants' media to what others do at points of instances; and how near it comes to a
//! fine lattice over all of them. `cargo bench -p flb-tests --bench stand` prints the whole table.

use flb_baker::scene_light::Ground;
use flb_fixtures::PlantKind;
use flb_format::sun::towards_sun;
use flb_format::{Placement, Transform};
use flb_runtime::scene_light::{Modulations, SceneFactor, SceneLight, TILTS, TURNS};
use flb_scene::scene::{self, Terrain};
use flb_tests::stand::{Kind, Pair, Stand, SunAndSky, day, error, light_at_sites, pairs};
use flb_transport::monte_carlo::{Illumination, Settings, trace};
use flb_transport::ordinates::SunBasis;
use flb_transport::turbid::scatter;

/// As `flb bake-scene` has it by default.
const SUNS: SunBasis = SunBasis::Harmonics { degree: 1, single: false, leaning: false };
/// A low sun in the east.
const EAST: [f64; 2] = [90.0, 20.0];

fn sun([azimuth_deg, elevation_deg]: [f64; 2]) -> [f64; 3] {
    towards_sun(azimuth_deg, elevation_deg)
}

/// A ball 2 m across, of optical depth 3.
fn ball() -> Kind {
    Kind::ball("ball", 16, 1.0, 1.5)
}

fn at(position_m: [f64; 3], yaw_deg: f64) -> Placement {
    let [sin, _, minus_cos] = towards_sun(yaw_deg, 0.0);
    let rotation = [[-minus_cos, 0.0, -sin], [0.0, 1.0, 0.0], [sin, 0.0, -minus_cos]];
    Placement { species: 0, transform: Transform { rotation, position_m, scale: 1.0 } }
}

fn stand(kind: Kind, instances: Vec<Placement>) -> Stand {
    Stand { kinds: vec![kind], instances, ground: None }
}

/// All sites' middles of an instance.
fn points(stand: &Stand, instance: u32) -> Vec<(u32, [f32; 3])> {
    let turbid = &stand.kinds[stand.instances[instance as usize].species].turbid;
    let grid = &turbid.grid;
    let middle = |site: u32| (instance, grid.middle_m(grid.site(site as usize)).map(|c| c as f32));
    turbid.sites().into_iter().map(middle).collect()
}

fn shares(stand: &Stand, lattice: u32, sun_deg: [f64; 2], instance: u32) -> Vec<Modulations> {
    let library = stand.library(lattice, &SUNS);
    stand.modulations(&library, sun(sun_deg), &points(stand, instance)).expect("a sun")
}

fn mean(shares: &[Modulations], of: impl Fn(&Modulations) -> f32) -> f64 {
    shares.iter().map(|shares| f64::from(of(shares))).sum::<f64>() / shares.len() as f64
}

/// Root mean square of what is taken.
fn taken(shares: &[Modulations], left: impl Fn(&Modulations) -> f32) -> f64 {
    mean(shares, |shares| (1.0 - left(shares)) * (1.0 - left(shares))).sqrt()
}

/// Where a plant's coarse sites fall otherwise than its own, its light is a little another: 1.5 % rms was found in the
/// sun and 0.8 % under the sky, on an oak 3.1 and 1.1 %.
const TURNED: [f64; 2] = [0.03, 0.015];

#[test]
fn a_plant_alone_keeps_its_light_to_the_last_bit_and_turned_within_the_grain_of_the_lattice() {
    for place in [[0.0; 3], [3.7, 2.1, -40.0]] {
        for shares in shares(&stand(ball(), vec![at(place, 0.0)]), 16, EAST, 0) {
            for share in [shares.sun, shares.sky] {
                assert!((share.scale - 1.0).abs() < 1e-4 && share.add < 1e-4, "{shares:?}");
            }
        }
    }
    let shares = shares(&stand(ball(), vec![at([0.0; 3], 30.0)]), 16, EAST, 0);
    let found = [taken(&shares, |shares| shares.sun.scale), taken(&shares, |shares| shares.sky.scale)];
    assert!(found[0] < TURNED[0] && found[1] < TURNED[1] && found[0] > 0.0, "{found:?}");
    assert!(mean(&shares, |shares| shares.sun.add) < 1e-3);
}

#[test]
fn a_neighbour_far_away_takes_nothing_and_one_that_is_near_much() {
    let beside =
        |x: f64| shares(&stand(ball(), vec![at([0.0; 3], 0.0), at([x, 0.0, 0.0], 0.0)]), 64, EAST, 0);
    let far = beside(20.0);
    assert!(mean(&far, |shares| shares.sun.scale) > 0.98 && mean(&far, |shares| shares.sky.scale) > 0.98);
    let near = beside(2.2);
    assert!(mean(&near, |shares| shares.sun.scale) < 0.7, "{}", mean(&near, |shares| shares.sun.scale));
    assert!(mean(&near, |shares| shares.sky.scale) < 0.97);
}

/// Rays through a lattice are not mirrored: of what is left 0.014 was found between both, of what is added 0.0013.
const MIRRORED: [f32; 2] = [0.03, 0.005];

#[test]
fn mirrored_plants_take_mirrored_light() {
    let stand = stand(ball(), vec![at([-1.3, 0.0, 0.0], 0.0), at([1.3, 0.0, 0.0], 0.0)]);
    let library = stand.library(32, &SUNS);
    // In the plane between them.
    for sun_deg in [[0.0, 35.0], [180.0, 10.0]] {
        let left = points(&stand, 0);
        let right: Vec<_> = left.iter().map(|(_, [x, y, z])| (1, [-x, *y, *z])).collect();
        let of =
            |points: &[(u32, [f32; 3])]| stand.modulations(&library, sun(sun_deg), points).expect("a sun");
        for (a, b) in of(&left).into_iter().zip(of(&right)) {
            for (a, b) in [(a.sun, b.sun), (a.sky, b.sky)] {
                let off = [(a.scale - b.scale).abs(), (a.add - b.add).abs()];
                assert!(off[0] < MIRRORED[0] && off[1] < MIRRORED[1], "{a:?} {b:?}");
            }
        }
    }
}

#[test]
fn doubling_everything_changes_no_share() {
    let of = |times: f64| {
        let instances = [[0.0; 3], [2.1, 0.3, 0.5]].map(|place| Placement {
            species: 0,
            transform: Transform { scale: times, ..at(place.map(|c| c * times), 0.0).transform },
        });
        shares(&stand(ball(), instances.to_vec()), 16, EAST, 0)
    };
    for (one, two) in of(1.0).into_iter().zip(of(2.0)) {
        assert!((one.sun.scale - two.sun.scale).abs() < 1e-4, "{one:?} {two:?}");
        assert!((one.sky.scale - two.sky.scale).abs() < 1e-4, "{one:?} {two:?}");
        assert!((one.sun.add - two.sun.add).abs() < 1e-4, "{one:?} {two:?}");
    }
}

#[test]
fn light_from_below_is_that_of_the_ground() {
    let on = |ground: Option<f64>| {
        let mut stand = stand(ball(), vec![at([0.0, 0.5, 0.0], 0.0), at([9.0, 0.5, 5.0], 0.0)]);
        stand.ground = ground.map(|share| {
            let terrain = Terrain::Plane { height_m: 0.0 };
            Ground::of(&scene::Ground { terrain, color: [share; 3] }).expect("a plane")
        });
        shares(&stand, 64, [90.0, 60.0], 0)
    };
    let (none, dark, bright) = (on(None), on(Some(0.0)), on(Some(0.5)));
    let sky = |shares: &[Modulations]| mean(shares, |shares| shares.sky.scale);
    // Half of the sky is below; what is left of the rest comes through leaves.
    assert!(sky(&none) > 0.97 && (0.4..0.7).contains(&sky(&dark)), "{} {}", sky(&none), sky(&dark));
    assert!(sky(&bright) > sky(&dark) + 0.05, "{} {}", sky(&bright), sky(&dark));
    let added = |shares: &[Modulations]| mean(shares, |shares| shares.sun.add);
    assert!(added(&none) < 1e-3 && added(&dark) < 1e-3, "{} {}", added(&none), added(&dark));
    // A sun at 60 degrees on half-bright ground: up to 2 x 0.5 x 0.87 from below.
    assert!((0.1..0.87).contains(&added(&bright)), "{}", added(&bright));
}

/// Plants in rows, more of them than have volumes of their own.
fn rows() -> Stand {
    let many = (0..40u32).map(|i| {
        let [x, z] = [i % 7, i / 7].map(|c| 2.3 * f64::from(c));
        at([x, 0.0, z], 9.7 * f64::from(i))
    });
    stand(ball(), many.collect())
}

/// Linear between turns of 11 degrees: 0.3 % rms and 2.3 % at most were found on an oak.
const BETWEEN_TURNS: f32 = 0.03;
/// Largest change of a share over a hundredth of a site.
const STEP_IN_SPACE: f32 = 0.02;
/// Root mean square change of shares while the sun moves by half a degree: 1.5 % was found, in the shade of rows whose
/// gaps pass by.
const STEP_OF_SUN: f32 = 0.03;

#[test]
fn shares_change_little_from_turn_to_turn_from_place_to_place_and_from_sun_to_sun() {
    let rows = rows();
    let light = SceneLight::load(&rows.library(32, &SUNS)).expect("scene light");
    let (prepared, placed) = (light.prepare(rows.names()), &rows.instances);
    assert!(placed.len() > TURNS);
    let shade = prepared.at_sun(Some(sun(EAST)), placed).expect("a sun");
    for instance in [0u32, 3, 11, 25, 39] {
        let own = [placed[instance as usize]];
        let exact = prepared.at_sun(Some(sun(EAST)), &own).expect("a sun");
        for (_, point) in points(&rows, instance) {
            let (found, expected) = (shade.at(instance, point), exact.at(0, point));
            let off = (found.sun.scale - expected.sun.scale).abs();
            assert!(off < BETWEEN_TURNS && found.sky == expected.sky, "{instance}: {off}");
        }
    }

    let site_m = rows.kinds[0].turbid.grid.spacing_m as f32;
    for [dx, dy, dz] in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.6, 0.0, 0.8]] {
        let along = |step: i32| {
            let way = site_m * 0.01 * step as f32;
            shade.at(17, [way * dx, 1.0 + way * dy, way * dz])
        };
        for step in -600..600 {
            let (here, there) = (along(step), along(step + 1));
            let change =
                (here.sun.scale - there.sun.scale).abs().max((here.sky.scale - there.sky.scale).abs());
            assert!(change < STEP_IN_SPACE, "{step}: {here:?} {there:?}");
        }
    }

    let under = |step: u32| -> Vec<Modulations> {
        let moved = sun([EAST[0] + 0.4 * f64::from(step), EAST[1] + 0.3 * f64::from(step)]);
        let shade = prepared.at_sun(Some(moved), placed).expect("a sun");
        let all = (0..40).flat_map(|instance| points(&rows, instance).into_iter().step_by(7));
        all.map(|(instance, point)| shade.at(instance, point)).collect()
    };
    let mut before = under(0);
    for step in 1..8 {
        let now = under(step);
        let square = |(a, b): (&Modulations, &Modulations)| {
            let change = a.sun.scale - b.sun.scale;
            change * change
        };
        let change = (before.iter().zip(&now).map(square).sum::<f32>() / now.len() as f32).sqrt();
        assert!(change > 0.0 && change < STEP_OF_SUN, "{step}: {change}");
        before = now;
    }
}

/// Linear between directions of up to 14 degrees.
const BETWEEN_DIRECTIONS: f32 = 0.04;

#[test]
fn plants_that_share_volumes_have_nearly_the_light_of_their_own() {
    // One in fifteen of another kind, one in four upright, the others tilted by 5 to 25 degrees to all sides.
    let count = 156u32;
    let many = (0..count).map(|i| {
        let [x, z] = [i % 13, i / 13].map(|c| 2.6 * f64::from(c));
        let upright = at([x, 0.0, z], 9.7 * f64::from(i));
        let (sin, cos) = libm::sincos((5.0 + f64::from(i * 7 % 20)).to_radians());
        let [a, b, c] = upright.transform.rotation;
        let along = |p: [f64; 3], q: [f64; 3], s: f64| std::array::from_fn(|i| p[i] * cos + q[i] * s);
        let rotation =
            if i % 4 == 0 { upright.transform.rotation } else { [along(a, b, -sin), along(b, a, sin), c] };
        Placement {
            species: usize::from(i % 15 == 7),
            transform: Transform { rotation, ..upright.transform },
        }
    });
    let kinds = vec![ball(), Kind::ball("thin", 16, 1.0, 0.5)];
    let stand = Stand { kinds, instances: many.collect(), ground: None };
    let light = SceneLight::load(&stand.library(64, &SUNS)).expect("scene light");
    let (prepared, placed) = (light.prepare(stand.names()), &stand.instances);
    let tilted = |one: &&Placement| one.species == 0 && one.transform.rotation[1][1] < 1.0;
    assert!(placed.iter().filter(tilted).count() > TILTS);
    let shade = prepared.at_sun(Some(sun(EAST)), placed).expect("a sun");
    let volumes = shade.flat().volumes.len();
    let (mut square, mut left, mut found) = (0.0, 0.0, 0);
    for instance in (0..count).step_by(11) {
        let own = [placed[instance as usize]];
        let exact = prepared.at_sun(Some(sun(EAST)), &own).expect("a sun");
        for (_, point) in points(&stand, instance).into_iter().step_by(5) {
            let (shared, own) = (shade.at(instance, point), exact.at(0, point));
            let off = (shared.sun.scale - own.sun.scale).abs();
            assert!(off < BETWEEN_DIRECTIONS && shared.sky == own.sky, "{instance}: {off}");
            (square, left, found) = (square + f64::from(off * off), left + own.sun.scale, found + 1);
        }
    }
    let (rms, left) = ((square / f64::from(found)).sqrt(), left / found as f32);
    eprintln!("{volumes} volumes, {:.2} % rms of {:.0} % that are left", 100.0 * rms, 100.0 * left);
    assert!(rms > 0.0 && left < 0.8);
}

#[test]
fn a_plant_behind_a_row_is_as_dark_as_monte_carlo_says() {
    // Three between it and the sun, 0.6 of their width apart.
    let kind = ball();
    let places = [(0, 0, [0.0, 0.0]), (0, 0, [2.0, -1.2]), (0, 1, [2.0, 0.0]), (0, 2, [2.0, 1.2])];
    let stand = Stand::in_step(vec![kind], &places);
    let (merged, places) = stand.merged(32);
    let towards = sun(EAST);
    let settings = Settings { photons: 1 << 19, ..Settings::default() };
    let of_sun = Illumination::Sun(towards);
    let traced =
        trace(&merged, &scatter(&stand.kinds[0].surfaces), of_sun, &settings, &|_| Ok(())).expect("light");
    let mut truth = vec![[0.0; 2]; merged.grid.sites()];
    for (site, light) in merged.sites().into_iter().zip(&traced.scattered) {
        truth[site as usize][0] = *light as f32;
    }
    let pairs = pairs(&stand, (&places, &truth), (&stand.library(32, &SUNS), SceneFactor::Alone), towards);
    let behind: Vec<Pair> = pairs.into_iter().filter(|pair| pair.instance == 0).collect();
    let bias = |of: fn(&Pair) -> SunAndSky| error(&behind, |pair| pair.truth[0], |pair| of(pair)[0])[1];
    let (without, with) = (bias(|pair| pair.own), bias(|pair| pair.whole));
    assert!(without > 0.4 && with.abs() < 0.12, "without {without}, with {with}");
}

/// Each nearer to the next than their crowns are wide.
fn three_oaks(oak: Kind) -> Stand {
    let [low, high] = oak.extent_m();
    let d = 0.7 * (high[0] - low[0]);
    Stand::in_step(vec![oak], &[(0, 0, [0.0, 0.0]), (0, 1, [d, 0.0]), (0, 3, [0.5 * d, 0.87 * d])])
}

/// Of the mean light of the model `paper`: compared with each plant alone, and the bound that the papers' factor and no
/// factor at all are above. 3.5 and 2.2 % were found under the two suns, 22 and 25 by the papers' factor, 22 and 10
/// without any.
const PAPER_STAND: [f64; 2] = [0.06, 0.08];

#[test]
fn three_oaks_of_the_papers_model_are_near_one_lattice_over_all_of_them_but_not_by_the_papers_factor() {
    let stand = three_oaks(Kind::grown_of_paper(PlantKind::Oak, 6_000, 32));
    let (merged, places) = stand.merged(64);
    let library = stand.paper_library(32);
    for sun_deg in [EAST, [200.0, 60.0]] {
        let truth = stand.kinds[0].light_at_sites(&merged, sun(sun_deg));
        let by = |factor, of: fn(&Pair) -> SunAndSky| {
            let pairs = pairs(&stand, (&places, &truth), (&library, factor), sun(sun_deg));
            error(&pairs, |pair| day(pair.truth), |pair| day(of(pair)))[0]
        };
        let without = by(SceneFactor::Alone, |pair| pair.own);
        let [alone, empty] =
            [SceneFactor::Alone, SceneFactor::Empty].map(|factor| by(factor, |pair| pair.whole));
        let [near, far] = PAPER_STAND;
        let found = format!("{sun_deg:?}: without {without}, empty {empty}, alone {alone}");
        assert!(alone < near && without > far && empty > far, "{found}");
    }
}

/// Of the mean indirect light; without scene light 37 and 26 % of it are missed, with it 7 and 7 were found.
const STAND: f64 = 0.10;
const WITHOUT: f64 = 0.20;

#[test]
fn three_oaks_with_scene_light_are_near_one_fine_lattice_over_all_of_them() {
    let stand = three_oaks(Kind::grown(PlantKind::Oak, 6_000, 32));
    let (merged, places) = stand.merged(64);
    let library = stand.library(32, &SUNS);
    for sun_deg in [EAST, [200.0, 60.0]] {
        let truth = light_at_sites(&merged, &stand.kinds[0].surfaces, sun(sun_deg));
        let pairs = pairs(&stand, (&places, &truth), (&library, SceneFactor::Alone), sun(sun_deg));
        let rms = |of: fn(&Pair) -> SunAndSky| error(&pairs, |pair| day(pair.truth), |pair| day(of(pair)))[0];
        let (without, with) = (rms(|pair| pair.own), rms(|pair| pair.whole));
        assert!(without > WITHOUT && with < STAND, "{sun_deg:?}: without {without}, with {with}");
    }
}

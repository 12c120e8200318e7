use flb_format::{Placement, Transform};
use proptest::prelude::*;

use super::*;
use flb_format::sun::{blend, towards_sun};
use flb_scene::scene::{AddedSun, Camera, HighlightChoice, SceneSky, SceneSpecies, SunPath, Sunlight};

fn path(text: &str) -> SunPath {
    text.parse().expect("a path")
}

fn scene(suns: Suns, instances: Vec<Placement>) -> Scene {
    let upright = instances.is_empty();
    let oak = SceneSpecies { name: "oak".to_owned(), upright, ..SceneSpecies::default() };
    Scene {
        bands: None,
        light: None,
        ambient: None,
        sky: SceneSky::Even,
        backdrop: None,
        suns,
        sunlight: Sunlight::default(),
        highlight: HighlightChoice::default(),
        camera: None,
        ground: None,
        water: None,
        species: vec![oak],
        instances,
    }
}

fn turned(rotation: Rotation) -> Placement {
    Placement { species: 0, transform: Transform { rotation, position_m: [0.0; 3], scale: 1.0 } }
}

fn yaw(degrees: f64) -> Rotation {
    let [sin, _, minus_cos] = towards_sun(degrees, 0.0);
    [[-minus_cos, 0.0, -sin], [0.0, 1.0, 0.0], [sin, 0.0, -minus_cos]]
}

/// About the axis +X.
fn tilt(degrees: f64) -> Rotation {
    let (sin, cos) = libm::sincos(degrees.to_radians());
    [[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]]
}

fn bases(suns: Suns, instances: Vec<Placement>) -> BaseSet {
    plan(&scene(suns, instances), &[None]).species[0].bases
}

fn set(bases: &[u8]) -> BaseSet {
    bases.iter().copied().collect()
}

#[test]
fn noon_at_a_solstice_stands_where_every_almanac_has_it() {
    let highest = |text: &str| match sun_set(&Suns::Path(path(text))).zones[0].elevations_deg() {
        Some([_, highest]) => highest,
        None => panic!("the sun rises"),
    };
    for latitude in [0.0, 23.0, 40.7, 52.5, 66.0, -33.9] {
        let summer = highest(&format!("{latitude},0,2026-06-21"));
        let winter = highest(&format!("{latitude},0,2026-12-21"));
        assert!((summer - (90.0 - (latitude - 23.44f64).abs())).abs() < 0.1, "{latitude}: {summer}");
        assert!((winter - (90.0 - (latitude + 23.44f64).abs())).abs() < 0.1, "{latitude}: {winter}");
    }
}

#[test]
fn a_winter_in_the_north_spares_the_base_straight_down_and_a_polar_night_all_but_the_sky() {
    let upright = |text: &str| bases(Suns::Path(path(text)), vec![]);
    assert_eq!(upright("52.5,13.4,2026-06-01..2026-08-31").missing(), set(&[3, 7, 10, 15, 17]));
    assert_eq!(upright("52.5,13.4,2026-11-01..2027-01-31").missing(), set(&[3, 4, 7, 10, 15, 17]));
    let night = plan(&scene(Suns::Path(path("78.2,15.6,2026-12-01..2026-12-31")), vec![]), &[None]);
    assert_eq!((night.species[0].bases, night.has_sun), (set(&[0]), false));
    assert!(
        night.reason.starts_with("no sun rises at latitude 78.2, 2026-12-01 to 2026-12-31"),
        "{}",
        night.reason
    );
    let midnight = sun_set(&Suns::Path(path("78.2,15.6,2026-06-21"))).zones[0].elevations_deg();
    assert!(midnight.is_some_and(|[lowest, _]| (lowest - 11.6).abs() < 0.1), "{midnight:?}");
}

#[test]
fn instances_need_what_their_own_turn_asks_for() {
    let sun = Suns::Fixed(vec![[123.0, 31.0]]);
    let one = bases(sun.clone(), vec![turned(yaw(0.0))]);
    assert_eq!(one.len(), 4);
    // A quarter turn of the plant is a quarter turn of the sun the other way.
    let quarter = bases(sun.clone(), vec![turned(yaw(90.0))]);
    assert_eq!(quarter, bases(Suns::Fixed(vec![[33.0, 31.0]]), vec![turned(yaw(0.0))]));
    let both = bases(sun.clone(), vec![turned(yaw(0.0)), turned(yaw(90.0)), turned(yaw(0.0))]);
    assert_eq!(both, one.union(quarter));
    // Upside down, the light travels upwards.
    let upside_down = bases(sun, vec![turned(tilt(180.0))]);
    assert!(!upside_down.intersection(set(&[3, 7, 10, 15, 17])).is_empty(), "{upside_down:?}");
}

#[test]
fn without_ambient_light_base_0_is_left_out() {
    let dark = Scene { ambient: Some(0.0), ..scene(Suns::Sky, vec![]) };
    let found = plan(&dark, &[None]);
    assert!(!found.species[0].bases.contains(0) && found.species[0].bases.len() == 13);
    assert!(found.reason.ends_with(", no ambient light"), "{}", found.reason);
}

#[test]
fn a_further_sun_needs_its_bases_too() {
    let low = || scene(Suns::Fixed(vec![[90.0, 10.0]]), vec![turned(yaw(0.0))]);
    let added = |sun_deg| {
        let mut scene = low();
        scene.sunlight.added.push(AddedSun { sun_deg, irradiance: [1.0; 3] });
        plan(&scene, &[None])
    };
    let [alone, more] = [plan(&low(), &[None]), added([270.0, 10.0])];
    let other = plan(&scene(Suns::Fixed(vec![[270.0, 10.0]]), vec![turned(yaw(0.0))]), &[None]);
    assert_ne!(more.species[0].bases, alone.species[0].bases);
    assert_eq!(more.species[0].bases, alone.species[0].bases.union(other.species[0].bases));
    assert!(more.reason.starts_with("the sun at 90,10 and 1 more, plants"), "{}", more.reason);
}

#[test]
fn under_an_uneven_sky_plants_need_the_suns_of_all_sides() {
    let noon = || Suns::Fixed(vec![[180.0, 60.0]]);
    let even = scene(noon(), vec![turned(yaw(0.0))]);
    let clear = Scene { sky: SceneSky::Clear { turbidity: 3.0 }, ..even.clone() };
    let dark = Scene { ambient: Some(0.0), ..clear.clone() };
    let [even, clear, dark] = [even, clear, dark].map(|scene| plan(&scene, &[None]));
    assert!(even.species[0].bases.len() < 10 && dark.species[0].bases.len() < 10);
    assert_eq!(clear.species[0].bases, BaseSet::ALL);
    assert!(clear.reason.ends_with(", an uneven sky"), "{}", clear.reason);
}

#[test]
fn a_forest_of_100_000_turned_and_tilted_plants_needs_what_a_few_of_them_need() {
    let narrow = Suns::Path(path("52.5,13.4,2026-06-01..2026-08-31"));
    // A hair of yaw apart, so that no two are equal and the set never saturates.
    let upright = (0..50_000).map(|i| turned(yaw(10.0 + f64::from(i) * 1e-5)));
    let tilted = (0..50_000).map(|i| turned(tilt(3.0 + f64::from(i) * 1e-5)));
    let many = bases(narrow.clone(), upright.chain(tilted).collect());
    let few = [turned(yaw(10.0)), turned(yaw(10.5)), turned(tilt(3.0)), turned(tilt(3.5))];
    assert_eq!(many, bases(narrow, few.to_vec()));
    assert!(many.len() < 19);
}

#[test]
fn a_camera_and_bounds_give_each_species_its_lattice() {
    let path_m = vec![[0.0, 0.5, 1.5]];
    let camera = Camera { path_m, look_at_m: None, fov_deg: 90.0, height_px: 1024, pixels_per_site: 4.0 };
    let seen = Scene { camera: Some(camera), ..scene(Suns::Sky, vec![turned(yaw(0.0))]) };
    let bounds = Bounds { min: [-0.5, 0.0, -0.5], max: [0.5, 1.0, 0.5] };
    assert_eq!(plan(&seen, &[Some(bounds)]).species[0].on_screen.map(|s| s.lattice), Some(128));
    assert_eq!(plan(&seen, &[None]).species[0].on_screen, None);
}

fn any_path() -> impl Strategy<Value = SunPath> {
    (-90.0f64..=90.0, -180.0f64..=180.0, 1901u16..2099, 1u8..=12, 1u8..=28, 0u16..2, 0u8..=12).prop_map(
        |(latitude, longitude, year, month, day, years, months)| {
            let later = u16::from(month) - 1 + u16::from(months);
            let (to_year, to_month) = (year + years + later / 12, later % 12 + 1);
            path(&format!(
                "{latitude},{longitude},{year:04}-{month:02}-{day:02}..{:04}-{to_month:02}-{day:02}",
                to_year.min(2100)
            ))
        },
    )
}

proptest! {
    #[test]
    fn no_sun_of_a_path_needs_a_base_that_its_plan_leaves_out(
        path in any_path(), instants in prop::collection::vec(0.0f64..1.0, 64), degrees in -180.0f64..180.0,
        tilted in any::<bool>(),
    ) {
        let rotation = if tilted { tilt(degrees) } else { yaw(degrees) };
        let kept = bases(Suns::Path(path), vec![turned(rotation)]);
        let any_yaw = bases(Suns::Path(path), vec![]);
        let (from, to) = (path.from.since_2000() as f64, path.to.since_2000() as f64 + 1.0);
        for share in instants {
            let [azimuth, elevation] =
                flb_testkit::psa::psa(from + share * (to - from), path.latitude_deg, path.longitude_deg);
            // The oracle is off by a few hundredths of a degree far from 2000: a sun on the very horizon may not rise
            // for us.
            if elevation < 0.05 {
                continue;
            }
            let sun = towards_sun(azimuth, elevation);
            let in_model = std::array::from_fn(|c| (0..3).map(|r| rotation[r][c] * sun[r]).sum());
            let blend = blend(in_model).expect("a direction");
            for (base, weight) in blend.bases.into_iter().zip(blend.weights) {
                // A weight of 0.002 is what 0.05 degrees make.
                prop_assert!(weight < 0.002 || kept.contains(base), "base {base} weighs {weight}, kept {kept:?}");
                prop_assert!(tilted || weight < 0.002 || any_yaw.contains(base), "base {base}, any yaw {any_yaw:?}");
            }
        }
    }
}

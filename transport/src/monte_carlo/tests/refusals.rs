//! Every input that is refused, and what is said.

use super::*;

const SUN: Illumination = Illumination::Sun([0.0, 1.0, 0.0]);

fn refuse(
    change: impl FnOnce(&mut TurbidMedium, &mut BandScatter, &mut Illumination, &mut Settings),
    says: &str,
) {
    let (mut medium, mut scatter) = (ball(1.0), alike(0.5, Phase::ISOTROPIC));
    let (mut light, mut settings) = (SUN, photons(64));
    change(&mut medium, &mut scatter, &mut light, &mut settings);
    let error = trace(&medium, &scatter, light, &settings, &quiet).map(|_| "light").expect_err(says);
    assert_eq!(error.to_string(), says);
}

#[test]
fn media_without_sense_are_refused() {
    refuse(|m, _, _, _| m.grid.lattice = 0, "lattice of 0 sites per edge: expected 1 to 256");
    refuse(|m, _, _, _| m.grid.lattice = u32::MAX, "lattice of 4294967295 sites per edge: expected 1 to 256");
    refuse(|m, _, _, _| m.grid.spacing_m = 0.0, "spacing of 0 m: expected a finite number above 0");
    refuse(|m, _, _, _| m.grid.spacing_m = f64::NAN, "spacing of NaN m: expected a finite number above 0");
    refuse(
        |m, _, _, _| m.leaf_per_m.truncate(7),
        "medium's leaf_per_m: found 7 values, expected 4096 for a lattice of 16",
    );
    refuse(
        |m, _, _, _| m.wood_per_m.push(0.0),
        "medium's wood_per_m: found 4097 values, expected 4096 for a lattice of 16",
    );
    refuse(
        |m, _, _, _| m.leaf_per_m[0x123] = f32::NAN,
        "site [3, 2, 1]: leaf_per_m is NaN, expected a finite number from 0",
    );
    refuse(
        |m, _, _, _| m.wood_per_m[1] = -0.5,
        "site [1, 0, 0]: wood_per_m is -0.5, expected a finite number from 0",
    );
    refuse(
        |m, _, _, _| m.wood_per_m[16] = f32::INFINITY,
        "site [0, 1, 0]: wood_per_m is inf, expected a finite number from 0",
    );
    refuse(
        |m, _, _, _| m.leaf_per_m.fill(0.0),
        "medium of 4096 sites: found none that holds matter, expected at least one",
    );
}

#[test]
fn optics_without_sense_are_refused() {
    refuse(|_, s, _, _| s.leaf.albedo = 1.5, "leaf: albedo 1.5, expected 0 to 1");
    refuse(|_, s, _, _| s.wood.albedo = f64::NAN, "wood: albedo NaN, expected 0 to 1");
    refuse(
        |_, s, _, _| s.wood.phase = Phase::HenyeyGreenstein { g: -1.0 },
        "wood: g = -1, expected more than -1 and less than 1",
    );
    refuse(
        |_, s, _, _| s.leaf.phase = Phase::BiLambert { transmitted: -0.1 },
        "leaf: transmitted = -0.1, expected 0 to 1",
    );
}

#[test]
fn light_and_settings_without_sense_are_refused() {
    refuse(
        |_, _, light, _| *light = Illumination::Sun([0.0; 3]),
        "direction towards the sun [0.0, 0.0, 0.0]: its length is 0, expected a unit vector",
    );
    refuse(
        |_, _, light, _| *light = Illumination::Sun([0.0, f64::NAN, 0.0]),
        "direction towards the sun [0.0, NaN, 0.0]: its length is NaN, expected a unit vector",
    );
    refuse(|_, _, _, settings| settings.photons = 0, "photons is 0: expected at least 1");
    refuse(
        |_, _, _, settings| settings.rays_per_site_edge = 0,
        "0 rays per edge of a site: expected 1 to 1024",
    );
    assert!(uncollided(&ball(1.0), [0.0, 1.0, 0.0], 0).is_err());
    assert!(uncollided(&ball(1.0), [0.0, 1.1, 0.0], 1).is_err());
    assert!(uncollided_sky(&ball(1.0), 5000).is_err());
}

#[test]
fn light_that_finds_no_way_out_is_given_up() {
    refuse(
        |m, s, _, settings| {
            m.leaf_per_m.iter_mut().for_each(|leaf| *leaf *= 1e9);
            s.leaf.albedo = 1.0;
            settings.photons = 4096;
        },
        "a photon was scattered 1000000 times and still flies: the medium is too dense to trace at this albedo (the densest site has an optical depth of 1.000e8 along its edge)",
    );
}

#[test]
fn fields_that_do_not_match_are_not_compared() {
    let a = trace(&ball(1.0), &alike(0.5, Phase::ISOTROPIC), SUN, &photons(64), &quiet).unwrap();
    let b =
        trace(&ball(1.0), &alike(0.5, Phase::ISOTROPIC), SUN, &Settings { seed: 1, ..photons(64) }, &quiet)
            .unwrap();
    let n = a.scattered.len();
    let refuse = |field: &[f64], b: &Fluence, says: String| {
        assert_eq!(compare(field, [&a, b], ComparedLight::Total).unwrap_err().to_string(), says);
    };
    refuse(&a.scattered[1..], &b, format!("field: found {} sites, expected {n}", n - 1));
    let mut short = b.clone();
    short.scattered.pop();
    refuse(&a.scattered, &short, format!("second estimate: found {} sites, expected {n}", n - 1));
    let mut broken = a.scattered.clone();
    broken[3] = f64::INFINITY;
    let says = "field, site 3 of the non-empty ones: found inf, expected a finite number";
    refuse(&broken, &b, says.to_owned());
    let black = trace(&ball(1.0), &alike(0.0, Phase::ISOTROPIC), SUN, &photons(64), &quiet).unwrap();
    let error = compare(&black.scattered, [&black, &black], ComparedLight::Scattered).unwrap_err();
    assert_eq!(error.to_string(), "the reference has a mean of 0 over its sites: expected more than 0");
}

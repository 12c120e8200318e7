use std::f32::consts::{FRAC_1_PI, FRAC_1_SQRT_2, PI};

use crate::tests::{Setup, assert_close, at, dark, glossy, material, plain, reference, render, wall};
use crate::*;
use flb_scene::MaterialClass;

const LEAF: Surfaces = Surfaces {
    leaf_reflectance: [0.07, 0.125, 0.04],
    leaf_transmittance: [0.055, 0.15, 0.02],
    wood_reflectance: [0.3, 0.2, 0.1],
    solid_offset_m: None,
};

fn physical() -> Setup {
    Setup { samples: 2, shading: Shading::Physical(LEAF), ..plain() }
}

/// Radiance of the wall's middle, which the shading and the path tracer must agree on to the last bit.
fn direct(class: MaterialClass, settings: &Setup) -> [f32; 3] {
    let mesh = wall(material("wall", [0.8, 0.5, 0.2]), vec![], 1.0);
    let shaded = render(&mesh, &[class], &dark, settings).unwrap();
    let traced = reference(&mesh, &[class], settings).unwrap();
    assert_eq!(shaded, traced.picture);
    at(&shaded, 16, 16)
}

#[test]
fn a_leaf_sends_back_r_and_lets_t_through_by_the_cosine_over_pi() {
    let sun = |sun: [f64; 3]| Setup { sun, sun_strength: 2.0, ..physical() };
    let expected = |shares: [f32; 3], cosine: f32| shares.map(|share| share * FRAC_1_PI * 2.0 * cosine);
    let [r, t] = [LEAF.leaf_reflectance, LEAF.leaf_transmittance];
    assert_close(direct(MaterialClass::Leaf, &sun([0.0, 0.0, 3.0])), expected(r, 1.0));
    assert_close(direct(MaterialClass::Leaf, &sun([0.0, 0.0, -1.0])), expected(t, 1.0));
    assert_close(direct(MaterialClass::Leaf, &sun([1.0, 0.0, 1.0])), expected(r, FRAC_1_SQRT_2));
    assert_close(direct(MaterialClass::Leaf, &sun([0.0, -2.0, -2.0])), expected(t, FRAC_1_SQRT_2));
}

#[test]
fn wood_sends_back_and_lets_nothing_through() {
    let sun = |z: f64| Setup { sun: [0.0, 0.0, z], ..physical() };
    let expected = LEAF.wood_reflectance.map(|share| share * FRAC_1_PI);
    assert_close(direct(MaterialClass::Wood, &sun(1.0)), expected);
    assert_eq!(direct(MaterialClass::Wood, &sun(-1.0)), [0.0; 3]);
}

#[test]
fn fluence_comes_out_of_either_side_of_a_leaf_and_of_the_outside_of_wood() {
    let mesh = wall(material("wall", [0.8, 0.5, 0.2]), vec![], 1.0);
    let phi = [1.0, 2.0, 0.5];
    let light = |_: [f32; 3], out: &mut [f32; 3]| *out = phi;
    for view_azimuth_deg in [0.0, 180.0] {
        let settings = Setup { indirect: Indirect::Only, view_azimuth_deg, ..physical() };
        let seen = |class: MaterialClass| at(&render(&mesh, &[class], &light, &settings).unwrap(), 16, 16);
        let leaf = |band: usize| LEAF.leaf_reflectance[band] + LEAF.leaf_transmittance[band];
        assert_close(seen(MaterialClass::Leaf), [0, 1, 2].map(|band| leaf(band) * phi[band] / (4.0 * PI)));
        let wood = [0, 1, 2].map(|band| LEAF.wood_reflectance[band] * phi[band] / (2.0 * PI));
        assert_close(seen(MaterialClass::Wood), wood);
    }
}

#[test]
fn a_solid_takes_a_quarter_of_the_fluence_in_front_of_the_side_that_is_seen() {
    let mesh = wall(material("wall", [0.8, 0.5, 0.2]), vec![], 1.0);
    let surfaces = Surfaces { solid_offset_m: Some(0.25), ..LEAF };
    // The wall lies at z = 0: light that tells where it was asked for.
    let light = |[_, _, z]: [f32; 3], out: &mut [f32; 3]| *out = [1.0 + z; 3];
    for (view_azimuth_deg, side) in [(0.0, -1.0), (180.0, 1.0)] {
        let shading = Shading::Physical(surfaces);
        let settings = Setup { indirect: Indirect::Only, view_azimuth_deg, shading, ..physical() };
        let seen = |class: MaterialClass| at(&render(&mesh, &[class], &light, &settings).unwrap(), 16, 16);
        let wood = LEAF.wood_reflectance.map(|share| share * (1.0 + 0.25 * side) / (4.0 * PI));
        assert_close(seen(MaterialClass::Wood), wood);
        let leaf = |band: usize| LEAF.leaf_reflectance[band] + LEAF.leaf_transmittance[band];
        assert_close(seen(MaterialClass::Leaf), [0, 1, 2].map(|band| leaf(band) / (4.0 * PI)));
    }
}

#[test]
fn scale_and_highlight_belong_to_the_paper() {
    let mesh = wall(material("wall", [0.8, 0.5, 0.2]), vec![], 1.0);
    let light = |_: [f32; 3], out: &mut [f32; 3]| *out = [1.0; 3];
    let picture = |indirect_scale: f32, strength: f32| {
        let highlights = glossy(strength);
        let settings = Setup { indirect: Indirect::On, indirect_scale, highlights, ..physical() };
        render(&mesh, &[MaterialClass::Leaf], &light, &settings).unwrap()
    };
    assert_eq!(picture(0.5, 0.0), picture(2.0, 1.0));
}

#[test]
fn the_ground_is_matt_and_lies_in_the_sun_and_under_the_sky() {
    // Seen from above, beside a wall that stands on edge and casts its shadow to the west.
    let mesh = wall(material("wall", [0.5; 3]), vec![], 1.0);
    let settings =
        Setup { sun: [3.0, 4.0, 0.0], ambient: 0.4, ground: true, view_elevation_deg: 80.0, ..physical() };
    let picture = |indirect: Indirect| {
        let settings = Setup { indirect, ..settings.clone() };
        let shaded = render(&mesh, &[MaterialClass::Wood], &dark, &settings).unwrap();
        at(&shaded, 16, 26)
    };
    // The disc fades towards its rim, so both parts are compared with each other, not with the full colour.
    let [sun, sky] = [picture(Indirect::Off), picture(Indirect::Only)];
    for band in 0..3 {
        let expected = (0.8 * FRAC_1_PI) / (0.4 / (4.0 * PI));
        assert!((sun[band] / sky[band] / expected - 1.0).abs() < 1e-5, "{sun:?} {sky:?}");
    }
    let full = [0.23, 0.22, 0.15].map(|share| share * 0.4 / (4.0 * PI));
    for band in 0..3 {
        assert!(sky[band] > 0.5 * full[band] && sky[band] <= full[band], "{sky:?}, at most {full:?}");
    }
}

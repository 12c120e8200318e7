//! Skies that are not even, and suns that are not white.

use flb_format::{Placement, Transform};
use flb_scene::sky::Sky;

use super::water::{grown_stand, phi, shore};
use super::*;
use crate::tests::sky_image;

fn lit(forest: &Forest, daylight: &Setup) -> Picture {
    let fragments = forest.trace(&shore(), &|_| Ok(())).unwrap();
    forest.relight(&fragments, &daylight.lighting(), &daylight.look(), &phi, &|_| Ok(())).unwrap()
}

fn ground() -> Option<Ground> {
    Some(Ground { land: Land::Plane { height_m: 0.0 }, color: [0.5, 0.4, 0.3], fades_at_m: None })
}

#[test]
fn a_white_image_lights_ground_and_water_as_an_even_sky_of_its_fluence() {
    let meshes = [grown(PlantKind::Shrub, 2000)];
    let dome = sky_image(|_, _| (3.0, 3.0, 3.0)).times(0.4);
    let even = Setup { sun: [0.6, 0.5, 0.5], ambient: 0.4, sky: false, ..Setup::default() };
    let under_image = Setup { dome: Some(dome), ambient: 7.0, ..even.clone() };
    let water = Water { height_m: 0.2, color: [0.3; 3], waves: None };
    for forest in [grown_stand(&meshes, ground()), grown_stand(&meshes, ground()).with_water(water).unwrap()]
    {
        let (expected, found) = (lit(&forest, &even), lit(&forest, &under_image));
        for (expected, found) in expected.rgb.iter().zip(&found.rgb) {
            assert!((expected - found).abs() < 0.01 * expected + 1e-6, "{found} for {expected}");
        }
        assert!(expected.rgb.iter().filter(|band| **band > 0.0).count() > expected.rgb.len() / 2);
    }
}

#[test]
fn a_sun_s_colour_falls_on_leaves_and_on_ground() {
    let meshes = [grown(PlantKind::Shrub, 2000)];
    let forest = grown_stand(&meshes, ground());
    let white = Setup { sun: [0.6, 0.5, 0.5], sky: false, indirect: Indirect::Off, ..Setup::default() };
    let color = [2.0, 1.0, 0.25];
    let (white, red) = (lit(&forest, &white), lit(&forest, &Setup { sun_color: color, ..white.clone() }));
    for (band, (white, red)) in white.rgb.iter().zip(&red.rgb).enumerate() {
        assert!((white * color[band % 3] - red).abs() < 1e-6, "band {band}: {red} of {white}");
    }
}

#[test]
fn the_camera_sees_the_sky_of_the_world() {
    let meshes = [grown(PlantKind::Shrub, 2000)];
    // North is in the middle of an image, and the camera looks there.
    let dome =
        sky_image(|column, _| if column.abs_diff(32) < 16 { (1.0, 0.5, 0.25) } else { (0.1, 0.1, 0.1) });
    let forest = grown_stand(&meshes, None);
    let daylight = Setup { dome: Some(dome.clone()), ..Setup::default() };
    let corner = pixel(&lit(&forest, &daylight), 2, 1);
    let expected = dome.seen([0.0, 0.2, -0.98]);
    assert_close(corner, expected);
    assert!(corner[0] > 3.0 * corner[2], "{corner:?}");
    let unseen = pixel(&lit(&forest, &Setup { sky: false, ..daylight }), 2, 1);
    assert_eq!(unseen, [0.0; 3]);
}

#[test]
fn light_is_asked_for_with_the_side_of_a_solid_that_is_seen() {
    let mesh = wall(material("bark", [1.0; 3]), vec![], 1.0);
    let surfaces = Surfaces {
        leaf_reflectance: [0.3; 3],
        leaf_transmittance: [0.2; 3],
        wood_reflectance: [0.4; 3],
        solid_offset_m: Some(0.25),
    };
    let seen = |class: MaterialClass, yaw_deg: f64| {
        let classes = [class];
        let species = Species { mesh: &mesh, classes: &classes, shading: Shading::Physical(surfaces) };
        let instance = Placement {
            species: 0,
            transform: Transform { rotation: yaw(yaw_deg), ..at_m([0.0; 3]).transform },
        };
        let forest = Forest::prepare(&[species], &[instance], None, Search::default()).unwrap();
        let fragments = forest.trace(&view([0.0; 3]), &|_| Ok(())).unwrap();
        let asked = std::sync::Mutex::new(None);
        let light = |one: LightQuery, _: &mut [f32; 3]| *asked.lock().unwrap() = Some(one);
        let daylight = Setup { indirect: Indirect::Only, ..plain() };
        forest.relight(&fragments, &daylight.lighting(), &daylight.look(), &light, &|_| Ok(())).unwrap();
        asked.into_inner().unwrap().expect("the wall is seen")
    };
    assert_eq!(seen(MaterialClass::Leaf, 0.0).facing, None);
    // From the north side of its model, once the wall has turned.
    for (turn, side) in [(0.0, 1.0), (180.0, -1.0)] {
        let LightQuery { point, facing, .. } = seen(MaterialClass::Wood, turn);
        let normal = facing.expect("a solid faces some way");
        assert!(
            (normal[2] - side).abs() < 1e-5 && (point[2] - 0.25 * side).abs() < 1e-5,
            "{point:?} {normal:?}"
        );
    }
}

#[test]
fn an_uneven_sky_over_paper_plants_and_a_sun_of_no_colour_are_refused() {
    let mesh = wall(material("wall", [0.5; 3]), vec![], 1.0);
    let stand = forest(&mesh, &[at_m([0.0; 3])], None);
    let fragments = stand.trace(&view([0.0; 3]), &|_| Ok(())).unwrap();
    let refusal = |daylight: Setup| {
        stand
            .relight(&fragments, &daylight.lighting(), &daylight.look(), &dark, &|_| Ok(()))
            .unwrap_err()
            .to_string()
    };
    let dome = Some(Sky::clear([0.0, 1.0, 0.0], 3.0).unwrap());
    assert!(refusal(Setup { dome, ..plain() }).contains("`dome` is a sky with the shading `paper`"));
    assert!(refusal(Setup { sun_color: [1.0, f32::NAN, 1.0], ..plain() }).contains("`sun_color` is NaN"));
}

#[test]
fn a_backdrop_is_drawn_and_mirrored_in_the_place_of_the_sky_that_lights_and_lights_nothing() {
    let mesh = wall(material("wall", [0.5; 3]), vec![], 1.0);
    let clouds = sky_image(|column, _| if column < 32 { (3.0, 1.0, 0.5) } else { (0.2, 0.4, 1.0) });
    let white = sky_image(|_, _| (5.0, 5.0, 5.0));
    let meshes = [grown(PlantKind::Shrub, 2000)];
    let water = Water { height_m: 0.2, color: [0.0; 3], waves: None };
    let dome = Some(Sky::clear([0.6, 0.5, 0.5], 3.0).unwrap());
    for (forest, daylight) in [
        (forest(&mesh, &[at_m([0.0; 3])], ground()), Setup { ambient: 0.02, ..plain() }),
        (grown_stand(&meshes, None).with_water(water).unwrap(), Setup { dome, ..plain() }),
        (grown_stand(&meshes, None), Setup { ambient: 0.3, ..plain() }),
    ] {
        let daylight = Setup { sky: true, ..daylight };
        let plants = lit(&forest, &Setup { sky: false, ..daylight.clone() });
        let drawn = |drawn: &Sky| lit(&forest, &Setup { drawn: Some(drawn.clone()), ..daylight.clone() });
        assert_eq!(
            plants,
            lit(&forest, &Setup { sky: false, drawn: Some(clouds.clone()), ..daylight.clone() })
        );
        let (with, twice) = (drawn(&clouds), drawn(&clouds.times(2.0)));
        let mut changed = 0;
        for ((with, twice), plants) in with.rgb.iter().zip(&twice.rgb).zip(&plants.rgb) {
            assert!((twice - plants - 2.0 * (with - plants)).abs() < 1e-4, "{with} {twice} {plants}");
            changed += usize::from(with - plants > 0.01);
        }
        assert!(changed > with.rgb.len() / 10, "{changed}");
        // White is as bright as the sky that it hides, in the mean over all sides.
        let top = |picture: &Picture| pixel(picture, 2, 1).iter().sum::<f32>();
        let (usual, white) = (top(&lit(&forest, &daylight)), top(&drawn(&white)));
        assert!(white > 0.4 * usual && white < 2.5 * usual, "{white} and {usual}");
    }
}

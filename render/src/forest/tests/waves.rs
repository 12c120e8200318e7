//! Waves: level water with slopes of 0, a mirror at each facet, and a glint that has all of the sun's light.

use flb_scene::waves::Waves;

use super::water::{afternoon, grown_stand, lit, phi, shore};
use super::*;
use crate::forest::placed::WorldRay;
use crate::forest::water::{WaterSurface, reflectance};

const BREEZE: Waves = Waves { wind_m_s: 4.0, from_deg: 250.0, fetch_m: 200.0, steepness: 1.0, seed: 3 };

fn wavy(waves: Option<Waves>) -> Water {
    Water { height_m: 0.2, color: [0.02, 0.05, 0.06], waves }
}

fn meshes() -> [Mesh; 2] {
    [grown(PlantKind::Oak, 2_000), grown(PlantKind::Shrub, 800)]
}

#[test]
fn waves_without_slopes_are_level_water_and_others_are_not() {
    let meshes = meshes();
    let paper = |water: Water| {
        let classes: &[MaterialClass] = &[MaterialClass::Wood, MaterialClass::Leaf];
        let species = [Species { mesh: &meshes[0], classes, shading: Shading::Paper }];
        let forest = Forest::prepare(&species, &[at_m([0.0; 3])], None, Search::default()).unwrap();
        lit(&forest.with_water(water).unwrap(), &shore(), &afternoon())
    };
    let level = paper(wavy(None));
    assert_eq!(level, paper(wavy(Some(Waves { steepness: 0.0, ..BREEZE }))));
    assert_ne!(level, paper(wavy(Some(BREEZE))));
    assert_ne!(paper(wavy(Some(BREEZE))), paper(wavy(Some(Waves { seed: 4, ..BREEZE }))));
}

#[test]
fn a_facet_mirrors_as_it_faces_and_nothing_goes_below_the_water() {
    let surface = WaterSurface::new(wavy(Some(Waves { wind_m_s: 12.0, ..BREEZE })));
    let level = WaterSurface::new(wavy(None));
    let (mut mirrored, mut others) = (0, 0);
    for step in 0..4000 {
        let [turn, rise] = crate::r2_sequence(5, step).map(f64::from);
        let looking = DVec3::new(libm::cos(6.3 * turn), -0.01 - rise, libm::sin(6.3 * turn)).normalize();
        let ray = WorldRay { origin: DVec3::new(13.0 * turn, 9.0, -7.0 * rise), direction: looking };
        let distance_m = surface.water.along(&ray).expect("it goes down");
        let facet = surface.facet(&ray, distance_m, 2.0);
        let back = facet.back.direction;
        assert!((facet.normal.length() - 1.0).abs() < 1e-12 && facet.normal.y > 0.5);
        assert!((back.length() - 1.0).abs() < 1e-9 && back.y >= 0.0, "{back}");
        assert_eq!(facet.back.origin, level.facet(&ray, distance_m, 2.0).back.origin);
        // What faces away, and what is mirrored downwards, is met by way of another wave.
        let across = looking + back - (looking + back).dot(facet.normal) * facet.normal;
        match (back - looking).normalize().dot(facet.normal) > 1.0 - 1e-9 {
            true => {
                assert!(across.dot(looking - looking.dot(facet.normal) * facet.normal) > -1e-9);
                assert_eq!(facet.share, reflectance(-looking.dot(facet.normal) as f32));
                mirrored += 1;
            }
            false => others += 1,
        }
    }
    assert!(mirrored > 3500 && others > 10, "{mirrored} {others}");
}

/// Light of a sun of irradiance 1 that glints from a square metre of water into the whole sky.
fn glinted(surface: &WaterSurface, towards_sun: DVec3) -> f64 {
    let points = 400_000;
    let mut sum = 0.0;
    for step in 0..points {
        let [turn, square] = crate::r2_sequence(11, step).map(f64::from);
        let [x, z] = crate::r2_sequence(29, step).map(f64::from);
        // Spread by the cosine, so that each direction counts as much.
        let (level, up) = (square.sqrt(), (1.0 - square).sqrt());
        let angle = std::f64::consts::TAU * turn;
        let looking = -DVec3::new(level * libm::cos(angle), up, level * libm::sin(angle));
        let ray = WorldRay { origin: DVec3::new(200.0 * x, 5.0, 200.0 * z), direction: looking };
        let facet = surface.facet(&ray, surface.water.along(&ray).unwrap(), 0.0);
        sum += f64::from(surface.glint(&facet, looking, towards_sun));
    }
    // The mean radiance, in that of white, over the sky; its irradiance is pi times as much, as white's is.
    sum / f64::from(points)
}

#[test]
fn a_glint_has_all_of_the_suns_light_that_water_mirrors() {
    for (wind_m_s, elevation_deg, tolerance) in [(3.0, 60.0, 0.05), (8.0, 60.0, 0.08), (3.0, 30.0, 0.1)] {
        let surface = WaterSurface::new(wavy(Some(Waves { wind_m_s, ..BREEZE })));
        let towards_sun = DVec3::from(flb_format::sun::towards_sun(200.0, elevation_deg));
        let expected = f64::from(reflectance(towards_sun.y as f32)) * towards_sun.y;
        let found = glinted(&surface, towards_sun);
        assert!(
            (found / expected - 1.0).abs() < tolerance,
            "{found} for {expected} at {elevation_deg}, {wind_m_s} m/s"
        );
    }
    let level = WaterSurface::new(wavy(None));
    assert_eq!(glinted(&level, DVec3::Y), 0.0);
}

#[test]
fn a_low_sun_glints_before_it_and_neither_behind_the_camera_nor_without_direct_light() {
    let meshes = meshes();
    let forest = grown_stand(&meshes, None).with_water(wavy(Some(BREEZE))).unwrap();
    // The camera looks to the north.
    let view = View { samples: 8, ..shore() };
    let picture =
        |sun: [f64; 3], indirect| lit(&forest, &view, &Setup { sun, indirect, ambient: 0.0, ..afternoon() });
    let sum = |picture: &Picture| picture.rgb.iter().map(|v| f64::from(*v)).sum::<f64>();
    let (before, behind) =
        (picture([0.0, 0.4, -1.0], Indirect::Off), picture([0.0, 0.4, 1.0], Indirect::Off));
    let lower = |picture: &Picture| picture.rgb[picture.rgb.len() / 2..].to_vec();
    let bright = |picture: &Picture| lower(picture).iter().filter(|v| **v > 0.05).count();
    assert!(bright(&before) > 3 * bright(&behind), "{} and {}", bright(&before), bright(&behind));
    assert!(sum(&before) > sum(&behind));
    let only = picture([0.0, 0.4, -1.0], Indirect::Only);
    assert_eq!(only, picture([0.0, 0.4, 1.0], Indirect::Only));
}

#[test]
fn waves_move_with_time_and_are_lit_again_as_if_traced_anew() {
    let meshes = meshes();
    let forest = grown_stand(&meshes, None).with_water(wavy(Some(BREEZE))).unwrap();
    let daylight = afternoon();
    let at = |time_s| View { samples: 2, sky_rays: 2, time_s, ..shore() };
    let [start, later] = [0.0, 0.3].map(|time_s| lit(&forest, &at(time_s), &daylight));
    assert_ne!(start, later);
    let kept = forest.trace(&at(0.3), &|_| Ok(())).unwrap();
    let relit = forest.relight(&kept, &daylight.lighting(), &daylight.look(), &phi, &|_| Ok(())).unwrap();
    assert_eq!(later, relit);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(later, one.install(|| lit(&forest, &at(0.3), &daylight)));
    let refused = forest.trace(&at(f64::NAN), &|_| Ok(())).err().expect("refused").to_string();
    assert!(refused.contains("`time_s` is NaN"), "{refused}");
}

#[test]
fn waves_out_of_range_are_refused() {
    let meshes = meshes();
    let refusal = |waves| {
        let forest = grown_stand(&meshes, None).with_water(wavy(Some(waves)));
        forest.err().expect("it is refused").to_string()
    };
    let message = refusal(Waves { wind_m_s: 50.0, ..BREEZE });
    assert!(message.contains("`water` is waves with wind_m_s 50, expected 0.5 to 30"), "{message}");
    let message = refusal(Waves { wind_m_s: 12.0, steepness: 4.0, ..BREEZE });
    assert!(message.contains("fold over"), "{message}");
}

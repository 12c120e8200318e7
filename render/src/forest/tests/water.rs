//! Water: what it mirrors, what it hides, and how bright it may be.

use flb_format::{Placement, Transform};

use super::*;
use crate::forest::water::{INTO_FROM_SKY, REFRACTIVE_INDEX, reflectance};

const NO_COLOR: [f32; 3] = [0.0; 3];

fn over<'a>(forest: Forest<'a>, height_m: f64, color: [f32; 3]) -> Forest<'a> {
    forest.with_water(Water { height_m, color, waves: None }).unwrap()
}

pub(super) fn grown_stand<'a>(meshes: &'a [Mesh], ground: Option<Ground>) -> Forest<'a> {
    let classes: &[MaterialClass] = &[MaterialClass::Wood, MaterialClass::Leaf];
    let surfaces = Surfaces {
        leaf_reflectance: [0.3; 3],
        leaf_transmittance: [0.2; 3],
        wood_reflectance: [0.4; 3],
        solid_offset_m: None,
    };
    let species: Vec<Species> =
        meshes.iter().map(|mesh| Species { mesh, classes, shading: Shading::Physical(surfaces) }).collect();
    let instances: Vec<Placement> =
        [[-30.0, 1.0, -4.0], [-5.0, 1.5, -2.0], [3.0, 1.0, -6.0], [30.0, 1.0, -3.0]]
            .into_iter()
            .enumerate()
            .map(|(i, position_m)| Placement {
                species: i % meshes.len(),
                transform: Transform { rotation: yaw(70.0 * i as f64), position_m, scale: 1.0 },
            })
            .collect();
    Forest::prepare(&species, &instances, ground, Search::default()).unwrap()
}

pub(super) fn phi(LightQuery { instance, point, .. }: LightQuery, phi: &mut [f32; 3]) {
    *phi = [0.1 + 0.01 * instance as f32, 0.02 * point[1].abs(), 0.3];
}

pub(super) fn lit(forest: &Forest, view: &View, daylight: &Setup) -> Picture {
    let fragments = forest.trace(view, &|_| Ok(())).unwrap();
    forest.relight(&fragments, &daylight.lighting(), &daylight.look(), &phi, &|_| Ok(())).unwrap()
}

pub(super) fn afternoon() -> Setup {
    Setup { sun: [0.6, 0.5, 0.5], ambient: 0.4, ..Setup::default() }
}

/// From the south, over the water.
pub(super) fn shore() -> View {
    let eye = Eye { position_m: [1.0, 4.0, 22.0], look_at_m: [0.0, 1.0, -2.0], fov_deg: 50.0 };
    View { eye, width: 80, height: 60, samples: 1, sky_rays: 0, time_s: 0.0 }
}

#[test]
fn fresnels_equations_hold_straight_down_at_brewsters_angle_and_along_the_water() {
    let n = f64::from(REFRACTIVE_INDEX);
    let squared = |value: f64| value * value;
    let near = |cosine: f64, expected: f64| {
        let found = f64::from(reflectance(cosine as f32));
        assert!((found - expected).abs() < 1e-6, "{found} for {expected} at {cosine}");
    };
    near(1.0, squared((n - 1.0) / (n + 1.0)));
    near(0.0, 1.0);
    // At Brewster's angle, whose tangent is n, one of two polarisations is not mirrored at all.
    near(1.0 / (1.0 + n * n).sqrt(), 0.5 * squared((n * n - 1.0) / (n * n + 1.0)));
    // At 60 degrees, by sines and tangents of the angles (Fresnel's own form).
    let (outside, inside) = (60f64.to_radians(), libm::asin(libm::sin(60f64.to_radians()) / n));
    let of = |wave: fn(f64) -> f64| squared(wave(outside - inside) / wave(outside + inside));
    near(0.5, 0.5 * (of(libm::sin) + of(libm::tan)));
    let steps = 200_000;
    let mean = (0..steps)
        .map(|step| {
            let sine_squared = (f64::from(step) + 0.5) / f64::from(steps);
            f64::from(reflectance((1.0 - sine_squared).sqrt() as f32))
        })
        .sum::<f64>()
        / f64::from(steps);
    assert!((1.0 - mean - f64::from(INTO_FROM_SKY)).abs() < 1e-4, "{mean}");
}

#[test]
fn the_mirror_image_of_a_plant_is_the_plant_that_the_mirrored_camera_sees() {
    let meshes = [grown(PlantKind::Oak, 3_000), grown(PlantKind::Shrub, 1_000)];
    let height_m = 0.5;
    let wet = over(grown_stand(&meshes, None), height_m, NO_COLOR);
    let dry = grown_stand(&meshes, None);
    let view = shore();
    let mirrored = |[x, y, z]: [f64; 3]| [x, 2.0 * height_m - y, z];
    let Eye { position_m, look_at_m, fov_deg } = view.eye;
    let eye = Eye { position_m: mirrored(position_m), look_at_m: mirrored(look_at_m), fov_deg };
    let below = View { eye, ..view };
    let (seen, twin) = (wet.trace(&view, &|_| Ok(())).unwrap(), dry.trace(&below, &|_| Ok(())).unwrap());
    let daylight = afternoon();
    let picture = wet.relight(&seen, &daylight.lighting(), &daylight.look(), &phi, &|_| Ok(())).unwrap();
    let expected = dry.relight(&twin, &daylight.lighting(), &daylight.look(), &phi, &|_| Ok(())).unwrap();
    let (mut plants, mut skies, mut others) = (0, 0, 0);
    for (x, y) in (0..view.height).flat_map(|y| (0..view.width).map(move |x| (x, y))) {
        let Some(Fragment::Water { distance_m, .. }) = seen.at(x, y, 0) else { continue };
        let ray = seen.camera.ray(x, y, 0);
        assert!((ray.origin.y + ray.direction.y * distance_m - height_m).abs() < 1e-9);
        let flipped = view.height - 1 - y;
        match (seen.mirrored_at(x, y, 0), twin.at(x, flipped, 0)) {
            (Some(Fragment::Sky), Some(Fragment::Sky)) => skies += 1,
            (Some(Fragment::Plant { instance, found }), Some(Fragment::Plant { instance: i, found: f }))
                if (instance, found.triangle) == (i, f.triangle) =>
            {
                plants += 1;
            }
            _ => {
                others += 1;
                continue;
            }
        }
        let share = reflectance(-ray.direction.y as f32);
        let (found, whole) = (pixel(&picture, x, y), pixel(&expected, x, flipped));
        // Shadow rays may graze an edge.
        let is_close = (0..3).all(|band| (found[band] - share * whole[band]).abs() < 1e-5);
        if !is_close {
            others += 1;
        }
    }
    // Rays that graze an edge may fall on either side of it.
    assert!(plants > 200 && skies > 200 && others < (plants + skies) / 50, "{plants} {skies} {others}");
}

#[test]
fn what_is_mirrored_is_what_an_eye_on_the_water_sees_hills_included() {
    let meshes = [grown(PlantKind::Oak, 3_000), grown(PlantKind::Shrub, 1_000)];
    let height_m: Vec<f32> =
        (0..21 * 21).map(|i| if i / 21 < 10 { 18.0 - 2.0 * (i / 21) as f32 } else { -3.0 }).collect();
    let hill = || {
        let heights = Heights {
            columns: 21,
            rows: 21,
            height_m: height_m.clone(),
            origin_m: [-60.0, -60.0],
            size_m: [120.0, 120.0],
        };
        Some(Ground { land: Land::Heights(heights), color: [0.4, 0.3, 0.2], fades_at_m: None })
    };
    let (wet, dry) = (over(grown_stand(&meshes, hill()), 0.0, NO_COLOR), grown_stand(&meshes, hill()));
    let (view, daylight) = (shore(), afternoon());
    let fragments = wet.trace(&view, &|_| Ok(())).unwrap();
    let picture = wet.relight(&fragments, &daylight.lighting(), &daylight.look(), &phi, &|_| Ok(())).unwrap();
    let (mut hills, mut others) = (0, 0);
    for (x, y) in (30..view.height).flat_map(|y| (0..view.width).map(move |x| (x, y))) {
        let Some(Fragment::Water { distance_m, .. }) = fragments.at(x, y, 0) else { continue };
        let ray = fragments.camera.ray(x, y, 0);
        let mirrored = wet.water.as_ref().unwrap().facet(&ray, distance_m, 0.0).back;
        let eye = Eye {
            position_m: mirrored.origin.to_array(),
            look_at_m: (mirrored.origin + mirrored.direction).to_array(),
            fov_deg: 1.0,
        };
        let from_there = View { eye, width: 1, height: 1, ..view };
        let seen = dry.trace(&from_there, &|_| Ok(())).unwrap();
        let expected = pixel(
            &dry.relight(&seen, &daylight.lighting(), &daylight.look(), &phi, &|_| Ok(())).unwrap(),
            0,
            0,
        );
        let share = reflectance(mirrored.direction.y as f32);
        let found = pixel(&picture, x, y);
        match (0..3).all(|band| (found[band] - share * expected[band]).abs() < 1e-5) {
            true => hills += usize::from(matches!(seen.at(0, 0, 0), Some(Fragment::Ground { .. }))),
            false => others += 1,
        }
    }
    assert!(hills > 100 && others < 10, "{hills} {others}");
}

#[test]
fn under_the_rim_of_a_height_map_is_water_and_no_hole() {
    let meshes = [grown(PlantKind::Shrub, 500)];
    let heights =
        Heights { columns: 3, rows: 3, height_m: vec![2.0; 9], origin_m: [-5.0; 2], size_m: [10.0; 2] };
    let ground = Some(Ground { land: Land::Heights(heights), color: [0.4; 3], fades_at_m: None });
    let forest = over(grown_stand(&meshes, ground), 0.0, [0.1; 3]);
    let eye = Eye { position_m: [0.0, 1.0, 12.0], look_at_m: [0.0, 0.0, 0.0], fov_deg: 6.0 };
    let view = View { eye, width: 32, height: 32, samples: 1, sky_rays: 0, time_s: 0.0 };
    let [_, ground, sky, water] = forest.trace(&view, &|_| Ok(())).unwrap().counts();
    assert_eq!((ground, sky), (0, 0));
    assert!(water > 500, "{water} of 1024");
}

#[test]
fn water_hides_what_lies_below_and_lies_only_where_ground_is_lower() {
    let meshes = [grown(PlantKind::Oak, 3_000)];
    // A bowl 40 m deep whose rim stands 2 m above the water, and an oak whose top nearly reaches it.
    let is_bowl = |i: u32| (2..7).contains(&(i % 9)) && (2..7).contains(&(i / 9));
    let bowl: Vec<f32> = (0..9 * 9).map(|i| if is_bowl(i) { -40.0 } else { 2.0 }).collect();
    let top_m = meshes[0].bounds().unwrap().max[1];
    let heights =
        Heights { columns: 9, rows: 9, height_m: bowl, origin_m: [-40.0, -40.0], size_m: [80.0, 80.0] };
    let ground = Ground { land: Land::Heights(heights.clone()), color: [0.4; 3], fades_at_m: None };
    let oak = Placement {
        species: 0,
        transform: Transform { position_m: [0.0, -0.1 - top_m, 0.0], ..at_m([0.0; 3]).transform },
    };
    let under = Forest::prepare(
        &[Species {
            mesh: &meshes[0],
            classes: &[MaterialClass::Wood, MaterialClass::Leaf],
            shading: Shading::Paper,
        }],
        &[oak],
        Some(ground),
        Search::default(),
    );
    let forest = over(under.unwrap(), 0.0, [0.1; 3]);
    let eye = Eye { position_m: [0.0, 60.0, 5.0], look_at_m: [0.0, 0.0, 0.0], fov_deg: 70.0 };
    let view = View { eye, width: 64, height: 64, samples: 1, sky_rays: 0, time_s: 0.0 };
    let fragments = forest.trace(&view, &|_| Ok(())).unwrap();
    let [plants, ground, sky, water] = fragments.counts();
    assert_eq!((plants, sky, plants + ground + sky + water), (0, 0, 64 * 64));
    for (x, y) in (0..64).flat_map(|y| (0..64).map(move |x| (x, y))) {
        let ray = fragments.camera.ray(x, y, 0);
        let point = ray.origin - ray.direction * (ray.origin.y / ray.direction.y);
        let beyond = point.x.abs().max(point.z.abs()) > 40.0;
        let is_lower = beyond || heights.at_m(point.x, point.z) < 0.0;
        match fragments.at(x, y, 0) {
            Some(Fragment::Water { .. }) => assert!(is_lower, "water on a hill at {point}"),
            Some(Fragment::Ground { distance_m, .. }) => {
                let height = ray.origin.y + ray.direction.y * distance_m;
                assert!(height >= -1e-6, "ground {height} m below the water is seen");
            }
            other => panic!("{other:?}"),
        }
    }
    assert!(ground > 500 && water > 500, "{ground} {water}");
}

#[test]
fn water_is_never_brighter_than_a_white_ground_or_what_it_mirrors() {
    for step in 0..=100 {
        let mirrored = reflectance(step as f32 / 100.0);
        assert!((0.0..=1.0).contains(&mirrored) && mirrored + (1.0 - mirrored) * INTO_FROM_SKY <= 1.0);
    }
    let meshes = [grown(PlantKind::Shrub, 800)];
    let white = Ground { land: Land::Plane { height_m: 0.0 }, color: [1.0; 3], fades_at_m: None };
    let (land, sea) = (grown_stand(&meshes, Some(white)), over(grown_stand(&meshes, None), 0.0, [1.0; 3]));
    for sun in [[0.0, 1.0, 0.0], [0.3, 0.1, 0.5], [0.0, -0.3, 1.0]] {
        for indirect in [Indirect::On, Indirect::Off, Indirect::Only] {
            let daylight = Setup { sun, indirect, ..afternoon() };
            let down = Eye { position_m: [0.0, 40.0, 20.0], look_at_m: [0.0, 0.0, 19.5], fov_deg: 8.0 };
            let view = View { eye: down, ..shore() };
            let (ground, water) = (lit(&land, &view, &daylight), lit(&sea, &view, &daylight));
            // Nothing but sky is mirrored there, and the ground has hardly faded into haze.
            let sky = lit(&over(grown_stand(&meshes, None), 0.0, NO_COLOR), &view, &daylight);
            let brightest = |picture: &Picture| picture.rgb.iter().copied().fold(0.0, f32::max);
            assert!(brightest(&water) <= brightest(&ground) * 1.02 + brightest(&sky), "{sun:?} {indirect:?}");
            // It is lit, unless there is no light at all.
            let has_light = indirect != Indirect::Off || sun[1] > 0.0;
            assert_eq!(brightest(&water) > brightest(&sky) + 0.01, has_light, "{sun:?} {indirect:?}");
        }
    }
}

#[test]
fn a_plant_shades_the_water_from_the_sun_and_hides_its_sky() {
    let mut roof = Mesh { materials: vec![material("roof", [1.0; 3])], ..Mesh::default() };
    add_quad(&mut roof, 0, [-4.0, 2.0, -4.0], [[8.0, 0.0, 0.0], [0.0, 0.0, 8.0]], 1.0);
    let sea = over(forest(&roof, &[at_m([0.0; 3])], None), 0.0, [1.0; 3]);
    let below_roof = Eye { position_m: [0.0, 1.0, 8.0], look_at_m: [0.0, 0.0, 0.0], fov_deg: 0.1 };
    let aside = |x_m: f64, daylight: &Setup| {
        let [eye, at] = [below_roof.position_m, below_roof.look_at_m].map(|[x, y, z]| [x + x_m, y, z]);
        let eye = Eye { position_m: eye, look_at_m: at, ..below_roof };
        shoot(&sea, &View { eye, width: 1, height: 1, samples: 64, sky_rays: 8, time_s: 0.0 }, daylight).rgb
            [0]
    };
    // The sun alone.
    let sun = Setup { sun: [0.0, 1.0, 0.0], ..plain() };
    assert_eq!(aside(0.0, &sun), 0.0);
    assert!(aside(15.0, &sun) > 0.1);
    // The sky alone, which is not drawn: what is left under the roof are its edges, and a quarter for the roof.
    let sky = Setup { indirect: Indirect::Only, ambient: 0.05, ..plain() };
    let (under, open) = (aside(0.0, &sky), aside(100.0, &sky));
    assert!(under < 0.6 * open && under > 0.2 * open, "{under} of {open}");
}

#[test]
fn fragments_with_water_are_lit_again_as_if_traced_anew_by_any_number_of_threads() {
    let meshes = [grown(PlantKind::Oak, 2_000), grown(PlantKind::Shrub, 800)];
    let forest = over(grown_stand(&meshes, None), 0.3, [0.02, 0.05, 0.06]);
    let view = View { samples: 3, sky_rays: 2, ..shore() };
    let kept = forest.trace(&view, &|_| Ok(())).unwrap();
    let dry = grown_stand(&meshes, None).trace(&view, &|_| Ok(())).unwrap();
    assert!(kept.size_bytes() > dry.size_bytes());
    for sun in [[0.6, 0.5, 0.5], [-0.9, 0.2, 0.3]] {
        let daylight = Setup { sun, ..afternoon() };
        let again = forest.relight(&kept, &daylight.lighting(), &daylight.look(), &phi, &|_| Ok(())).unwrap();
        let shoot = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| lit(&forest, &view, &daylight))
        };
        assert!(again == shoot(1) && again == shoot(5), "{sun:?}");
    }
}

#[test]
fn every_way_of_searching_finds_the_same_water() {
    let meshes = [grown(PlantKind::Oak, 2_000), grown(PlantKind::Shrub, 800)];
    let pictures = ways::ways().into_iter().map(|search| {
        let mut forest = grown_stand(&meshes, None);
        forest.search = search;
        lit(&over(forest, 0.3, [0.02, 0.05, 0.06]), &shore(), &afternoon())
    });
    let pictures: Vec<Picture> = pictures.collect();
    assert!(pictures.iter().all(|picture| *picture == pictures[0]));
}

#[test]
fn water_that_cannot_be_and_an_eye_below_it_are_refused() {
    let mesh = wall(material("wall", [0.5; 3]), vec![], 1.0);
    let refusal = |height_m, color| {
        let alone = forest(&mesh, &[at_m([0.0; 3])], None);
        alone.with_water(Water { height_m, color, waves: None }).err().expect("it is refused").to_string()
    };
    for (message, expected) in [
        (refusal(f64::NAN, [0.1; 3]), "`water` is height_m NaN, expected a finite height"),
        (refusal(0.0, [0.1, 1.5, 0.1]), "`water` is colour [0.1, 1.5, 0.1], expected 0..=1 in every band"),
    ] {
        assert!(message.contains(expected), "{message} for {expected}");
    }
    let sea = over(forest(&mesh, &[at_m([0.0; 3])], None), 0.0, NO_COLOR);
    for height_m in [0.0, -2.5] {
        let eye = Eye { position_m: [0.0, height_m, 9.0], ..shore().eye };
        let message = sea.trace(&View { eye, ..shore() }, &|_| Ok(())).err().expect("refused").to_string();
        let expected =
            format!("the camera stands at a height of {height_m} m, expected above the water at 0 m");
        assert!(message.starts_with(&expected), "{message} for {expected}");
    }
}

#[test]
fn a_picture_without_a_backdrop_lacks_what_its_cover_leaves_of_the_sky_and_mirrors_it_all_the_same() {
    let meshes = [grown(PlantKind::Oak, 2_000), grown(PlantKind::Shrub, 800)];
    let level = Ground {
        fades_at_m: Some(60.0),
        ..Ground { land: Land::Plane { height_m: 0.0 }, color: [0.2; 3], fades_at_m: None }
    };
    for (forest, view) in [
        (over(grown_stand(&meshes, None), 0.2, [0.1; 3]), shore()),
        (grown_stand(&meshes, Some(level)), View { samples: 2, ..shore() }),
    ] {
        let look = |backdrop| Setup { backdrop, ..afternoon() };
        let [with, without] = [true, false].map(|backdrop| lit(&forest, &view, &look(backdrop)));
        let fragments = forest.trace(&view, &|_| Ok(())).unwrap();
        let cover = forest.coverage(&fragments, &look(false).lighting(), &look(false).look()).unwrap();
        assert_eq!(cover, forest.coverage_of(&view, &look(false).lighting(), &look(false).look()).unwrap());
        let mut seen = [0; 3];
        for ((with, without), cover) in with.rgb.chunks(3).zip(without.rgb.chunks(3)).zip(cover.rgb.chunks(3))
        {
            assert!(cover[0] == cover[1] && cover[1] == cover[2] && (0.0..=1.0).contains(&cover[0]));
            let is_same = with.iter().zip(without).all(|(a, b)| (a - b).abs() < 1e-6);
            match cover[0] {
                0.0 => assert!(without == [0.0; 3] && with[2] > 0.0),
                1.0 => assert!(is_same, "{with:?} {without:?}"),
                _ => assert!(with.iter().zip(without).all(|(a, b)| a > b), "{with:?} {without:?} {cover:?}"),
            }
            seen[if cover[0] == 0.0 {
                0
            } else if cover[0] == 1.0 {
                1
            } else {
                2
            }] += 1;
        }
        assert!(seen[0] > 20 && seen[1] > 20 && (view.samples == 1 || seen[2] > 20), "{seen:?}");
    }
}

use flb_format::progress::Cancelled;
use flb_format::{Placement, Transform};
use flb_scene::scene::Heights;
use glam::{DMat3, Vec3};

use super::*;
use crate::highlight::Highlights;
use crate::tests::{Setup, add_quad, glossy, grown, image, material, textured, wall};
use crate::{Indirect, LightQuery, Picture, Surfaces};
use flb_fixtures::PlantKind;
use flb_scene::mesh::{AlphaMode, Wrap};

mod sky;
mod water;
mod waves;
mod ways;

const LEAF: [MaterialClass; 2] = [MaterialClass::Leaf; 2];

fn yaw(degrees: f64) -> [[f64; 3]; 3] {
    DMat3::from_rotation_y(degrees.to_radians()).transpose().to_cols_array_2d()
}

fn at_m(position_m: [f64; 3]) -> Placement {
    Placement { species: 0, transform: Transform { rotation: yaw(0.0), position_m, scale: 1.0 } }
}

fn paper<'a>(mesh: &'a Mesh, classes: &'a [MaterialClass]) -> Species<'a> {
    Species { mesh, classes: &classes[..mesh.materials.len()], shading: Shading::Paper }
}

/// From 10 m in the south of a point, looking north.
fn view(target: [f64; 3]) -> View {
    let position_m = [target[0], target[1], target[2] + 10.0];
    let eye = Eye { position_m, look_at_m: target, fov_deg: 30.0 };
    View { eye, width: 33, height: 33, samples: 1, sky_rays: 0, time_s: 0.0 }
}

/// The sun alone, from behind the camera, and no sky.
fn plain() -> Setup {
    Setup {
        sun: [0.0, 1e-4, 1.0],
        highlights: Highlights::MATT,
        indirect: Indirect::Off,
        sky: false,
        ..Setup::default()
    }
}

fn dark(_: LightQuery, phi: &mut [f32; 3]) {
    *phi = [0.0; 3];
}

fn shoot(forest: &Forest, view: &View, daylight: &Setup) -> Picture {
    let fragments = forest.trace(view, &|_| Ok(())).unwrap();
    forest.relight(&fragments, &daylight.lighting(), &daylight.look(), &dark, &|_| Ok(())).unwrap()
}

fn forest<'a>(mesh: &'a Mesh, instances: &[Placement], ground: Option<Ground>) -> Forest<'a> {
    Forest::prepare(&[paper(mesh, &LEAF)], instances, ground, Search::default()).unwrap()
}

fn pixel(picture: &Picture, x: u32, y: u32) -> [f32; 3] {
    let first = ((y * picture.width + x) * 3) as usize;
    picture.rgb[first..first + 3].try_into().unwrap()
}

#[track_caller]
fn assert_close(found: [f32; 3], expected: [f32; 3]) {
    let far = (0..3).any(|band| (found[band] - expected[band]).abs() > 1e-4);
    assert!(!far, "found {found:?}, expected {expected:?}");
}

#[test]
fn a_turned_scaled_and_moved_instance_looks_as_a_mesh_with_all_that_done_to_it() {
    let mesh = grown(PlantKind::Oak, 3_000);
    let instance = Placement {
        species: 0,
        transform: Transform { rotation: yaw(40.0), position_m: [30.0, 2.0, -7.0], scale: 0.6 },
    };
    let rotation = DMat3::from_cols_array_2d(&instance.transform.rotation).transpose();
    let mut moved = mesh.clone();
    for point in &mut moved.positions {
        let turned = rotation * Vec3::from(*point).as_dvec3() * instance.transform.scale;
        *point = (turned + DVec3::from(instance.transform.position_m)).as_vec3().to_array();
    }
    for normal in &mut moved.normals {
        *normal = (rotation * Vec3::from(*normal).as_dvec3()).as_vec3().to_array();
    }
    let view = View { width: 64, height: 64, ..view([30.0, 5.0, -7.0]) };
    let daylight = Setup { sun: [0.5, 0.8, 0.4], highlights: glossy(0.1), ..plain() };
    let placed = shoot(&forest(&mesh, &[instance], None), &view, &daylight);
    let baked_in = shoot(&forest(&moved, &[at_m([0.0; 3])], None), &view, &daylight);
    // Rays that graze an edge may fall on either side of it.
    let differ = placed.rgb.iter().zip(&baked_in.rgb).filter(|(a, b)| (**a - **b).abs() > 1e-3).count();
    assert!(differ < placed.rgb.len() / 200, "{differ} of {}", placed.rgb.len());
    assert!(placed.rgb.iter().filter(|value| **value > 0.0).count() > placed.rgb.len() / 50);
}

#[test]
fn a_stand_a_thousand_kilometres_off_looks_as_it_does_at_the_origin() {
    let mesh = grown(PlantKind::Oak, 3_000);
    let picture = |off: f64| {
        let instances = [at_m([off, 0.0, 0.0]), at_m([off + 4.0, 0.0, -3.0])];
        shoot(&forest(&mesh, &instances, None), &view([off, 5.0, 0.0]), &plain())
    };
    let (near, far) = (picture(0.0), picture(1_048_576.0));
    let differ = near.rgb.iter().zip(&far.rgb).filter(|(a, b)| (**a - **b).abs() > 1e-3).count();
    assert!(differ < near.rgb.len() / 200, "{differ} of {}", near.rgb.len());
}

#[test]
fn a_picture_stops_when_it_is_told_to() {
    let mesh = wall(material("wall", [1.0; 3]), vec![], 1.0);
    let (forest, view, daylight) = (forest(&mesh, &[at_m([0.0; 3])], None), view([0.0; 3]), plain());
    let asked = std::sync::atomic::AtomicU32::new(0);
    // At the third question: 9 squares ask, and before them the whole.
    let stop = |_| match asked.fetch_add(1, std::sync::atomic::Ordering::Relaxed) {
        0 | 1 => Ok(()),
        _ => Err(Cancelled),
    };
    let is_stopped = |error: Option<RenderError>| matches!(error, Some(RenderError::Cancelled(Cancelled)));
    assert!(is_stopped(forest.trace(&view, &stop).err()));
    let fragments = forest.trace(&view, &|_| Ok(())).unwrap();
    asked.store(0, std::sync::atomic::Ordering::Relaxed);
    let (lighting, look) = (daylight.lighting(), daylight.look());
    assert!(is_stopped(forest.relight(&fragments, &lighting, &look, &dark, &stop).err()));
}

#[test]
fn the_light_is_asked_for_at_the_instance_and_at_the_point_of_its_model() {
    let mesh = wall(material("wall", [1.0; 3]), vec![], 1.0);
    let instances = [
        at_m([-1.0, 0.0, 0.0]),
        Placement { species: 0, transform: Transform { scale: 0.5, ..at_m([1.5, 0.0, 0.0]).transform } },
    ];
    let forest = forest(&mesh, &instances, None);
    let fragments = forest.trace(&view([0.0; 3]), &|_| Ok(())).unwrap();
    let ask = |LightQuery { instance, point, .. }: LightQuery, phi: &mut [f32; 3]| {
        *phi = [instance as f32, point[0], point[1]]
    };
    let daylight = Setup { indirect: Indirect::Only, indirect_scale: 1.0, ..plain() };
    let picture =
        forest.relight(&fragments, &daylight.lighting(), &daylight.look(), &ask, &|_| Ok(())).unwrap();
    let half_m = 10.0 * libm::tan(15.0f64.to_radians());
    let middle = |x_m: f64| (16.5 * (1.0 + x_m / half_m)) as u32;
    let left = pixel(&picture, middle(-1.0), 16);
    let right = pixel(&picture, middle(1.5), 16);
    assert!(left[0] == 0.0 && left[1].abs() < 0.2, "{left:?}");
    assert!(right[0] == 1.0 && right[1].abs() < 0.4 && right[2].abs() < 0.4, "{right:?}");
    assert_eq!(forest.world_point_m(1, [1.0, 1.0, 0.0]), [2.0, 0.5, 0.0]);
}

#[test]
fn an_instance_shades_another_and_the_ground_and_is_hidden_by_what_is_nearer() {
    let mesh = wall(material("wall", [0.8, 0.5, 0.2]), vec![], 1.0);
    let ground = Ground { land: Land::Plane { height_m: -2.0 }, color: [0.5; 3], fades_at_m: None };
    // The sun stands 45 degrees high in the south: what is 3 m further south shades what is 3 m lower.
    let daylight = Setup { sun: [0.0, 1.0, 1.0], ..plain() };
    let slope = std::f32::consts::FRAC_1_SQRT_2;
    let alone = shoot(&forest(&mesh, &[at_m([0.0; 3])], Some(ground.clone())), &view([0.0; 3]), &daylight);
    assert_close(pixel(&alone, 16, 16), [0.8, 0.5, 0.2].map(|v| v * slope));
    let lit = pixel(&alone, 2, 30);
    assert!(lit[0] > 0.9 * 0.5 * slope && lit[0] <= 0.5 * slope, "{lit:?}");
    let two = [at_m([0.0; 3]), at_m([0.0, 4.0, 4.0])];
    let shaded = shoot(&forest(&mesh, &two, Some(ground.clone())), &view([0.0; 3]), &daylight);
    assert_eq!(pixel(&shaded, 16, 16), [0.0; 3]);
    assert!((pixel(&shaded, 2, 30)[0] - lit[0]).abs() < 0.01, "{lit:?}");
    // The shadow of the first falls behind it, on the ground: 2 m below, 1 to 3 m to the north.
    let from_above = View {
        eye: Eye { position_m: [0.0, 20.0, -0.01], look_at_m: [0.0, -2.0, 0.0], fov_deg: 30.0 },
        ..view([0.0; 3])
    };
    let above = shoot(&forest(&mesh, &[at_m([0.0; 3])], Some(ground)), &from_above, &daylight);
    let dark: Vec<u32> = (0..33 * 33).filter(|i| above.rgb[*i as usize * 3] == 0.0).collect();
    let size_m = 2.0 * 22.0 * libm::tan(15.0f64.to_radians()) / 33.0;
    let shadow_m2 = dark.len() as f64 * size_m * size_m;
    assert!((shadow_m2 - 4.0).abs() < 0.8, "{shadow_m2} m2 of shadow, expected 4");
}

#[test]
fn what_alpha_cuts_away_is_seen_and_lit_through() {
    let half = textured(0, Wrap::Clamp, AlphaMode::Cut { cutoff: 0.5 });
    let texels = image(&[[255; 4], [255, 255, 255, 0]]);
    let mut mesh = wall(half, vec![texels], 1.0);
    mesh.materials.push(material("behind", [0.5; 3]));
    let behind = {
        let mut mesh = Mesh { materials: vec![material("wall", [0.5; 3])], ..Mesh::default() };
        add_quad(&mut mesh, 0, [-2.0, -2.0, 0.0], [[4.0, 0.0, 0.0], [0.0, 4.0, 0.0]], 1.0);
        mesh
    };
    let species = [paper(&mesh, &LEAF), paper(&behind, &LEAF)];
    let instances = [at_m([0.0, 0.0, 1.0]), Placement { species: 1, transform: at_m([0.0; 3]).transform }];
    for model in [ModelSearch::Tree, ModelSearch::Grid] {
        let search = Search { model, ..Search::default() };
        let forest = Forest::prepare(&species, &instances, None, search).unwrap();
        let picture = shoot(&forest, &view([0.0; 3]), &plain());
        assert_close(pixel(&picture, 14, 16), [1.0; 3]);
        assert_close(pixel(&picture, 19, 16), [0.5; 3]);
        // From the side: what is left of the leaf shades the half of the wall behind it, the other half is lit.
        let aside = Eye { position_m: [9.0, 0.0, 8.0], look_at_m: [0.0; 3], fov_deg: 20.0 };
        let picture = shoot(&forest, &View { eye: aside, ..view([0.0; 3]) }, &plain());
        let darkest = picture.rgb.iter().filter(|value| **value == 0.0).count();
        assert!(darkest > 50, "{darkest}");
    }
}

#[test]
fn a_level_height_map_is_a_plane_and_a_hill_hides_and_shades() {
    let mesh = wall(material("wall", [1.0; 3]), vec![], 1.0);
    let grid = |height: fn(u32, u32) -> f32| {
        let height_m = (0..11 * 11).map(|i| height(i % 11, i / 11)).collect();
        Land::Heights(Heights {
            columns: 11,
            rows: 11,
            height_m,
            origin_m: [-50.0, -50.0],
            size_m: [100.0, 100.0],
        })
    };
    let picture = |land: Land, sun: [f64; 3]| {
        let ground = Ground { land, color: [0.5, 0.4, 0.3], fades_at_m: None };
        let eye = Eye { position_m: [3.0, 6.0, 30.0], look_at_m: [0.0, 0.0, 0.0], fov_deg: 40.0 };
        let forest = forest(&mesh, &[at_m([0.0, 1.0, 0.0])], Some(ground));
        shoot(&forest, &View { eye, ..view([0.0; 3]) }, &Setup { sun, ..plain() })
    };
    let level = picture(grid(|_, _| -1.0), [1.0, 1.0, 1.0]);
    let plane = picture(Land::Plane { height_m: -1.0 }, [1.0, 1.0, 1.0]);
    // The height map ends, the plane does not: both are compared where there is one.
    for (a, b) in level.rgb.iter().zip(&plane.rgb).filter(|(a, _)| **a > 0.0) {
        assert!((a - b).abs() < 1e-4, "{a} for {b}");
    }
    assert!(level.rgb.iter().filter(|value| **value > 0.0).count() > 1500);
    // A ridge along x at z = 10 hides the wall behind it, and shades it from a low sun in the south.
    let ridge = |_: u32, row: u32| if row == 6 { 8.0 } else { -1.0 };
    let hidden = picture(grid(ridge), [0.0, 1.0, 0.01]);
    assert!((0..33).all(|x| pixel(&hidden, x, 16)[2] < 0.5), "a white wall shows through the ridge");
    let low = picture(grid(ridge), [0.0, 0.1, 1.0]);
    assert!(low.rgb.iter().filter(|value| **value > 0.0).count() > 300);
}

#[test]
fn rays_through_a_height_field_agree_with_many_small_steps() {
    let height = |x: f64, z: f64| (3.0 * libm::sin(x) + 2.0 * libm::cos(1.7 * z + 0.3 * x)) as f32;
    let (columns, rows) = (17, 13);
    let height_m =
        (0..columns * rows).map(|i| height(f64::from(i % columns), f64::from(i / columns))).collect();
    let heights = Heights { columns, rows, height_m, origin_m: [-8.0, -6.0], size_m: [16.0, 12.0] };
    let soil = GroundSurface::new(Ground {
        land: Land::Heights(heights.clone()),
        color: [0.5; 3],
        fades_at_m: None,
    });
    let mut met = 0;
    for i in 0..400u32 {
        let [u, v] = crate::r2_sequence(7, i).map(f64::from);
        let [p, q] = crate::r2_sequence(8, i).map(f64::from);
        let origin = DVec3::new(-12.0 + 24.0 * u, 7.0 * (p - 0.2), -9.0 + 18.0 * v);
        let direction = DVec3::new(q - 0.5, -0.3 * p, 0.5 - u).normalize();
        let ray = placed::WorldRay { origin, direction };
        let (step, mut before) = (1e-3, None);
        let walked = (0..60_000).map(|step_count| f64::from(step_count) * step).find(|distance| {
            let point = origin + direction * *distance;
            let is_over = (-8.0..=8.0).contains(&point.x) && (-6.0..=6.0).contains(&point.z);
            let is_above = is_over.then(|| point.y > heights.at_m(point.x, point.z));
            let is_through = before.zip(is_above).is_some_and(|(before, above)| before != above);
            before = is_above;
            is_through
        });
        // Within a step a ray may come in and out again.
        let found = soil.along(&ray);
        match (found, walked) {
            (Some(found), Some(walked)) => {
                assert!(found <= walked + step, "ray {i}: {found} for {walked}");
                met += u32::from((found - walked).abs() <= 2.0 * step);
            }
            (None, Some(walked)) => panic!("ray {i}: nothing for {walked}"),
            _ => {}
        }
    }
    assert!(met > 100, "{met}");
}

#[test]
fn ground_under_a_roof_sees_little_of_the_sky() {
    let mut roof = Mesh { materials: vec![material("roof", [1.0; 3])], ..Mesh::default() };
    add_quad(&mut roof, 0, [-4.0, 1.0, -4.0], [[8.0, 0.0, 0.0], [0.0, 0.0, 8.0]], 1.0);
    let ground = Ground { land: Land::Plane { height_m: 0.0 }, color: [1.0; 3], fades_at_m: None };
    let forest = forest(&roof, &[at_m([0.0; 3])], Some(ground));
    let eye = Eye { position_m: [0.0, 0.5, 30.0], look_at_m: [0.0, 0.0, 0.0], fov_deg: 3.0 };
    let daylight = Setup { ambient: 1.0 / 18.0, indirect_scale: 1.0, indirect: Indirect::Only, ..plain() };
    let center = |sky_rays: u32| {
        let view = View { eye, samples: 16, sky_rays, ..view([0.0; 3]) };
        pixel(&shoot(&forest, &view, &daylight), 16, 16)[0]
    };
    // The middle of a square roof of 8 m sees what is lower than 1 m over 4 m: about 4 % by the cosine. The roof itself
    // counts as a quarter as bright as the sky.
    let (open, covered) = (center(0), center(64));
    assert!(open > 0.9, "{open}");
    let seen = (covered / open - 0.25) / 0.75;
    assert!(seen > 0.005 && seen < 0.12, "{covered} of {open}");
}

#[test]
fn physical_species_are_shaded_in_radiance() {
    let mesh = wall(material("wall", [0.5; 3]), vec![], 1.0);
    let surfaces = Surfaces {
        leaf_reflectance: [0.1; 3],
        leaf_transmittance: [0.2; 3],
        wood_reflectance: [0.3; 3],
        solid_offset_m: None,
    };
    let one = |shading| Species { mesh: &mesh, classes: &LEAF[..1], shading };
    let physical = Shading::Physical(surfaces);
    let forest = Forest::prepare(&[one(physical)], &[at_m([0.0; 3])], None, Search::default()).unwrap();
    let found = pixel(&shoot(&forest, &view([0.0; 3]), &plain()), 16, 16);
    assert_close(found, [0.1 * std::f32::consts::FRAC_1_PI; 3]);
    let from_behind = shoot(&forest, &view([0.0; 3]), &Setup { sun: [0.0, 1e-4, -1.0], ..plain() });
    assert_close(pixel(&from_behind, 16, 16), [0.2 * std::f32::consts::FRAC_1_PI; 3]);
    let both =
        Forest::prepare(&[one(physical), one(Shading::Paper)], &[at_m([0.0; 3])], None, Search::default());
    let message = both.err().expect("units differ").to_string();
    assert!(message.starts_with("species 1 is shaded by another model than species 0"), "{message}");
}

#[test]
fn a_scene_that_cannot_be_is_refused_with_what_was_found() {
    let mesh = wall(material("wall", [0.5; 3]), vec![], 1.0);
    let refusal = |instances: &[Placement], ground: Option<Ground>| {
        let found = Forest::prepare(&[paper(&mesh, &LEAF)], instances, ground, Search::default());
        found.err().expect("it is refused").to_string()
    };
    let good = at_m([0.0; 3]);
    let plane = |height_m, color| Some(Ground { land: Land::Plane { height_m }, color, fades_at_m: None });
    let heights = |columns, height_m: &[f32], edge| {
        let (height_m, size_m) = (height_m.to_vec(), [edge; 2]);
        let land = Land::Heights(Heights { columns, rows: 2, height_m, origin_m: [0.0; 2], size_m });
        Some(Ground { land, color: [0.5; 3], fades_at_m: None })
    };
    let mirrored = [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for (instance, ground, expected) in [
        (Placement { species: 1, ..good }, None, "instance 0: species 1 of 1"),
        (at_m([0.0, f64::NAN, 0.0]), None, "instance 0: stands at [0.0, NaN, 0.0]"),
        (
            Placement { transform: Transform { scale: 0.0, ..good.transform }, ..good },
            None,
            "instance 0: scale 0, expected",
        ),
        (
            Placement { transform: Transform { rotation: mirrored, ..good.transform }, ..good },
            None,
            "expected one of unit length that mirrors nothing",
        ),
        (good, plane(f64::INFINITY, [0.5; 3]), "`ground` is height_m inf"),
        (good, plane(0.0, [0.5, 2.0, 0.0]), "`ground` is colour [0.5, 2.0, 0.0], expected 0..=1"),
        (good, heights(2, &[0.0; 3], 1.0), "`ground` is 2 x 2 points, 3 heights"),
        (good, heights(2, &[0.0; 4], 0.0), "`ground` is size_m [0.0, 0.0]"),
        (good, heights(2, &[0.0, 0.0, f32::NAN, 0.0], 1.0), "`ground` is a height of NaN"),
    ] {
        let message = refusal(&[instance], ground);
        assert!(message.contains(expected), "{message} for {expected}");
    }
    assert_eq!(refusal(&[], None), "the scene has no instances, so there is nothing to render");
    let stand = forest(&mesh, &[good], None);
    let seen = |view: View| stand.trace(&view, &|_| Ok(())).err().expect("it is refused").to_string();
    let view = view([0.0; 3]);
    for (view, expected) in [
        (View { width: 0, ..view }, "`width` is 0, expected 1..=16384"),
        (View { samples: 5000, ..view }, "`samples` is 5000"),
        (View { sky_rays: 257, ..view }, "`sky_rays` is 257, expected 0..=256"),
        (View { width: 16_384, height: 16_384, ..view }, "`width x height` is 268435456"),
        (View { width: 8192, height: 8192, samples: 16, ..view }, "`width x height x samples` is 1073741824"),
        (View { eye: Eye { fov_deg: 180.0, ..view.eye }, ..view }, "`fov_deg` is 180"),
        (
            View { eye: Eye { look_at_m: view.eye.position_m, ..view.eye }, ..view },
            "`look_at_m` is [0.0, 0.0, 10.0]",
        ),
        (
            View { eye: Eye { position_m: [f64::NAN; 3], ..view.eye }, ..view },
            "`position_m` is [NaN, NaN, NaN]",
        ),
    ] {
        let message = seen(view);
        assert!(message.contains(expected), "{message} for {expected}");
    }
    let fragments = stand.trace(&view, &|_| Ok(())).unwrap();
    let lit = |daylight: Setup, phi: f32| {
        let light = move |_: LightQuery, out: &mut [f32; 3]| *out = [phi; 3];
        stand
            .relight(&fragments, &daylight.lighting(), &daylight.look(), &light, &|_| Ok(()))
            .expect_err("it is refused")
            .to_string()
    };
    assert!(lit(Setup { sun: [0.0; 3], ..plain() }, 0.0).contains("`towards_sun` is [0.0, 0.0, 0.0]"));
    assert!(lit(Setup { ambient: -1.0, ..plain() }, 0.0).contains("`sky` is -1"));
    assert!(lit(Setup { sun_strength: -1.0, ..plain() }, 0.0).contains("`sun` is -1"));
    let bright = lit(Setup { highlights: glossy(1e4), ..plain() }, 0.0);
    assert!(bright.contains("`highlight of leaves` is 10000, expected 0..=1000"), "{bright}");
    let mut flat = glossy(0.1);
    flat.water.exponent = 0.0;
    let flat = lit(Setup { highlights: flat, ..plain() }, 0.0);
    assert!(flat.contains("`highlight of water` is 0, expected 0.0"), "{flat}");
    assert!(lit(Setup { indirect_scale: 1e7, ..plain() }, 0.0).contains("`indirect_scale` is 10000000"));
    let infinite = lit(Setup { indirect: Indirect::Only, ..plain() }, f32::INFINITY);
    assert!(infinite.contains("band R is inf, expected a finite value"), "{infinite}");
}

#[test]
fn a_camera_may_look_straight_down() {
    let lens = eye::lens(&Eye { position_m: [0.0, 5.0, 0.0], look_at_m: [0.0; 3], fov_deg: 60.0 }, [8, 8]);
    let lens = lens.unwrap();
    let north = lens.project(DVec3::new(0.0, 0.0, -1.0)).expect("it is in front");
    assert!((north[0] - 4.0).abs() < 1e-9 && north[1] < 4.0, "{north:?}");
    let ray = lens.ray(north[0], north[1]);
    let hit = ray.origin + ray.direction * (5.0 / -ray.direction.y);
    assert!((hit - DVec3::new(0.0, 0.0, -1.0)).length() < 1e-9, "{hit}");
    assert_eq!(lens.project(DVec3::new(0.0, 6.0, 0.0)), None);
}

#[test]
fn fragments_are_told_ray_by_ray_and_instances_can_be_changed() {
    let mesh = wall(material("wall", [1.0; 3]), vec![], 1.0);
    let ground = Ground { land: Land::Plane { height_m: -2.0 }, color: [0.5; 3], fades_at_m: None };
    let mut stand = forest(&mesh, &[at_m([0.0; 3])], Some(ground.clone()));
    let view = View { width: 37, samples: 2, ..view([0.0; 3]) };
    let counted = |fragments: &Fragments| {
        let mut counts = [0; 4];
        for (y, x, sample) in (0..33).flat_map(|y| (0..37).flat_map(move |x| [(y, x, 0), (y, x, 1)])) {
            counts[match fragments.at(x, y, sample).expect("it is in the picture") {
                Fragment::Plant { instance, .. } => instance as usize,
                Fragment::Ground { .. } => 1,
                Fragment::Sky => 2,
                Fragment::Water { .. } => 3,
            }] += 1;
        }
        counts
    };
    let one = stand.trace(&view, &|_| Ok(())).unwrap();
    assert_eq!(counted(&one), one.counts());
    for (x, y, sample) in [(37, 0, 0), (0, 33, 0), (0, 0, 2)] {
        assert_eq!(one.at(x, y, sample), None);
    }
    stand.set_instances(&[at_m([1.5, 0.0, 0.0])]).unwrap();
    let fresh = forest(&mesh, &[at_m([1.5, 0.0, 0.0])], Some(ground));
    let (moved, expected) =
        (stand.trace(&view, &|_| Ok(())).unwrap(), fresh.trace(&view, &|_| Ok(())).unwrap());
    assert_eq!(moved.at(25, 16, 0), expected.at(25, 16, 0));
    assert_ne!(moved.at(16, 16, 0), one.at(16, 16, 0));
    assert!(matches!(stand.set_instances(&[]), Err(RenderError::NoInstances)));
    assert_eq!(stand.trace(&view, &|_| Ok(())).unwrap().counts(), expected.counts());
}

//! Water: mirrors on a GPU what it mirrors on the CPU.

use flb_format::sun::towards_sun;
use flb_format::{Daylight, Placement};
use flb_render::forest::{Fragment, Ground, InstanceSearch, Land, ModelSearch, Search, View, Water};
use flb_render::highlight::{Highlight, Highlights};
use flb_render::picture::PHYSICAL_EXPOSURE;
use flb_render::{Indirect, LightQuery, Lighting, Look, Picture, RenderError, Shading};
use flb_scene::waves::Waves;
use flb_testkit::scenes::{hills, physical, stand, view};

use super::gpu;
use super::lit::{assert_alike, difference};
use super::traced::{meshes, settings, two};
use crate::{CameraHit, ForestError, ForestSettings, GpuForest, LightSet, LightSource};

/// Rays that may come to something else by way of the water: more than straight ones, as they start where f32 has
/// rounded them to.
const DIFFERENT: f64 = 2e-3;
/// The same by way of waves: f32 places short waves that are far off to a part of their length, so that leaves beside
/// each other are met. The light of many rays is the same.
const DIFFERENT_BY_WAVES: f64 = 2e-2;
/// Of distances from the water to the ground, as a share: rays meet it at small angles.
const DISTANCE: f64 = 1e-4;
/// Light of fields everywhere in a plant.
const EVEN: [f32; 3] = [0.3, 0.2, 0.1];

fn even(_: LightQuery, phi: &mut [f32; 3]) {
    *phi = EVEN;
}

const LAKE: Water = Water { height_m: 0.35, color: [0.02, 0.06, 0.07], waves: None };

/// With waves, high enough that many rays come to something else.
const WAVY: Water = Water {
    waves: Some(Waves { wind_m_s: 5.0, from_deg: 200.0, fetch_m: 200.0, steepness: 1.0, seed: 5 }),
    ..LAKE
};

/// Of each kind of surface another one, wide enough to be seen everywhere.
const GLOSSY: Highlights = Highlights {
    leaf: Highlight { strength: 0.3, exponent: 3.0 },
    wood: Highlight { strength: 0.2, exponent: 2.0 },
    water: Highlight { strength: 0.6, exponent: 1.5 },
};

/// Up to 3 m above the water, and valleys below it.
fn peaks() -> Ground {
    let mut ground = hills(60.0);
    if let Land::Heights(heights) = &mut ground.land {
        heights.height_m.iter_mut().for_each(|height_m| *height_m = 10.0 * *height_m - 6.65);
    }
    ground
}

/// Partly below the water.
fn plants(middle: [f64; 3]) -> Vec<Placement> {
    stand(13, 25.0, middle)
}

/// From 2 m above the water.
fn shore(size: [u32; 2], samples: u32, water: Water, middle: [f64; 3]) -> View {
    let mut view = view(size, samples, 26.0);
    view.eye.position_m[1] = water.height_m - middle[1] + 2.0;
    for point in [&mut view.eye.position_m, &mut view.eye.look_at_m] {
        *point = std::array::from_fn(|axis| point[axis] + middle[axis]);
    }
    view
}

#[test]
fn rays_come_to_the_same_by_way_of_the_water_as_on_the_cpu() {
    let (meshes, gpu) = (meshes(), gpu());
    let far = [1_048_576.3, 211.7, -734_003.9];
    let grids =
        Search { model: ModelSearch::Grid, primary: InstanceSearch::Grid, shadow: InstanceSearch::Grid };
    for (search, ground, water, middle) in [
        (Search::default(), Some(peaks()), LAKE, [0.0; 3]),
        (grids, Some(peaks()), LAKE, [0.0; 3]),
        (Search::default(), None, Water { height_m: far[1] + 0.35, ..LAKE }, far),
        (Search::default(), Some(peaks()), WAVY, [0.0; 3]),
        (grids, None, Water { height_m: far[1] + 0.35, ..WAVY }, far),
    ] {
        let forest = two(&meshes, Shading::Paper, &plants(middle), ground).with_water(water).unwrap();
        let lights = super::traced::dark(&gpu, 2);
        let by = ForestSettings { search, ..settings() };
        let mut on_gpu = GpuForest::new(&gpu, &forest, &lights, by).unwrap();
        let view = View { time_s: 3.5, ..shore([150, 110], 1, water, middle) };
        on_gpu.trace(&view).unwrap();
        let expected = forest.trace(&view, &|_| Ok(())).unwrap();
        let (found, mirrored) = (on_gpu.fragments().unwrap(), on_gpu.mirrored().unwrap());
        let (mut kinds, mut different) = ([0; 3], 0);
        for (ray, met) in found.iter().enumerate() {
            let [x, y] = [ray as u32 % view.width, ray as u32 / view.width];
            assert_eq!(mirrored[ray].is_some(), matches!(met, CameraHit::Water { .. }));
            match (mirrored[ray], expected.mirrored_at(x, y, 0)) {
                (None, None) => {}
                (Some(CameraHit::Sky), Some(Fragment::Sky)) => kinds[0] += 1,
                (
                    Some(CameraHit::Ground { distance_m, .. }),
                    Some(Fragment::Ground { distance_m: of_twin, .. }),
                ) => {
                    kinds[1] += 1;
                    different += usize::from((f64::from(distance_m) / of_twin - 1.0).abs() > DISTANCE);
                }
                (
                    Some(CameraHit::Plant { instance, triangle, .. }),
                    Some(Fragment::Plant { instance: of_twin, found }),
                ) if (instance, triangle) == (of_twin, found.triangle) => kinds[2] += 1,
                _ => different += 1,
            }
        }
        println!("{kinds:?}, {different} of {}", found.len());
        let least = found.len() / 100;
        assert!(kinds[0] > least && kinds[2] > least && (middle == far || kinds[1] > least), "{kinds:?}");
        let most = if water.waves.is_some() { DIFFERENT_BY_WAVES } else { DIFFERENT };
        assert!(different <= (most * found.len() as f64) as usize, "{different} of {}", found.len());
    }
}

#[test]
fn pictures_with_water_are_those_of_the_cpu_for_every_sun_of_one_trace() {
    let (meshes, gpu) = (meshes(), gpu());
    for (shading, exposure, ground, water) in [
        (Shading::Paper, 0.0, None, LAKE),
        (physical(), PHYSICAL_EXPOSURE, Some(peaks()), LAKE),
        (Shading::Paper, 0.0, None, WAVY),
        (physical(), PHYSICAL_EXPOSURE, Some(peaks()), WAVY),
    ] {
        let forest = two(&meshes, shading, &plants([0.0; 3]), ground).with_water(water).unwrap();
        let view = shore([112, 70], 4, water, [0.0; 3]);
        let fragments = forest.trace(&view, &|_| Ok(())).unwrap();
        let sources = [LightSource::Even(EVEN), LightSource::Even(EVEN)];
        let mut lights = LightSet::load(&gpu, &sources, plants([0.0; 3]).len()).unwrap();
        let mut on_gpu = GpuForest::new(&gpu, &forest, &lights, settings()).unwrap();
        on_gpu.trace(&view).unwrap();
        let cases = [
            (towards_sun(135.0, 35.0), Indirect::On),
            (towards_sun(250.0, 8.0), Indirect::On),
            (towards_sun(135.0, 35.0), Indirect::Only),
            (towards_sun(135.0, 35.0), Indirect::Off),
            (towards_sun(90.0, -10.0), Indirect::On),
        ];
        for (sun, indirect) in cases {
            let daylight = Lighting::of(Daylight { towards_sun: sun, sun: 1.0, sky: 0.2 });
            // One of them without a sky behind, which the water mirrors all the same.
            let has_backdrop = sun[1] > 0.2 || indirect != Indirect::On;
            let look = Look { indirect, highlights: GLOSSY, has_backdrop, ..Look::default() };
            on_gpu.relight(&mut lights, &daylight, &look).unwrap();
            let expected = forest.relight(&fragments, &daylight, &look, &even, &|_| Ok(())).unwrap();
            let found = on_gpu.picture().unwrap();
            if water.waves.is_none() {
                assert_alike(&found, &expected, exposure);
                continue;
            }
            let mean = |picture: &Picture| {
                picture.rgb.iter().map(|value| f64::from(*value)).sum::<f64>() / picture.rgb.len() as f64
            };
            let (rms, median) = difference(&found, &expected, exposure);
            let off = (mean(&found) / mean(&expected) - 1.0).abs();
            println!("rms {rms:.5}, mean {off:.5} off");
            assert!(rms < 0.02 && median == 0.0 && off < 2e-3, "rms {rms}, median {median}, mean {off} off");
        }
    }
}

#[test]
fn a_planted_difference_of_the_water_is_found() {
    let (meshes, gpu) = (meshes(), gpu());
    let view = shore([112, 70], 1, LAKE, [0.0; 3]);
    let daylight = Lighting::towards(towards_sun(135.0, 35.0));
    let on_cpu = |water: Water, highlights: Highlights| {
        let forest = two(&meshes, Shading::Paper, &plants([0.0; 3]), None).with_water(water).unwrap();
        let fragments = forest.trace(&view, &|_| Ok(())).unwrap();
        let look = Look { highlights, ..Look::default() };
        forest.relight(&fragments, &daylight, &look, &even, &|_| Ok(())).unwrap()
    };
    let forest = two(&meshes, Shading::Paper, &plants([0.0; 3]), None).with_water(LAKE).unwrap();
    let sources = [LightSource::Even(EVEN), LightSource::Even(EVEN)];
    let mut lights = LightSet::load(&gpu, &sources, plants([0.0; 3]).len()).unwrap();
    let mut on_gpu = GpuForest::new(&gpu, &forest, &lights, settings()).unwrap();
    on_gpu.trace(&view).unwrap();
    let look = Look { highlights: GLOSSY, ..Look::default() };
    on_gpu.relight(&mut lights, &daylight, &look).unwrap();
    let found = on_gpu.picture().unwrap();
    let off = |water: Water| difference(&found, &on_cpu(water, GLOSSY), 0.0).0;
    let same = off(LAKE);
    for other in
        [Water { height_m: LAKE.height_m + 0.02, ..LAKE }, Water { color: [0.03, 0.07, 0.08], ..LAKE }, WAVY]
    {
        assert!(off(other) > 2.0 * same, "{other:?}: {} for {same}", off(other));
    }
    let waves = WAVY.waves.map(|waves| Waves { seed: 6, ..waves });
    let (one, other) = (on_cpu(WAVY, GLOSSY), on_cpu(Water { waves, ..LAKE }, GLOSSY));
    assert!(difference(&one, &other, 0.0).0 > 0.02, "other waves are another picture");
    let other = Highlights { water: Highlight::MATT, ..GLOSSY };
    let off = difference(&found, &on_cpu(LAKE, other), 0.0).0;
    assert!(off > 2.0 * same, "{off} for {same}");
}

#[test]
fn an_eye_below_the_water_is_refused_on_a_gpu_too() {
    let (meshes, gpu) = (meshes(), gpu());
    let forest = two(&meshes, Shading::Paper, &plants([0.0; 3]), None).with_water(LAKE).unwrap();
    let mut on_gpu = GpuForest::new(&gpu, &forest, &super::traced::dark(&gpu, 2), settings()).unwrap();
    let mut below = shore([16, 16], 1, LAKE, [0.0; 3]);
    below.eye.position_m[1] = 0.3;
    let error = on_gpu.trace(&below).expect_err("it is refused");
    assert!(matches!(error, ForestError::Render(RenderError::Underwater { .. })), "{error}");
}

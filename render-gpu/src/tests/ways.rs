//! All ways to find what a ray meets: what the CPU finds, whatever grids there are, and whichever were there before.

use flb_format::sun::towards_sun;
use flb_render::forest::{Forest, InstanceSearch, ModelSearch, Search};
use flb_render::{Indirect, Lighting, Look, Picture, Shading};
use flb_testkit::scenes::{hills, plane, stand, view};

use super::gpu;
use super::lit::difference;
use super::traced::{assert_agrees, compare_by, dark, meshes, settings, two};
use crate::models::Models;
use crate::statics::Statics;
use crate::{CameraHit, ForestError, ForestSettings, GpuForest};

/// Trees everywhere first.
pub(super) fn all() -> Vec<Search> {
    let both = [InstanceSearch::Tree, InstanceSearch::Grid];
    let by = |model| both.map(|primary| both.map(|shadow| Search { model, primary, shadow })).concat();
    [ModelSearch::Tree, ModelSearch::Grid].map(by).concat()
}

/// Between ways on one GPU, root mean square: they test the same triangles with the same numbers, but compilers may
/// round apart.
const SAME: f64 = 0.001;
/// Share of a picture's values that may be off by more than a twentieth from the CPU's: of rays that graze an edge.
const GRAZING: f64 = 1e-3;

fn by(search: Search) -> ForestSettings {
    ForestSettings { search, ..settings() }
}

#[test]
fn rays_meet_what_they_meet_on_the_cpu_by_any_way() {
    let meshes = meshes();
    let both = [&meshes[0], &meshes[1]];
    for middle in [[0.0; 3], [1_048_576.3, 211.7, -734_003.9]] {
        let instances = stand(13, 24.0, middle);
        let ground = (middle == [0.0; 3]).then(|| hills(60.0));
        let forest = two(&meshes, Shading::Paper, &instances, ground);
        let mut view = view([120, 90], 1, 26.0);
        let moved = |point: [f64; 3]| std::array::from_fn(|axis| point[axis] + middle[axis]);
        view.eye.position_m = moved(view.eye.position_m);
        view.eye.look_at_m = moved(view.eye.look_at_m);
        // How shadows are found does not matter here.
        for search in all().into_iter().filter(|search| search.shadow == InstanceSearch::Tree) {
            assert_agrees(&compare_by(by(search), &forest, &both, &instances, &view));
        }
    }
}

fn lit(forest: &Forest, search: Search, suns: &[[f64; 2]]) -> Vec<Picture> {
    let gpu = gpu();
    let mut lights = dark(&gpu, 2);
    let mut on_gpu = GpuForest::new(&gpu, forest, &lights, by(search)).unwrap();
    on_gpu.trace(&view([112, 70], 2, 30.0)).unwrap();
    let mut take = |[azimuth, elevation]: [f64; 2]| {
        let sun = towards_sun(azimuth, elevation);
        let daylight = Lighting::towards(sun);
        let look = Look { indirect: Indirect::Off, ..Look::default() };
        on_gpu.relight(&mut lights, &daylight, &look).unwrap();
        on_gpu.picture().unwrap()
    };
    suns.iter().map(|sun| take(*sun)).collect()
}

#[test]
fn shadows_are_those_of_the_cpu_by_any_way() {
    // A low sun needs a wider grid than the one before, and one overhead a square one.
    let suns = [[135.0, 50.0], [250.0, 6.0], [0.0, 90.0]];
    let (meshes, instances) = (meshes(), stand(17, 30.0, [0.0; 3]));
    for ground in [Some(plane()), None] {
        let forest = two(&meshes, Shading::Paper, &instances, ground);
        let fragments = forest.trace(&view([112, 70], 2, 30.0), &|_| Ok(())).unwrap();
        let expected = suns.map(|[azimuth, elevation]| {
            let sun = towards_sun(azimuth, elevation);
            let daylight = Lighting::towards(sun);
            let look = Look { indirect: Indirect::Off, ..Look::default() };
            forest.relight(&fragments, &daylight, &look, &|_, phi| *phi = [0.0; 3], &|_| Ok(())).unwrap()
        });
        let ways = all();
        let shadows = ways.iter().filter(|search| search.primary == InstanceSearch::Tree);
        let found: Vec<Vec<Picture>> = shadows.map(|search| lit(&forest, *search, &suns)).collect();
        for pictures in &found {
            for (sun, picture) in pictures.iter().enumerate() {
                assert!(difference(picture, &found[0][sun], 0.0).0 < SAME, "sun {sun}");
                assert!(difference(picture, &found[0][(sun + 1) % 3], 0.0).0 > 0.02, "any picture would do");
            }
        }
        for (picture, expected) in found[0].iter().zip(&expected) {
            let (a, b) = (picture.tone_mapped(0.0), expected.tone_mapped(0.0));
            let off = a.iter().zip(&b).filter(|(a, b)| a.abs_diff(**b) > 12).count();
            assert!(off as f64 <= GRAZING * a.len() as f64, "{off} of {}", a.len());
        }
    }
}

#[test]
fn grids_make_room_for_larger_ones() {
    let (meshes, instances) = (meshes(), stand(17, 30.0, [0.0; 3]));
    let forest = two(&meshes, Shading::Paper, &instances, Some(hills(50.0)));
    let gpu = gpu();
    let mut lights = dark(&gpu, 2);
    let grids = *all().last().expect("eight ways");
    let mut kept = GpuForest::new(&gpu, &forest, &lights, by(grids)).unwrap();
    let bare = kept.size_bytes()[0];
    let daylight = Lighting::towards(towards_sun(200.0, 20.0));
    for size in [[24, 16], [900, 90], [64, 64]] {
        let view = view(size, 1, 30.0);
        let mut take = |on_gpu: &mut GpuForest| {
            on_gpu.trace(&view).unwrap();
            on_gpu.relight(&mut lights, &daylight, &Look::default()).unwrap();
            (on_gpu.fragments().unwrap(), on_gpu.picture().unwrap())
        };
        let mut fresh = GpuForest::new(&gpu, &forest, &dark(&gpu, 2), by(grids)).unwrap();
        let (met, picture) = take(&mut kept);
        assert!((met.clone(), picture) == take(&mut fresh), "{size:?}");
        assert!(met.iter().filter(|met| matches!(met, CameraHit::Plant { .. })).count() > met.len() / 20);
    }
    assert!(kept.size_bytes()[0] > bare);
}

#[test]
fn grids_for_which_there_is_no_room_are_refused_with_both_numbers() {
    let gpu = flb_gpu::Gpu::open_alike(wgpu::Features::empty(), 4096, 1).unwrap().remove(0);
    let mut statics = Statics::new(&gpu, &Models::new()).unwrap();
    let still = statics.put(&gpu, 0, &[7; 100]).unwrap().first;
    let error = statics.put(&gpu, 100, &[7; 1000]).err().unwrap();
    let all = u64::from(4 * (still + 1100));
    assert!(matches!(error, ForestError::TooLarge { needed, limit: 4096, .. } if needed == all), "{error:?}");
    assert!(error.to_string().contains("grids"), "{error}");
}

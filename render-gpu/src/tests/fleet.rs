//! Several devices at one picture, here all on one adapter: the same picture to the bit, also where some are lost.

use flb_format::Codec;
use flb_format::light::SunBasis;
use flb_format::sun::towards_sun;
use flb_gpu::{DeviceError, Gpu};
use flb_render::forest::{Forest, View, Water};
use flb_render::{Lighting, Look, RenderError, Shading};
use flb_runtime::Library;
use flb_runtime::scene_light::SceneLight;
use flb_testkit::scenes::{hills, library, scene_light, stand, view};

use super::gpu;
use super::traced::{meshes, settings, two};
use super::ways;
use crate::{CameraHit, Fleet, ForestError, ForestSettings, GpuForest, LightSet, LightSource, PictureRect};

const NAMES: [&str; 2] = ["oak", "spruce"];

fn on(gpu: &Gpu, forest: &Forest, library: &Library, settings: ForestSettings) -> (GpuForest, LightSet) {
    let sources = [0, 1].map(|species| LightSource::Library { library, species });
    let lights = LightSet::load(gpu, &sources, forest.placements().len()).unwrap();
    (GpuForest::new(gpu, forest, &lights, settings).unwrap(), lights)
}

fn days() -> [Lighting; 2] {
    [[135.0, 35.0], [250.0, 12.0]]
        .map(|[azimuth, elevation]| Lighting::towards(towards_sun(azimuth, elevation)))
}

/// Counts as a fleet counts them.
fn counts(met: &[CameraHit]) -> [usize; 4] {
    let of = |is: fn(&CameraHit) -> bool| met.iter().filter(|met| is(met)).count();
    [
        of(|met| matches!(met, CameraHit::Plant { .. })),
        of(|met| matches!(met, CameraHit::Ground { .. })),
        of(|met| *met == CameraHit::Sky),
        of(|met| matches!(met, CameraHit::Water { .. })),
    ]
}

#[test]
fn many_gpus_draw_the_picture_of_one_to_the_bit() {
    let (meshes, instances) = (meshes(), stand(11, 22.0, [0.0; 3]));
    let library = library(&NAMES.map(|name| (name, None)), Codec::Classed);
    let water = Water { height_m: 0.35, color: [0.02, 0.06, 0.07], waves: None };
    let forest = two(&meshes, Shading::Paper, &instances, Some(hills(50.0))).with_water(water).unwrap();
    let light = SceneLight::load(&scene_light(&NAMES, Some(&SunBasis::Lattice18))).unwrap();
    let prepared = light.prepare(NAMES);
    // Trees everywhere, and grids everywhere.
    for search in [ways::all()[0], ways::all()[7]] {
        let settings = ForestSettings { search, ..settings() };
        let (mut alone, mut lights) = on(&gpu(), &forest, &library, settings);
        let mut fleet = Fleet::new([0, 1].map(|_| on(&gpu(), &forest, &library, settings))).unwrap();
        for (size, distance_m) in [([203, 117], 26.0), ([96, 64], 26.0), ([96, 64], 31.0)] {
            let view = view(size, 2, distance_m);
            alone.trace(&view).unwrap();
            fleet.trace(&view).unwrap();
            for (daylight, is_among) in days().iter().zip([false, true]) {
                let shade = prepared.at_sun(Some(daylight.daylight.towards_sun), &instances).unwrap();
                let shade = Some(&shade).filter(|_| is_among);
                alone.set_scene_light(shade).unwrap();
                alone.relight(&mut lights, daylight, &Look::default()).unwrap();
                fleet.set_scene_light(shade).unwrap();
                let found = fleet.relight(daylight, &Look::default()).unwrap();
                assert!(found == alone.picture().unwrap(), "{size:?}");
            }
            let counts = counts(&alone.fragments().unwrap());
            assert_eq!(fleet.counts().unwrap(), counts);
            // The water goes on to the horizon.
            assert!([0, 1, 3].iter().all(|kind| counts[*kind] > 100), "{counts:?}");
        }
        assert_eq!(fleet.light_bytes(), 2 * lights.size_bytes());
        assert_eq!(fleet.lost().count(), 0);
    }
}

#[test]
fn tiles_of_a_gpu_that_is_lost_are_drawn_by_the_others() {
    let (meshes, instances) = (meshes(), stand(7, 16.0, [0.0; 3]));
    let library = library(&NAMES.map(|name| (name, None)), Codec::Classed);
    let forest = two(&meshes, Shading::Paper, &instances, None);
    let view = view([128, 96], 1, 22.0);
    let (mut alone, mut lights) = on(&gpu(), &forest, &library, settings());
    alone.trace(&view).unwrap();
    let [first, second] = days().map(|daylight| {
        alone.relight(&mut lights, &daylight, &Look::default()).unwrap();
        (alone.picture().unwrap(), daylight)
    });
    let gpus = [gpu(), gpu(), gpu()];
    let mut fleet = Fleet::new(gpus.each_ref().map(|gpu| on(gpu, &forest, &library, settings()))).unwrap();
    fleet.trace(&view).unwrap();
    // One with tiles of its own.
    gpus[0].device.destroy();
    assert!(fleet.relight(&first.1, &Look::default()).unwrap() == first.0);
    assert_eq!(fleet.lost().map(|(number, _)| number).collect::<Vec<_>>(), [0]);
    // One in the midst of its tiles.
    let destroyed = std::thread::scope(|scope| {
        scope.spawn(|| gpus[1].device.destroy());
        fleet.trace(&view).and_then(|()| fleet.relight(&second.1, &Look::default()))
    });
    assert!(destroyed.unwrap() == second.0);
    assert!(fleet.relight(&first.1, &Look::default()).unwrap() == first.0);
    assert_eq!(fleet.lost().count(), 2);
    gpus[2].device.destroy();
    for error in [
        fleet.relight(&first.1, &Look::default()).map(|_| ()),
        fleet.trace(&view),
        fleet.counts().map(|_| ()),
    ] {
        let error = error.unwrap_err();
        assert!(matches!(error, ForestError::Device(DeviceError::Failed { .. })), "{error:?}");
    }
    assert_eq!(fleet.lost().count(), 3);
}

#[test]
fn what_no_gpu_can_draw_is_refused_at_once() {
    let error = Fleet::new([]).err().unwrap();
    assert!(matches!(error, ForestError::NoGpu), "{error:?}");
    assert!(error.to_string().contains("no GPU"), "{error}");
    let (meshes, instances) = (meshes(), stand(3, 8.0, [0.0; 3]));
    let library = library(&NAMES.map(|name| (name, None)), Codec::Classed);
    let forest = two(&meshes, Shading::Paper, &instances, None);
    let small = ForestSettings { fragment_bytes: 1000, ..settings() };
    let mut fleet = Fleet::new([0, 1].map(|_| on(&gpu(), &forest, &library, small))).unwrap();
    assert!(matches!(fleet.relight(&days()[0], &Look::default()), Err(ForestError::NotTraced)));
    assert!(matches!(fleet.counts(), Err(ForestError::NotTraced)));
    let error = fleet.trace(&view([64, 64], 1, 10.0)).unwrap_err();
    assert!(matches!(error, ForestError::TooLarge { limit: 1000, .. }), "{error:?}");
    let none = View { width: 0, ..view([64, 64], 1, 10.0) };
    assert!(matches!(fleet.trace(&none), Err(ForestError::Render(RenderError::Setting { .. }))));
    assert_eq!(fleet.lost().count(), 0);
    // A part that is none.
    let (mut alone, _) = on(&gpu(), &forest, &library, settings());
    let outside = PictureRect { left: 60, top: 0, width: 8, height: 8 };
    let error = alone.trace_part(&view([64, 64], 1, 10.0), outside).unwrap_err();
    assert!(error.to_string().contains("part"), "{error}");
}

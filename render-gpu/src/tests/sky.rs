//! Uneven skies: pictures as the CPU relights them, with coloured suns, on leaves and on solids, over ground and water.

use std::sync::Arc;

use flb_format::light::SunBasis;
use flb_format::sun::towards_sun;
use flb_format::{Codec, Daylight, Placement};
use flb_render::forest::View;
use flb_render::picture::PHYSICAL_EXPOSURE;
use flb_render::{Indirect, LightQuery, Lighting, Look, Picture, Shading, Surfaces};
use flb_runtime::light::SkyBeams;
use flb_runtime::scene_light::{SceneLight, SceneLightAtSun};
use flb_runtime::{Library, SpeciesLight};
use flb_scene::sky::Sky;
use flb_testkit::scenes::{hills, library, physical, plane, scene_light, stand, view};

use super::gpu;
use super::lit::{assert_alike, difference};
use super::traced::{meshes, settings, two};
use crate::{ForestError, GpuForest, LightSet, LightSource};

const NAMES: [&str; 2] = ["oak", "spruce"];

/// A clear sky over a sun, and its sun.
fn clear([azimuth, elevation]: [f64; 2]) -> Lighting {
    let towards_sun = towards_sun(azimuth, elevation);
    let sky = Sky::clear(towards_sun, 3.0).expect("a sun above the horizon");
    let sun_color = sky.sun().expect("a clear sky has a sun");
    let light = Lighting::of(Daylight { towards_sun, sun: 1.0, sky: 0.3 });
    Lighting { sun_color, dome: Some(sky), ..light }
}

fn lights(library: &Library) -> ([SpeciesLight<'static>; 2], Vec<Option<Arc<SkyBeams>>>) {
    let lights = [0, 1].map(|species| SpeciesLight::load(library, species).expect("a sound file"));
    let beams = |light: &SpeciesLight| Some(Arc::new(light.sky_beams().expect("a physical file")));
    let beams = lights.iter().map(beams).collect();
    (lights, beams)
}

/// A picture on each of the two, of plants that do this to each other's light.
fn both(
    (forest, view): (&flb_render::forest::Forest, &View),
    library: &Library,
    (lighting, look): (&Lighting, &Look),
    shade: Option<&SceneLightAtSun>,
) -> [Picture; 2] {
    let (species, beams) = lights(library);
    let sources = [0, 1].map(|species| LightSource::Library { library, species });
    let plants: Vec<Placement> = forest.placements().copied().collect();
    let gpu = gpu();
    let mut set = LightSet::load_for_skies(&gpu, &sources, &beams, plants.len()).expect("it fits");
    let mut on_gpu = GpuForest::new(&gpu, forest, &set, settings()).expect("it fits");
    on_gpu.set_scene_light(shade).expect("of the same plants");
    on_gpu.trace(view).expect("a view");
    on_gpu.relight(&mut set, lighting, look).expect("a daylight");
    let found = on_gpu.picture().expect("it is lit");

    let dome = lighting.dome.as_ref().expect("an uneven sky");
    let sky = |plant: &Placement| {
        beams[plant.species].as_ref().expect("of a file").sky(dome.patches(), &plant.transform)
    };
    let skies: Vec<_> = plants.iter().map(|plant| sky(plant).expect("a whole sky")).collect();
    let daylight = Daylight { sky: 0.0, ..lighting.daylight };
    let lit = |(number, plant): (u32, &Placement)| {
        let lit = species[plant.species].lit_by(&daylight, &plant.transform).expect("a sun");
        let lit = lit.with_sky(&skies[number as usize], lighting.sun_color).for_rays(view.samples);
        match shade {
            Some(shade) => lit.with_neighbours(shade, number).expect("three bands"),
            None => lit,
        }
    };
    let lit: Vec<_> = (0..).zip(&plants).map(lit).collect();
    let light = |LightQuery { instance, point, facing }: LightQuery, phi: &mut [f32; 3]| {
        lit[instance as usize].at_facing(point, facing, phi);
    };
    let fragments = forest.trace(view, &|_| Ok(())).expect("a view");
    [found, forest.relight(&fragments, lighting, look, &light, &|_| Ok(())).expect("a daylight")]
}

#[test]
fn pictures_under_a_clear_sky_are_those_of_the_cpu() {
    let meshes = meshes();
    let instances = stand(13, 25.0, [0.0; 3]);
    let suns = Some(SunBasis::Lattice18);
    let library = library(&NAMES.map(|name| (name, suns.clone())), Codec::Classed);
    for (ground, sun, indirect) in
        [(plane(), [135.0, 35.0], Indirect::On), (hills(50.0), [250.0, 12.0], Indirect::Only)]
    {
        let forest = two(&meshes, physical(), &instances, Some(ground));
        let view = view([112, 70], 4, 30.0);
        let lighting = clear(sun);
        let look = Look { indirect, ..Look::default() };
        let [found, expected] = both((&forest, &view), &library, (&lighting, &look), None);
        assert_alike(&found, &expected, PHYSICAL_EXPOSURE);
        // Under an even sky of the same fluence it is another picture.
        let fluence = lighting.dome.as_ref().expect("a sky").fluence().iter().sum::<f32>() / 3.0;
        let even = Lighting::of(Daylight { sky: fluence, ..lighting.daylight });
        let sources = [0, 1].map(|species| LightSource::Library { library: &library, species });
        let gpu = gpu();
        let mut set = LightSet::load(&gpu, &sources, instances.len()).expect("it fits");
        let mut on_gpu = GpuForest::new(&gpu, &forest, &set, settings()).expect("it fits");
        on_gpu.trace(&view).expect("a view");
        on_gpu.relight(&mut set, &even, &look).expect("a daylight");
        assert!(difference(&on_gpu.picture().expect("it is lit"), &expected, PHYSICAL_EXPOSURE).0 > 0.01);
    }
}

#[test]
fn pictures_of_harmonics_under_a_clear_sky_have_the_light_of_the_cpu() {
    let meshes = meshes();
    let instances = stand(9, 20.0, [0.0; 3]);
    let suns = Some(SunBasis::Harmonics { degree: 2, single: true, leaning: true });
    let library = library(&NAMES.map(|name| (name, suns.clone())), Codec::Classed);
    // Fields of the mean fluence: half of it falls on solids.
    let Shading::Physical(surfaces) = physical() else { panic!("a physical shading") };
    let shading = Shading::Physical(Surfaces { solid_offset_m: None, ..surfaces });
    let forest = two(&meshes, shading, &instances, Some(plane()));
    let view = view([96, 64], 4, 26.0);
    let look = Look { indirect: Indirect::Only, ..Look::default() };
    let [found, expected] = both((&forest, &view), &library, (&clear([135.0, 35.0]), &look), None);
    // Places of the sun's estimates depend on the last bits of a point, so single pixels differ by their noise and
    // means must not.
    let (rms, _) = difference(&found, &expected, PHYSICAL_EXPOSURE);
    let mean = |picture: &Picture, band: usize| {
        picture.rgb.chunks_exact(3).map(|rgb| f64::from(rgb[band])).sum::<f64>()
    };
    for band in 0..3 {
        let off = (mean(&found, band) / mean(&expected, band) - 1.0).abs();
        assert!(rms < 0.02 && off < 4e-3, "band {band}: rms {rms}, mean {off} off");
    }
}

#[test]
fn neighbours_do_to_an_uneven_sky_what_they_do_on_the_cpu() {
    let meshes = meshes();
    let instances = stand(13, 25.0, [0.0; 3]);
    let suns = Some(SunBasis::Lattice18);
    let library = library(&NAMES.map(|name| (name, suns.clone())), Codec::Classed);
    let scene_light =
        SceneLight::load(&scene_light(&NAMES, Some(&SunBasis::Lattice18))).expect("a sound file");
    let prepared = scene_light.prepare(NAMES);
    let lighting = clear([135.0, 35.0]);
    let shade = prepared.at_sun(Some(lighting.daylight.towards_sun), &instances).expect("its sun");
    let forest = two(&meshes, physical(), &instances, Some(plane()));
    let view = view([112, 70], 4, 30.0);
    let subject = (&forest, &view);
    let look = Look::default();
    let [found, expected] = both(subject, &library, (&lighting, &look), Some(&shade));
    assert_alike(&found, &expected, PHYSICAL_EXPOSURE);
    let [alone, _] = both(subject, &library, (&lighting, &look), None);
    assert!(difference(&alone, &expected, PHYSICAL_EXPOSURE).0 > 0.004, "a shade is seen");
}

#[test]
fn an_uneven_sky_over_the_shading_paper_is_refused_on_a_gpu_too() {
    let meshes = meshes();
    let instances = stand(2, 10.0, [0.0; 3]);
    let forest = two(&meshes, Shading::Paper, &instances, None);
    let gpu = gpu();
    let mut lights = super::traced::dark(&gpu, 2);
    let mut on_gpu = GpuForest::new(&gpu, &forest, &lights, settings()).expect("it fits");
    on_gpu.trace(&view([16, 16], 1, 20.0)).expect("a view");
    let refused = on_gpu.relight(&mut lights, &clear([135.0, 35.0]), &Look::default());
    assert!(matches!(refused, Err(ForestError::Render(_))), "{refused:?}");
}

#[test]
fn a_backdrop_is_drawn_as_on_the_cpu_over_plants_of_either_shading() {
    let meshes = meshes();
    let instances = stand(9, 20.0, [0.0; 3]);
    let gpu = gpu();
    let backdrop =
        Some(Sky::clear(towards_sun(20.0, 10.0), 6.0).expect("a sun above the horizon").times(0.7));
    for (shading, exposure, lighting) in [
        (Shading::Paper, 0.0, Lighting::of(Daylight { sky: 0.02, ..clear([135.0, 35.0]).daylight })),
        (physical(), PHYSICAL_EXPOSURE, clear([135.0, 35.0])),
    ] {
        let lighting = Lighting { backdrop: backdrop.clone(), ..lighting };
        let forest = two(&meshes, shading, &instances, Some(plane()));
        let mut lights = super::traced::dark(&gpu, 2);
        let mut on_gpu = GpuForest::new(&gpu, &forest, &lights, settings()).expect("it fits");
        let (view, look) = (view([112, 70], 4, 30.0), Look { indirect: Indirect::Off, ..Look::default() });
        on_gpu.trace(&view).expect("a view");
        on_gpu.relight(&mut lights, &lighting, &look).expect("a daylight");
        let fragments = forest.trace(&view, &|_| Ok(())).expect("a view");
        let on_cpu = |lighting: &Lighting| {
            forest.relight(&fragments, lighting, &look, &|_, _| {}, &|_| Ok(())).expect("a daylight")
        };
        let found = on_gpu.picture().expect("it is lit");
        assert_alike(&found, &on_cpu(&lighting), exposure);
        let without = on_cpu(&Lighting { backdrop: None, ..lighting });
        assert!(difference(&found, &without, exposure).0 > 0.01);
    }
}

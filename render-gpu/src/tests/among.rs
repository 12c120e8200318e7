//! Light among neighbours: as the CPU lights plants by the same shade, in both shadings, and with shades that plants
//! share.

use flb_format::light::SunBasis;
use flb_format::sun::towards_sun;
use flb_format::{Codec, Daylight, Placement};
use flb_render::forest::Forest;
use flb_render::picture::PHYSICAL_EXPOSURE;
use flb_render::{Indirect, LightQuery, Lighting, Look, Picture, Shading};
use flb_runtime::Library;
use flb_runtime::samplers::{PhysicalSampler, SpeciesSampler, offset};
use flb_runtime::scene_light::{
    Modulations, PreparedSceneLight, SceneFactor, SceneLight, SceneLightAtSun, TILTS,
};
use flb_scene::sampling::hash;
use flb_testkit::scenes::{library, physical, plane, scene_light, stand, view};

use super::gpu;
use super::lit::{assert_alike, difference, turned};
use super::traced::{dark, meshes, settings, two};
use crate::{ForestError, GpuForest, LightSet, LightSource};

const NAMES: [&str; 2] = ["oak", "spruce"];

/// Root mean square of a difference that a shade makes, at least: some times what processors differ by.
const SEEN: f64 = 0.004;

fn under<'l>(
    prepared: &'l PreparedSceneLight<'l>,
    daylight: &Lighting,
    placed: &'l [Placement],
) -> SceneLightAtSun<'l> {
    prepared
        .at_sun((daylight.daylight.towards_sun[1] > 0.0).then_some(daylight.daylight.towards_sun), placed)
        .unwrap()
}

/// A picture on the GPU under each of some lights of the day, each with its shade, and at last without one.
fn pictures(
    forest: &Forest,
    library: &Library,
    view: &flb_render::forest::View,
    look: &Look,
    cases: &[(Lighting, &SceneLightAtSun)],
) -> Vec<Picture> {
    let gpu = gpu();
    let sources = [0, 1].map(|species| LightSource::Library { library, species });
    let mut lights = LightSet::load(&gpu, &sources, forest.placements().len()).unwrap();
    let mut on_gpu = GpuForest::new(&gpu, forest, &lights, settings()).unwrap();
    on_gpu.trace(view).unwrap();
    let prepared = cases.iter().map(|(daylight, shade)| (daylight, Some(*shade)));
    let without = cases.last().map(|(daylight, _)| (daylight, None));
    let take = |(daylight, shade): (&Lighting, Option<&SceneLightAtSun>)| {
        on_gpu.set_scene_light(shade).unwrap();
        on_gpu.relight(&mut lights, daylight, look).unwrap();
        on_gpu.picture().unwrap()
    };
    prepared.chain(without).map(take).collect()
}

/// Writes light of an instance's file at a point of its model, for a sun and a sky of two strengths.
type Alone<'a> = dyn Fn(u32, [f32; 2], [f32; 3], &mut [f32; 3]) + Sync + 'a;

/// A picture on the CPU.
fn on_cpu(
    forest: &Forest,
    view: &flb_render::forest::View,
    (daylight, look): (&Lighting, &Look),
    shade: Option<&SceneLightAtSun>,
    alone: &Alone,
) -> Picture {
    let fragments = forest.trace(view, &|_| Ok(())).unwrap();
    let strength = forest.around().scenery(daylight, &Look::default(), [0.0; 3]).unwrap().sun_strength;
    let light = |LightQuery { instance, point, .. }: LightQuery, phi: &mut [f32; 3]| {
        let modulation = shade.map_or(Modulations::UNCHANGED, |shade| shade.at(instance, point));
        let left = [strength * modulation.sun.scale, daylight.daylight.sky * modulation.sky.scale];
        alone(instance, left, point, phi);
        modulation.add(strength, daylight.daylight.sky, phi);
    };
    forest.relight(&fragments, daylight, look, &light, &|_| Ok(())).unwrap()
}

#[test]
fn paper_pictures_among_neighbours_are_those_of_the_cpu() {
    let meshes = meshes();
    let instances = stand(13, 25.0, [0.0; 3]);
    let library = library(&NAMES.map(|name| (name, None)), Codec::Classed);
    let bases: Vec<u8> = (0..19).collect();
    let samplers = [0, 1].map(|species| SpeciesSampler::load(&library, species, &bases).unwrap());
    let light = SceneLight::load(&scene_light(&NAMES, Some(&SunBasis::Lattice18))).unwrap();
    let (prepared, placed) = (light.prepare(NAMES), instances.clone());
    let of_paper = SceneLight::load(&scene_light(&NAMES, None)).unwrap();
    let papers = of_paper.compared_with(SceneFactor::Empty).unwrap();
    let by_factor = papers.prepare(NAMES);
    let forest = two(&meshes, Shading::Paper, &instances, Some(plane()));
    let view = view([112, 70], 4, 30.0);
    let days = [[135.0, 35.0], [250.0, 12.0], [90.0, -10.0]]
        .map(|[azimuth, elevation]| Lighting::towards(towards_sun(azimuth, elevation)));
    let shades: Vec<_> = days
        .iter()
        .map(|daylight| under(&prepared, daylight, &placed))
        .chain(days.iter().map(|daylight| under(&by_factor, daylight, &placed)))
        .collect();
    let cases: Vec<_> = days.iter().chain(&days).cloned().zip(&shades).collect();
    let found = pictures(&forest, &library, &view, &Look::default(), &cases);
    let expected = |daylight: &Lighting, shade| {
        let alone = |instance: u32, [sun, sky]: [f32; 2], point: [f32; 3], phi: &mut [f32; 3]| {
            let placed = &instances[instance as usize];
            let blend = flb_format::sun::blend(turned(placed, daylight.daylight.towards_sun)).unwrap();
            samplers[placed.species].indirect(&blend, sun, sky, point, phi);
        };
        on_cpu(&forest, &view, (daylight, &Look::default()), shade, &alone)
    };
    for ((daylight, shade), found) in cases.iter().zip(&found) {
        assert_alike(found, &expected(daylight, Some(shade)), 0.0);
        // A shade is seen.
        assert!(difference(found, &expected(daylight, None), 0.0).0 > SEEN);
    }
    assert_alike(&found[cases.len()], &expected(&days[2], None), 0.0);
}

#[test]
fn physical_pictures_among_neighbours_that_share_volumes_are_those_of_the_cpu() {
    let meshes = meshes();
    // One species upright and turned each to another side, between two turns of it; one tilted, between three
    // directions.
    let mut instances = stand(2 * TILTS + 6, 50.0, [0.0; 3]);
    for one in instances.iter_mut().filter(|one| one.species == 1) {
        let (sin, cos) = (0.28, 0.96);
        let [x, y, z] = one.transform.rotation;
        let mix = |a: [f64; 3], b: [f64; 3], [s, c]: [f64; 2]| std::array::from_fn(|i| a[i] * c + b[i] * s);
        one.transform.rotation = [mix(x, y, [-sin, cos]), mix(y, x, [sin, cos]), z];
    }
    let library = library(&NAMES.map(|name| (name, Some(SunBasis::Lattice18))), Codec::Classed);
    let samplers = [0, 1].map(|species| PhysicalSampler::load(&library, species).unwrap());
    let light = SceneLight::load(&scene_light(&NAMES, Some(&SunBasis::Lattice18))).unwrap();
    let (prepared, mut placed) = (light.prepare(NAMES), instances.clone());
    // The light of one is its own.
    placed[3].species = NAMES.len();
    let forest = two(&meshes, physical(), &instances, Some(plane()));
    let view = view([112, 70], 4, 34.0);
    let sun = towards_sun(135.0, 35.0);
    let daylight = Lighting::of(Daylight { towards_sun: sun, sun: 1.0, sky: 0.3 });
    let look = Look { indirect: Indirect::Only, ..Look::default() };
    let shade = under(&prepared, &daylight, &placed);
    let flat = shade.flat();
    let between = |least| {
        flat.plants.iter().filter(|(_, blend)| blend.is_some_and(|blend| blend.weights[least] > 0.0)).count()
    };
    assert!(between(2) > TILTS - 10 && between(1) > between(2) + TILTS - 10, "{} {}", between(1), between(2));
    let found = pictures(&forest, &library, &view, &look, &[(daylight.clone(), &shade)]);
    let expected = |placed: &[Placement]| {
        let alone = |instance: u32, [sun, sky]: [f32; 2], point: [f32; 3], phi: &mut [f32; 3]| {
            let placed = &instances[instance as usize];
            let sampler = &samplers[placed.species];
            let terms = sampler.terms(turned(placed, daylight.daylight.towards_sun)).unwrap();
            sampler.fluence_of(&terms, Default::default(), sun, sky, point, phi);
        };
        on_cpu(&forest, &view, (&daylight, &look), Some(&under(&prepared, &daylight, placed)), &alone)
    };
    assert_alike(&found[0], &expected(&placed), PHYSICAL_EXPOSURE);
    // A plant that others are in the way of from another side is another picture.
    let same = difference(&found[0], &expected(&placed), PHYSICAL_EXPOSURE).0;
    placed.iter_mut().for_each(|plant| plant.transform.position_m[0] += 1.0);
    let other = difference(&found[0], &expected(&placed), PHYSICAL_EXPOSURE).0;
    // An H200 rounds more: rays that graze an edge fall on its other side more often.
    let times = if gpu().is_software { 4.0 } else { 2.0 };
    assert!(other > times * same, "{other} {same}");
}

#[test]
fn harmonics_among_neighbours_have_the_near_beam_of_the_cpu() {
    let meshes = meshes();
    let instances = stand(9, 20.0, [0.0; 3]);
    let suns = SunBasis::Harmonics { degree: 2, single: true, leaning: true };
    let library = library(&NAMES.map(|name| (name, Some(suns.clone()))), Codec::Classed);
    let samplers = [0, 1].map(|species| PhysicalSampler::load(&library, species).unwrap());
    let marchers = samplers.each_ref().map(PhysicalSampler::marcher);
    let light = SceneLight::load(&scene_light(&NAMES, Some(&suns))).unwrap();
    let (prepared, placed) = (light.prepare(NAMES), instances.clone());
    let forest = two(&meshes, physical(), &instances, Some(plane()));
    let view = view([96, 64], 4, 26.0);
    let sun = towards_sun(135.0, 35.0);
    let daylight = Lighting::of(Daylight { towards_sun: sun, sun: 1.0, sky: 0.3 });
    let look = Look { indirect: Indirect::Only, ..Look::default() };
    let shade = under(&prepared, &daylight, &placed);
    let found = pictures(&forest, &library, &view, &look, &[(daylight.clone(), &shade)]);
    let expected = |shade| {
        let alone = |instance: u32, [sun, sky]: [f32; 2], point: [f32; 3], phi: &mut [f32; 3]| {
            let placed = &instances[instance as usize];
            let (sampler, marcher) = (&samplers[placed.species], &marchers[placed.species]);
            let terms = sampler.terms(turned(placed, daylight.daylight.towards_sun)).unwrap();
            let seed = point.iter().fold(0, |seed, coordinate| hash(seed ^ coordinate.to_bits()));
            let near = marcher.near(point, terms.towards_sun, &[offset(seed, 0)]);
            sampler.fluence_of(&terms, near, sun, sky, point, phi);
        };
        on_cpu(&forest, &view, (&daylight, &look), shade, &alone)
    };
    // Places of estimates depend on the last bits of a point, so single pixels differ by their noise and means must
    // not.
    let mean = |picture: &Picture| picture.rgb.iter().map(|v| f64::from(*v)).sum::<f64>();
    let among = expected(Some(&shade));
    let (rms, _) = difference(&found[0], &among, PHYSICAL_EXPOSURE);
    let off = (mean(&found[0]) / mean(&among) - 1.0).abs();
    assert!(rms < 0.02 && off < 2e-3, "rms {rms}, mean {off} off");
    assert!((mean(&expected(None)) / mean(&among) - 1.0).abs() > 0.03);
}

#[test]
fn a_shade_of_other_plants_is_refused_and_forgotten_with_those_it_was_for() {
    let meshes = meshes();
    let instances = stand(5, 12.0, [0.0; 3]);
    let library = library(&NAMES.map(|name| (name, None)), Codec::Classed);
    let light = SceneLight::load(&scene_light(&NAMES, Some(&SunBasis::Lattice18))).unwrap();
    let (prepared, placed) = (light.prepare(NAMES), instances.clone());
    let daylight = Lighting::towards(towards_sun(135.0, 35.0));
    let mut forest = two(&meshes, Shading::Paper, &instances, Some(plane()));
    let gpu = gpu();
    let sources = [0, 1].map(|species| LightSource::Library { library: &library, species });
    let mut lights = LightSet::load(&gpu, &sources, instances.len()).unwrap();
    let mut on_gpu = GpuForest::new(&gpu, &forest, &lights, settings()).unwrap();
    let few = under(&prepared, &daylight, &placed[..4]);
    let error = on_gpu.set_scene_light(Some(&few)).unwrap_err();
    assert!(matches!(error, ForestError::Neighbours { found: 4, expected: 5 }), "{error:?}");
    assert_eq!(error.to_string(), "scene light for 4 plants, expected 5 as the forest has");
    let bare = on_gpu.size_bytes()[0];
    on_gpu.set_scene_light(Some(&under(&prepared, &daylight, &placed))).unwrap();
    assert!(on_gpu.size_bytes()[0] > bare);
    // The same plants, but put there anew.
    forest.set_instances(&instances).unwrap();
    on_gpu.set_instances(&forest).unwrap();
    assert_eq!(on_gpu.size_bytes()[0], bare);
    let view = view([64, 48], 1, 18.0);
    let mut take = |on_gpu: &mut GpuForest| {
        on_gpu.trace(&view).unwrap();
        on_gpu.relight(&mut lights, &daylight, &Look::default()).unwrap();
        on_gpu.picture().unwrap()
    };
    let without = take(&mut on_gpu);
    on_gpu.set_scene_light(Some(&under(&prepared, &daylight, &placed))).unwrap();
    assert!(take(&mut on_gpu) != without);
    // Light that is the same everywhere is no plant's.
    let mut even = dark(&gpu, 2);
    on_gpu.relight(&mut even, &daylight, &Look::default()).unwrap();
    let dark_among = on_gpu.picture().unwrap();
    on_gpu.set_scene_light(None).unwrap();
    on_gpu.relight(&mut even, &daylight, &Look::default()).unwrap();
    assert!(on_gpu.picture().unwrap() == dark_among);
}

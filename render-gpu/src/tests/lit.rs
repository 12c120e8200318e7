//! Pictures: as the CPU relights them, in both shadings, with light from files.

use flb_fixtures::PlantKind;
use flb_format::light::SunBasis;
use flb_format::sun::towards_sun;
use flb_format::{Codec, Daylight, Placement};
use flb_render::forest::{Forest, Search};
use flb_render::picture::PHYSICAL_EXPOSURE;
use flb_render::{Indirect, LightQuery, Lighting, Look, Picture, Shading, Species, Surfaces};
use flb_runtime::samplers::{PhysicalSampler, SpeciesSampler, offset};
use flb_scene::mesh::Filter;
use flb_scene::sampling::hash;
use flb_testkit::scenes::{self, CLASSES, hills, library, physical, plane, plant, stand, view};

use super::gpu;
use super::traced::{meshes, settings, two};
use crate::{ForestError, GpuForest, LightSet, LightSource, Show};

/// Root mean square of the difference of tone-mapped pictures. What there is of it comes from rays that graze an edge,
/// of a leaf or of a shadow: about one in some thousands falls on its other side.
const RMS: f64 = 0.002;
/// The middle of the differences: rounding alone.
const MEDIAN: f64 = 1.0 / 255.0;

pub(super) fn difference(a: &Picture, b: &Picture, exposure: f32) -> (f64, f64) {
    let (a, b) = (a.tone_mapped(exposure), b.tone_mapped(exposure));
    let mut all: Vec<f64> =
        a.iter().zip(&b).map(|(a, b)| (f64::from(*a) - f64::from(*b)).abs() / 255.0).collect();
    all.sort_by(f64::total_cmp);
    let rms = (all.iter().map(|d| d * d).sum::<f64>() / all.len() as f64).sqrt();
    println!("rms {rms:.5}, median {}, worst {}", all[all.len() / 2], all[all.len() - 1]);
    (rms, all[all.len() / 2])
}

#[track_caller]
pub(super) fn assert_alike(found: &Picture, expected: &Picture, exposure: f32) {
    let (rms, median) = difference(found, expected, exposure);
    assert!(rms < RMS && median < MEDIAN, "rms {rms}, median {median}");
    let bright = expected.rgb.iter().filter(|value| **value > 0.0).count();
    assert!(bright > expected.rgb.len() / 4, "the picture is black");
}

/// A direction of the world in an instance's own frame.
pub(super) fn turned(instance: &Placement, sun: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|column| (0..3).map(|row| instance.transform.rotation[row][column] * sun[row]).sum())
}

#[test]
fn paper_pictures_are_those_of_the_cpu() {
    let mut meshes = meshes();
    // Vertices of the second species have colours of their own.
    let tint =
        |vertex: usize| [0, 1, 2].map(|band| 0.25 + 0.75 * (hash(3 * vertex as u32 + band) % 7) as f32 / 6.0);
    meshes[1].colors = (0..meshes[1].positions.len()).map(tint).collect();
    // Leaves of the first one show single texels of a palette.
    let leaf = meshes[0].materials[1].color_texture.as_mut().expect("leaves have a texture");
    (leaf.filter, leaf.transform) = (Filter::Nearest, [[0.05, 0.02, 0.4], [0.01, 0.05, 0.4]]);
    let instances = stand(13, 25.0, [0.0; 3]);
    let library = library(&[("oak", None), ("spruce", None)], Codec::Classed);
    let sources = [0, 1].map(|species| LightSource::Library { library: &library, species });
    let bases: Vec<u8> = (0..19).collect();
    let samplers = [0, 1].map(|species| SpeciesSampler::load(&library, species, &bases).unwrap());
    let gpu = gpu();
    for (ground, most) in [(Some(plane()), 5), (Some(hills(50.0)), 2), (None, 1)] {
        let forest = two(&meshes, Shading::Paper, &instances, ground);
        let view = view([112, 70], 4, 30.0);
        let fragments = forest.trace(&view, &|_| Ok(())).unwrap();
        let mut lights = LightSet::load(&gpu, &sources, instances.len()).unwrap();
        let mut on_gpu = GpuForest::new(&gpu, &forest, &lights, settings()).unwrap();
        on_gpu.trace(&view).unwrap();
        // Fragments are traced once, for all suns and all parts of the light.
        let cases = [
            (towards_sun(135.0, 35.0), Indirect::On),
            (towards_sun(250.0, 12.0), Indirect::On),
            (towards_sun(135.0, 35.0), Indirect::Only),
            (towards_sun(135.0, 35.0), Indirect::Off),
            (towards_sun(90.0, -10.0), Indirect::On),
        ];
        for (sun, indirect) in cases.into_iter().take(most) {
            let daylight = Lighting::towards(sun);
            let look = Look { indirect, ..Look::default() };
            on_gpu.relight(&mut lights, &daylight, &look).unwrap();
            let found = on_gpu.picture().unwrap();
            let strength =
                forest.around().scenery(&daylight, &Look::default(), [0.0; 3]).unwrap().sun_strength;
            let light = |LightQuery { instance, point, .. }: LightQuery, phi: &mut [f32; 3]| {
                let placed = &instances[instance as usize];
                let blend = flb_format::sun::blend(turned(placed, sun)).unwrap();
                samplers[placed.species].indirect(&blend, strength, daylight.daylight.sky, point, phi);
            };
            let expected = forest.relight(&fragments, &daylight, &look, &light, &|_| Ok(())).unwrap();
            assert_alike(&found, &expected, 0.0);
        }
    }
}

#[test]
fn physical_pictures_are_those_of_the_cpu() {
    let meshes = meshes();
    let instances = stand(13, 25.0, [0.0; 3]);
    let suns = Some(SunBasis::Lattice18);
    let library = library(&[("oak", suns.clone()), ("spruce", suns)], Codec::Classed);
    let sources = [0, 1].map(|species| LightSource::Library { library: &library, species });
    let samplers = [0, 1].map(|species| PhysicalSampler::load(&library, species).unwrap());
    let gpu = gpu();
    let forest = two(&meshes, physical(), &instances, Some(plane()));
    let view = view([112, 70], 4, 30.0);
    let fragments = forest.trace(&view, &|_| Ok(())).unwrap();
    let mut lights = LightSet::load(&gpu, &sources, instances.len()).unwrap();
    let mut on_gpu = GpuForest::new(&gpu, &forest, &lights, settings()).unwrap();
    on_gpu.trace(&view).unwrap();
    for (sun, indirect) in
        [(towards_sun(135.0, 35.0), Indirect::On), (towards_sun(300.0, 60.0), Indirect::Only)]
    {
        let daylight = Lighting::of(Daylight { towards_sun: sun, sun: 1.0, sky: 0.3 });
        let look = Look { indirect, ..Look::default() };
        on_gpu.relight(&mut lights, &daylight, &look).unwrap();
        let light = |LightQuery { instance, point, .. }: LightQuery, phi: &mut [f32; 3]| {
            let placed = &instances[instance as usize];
            let sampler = &samplers[placed.species];
            let terms = sampler.terms(turned(placed, sun)).unwrap();
            sampler.fluence_of(&terms, Default::default(), 1.0, daylight.daylight.sky, point, phi);
        };
        let expected = forest.relight(&fragments, &daylight, &look, &light, &|_| Ok(())).unwrap();
        assert_alike(&on_gpu.picture().unwrap(), &expected, PHYSICAL_EXPOSURE);
    }
}

#[test]
fn harmonics_are_lit_with_the_near_beam_as_on_the_cpu() {
    let meshes = meshes();
    let instances = stand(9, 20.0, [0.0; 3]);
    let suns = Some(SunBasis::Harmonics { degree: 2, single: true, leaning: true });
    let library = library(&[("oak", suns.clone()), ("spruce", suns)], Codec::Classed);
    let sources = [0, 1].map(|species| LightSource::Library { library: &library, species });
    let samplers = [0, 1].map(|species| PhysicalSampler::load(&library, species).unwrap());
    let marchers = samplers.each_ref().map(PhysicalSampler::marcher);
    let gpu = gpu();
    // Fields of the mean fluence: half of it falls on solids.
    let Shading::Physical(surfaces) = physical() else { panic!("a physical shading") };
    let shading = Shading::Physical(Surfaces { solid_offset_m: None, ..surfaces });
    let forest = two(&meshes, shading, &instances, Some(plane()));
    let view = view([96, 64], 4, 26.0);
    let fragments = forest.trace(&view, &|_| Ok(())).unwrap();
    let mut lights = LightSet::load(&gpu, &sources, instances.len()).unwrap();
    let mut on_gpu = GpuForest::new(&gpu, &forest, &lights, settings()).unwrap();
    on_gpu.trace(&view).unwrap();
    let sun = towards_sun(135.0, 35.0);
    let daylight = Lighting::of(Daylight { towards_sun: sun, sun: 1.0, sky: 0.3 });
    let look = Look { indirect: Indirect::Only, ..Look::default() };
    on_gpu.relight(&mut lights, &daylight, &look).unwrap();
    let found = on_gpu.picture().unwrap();
    let light = |LightQuery { instance, point, .. }: LightQuery, phi: &mut [f32; 3]| {
        let placed = &instances[instance as usize];
        let (sampler, marcher) = (&samplers[placed.species], &marchers[placed.species]);
        let terms = sampler.terms(turned(placed, sun)).unwrap();
        let seed = point.iter().fold(0, |seed, coordinate| hash(seed ^ coordinate.to_bits()));
        let near = marcher.near(point, terms.towards_sun, &[offset(seed, 0)]);
        sampler.fluence_of(&terms, near, 1.0, daylight.daylight.sky, point, phi);
    };
    let expected = forest.relight(&fragments, &daylight, &look, &light, &|_| Ok(())).unwrap();
    // Places of estimates depend on the last bits of a point, so single pixels differ by their noise and means must
    // not.
    let (rms, _) = difference(&found, &expected, PHYSICAL_EXPOSURE);
    let mean = |picture: &Picture| picture.rgb.iter().map(|v| f64::from(*v)).sum::<f64>();
    let off = (mean(&found) / mean(&expected) - 1.0).abs();
    assert!(rms < 0.02 && off < 2e-3, "rms {rms}, mean {off} off");
    // Without the near beam it would be another picture.
    let dark = |LightQuery { instance, point, .. }: LightQuery, phi: &mut [f32; 3]| {
        let placed = &instances[instance as usize];
        let terms = samplers[placed.species].terms(turned(placed, sun)).unwrap();
        let none = Default::default();
        samplers[placed.species].fluence_of(&terms, none, 1.0, daylight.daylight.sky, point, phi);
    };
    let other = forest.relight(&fragments, &daylight, &look, &dark, &|_| Ok(())).unwrap();
    assert!((mean(&other) / mean(&expected) - 1.0).abs() > 0.05);
}

#[test]
fn a_planted_difference_of_light_is_found() {
    let meshes = meshes();
    let instances = stand(5, 12.0, [0.0; 3]);
    let forest = two(&meshes, Shading::Paper, &instances, Some(plane()));
    let gpu = gpu();
    let view = view([96, 64], 1, 18.0);
    let pictures = [0.3f32, 0.33].map(|light| {
        let mut lights =
            LightSet::load(&gpu, &[LightSource::Even([light; 3]), LightSource::Even([light; 3])], 1).unwrap();
        let mut on_gpu = GpuForest::new(&gpu, &forest, &lights, settings()).unwrap();
        on_gpu.trace(&view).unwrap();
        on_gpu.relight(&mut lights, &Lighting::towards(towards_sun(135.0, 35.0)), &Look::default()).unwrap();
        on_gpu.picture().unwrap()
    });
    let fragments = forest.trace(&view, &|_| Ok(())).unwrap();
    let light = |_: LightQuery, phi: &mut [f32; 3]| *phi = [0.3; 3];
    let daylight = Lighting::towards(towards_sun(135.0, 35.0));
    let expected = forest.relight(&fragments, &daylight, &Look::default(), &light, &|_| Ok(())).unwrap();
    let [same, other] = pictures.each_ref().map(|picture| difference(picture, &expected, 0.0).0);
    assert!(same < 2.0 * RMS && other > 1.5 * same, "{same} {other}");
}

#[test]
fn another_camera_sees_another_picture_and_the_same_one_the_same() {
    let meshes = meshes();
    let instances = stand(5, 12.0, [0.0; 3]);
    let forest = two(&meshes, Shading::Paper, &instances, Some(plane()));
    let gpu = gpu();
    let mut lights = super::traced::dark(&gpu, 2);
    let mut on_gpu = GpuForest::new(&gpu, &forest, &lights, settings()).unwrap();
    let mut shoot = |distance_m: f64| {
        on_gpu.trace(&view([64, 48], 1, distance_m)).unwrap();
        assert!(matches!(on_gpu.picture(), Err(ForestError::NotTraced)), "it is not lit yet");
        on_gpu.relight(&mut lights, &Lighting::default(), &Look::default()).unwrap();
        on_gpu.picture().unwrap()
    };
    let (first, second, again) = (shoot(18.0), shoot(22.0), shoot(18.0));
    assert!(first == again && first != second);
    on_gpu.set_show(Show::Instances);
    on_gpu.relight(&mut lights, &Lighting::default(), &Look::default()).unwrap();
    assert!(on_gpu.picture().unwrap() != again);
}

#[test]
fn species_that_no_shader_lights_are_refused_by_name() {
    let gpu = gpu();
    let raw = library(&[("elm", None)], Codec::RawF32);
    let error = LightSet::load(&gpu, &[LightSource::Library { library: &raw, species: 0 }], 1).err().unwrap();
    assert!(matches!(error, ForestError::Unlit { .. }), "{error:?}");
    for part in ["elm", "raw-f32", "on the CPU"] {
        assert!(error.to_string().contains(part), "{error}");
    }
    let error = LightSet::load(&gpu, &[LightSource::Library { library: &raw, species: 7 }], 1).err().unwrap();
    assert!(error.to_string().contains('7'), "{error}");
}

#[test]
fn one_plant_alone_is_lit_too() {
    // A tree whose first box holds the items themselves, in the stand; and a mesh without normals, with bark without an
    // image.
    let mut mesh = plant(PlantKind::Shrub, 500);
    mesh.normals.clear();
    mesh.materials[0].color_texture = None;
    let instances = [Placement { species: 0, transform: stand(1, 1.0, [0.0; 3])[0].transform }];
    let species = [Species { mesh: &mesh, classes: &CLASSES, shading: Shading::Paper }];
    let forest = Forest::prepare(&species, &instances, Some(plane()), Search::default()).unwrap();
    let gpu = gpu();
    let mut lights = LightSet::load(&gpu, &[LightSource::Even([0.3; 3])], 1).unwrap();
    let mut on_gpu = GpuForest::new(&gpu, &forest, &lights, settings()).unwrap();
    let mut view = scenes::view([64, 64], 4, 4.0);
    view.eye.look_at_m = [0.0, 0.6, 0.0];
    on_gpu.trace(&view).unwrap();
    let daylight = Lighting::towards(towards_sun(200.0, 40.0));
    on_gpu.relight(&mut lights, &daylight, &Look::default()).unwrap();
    let fragments = forest.trace(&view, &|_| Ok(())).unwrap();
    let light = |_: LightQuery, phi: &mut [f32; 3]| *phi = [0.3; 3];
    let expected = forest.relight(&fragments, &daylight, &Look::default(), &light, &|_| Ok(())).unwrap();
    let (rms, median) = difference(&on_gpu.picture().unwrap(), &expected, 0.0);
    assert!(rms < 2.0 * RMS && median < MEDIAN);
}

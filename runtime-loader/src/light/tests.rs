//! The one light against its parts, for every kind of suns, from files and from what is loaded.

use std::sync::Arc;

use flb_format::beam::BEAM_RAYS;
use flb_format::light::SunBasis;
use flb_format::meta::LeftOut;
use flb_format::sun::{self, directions::SunDirections, towards_sun};
use flb_format::{Codec, Placement, SpeciesFields, Transform};
use flb_packer::{EncodeSettings, encode_species, write_library_to};

use super::*;
use crate::near_beam::{Marcher, RayOffsets, seed_of};
use crate::physical::PhysicalSampler;
use crate::plants;
use crate::plants::{BANDS, noise, plant};
use crate::residency::{ResidencySettings, UnitId};
use crate::resident::{LightLevel, Resident};
use crate::sampler::{SpeciesSampler, bases_needed};
use crate::scene_light::tests::{alone, coarse, scene};
use crate::scene_light::{PreparedSceneLight, SceneLight, SceneLightAtSun};
use crate::stream::Stage;

mod cursors;
mod errors;
mod golden;
mod sky;

const LATTICE: u32 = 16;
/// Between a cursor and a sum in another order: of lights of up to 10, whose harmonics are larger than they.
const ROUNDING: f32 = 1e-4;

/// `None` is the model `paper`.
fn kinds() -> Vec<Option<SunBasis>> {
    let corners = [
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 0.0, -1.0],
    ];
    let mut triangles =
        [[0, 2, 4], [0, 5, 2], [0, 3, 5], [0, 4, 3], [1, 4, 2], [1, 2, 5], [1, 5, 3], [1, 3, 4]];
    triangles.sort_unstable();
    let list =
        SunDirections::new(corners.to_vec(), triangles.to_vec()).expect("an octahedron covers the sphere");
    let harmonics = [(1, false), (2, false), (2, true), (3, true)];
    let harmonics =
        harmonics.map(|(degree, single)| Some(SunBasis::Harmonics { degree, single, leaning: true }));
    [None, Some(SunBasis::Lattice18), Some(SunBasis::Directions(list.into()))]
        .into_iter()
        .chain(harmonics)
        .collect()
}

fn library(fields: &SpeciesFields, codec: Codec) -> Arc<Library> {
    if codec.is_near_geometry() {
        return plants::library(std::slice::from_ref(fields), codec);
    }
    let encoded = encode_species(fields, &EncodeSettings { codec, ..EncodeSettings::default() }, &|_| Ok(()));
    let mut bytes = Vec::new();
    write_library_to(&mut bytes, &[&encoded.expect("good fields")]).expect("memory takes it");
    Arc::new(Library::from_source("plants.flb", Box::new(bytes)).expect("it opens"))
}

/// All that a library has, as a streamer would have loaded it.
fn resident(library: &Arc<Library>) -> Resident {
    let stage = Stage::new(Arc::clone(library), ResidencySettings::default()).expect("coded near geometry");
    let units = Arc::clone(stage.residency().units());
    let mut resident = Resident::new(library.container(), &units);
    for unit in units.all().collect::<Vec<UnitId>>() {
        for job in crate::stream::jobs(library.container(), &units, &resident, &[unit]) {
            for (unit, outcome) in stage.read(&job) {
                resident.insert(&units, unit, outcome.expect("a sound file")).expect("a sound page");
            }
        }
    }
    resident
}

/// About the vertical and an axis of the level.
fn tilted() -> Transform {
    let ([a, b], [c, d]) = ([0.6, 0.8], [0.28, 0.96]);
    let rotation = [[a, -b * c, b * d], [0.0, d, c], [-b, -a * c, a * d]];
    Transform { rotation, position_m: [30.0, 1.0, -7.0], scale: 1.5 }
}

fn days() -> [Daylight; 4] {
    let day = Daylight { towards_sun: towards_sun(130.0, 35.0), sun: 1.3, sky: 0.2 };
    let huge = towards_sun(90.0, 90.0).map(|c| 1e150 * c);
    [
        day,
        Daylight { sky: 0.0, towards_sun: huge, ..day },
        Daylight { sun: 0.0, ..day },
        Daylight { sun: 0.0, sky: 0.0, ..day },
    ]
}

fn point(seed: u32) -> [f32; 3] {
    let along = |axis: u32| noise(seed * 3 + axis, 77);
    [along(0) * 5.0 - 2.5, along(1) * 5.0 - 0.5, along(2) * 5.0 - 2.5]
}

fn light(lit: &InstanceLight, point: [f32; 3]) -> [f32; BANDS] {
    let mut out = [f32::NAN; BANDS];
    lit.at(point, &mut out);
    out
}

/// The parts of a file, put together by hand.
enum Parts {
    Paper(Box<SpeciesSampler>),
    Physical(Box<(PhysicalSampler, Marcher<'static>)>),
}

impl Parts {
    fn load(library: &Library) -> Parts {
        match library.container().species()[0].meta.physical() {
            None => Parts::Paper(Box::new(
                SpeciesSampler::load(library, 0, &(0..19).collect::<Vec<_>>()).expect("it loads"),
            )),
            Some(_) => {
                let sampler = PhysicalSampler::load(library, 0).expect("it loads");
                let marcher = sampler.marcher();
                Parts::Physical(Box::new((sampler, marcher)))
            }
        }
    }

    fn light(&self, towards_sun: [f64; 3], [sun, sky]: [f32; 2], rays: u32, point: [f32; 3]) -> [f32; BANDS] {
        let mut out = [0.0; BANDS];
        match self {
            Parts::Paper(sampler) => {
                let blend = sun::blend(towards_sun).expect("a direction");
                sampler.indirect(&blend, sun, sky, point, &mut out);
            }
            Parts::Physical(physical) => {
                let (sampler, marcher) = &**physical;
                let terms = sampler.terms(towards_sun).expect("a direction");
                let near = match sampler.suns().first_near_item() {
                    Some(_) => RayOffsets::new(rays)
                        .with(seed_of(point), |offsets| marcher.near(point, terms.towards_sun, offsets)),
                    None => Default::default(),
                };
                sampler.fluence_of(&terms, near, sun, sky, point, &mut out);
            }
        }
        out
    }
}

#[test]
fn light_of_a_file_is_that_of_its_parts_to_the_bit() {
    for (suns, codec) in kinds().into_iter().flat_map(|suns| Codec::ALL.map(|codec| (suns.clone(), codec))) {
        let library = library(&plant("oak", suns.as_ref(), LATTICE, 3), codec);
        let (species, parts) = (SpeciesLight::load(&library, 0).expect("it loads"), Parts::load(&library));
        for (daylight, stands) in
            days().into_iter().flat_map(|day| [(day, tilted()), (day, Transform::IDENTITY)])
        {
            let towards_sun = stands.model_from_world_direction(daylight.towards_sun);
            for rays in [1, 4] {
                let lit = species.lit_by(&daylight, &stands).expect("a sun").for_rays(rays);
                for at in (0..40).map(point) {
                    let expected = parts.light(towards_sun, [daylight.sun, daylight.sky], rays, at);
                    let mut found = light(&lit, at);
                    if rays > 1 && suns.is_some() {
                        // The mean over a pixel is bounded, and not each ray.
                        found = found.map(|value| value.max(0.0));
                    }
                    assert_eq!(found, expected, "{suns:?} {codec:?} {daylight:?}");
                }
            }
        }
    }
}

#[test]
fn the_sky_alone_is_the_sampler_s_sky_times_its_strength() {
    for codec in Codec::ALL {
        let night = days()[2];
        let library = library(&plant("oak", Some(&SunBasis::Lattice18), LATTICE, 3), codec);
        let (species, sampler) =
            (SpeciesLight::load(&library, 0).expect("it loads"), PhysicalSampler::load(&library, 0));
        let (lit, sampler) = (species.lit_by(&night, &tilted()).expect("a sky"), sampler.expect("it loads"));
        for at in (0..40).map(point) {
            let mut expected = [0.0; BANDS];
            sampler.sky(at, &mut expected);
            let found = light(&lit, at);
            let is_near = |(a, b): (&f32, f32)| (a - b * night.sky).abs() <= 1e-6 * b.max(1.0);
            assert!(found.iter().zip(expected).all(is_near), "{codec:?}: {found:?} for {expected:?}");
        }
    }
}

#[test]
fn a_prepared_sun_is_that_of_the_sampler_to_the_bit() {
    for suns in kinds().into_iter().flatten() {
        let library = library(&plant("oak", Some(&suns), LATTICE, 3), Codec::Classed);
        let (species, daylight) = (SpeciesLight::load(&library, 0).expect("it loads"), days()[0]);
        let lit = species.lit_by_in_model(&daylight).expect("a sun").prepared();
        let near = species.near();
        let by_shared = species.lit_by_in_model(&daylight).expect("a sun").prepared_by(near.as_ref());
        assert_eq!(by_shared.prepared_sun(), lit.prepared_sun());
        let sampler = PhysicalSampler::load(&library, 0).expect("it loads");
        let terms = sampler.terms(daylight.towards_sun).expect("a direction");
        let prepared = sampler.prepare(&sampler.near(), terms, BEAM_RAYS);
        for at in (0..60).map(point) {
            let mut expected = [0.0; BANDS];
            sampler.fluence(&prepared, daylight.sun, daylight.sky, at, &mut expected);
            assert_eq!(light(&lit, at), expected, "{suns:?}");
        }
    }
}

#[test]
fn streamed_light_is_that_of_the_file_to_the_bit() {
    for (suns, codec) in
        kinds().into_iter().flat_map(|suns| [(suns.clone(), Codec::Classed), (suns, Codec::Haar)])
    {
        let library = library(&plant("oak", suns.as_ref(), LATTICE, 3), codec);
        let resident = resident(&library);
        let loaded = resident.species(0);
        let (streamed, file) =
            (SpeciesLight::streamed(loaded), SpeciesLight::load(&library, 0).expect("it loads"));
        for daylight in days() {
            let daylight = Daylight { towards_sun: towards_sun(200.0, 50.0), ..daylight };
            let lit = streamed.lit_by(&daylight, &tilted()).expect("a sun");
            let of_file = file.lit_by(&daylight, &tilted()).expect("a sun");
            assert_eq!((lit.level(), of_file.level()), (LightLevel::Whole, LightLevel::Whole));
            let sun = tilted().model_from_world_direction(daylight.towards_sun);
            let terms = loaded.terms(sun, daylight.sun, daylight.sky);
            assert_eq!(lit.terms(), &terms);
            assert_eq!(of_file.terms(), &terms);
            for at in (0..40).map(point) {
                let near = RayOffsets::new(1)
                    .with(seed_of(at), |offsets| loaded.near(at, terms.towards_sun(), offsets));
                let mut expected = [0.0; BANDS];
                loaded.light(&terms, near, at, &mut expected);
                assert_eq!(light(&lit, at), expected, "{suns:?} {codec:?}");
                assert_eq!(light(&of_file, at), expected, "{suns:?} {codec:?}");
            }
        }
    }
}

/// Scene light in which others leave two fifths of the sun and of the sky, or bring three tenths.
fn scene_light(of_scene: f32) -> SceneLight {
    let entries = [coarse(&alone(), 0.5), coarse(&scene(), of_scene)];
    SceneLight::load(&plants::library(&entries, Codec::RawF32)).expect("scene light")
}

/// Nearer to the middle, where the plant is.
fn inside([x, y, z]: [f32; 3]) -> [f32; 3] {
    [0.4 * x, 1.2 + 0.4 * y, 0.4 * z]
}

fn shade<'l>(prepared: &'l PreparedSceneLight<'l>, placed: &'l [Placement]) -> SceneLightAtSun<'l> {
    prepared.at_sun(Some(towards_sun(130.0, 35.0)), placed).expect("a sun")
}

#[test]
fn scene_light_is_counted_as_pictures_count_it() {
    let placed = [
        Placement { species: 1, transform: tilted() },
        Placement { species: 0, transform: Transform::IDENTITY },
    ];
    let daylight = days()[0];
    let [sun, sky] = [daylight.sun, daylight.sky];
    for (suns, of_scene) in kinds().into_iter().flat_map(|suns| [(suns.clone(), 0.2), (suns, 0.8)]) {
        let scene_light = scene_light(of_scene);
        let prepared = scene_light.prepare(["oak", "ash"]);
        let shade = shade(&prepared, &placed);
        let library = library(&plant("oak", suns.as_ref(), LATTICE, 3), Codec::Classed);
        let (file, parts) = (SpeciesLight::load(&library, 0).expect("it loads"), Parts::load(&library));
        let resident = resident(&library);
        let streamed = SpeciesLight::streamed(resident.species(0));
        let among = |light: &SpeciesLight, at| {
            let lit =
                light.lit_by(&daylight, &Transform::IDENTITY).expect("a sun").with_neighbours(&shade, 1);
            self::light(&lit.expect("three bands"), at)
        };
        let mut changed = 0;
        for at in (0..40).map(|seed| inside(point(seed))) {
            let modulation = shade.at(1, at);
            changed += usize::from(modulation != crate::scene_light::Modulations::UNCHANGED);
            // Each strength is scaled before the sum.
            let strengths = [sun * modulation.sun.scale, sky * modulation.sky.scale];
            let mut expected = parts.light(daylight.towards_sun, strengths, 1, at);
            modulation.add(sun, sky, &mut expected);
            assert_eq!(among(&file, at), expected, "{suns:?}");
            assert_eq!(among(&streamed, at), expected, "{suns:?}");
        }
        assert!(changed > 30, "{changed} of 40 points have neighbours");
        // One whose light others do not change.
        let lone = file.lit_by(&daylight, &tilted()).expect("a sun");
        let expected = light(&lone, point(5));
        assert_eq!(light(&lone.with_neighbours(&shade, 0).expect("three bands"), point(5)), expected);
    }
}

#[test]
fn a_cursor_has_the_light_of_the_plain_way_but_for_rounding_whatever_was_asked_before() {
    let placed = [Placement { species: 0, transform: Transform::IDENTITY }];
    let scene_light = scene_light(0.2);
    let prepared = scene_light.prepare(["oak", "ash"]);
    let shade = shade(&prepared, &placed);
    // Steps of a walk, then anywhere.
    let walk = |seed: u32| if seed < 60 { point(7).map(|c| c + 0.01 * seed as f32) } else { point(seed) };
    for (suns, codec) in
        kinds().into_iter().flat_map(|suns| [Codec::Classed, Codec::RawF32].map(|c| (suns.clone(), c)))
    {
        let library = library(&plant("oak", suns.as_ref(), LATTICE, 3), codec);
        let file = SpeciesLight::load(&library, 0).expect("it loads");
        let resident = codec.is_near_geometry().then(|| resident(&library));
        let streamed = resident.as_ref().map(|resident| SpeciesLight::streamed(resident.species(0)));
        for (species, daylight) in
            [Some(file), streamed].iter().flatten().flat_map(|s| days().map(|day| (s, day)))
        {
            let daylight = Daylight { towards_sun: towards_sun(200.0, 50.0), ..daylight };
            let lit = || species.lit_by(&daylight, &Transform::IDENTITY).expect("a sun");
            for lit in [lit(), lit().prepared(), lit().with_neighbours(&shade, 0).expect("three bands")] {
                let (mut cursor, mut other) = (lit.cursor(), lit.cursor());
                for seed in 0..100 {
                    let (mut found, expected) = ([f32::NAN; BANDS], light(&lit, walk(seed)));
                    cursor.at(walk(seed), &mut found);
                    for (found, expected) in found.into_iter().zip(expected) {
                        let near = (found - expected).abs() < ROUNDING * expected.max(1.0);
                        assert!(near, "{suns:?} {codec:?}: {found} for {expected}");
                    }
                    let mut again = [f32::NAN; BANDS];
                    other.at(walk(99 - seed), &mut again);
                    cursor.at(walk(99 - seed), &mut found);
                    assert_eq!(again, found, "{suns:?} {codec:?}: the same whatever was asked before");
                    cursor.at(walk(seed), &mut found);
                }
                if !codec.is_near_geometry() {
                    let mut found = [f32::NAN; BANDS];
                    cursor.at(point(3), &mut found);
                    assert_eq!(found, light(&lit, point(3)), "uncoded fields are asked as ever");
                }
            }
        }
    }
}

#[test]
fn threads_share_one_light() {
    let library = library(
        &plant("oak", Some(&SunBasis::Harmonics { degree: 2, single: true, leaning: true }), LATTICE, 3),
        Codec::Classed,
    );
    let species = SpeciesLight::load(&library, 0).expect("it loads");
    let lit = species.lit_by(&days()[0], &tilted()).expect("a sun");
    let expected: Vec<_> = (0..50).map(|seed| light(&lit, point(seed))).collect();
    let shared = species.lit_by(&days()[0], &tilted()).expect("a sun");
    std::thread::scope(|scope| {
        let all = || (0..50).map(|seed| light(&shared, point(seed))).collect::<Vec<_>>();
        let threads = [0; 4].map(|_| scope.spawn(all));
        threads.into_iter().for_each(|thread| assert_eq!(thread.join().expect("no panic"), expected));
    });
}

/// Wind: the higher and the farther from the stem, the farther a point goes.
fn blown([x, y, z]: [f32; 3], phase: f32) -> [f32; 3] {
    let sway = 0.05 * y * libm::sinf(phase + 3.0 * x);
    [x + sway, y - 0.2 * sway * sway, z + 0.5 * sway]
}

#[test]
fn a_leaf_asked_for_at_rest_keeps_its_light_in_the_wind_and_in_every_level_of_detail() {
    let library = library(
        &plant("oak", Some(&SunBasis::Harmonics { degree: 2, single: true, leaning: true }), LATTICE, 3),
        Codec::Classed,
    );
    let species = SpeciesLight::load(&library, 0).expect("it loads");
    let lit = species.lit_by(&days()[0], &tilted()).expect("a sun");
    let rest: Vec<[f32; 3]> = (0..64).map(point).collect();
    let still: Vec<_> = rest.iter().map(|at| light(&lit, *at)).collect();
    let mut changed = 0;
    for frame in 0..8 {
        // What a vertex shader hands on: where the vertex is, and where it is at rest.
        let moved = rest.iter().map(|rest| (blown(*rest, frame as f32), *rest));
        for ((posed, rest), still) in moved.zip(&still) {
            assert_eq!(light(&lit, rest), *still, "the leaf keeps its light");
            changed += usize::from(light(&lit, posed) != *still);
        }
    }
    assert!(changed > 200, "where it is blown to, the light is another: {changed} of 512");
    // Every fourth vertex, and a corner of a coarse triangle where a fine one had its middle: the field knows no mesh.
    for (at, still) in rest.iter().zip(&still).step_by(4) {
        assert_eq!(light(&lit, *at), *still);
    }
    let middle: [f32; 3] = std::array::from_fn(|axis| (rest[0][axis] + rest[1][axis]) / 2.0);
    let by_cursor = |before: &[[f32; 3]]| {
        let (mut cursor, mut found) = (lit.cursor(), [0.0; BANDS]);
        before.iter().for_each(|at| cursor.at(*at, &mut found));
        cursor.at(middle, &mut found);
        found
    };
    assert_eq!(by_cursor(&rest), by_cursor(&[]), "whatever mesh asked before");
}

#[test]
fn only_what_the_suns_need_is_loaded_of_a_paper_file() {
    let library = library(&plant("oak", None, LATTICE, 3), Codec::HaarPaper);
    let direction = towards_sun(130.0, 35.0);
    let needed = bases_needed(&sun::blend(direction).expect("a direction"), true);
    let some = SpeciesLight::load_for(&library, 0, [direction], true).expect("it loads");
    let sampler = SpeciesSampler::load(&library, 0, &needed).expect("it loads");
    assert_eq!(some.size_bytes(), sampler.size_bytes());
    let all = SpeciesLight::load(&library, 0).expect("it loads");
    assert!(all.size_bytes() > 2 * some.size_bytes(), "{} and {}", all.size_bytes(), some.size_bytes());
    let [a, b] = [&some, &all].map(|one| light(&one.lit_by_in_model(&days()[0]).expect("a sun"), point(1)));
    assert_eq!(a, b);
    assert_eq!((some.bands(), some.grid(), some.has_sky()), (BANDS, sampler.grid(), true));
}

#[test]
fn a_point_that_is_no_number_is_clamped_and_never_black_or_nan() {
    for suns in kinds() {
        let library = library(&plant("oak", suns.as_ref(), LATTICE, 3), Codec::Classed);
        let resident = resident(&library);
        for species in
            [SpeciesLight::load(&library, 0).expect("it loads"), SpeciesLight::streamed(resident.species(0))]
        {
            let lit = species.lit_by(&days()[0], &tilted()).expect("a sun");
            for at in [[f32::NAN; 3], [f32::INFINITY, 0.0, f32::NEG_INFINITY], [f32::MAX, 1.0, f32::NAN]] {
                let mut by_cursor = [f32::NAN; BANDS];
                lit.cursor().at(at, &mut by_cursor);
                assert!(light(&lit, at).iter().chain(&by_cursor).all(|v| v.is_finite()), "{suns:?} {at:?}");
            }
        }
    }
}

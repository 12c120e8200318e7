//! sky.wgsl against the skies of the CPU.

use std::f32::consts::PI;

use flb_format::light::SunBasis;
use flb_format::sky_part::SkyPart;
use flb_format::{Codec, Transform};

use super::super::{GpuError, GpuLight, GpuSpecies, LightSettings, SkyOnGpu};
use super::probe::{self, Ask};
use crate::plants::{library, noise, plant};
use crate::{Daylight, SpeciesLight};

const LATTICE: u32 = 16;
/// Binary16 of beams of up to 1, and sums in another order; of the mean light.
const CLOSE: f32 = 2e-3;

/// In place of what [`probe::SAMPLES`] finds. Of a point, w says whether it lies before a solid.
pub(super) fn sky() -> String {
    let facing = "select(vec3<f32>(0.0), vec3<f32>(0.6, 0.0, -0.8), points[at.x].w > 0.0)";
    probe::finding(&format!("vec4<f32>(flb_sky(ask.species, ask.first, points[at.x].xyz, {facing}), 1.0)"))
}

/// Brighter in the west, blue from above, of the whole sphere.
fn parts() -> Vec<SkyPart> {
    let directions = flb_format::ordinates::Ordinates::Lebedev50.directions();
    let part = |ordinate: &flb_format::ordinates::Ordinate| {
        let [x, y, _] = ordinate.direction;
        let solid_angle = 4.0 * std::f64::consts::PI * ordinate.weight;
        let radiance = [0.1 + (1.0 - x) as f32 / 4.0, 0.1, 0.2 + 0.15 * y as f32];
        SkyPart {
            towards: ordinate.direction,
            solid_angle,
            fluence: radiance.map(|band| band * solid_angle as f32),
        }
    };
    directions.iter().map(part).collect()
}

fn tilted() -> Transform {
    let rotation = [[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]];
    Transform { rotation, ..Transform::IDENTITY }
}

/// All over the lattice, half of them before a solid, and some beyond it.
fn points() -> Vec<[f32; 4]> {
    let at = |i: u32, axis: u32| noise(i, axis) * 5.0 - if axis == 2 { 0.5 } else { 2.5 };
    (0..400).map(|i| [at(i, 1), at(i, 2), at(i, 3), (i % 2) as f32]).collect()
}

#[test]
fn light_of_an_uneven_sky_is_that_of_the_cpu() {
    let gpu = probe::gpu();
    let directions = SunBasis::Harmonics { degree: 3, single: false, leaning: true };
    for suns in
        [SunBasis::Lattice18, SunBasis::Harmonics { degree: 2, single: true, leaning: true }, directions]
    {
        let library = library(&[plant("plant", Some(&suns), LATTICE, 3)], Codec::Classed);
        let mut light = GpuLight::new(&gpu.device, &gpu.queue, LightSettings::default()).expect("buffers");
        let on_gpu = GpuSpecies::load(&mut light, &library, 0).expect("it fits");
        let species = SpeciesLight::load(&library, 0).expect("a sound file");
        let beams = species.sky_beams().expect("a physical file");
        light.set_sky_beams(on_gpu.number(), &beams).expect("it fits");
        let over = beams.sky(&parts(), &tilted()).expect("a sky");
        let sky = SkyOnGpu::of(&over).expect("of beams");
        assert_eq!(sky.fluence(), over.fluence());
        let terms = on_gpu.sky_terms(&sky).expect("all bases are there");
        assert!(terms.len() <= SkyOnGpu::most_terms(&suns) as usize, "{suns:?}: {}", terms.len());
        light.set_terms(5, &terms).expect("it fits");

        let points = points();
        let ask = Ask { species: on_gpu.number(), first: 5, second: 0 };
        let found = probe::asked(&gpu, &light, &self::sky(), ask, &points);
        let night = Daylight { towards_sun: [0.0, 1.0, 0.0], sun: 0.0, sky: 0.0 };
        let lit = species.lit_by(&night, &tilted()).expect("no sun").with_sky(&over, [1.0; 3]);
        let mut expected = Vec::new();
        for [x, y, z, is_solid] in &points {
            let mut out = [0.0; 3];
            lit.at_facing([*x, *y, *z], (*is_solid > 0.0).then_some([0.6, 0.0, -0.8]), &mut out);
            expected.push(out);
        }
        let all = expected.as_flattened();
        let mean = all.iter().sum::<f32>() / all.len() as f32;
        for (i, ([x, y, z, _], expected)) in found.iter().zip(&expected).enumerate() {
            for (found, expected) in [x, y, z].into_iter().zip(expected) {
                let off = (found - expected).abs() / mean;
                assert!(off < CLOSE, "{suns:?}, {:?}: {found} and {expected}", points[i]);
            }
        }
        let dark = expected.iter().filter(|out| **out == [0.0; 3]).count();
        assert!(mean > 0.05 && dark < points.len() / 2, "{suns:?}: {mean}, {dark} dark");
    }
}

#[test]
fn beams_of_a_sky_go_with_the_extinction_and_their_memory_comes_back() {
    let gpu = probe::gpu();
    let suns = SunBasis::Harmonics { degree: 2, single: true, leaning: true };
    let library = library(&[plant("plant", Some(&suns), LATTICE, 3)], Codec::Classed);
    let species = SpeciesLight::load(&library, 0).expect("a sound file");
    let beams = species.sky_beams().expect("a physical file");
    let mut light = GpuLight::new(&gpu.device, &gpu.queue, LightSettings::default()).expect("buffers");
    let on_gpu = GpuSpecies::load(&mut light, &library, 0).expect("it fits").number();
    let [before, of_light] = [light.free_bytes(), light.species_bytes(on_gpu).expect("it is there")];
    for _ in 0..3 {
        light.set_sky_beams(on_gpu, &beams).expect("it fits");
    }
    assert!(light.has_sky_beams(on_gpu));
    let taken = before - light.free_bytes();
    assert_eq!(taken, light.species_bytes(on_gpu).expect("it is there") - of_light);
    assert!(taken > 0 && taken <= 4 + beams.size_bytes() as u64, "half of binary32, and a word: {taken}");
    light.remove_extinction(on_gpu).expect("it is there");
    assert!(!light.has_sky_beams(on_gpu) && light.free_bytes() > before);
    light.set_sky_beams(on_gpu, &beams).expect("it brings the extinction back");
    light.remove_species(on_gpu).expect("it is there");
    assert_eq!(light.set_sky_beams(on_gpu, &beams), Err(GpuError::NoSpecies { species: on_gpu }));
    let whole = GpuLight::new(&gpu.device, &gpu.queue, LightSettings::default()).expect("buffers");
    assert_eq!(light.free_bytes(), whole.free_bytes());
}

#[test]
fn a_sky_that_was_found_for_a_plant_alone_has_no_terms() {
    let library = library(&[plant("plant", Some(&SunBasis::Lattice18), LATTICE, 3)], Codec::Classed);
    let species = SpeciesLight::load(&library, 0).expect("a sound file");
    let own = species.sky(&parts(), &Transform::IDENTITY).expect("a sky");
    assert!(SkyOnGpu::of(&own).is_none());
    assert!(own.fluence().iter().all(|band| (band / (4.0 * PI) - 0.1).abs() < 0.3));
}

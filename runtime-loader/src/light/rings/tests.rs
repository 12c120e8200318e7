use flb_format::Transform;
use flb_format::light::SunBasis;
use flb_format::sun::towards_sun;

use super::*;
use crate::Daylight;
use crate::plants::{noise, plant};

const LATTICE: u32 = 32;
const SINGLE: [bool; 2] = [true, false];

/// A plant whose suns are harmonics; its fields are no light, but its near beams are.
fn species(single: bool) -> SpeciesLight<'static> {
    let suns = SunBasis::Harmonics { degree: 2, single, leaning: true };
    let library =
        crate::plants::library(&[plant("oak", Some(&suns), LATTICE, 7)], flb_format::Codec::Classed);
    SpeciesLight::load(&library, 0).expect("a sound file")
}

fn sun(azimuth_deg: f64, elevation_deg: f64) -> Daylight {
    Daylight { towards_sun: towards_sun(azimuth_deg, elevation_deg), sun: 1.0, sky: 0.0 }
}

fn lit<'l>(light: &'l SpeciesLight, daylight: &Daylight) -> InstanceLight<'l> {
    light.lit_by(daylight, &Transform::IDENTITY).expect("a sun")
}

fn rings(light: &SpeciesLight, near: &Near, elevation_deg: f64) -> SunRings {
    let mut rings = SunRings::default();
    for step in SunRings::steps(towards_sun(0.0, elevation_deg)) {
        rings.insert(step, Arc::new(light.sun_ring(near, step).expect("a near beam")));
    }
    rings
}

/// Points in the plant.
fn points() -> impl Iterator<Item = [f32; 3]> {
    (0..400).map(|at| {
        std::array::from_fn(|axis| {
            3.0 * noise(3 * at + axis as u32, 5) - 1.5 + if axis == 1 { 2.0 } else { 0.0 }
        })
    })
}

/// Root of the mean square and mean of the differences of the near beam, as shares of the mean beam in the sites.
fn error(found: &InstanceLight, exact: &InstanceLight) -> [f64; 2] {
    let (mut squares, mut sum, mut mean, mut count) = (0.0, 0.0, 0.0, 0.0);
    for point in points() {
        let (found, exact) = (found.near(point), exact.near(point));
        for (found, exact) in found.iter().zip(exact) {
            let difference = f64::from(found - exact);
            squares += difference * difference;
            sum += difference;
            count += 1.0;
        }
        mean += f64::from(exact[0]) * found.len() as f64;
    }
    [libm::sqrt(squares / count), sum / count].map(|error| error / (mean / count))
}

#[test]
fn suns_of_a_ring_are_as_exact_as_their_bits_and_those_between_nearly() {
    for single in SINGLE {
        let light = species(single);
        let near = light.near().expect("a near beam");
        for elevation_deg in [4.0, 46.0] {
            let rings = rings(&light, &near, elevation_deg);
            let ring = &rings.rings[&(elevation_deg as i32 / 2)];
            let turn_deg = 360.0 / ring.suns() as f64;
            for turn in [0.0, 3.0, 0.5, 7.37] {
                let daylight = sun(turn * turn_deg, elevation_deg);
                let exact = lit(&light, &daylight).prepared_by(Some(&near));
                let [rms, bias] = error(&lit(&light, &daylight).with_rings(&rings), &exact);
                let most = if turn == libm::trunc(turn) { 0.015 } else { 0.05 };
                assert!(rms < most && bias.abs() < 0.005, "{single} {elevation_deg} {turn}: {rms} {bias}");
            }
        }
    }
}

#[test]
fn between_two_heights_the_light_is_faded_and_one_ring_alone_serves_near_by() {
    let light = species(true);
    let near = light.near().expect("a near beam");
    let both = rings(&light, &near, 21.0);
    let daylight = sun(77.0, 21.0);
    let exact = lit(&light, &daylight).prepared_by(Some(&near));
    let [faded, _] = error(&lit(&light, &daylight).with_rings(&both), &exact);
    for step in [10, 11] {
        let mut one = both.clone();
        one.keep([step, step]);
        assert!(one.has(step) && !one.has(21 - step));
        let [alone, _] = error(&lit(&light, &daylight).with_rings(&one), &exact);
        assert!(faded < 0.05 && faded < alone && alone < 0.1, "{faded} {alone}");
    }
    assert!(both.size_bytes() > 0 && both.size_bytes() < 2 * 53 * 4 * (LATTICE as usize).pow(3));
}

#[test]
fn without_its_rings_a_light_stays_as_it_is_and_with_them_it_is_kept() {
    let light = species(true);
    let near = light.near().expect("a near beam");
    let rings = rings(&light, &near, 21.0);
    let (here, elsewhere) = (sun(200.0, 21.0), sun(200.0, 50.0));
    let at = |lit: &InstanceLight| {
        points()
            .map(|point| {
                let mut rgb = [0.0; 3];
                lit.at(point, &mut rgb);
                rgb
            })
            .collect::<Vec<_>>()
    };
    let marched = at(&lit(&light, &elsewhere));
    assert!(at(&lit(&light, &elsewhere).with_rings(&rings)) == marched);
    let by_rings = lit(&light, &here).with_rings(&rings);
    assert!(at(&by_rings) != at(&lit(&light, &here)));
    let again = light.lit_again(&by_rings.keep()).expect("nothing changed");
    assert!(at(&again) == at(&by_rings));
    // Of a species of directions there are none.
    let library = crate::plants::library(
        &[plant("pine", Some(&SunBasis::Lattice18), 16, 2)],
        flb_format::Codec::Classed,
    );
    let pine = SpeciesLight::load(&library, 0).expect("a sound file");
    assert!(pine.sun_ring(&near, 10).is_none());
    assert!(at(&lit(&pine, &here).with_rings(&rings)) == at(&lit(&pine, &here)));
}

#[test]
fn every_height_lies_between_two_steps() {
    for (elevation_deg, steps) in [
        (0.0, [0, 1]),
        (1.9, [0, 1]),
        (-0.1, [-1, 0]),
        (89.9, [44, 45]),
        (90.0, [44, 45]),
        (-90.0, [-45, -44]),
    ] {
        assert_eq!(SunRings::steps(towards_sun(30.0, elevation_deg)), steps, "{elevation_deg}");
    }
}

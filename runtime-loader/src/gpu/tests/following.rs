//! A GPU's light behind a stage that loads and drops.

use std::sync::Arc;

use flb_format::Codec;
use flb_format::light::SunBasis;

use super::super::{Follower, Gpu, GpuLight, LightSettings};
use super::near;
use super::probe::{self, Ask};
use crate::plants::{library, library_of_three, noise, plant};
use crate::residency::{Need, ResidencySettings, SpeciesNeed, Units};
use crate::stream::{Frame, Stage};

/// Coded samples are sums in another order (light.wgsl), of fields of magnitude 10.
const ROUNDING: f32 = 1e-4;
const SETTINGS: LightSettings = LightSettings { budget_bytes: 24 << 20, most_bases: 64, most_terms: 64 };

fn open(settings: LightSettings) -> (Gpu, GpuLight) {
    let gpu = probe::gpu();
    let light = GpuLight::new(&gpu.device, &gpu.queue, settings).expect("buffers");
    (gpu, light)
}

fn need(units: &Units, seen: [f32; 3]) -> Need {
    let of = |species: usize| {
        let bases = vec![seen[species]; units.bases(species).len()];
        SpeciesNeed {
            pixels: seen[species],
            detail: bases.clone(),
            is_now: vec![true; bases.len()],
            bases,
            windows: None,
        }
    };
    Need { species: (0..3).map(of).collect() }
}

fn points() -> Vec<[f32; 3]> {
    (0..200).map(|i| [noise(i, 1) * 4.0 - 2.0, noise(i, 2) * 4.0, noise(i, 3) * 4.0 - 2.0]).collect()
}

/// What the GPU gives for a species, and what the stage's own light is.
fn both(
    gpu: &Gpu,
    follower: &mut Follower,
    stage: &Stage,
    species: usize,
    sun: [f64; 3],
) -> Option<[Vec<[f32; 3]>; 2]> {
    let (terms, all) = follower.terms(species, stage.resident(), sun, 1.0, 0.2);
    let number = follower.species(species)?;
    follower.light_mut().set_terms(3, &terms).expect("there is room");
    let near_count = all.near_bases().0.len() as u32;
    let mut found = if near_count == 0 {
        let ask = Ask { species: number, first: 3, second: terms.len() as u32 };
        probe::samples(gpu, follower.light(), ask, &points())
    } else {
        // As near.rs has it: the sun's direction first, and no offsets.
        let first = [sun].map(|sun| [sun[0] as f32, sun[1] as f32, sun[2] as f32, 0.0]);
        let asked: Vec<[f32; 4]> =
            first.into_iter().chain(points().into_iter().map(|[x, y, z]| [x, y, z, 0.0])).collect();
        let ask = Ask { species: number, first: terms.len() as u32 | near_count << 8, second: 0 };
        let found = probe::asked(gpu, follower.light(), &near::light(), ask, &asked);
        found[1..].iter().map(|[r, g, b, _]| [*r, *g, *b]).collect()
    };
    for light in &mut found {
        *light = std::array::from_fn(|band| (light[band] + all.constant()[band]).max(0.0));
    }
    let resident = stage.resident().species(species);
    let expected = points().into_iter().map(|point| {
        let mut out = [0.0; 3];
        let near = resident.near(point, sun, &[]);
        resident.light(&resident.terms(sun, 1.0, 0.2), near, point, &mut out);
        out
    });
    Some([found, expected.collect()])
}

/// A frame of a stage that reads what it asks for at once.
fn step(stage: &mut Stage, need: &Need) -> Frame {
    let mut frame = Frame::default();
    stage.plan(need, &mut frame);
    for job in stage.jobs(&frame.requests) {
        for (unit, outcome) in stage.read(&job) {
            stage.take(unit, outcome, &mut frame);
        }
    }
    frame
}

#[test]
fn what_is_on_the_gpu_follows_what_is_loaded() {
    let library = library_of_three(Codec::Classed);
    let (gpu, light) = open(SETTINGS);
    let empty = light.free_bytes();
    let mut stage =
        Stage::new(Arc::clone(&library), ResidencySettings::default()).expect("coded near geometry");
    let units = Arc::clone(stage.residency().units());
    let mut follower = Follower::new(light, &units);
    let sun = [0.36, 0.8, 0.48];
    // Two species come, a few kilobytes a frame; one goes, the third comes in its place.
    for (seen, frames) in [([1.0, 1.0, 0.0], 400), ([0.0, 1.0, 0.0], 20), ([0.0, 1.0, 1.0], 400)] {
        let mut waited = false;
        if seen[0] == 0.0 {
            stage.set_budget(
                units.of_species(1).chain(units.of_species(2)).map(|u| units.get(u).memory_bytes).sum(),
            );
        }
        for index in 0..frames {
            let frame = step(&mut stage, &need(&units, seen));
            let followed = follower.follow(&frame, &units, stage.resident(), 40_000).expect("there is room");
            waited |= followed.waiting > 0;
            assert!(!followed.is_full && (followed.sent < 2 || followed.sent_bytes <= 40_000));
            // At any time there is light, of whatever was sent.
            if index % 16 == 0
                && let Some([found, _]) = both(&gpu, &mut follower, &stage, 1, sun)
            {
                assert!(
                    found.iter().flatten().all(|value| value.is_finite() && *value > 0.01),
                    "frame {index}"
                );
            }
            if followed.waiting == 0 && frame.loaded.is_empty() && frame.requests.is_empty() {
                break;
            }
        }
        assert!(waited || seen[0] == 0.0, "it took several frames");
        for species in (0..2).filter(|species| seen[*species] > 0.0) {
            let [found, expected] = both(&gpu, &mut follower, &stage, species, sun).expect("it was sent");
            for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
                assert!((found - expected).abs() < ROUNDING, "{species}: {found} for {expected}");
            }
        }
    }
    assert_eq!(follower.species(0), None, "it was dropped");
    stage.set_budget(0);
    let frame = step(&mut stage, &Need::default());
    follower.follow(&frame, &units, stage.resident(), 0).expect("there is nothing to send");
    assert_eq!(follower.light().free_bytes(), empty);
}

#[test]
fn a_gpu_that_is_full_keeps_what_it_has_and_says_so() {
    let library = library_of_three(Codec::Haar);
    let tables = LightSettings { budget_bytes: 1 << 20, ..SETTINGS };
    let (gpu, light) = open(tables);
    let mut stage =
        Stage::new(Arc::clone(&library), ResidencySettings::default()).expect("coded near geometry");
    let units = Arc::clone(stage.residency().units());
    let mut follower = Follower::new(light, &units);
    let mut last = Default::default();
    for _ in 0..30 {
        let frame = step(&mut stage, &need(&units, [1.0, 0.0, 0.0]));
        last = follower.follow(&frame, &units, stage.resident(), 1 << 20).expect("waiting is no error");
    }
    assert!(last.is_full && last.waiting > 0, "{last:?}");
    let [found, expected] = both(&gpu, &mut follower, &stage, 0, [0.36, 0.8, 0.48]).expect("it was sent");
    assert!(found.iter().flatten().all(|value| *value > 0.01));
    // Coarser than what is loaded, and not far off.
    let apart = found.iter().flatten().zip(expected.iter().flatten()).map(|(f, e)| (f - e).abs());
    assert!(apart.fold(0.0, f32::max) < 1.0);
    // Species 1 waits for room; when the first goes, there is some.
    stage.set_budget(units.of_species(1).map(|unit| units.get(unit).memory_bytes).sum());
    for _ in 0..30 {
        let frame = step(&mut stage, &need(&units, [0.0, 1.0, 0.0]));
        follower.follow(&frame, &units, stage.resident(), 1 << 20).expect("waiting is no error");
    }
    assert!(follower.species(0).is_none() && follower.species(1).is_some());
}

#[test]
fn harmonics_of_the_highest_degree_and_the_sky_are_all_summed() {
    let suns = SunBasis::Harmonics { degree: 3, single: true, leaning: true };
    let library = library(&[plant("pine", Some(&suns), 16, 4)], Codec::Classed);
    let (gpu, light) = open(SETTINGS);
    let mut stage =
        Stage::new(Arc::clone(&library), ResidencySettings::default()).expect("coded near geometry");
    let units = Arc::clone(stage.residency().units());
    let mut follower = Follower::new(light, &units);
    let bases = vec![1.0; units.bases(0).len()];
    let seen = SpeciesNeed {
        pixels: 1.0,
        detail: bases.clone(),
        is_now: vec![true; bases.len()],
        bases,
        windows: None,
    };
    let need = Need { species: vec![seen] };
    for _ in 0..10 {
        let frame = step(&mut stage, &need);
        follower.follow(&frame, &units, stage.resident(), 1 << 20).expect("there is room");
    }
    let sun = [0.36, 0.8, 0.48];
    let (terms, _) = follower.terms(0, stage.resident(), sun, 1.0, 0.2);
    assert_eq!(terms.len(), 20, "16 harmonics, the sky and three means of the near beam");
    let [found, expected] = both(&gpu, &mut follower, &stage, 0, sun).expect("it was sent");
    for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
        assert!((found - expected).abs() < ROUNDING, "{found} for {expected}");
    }
}

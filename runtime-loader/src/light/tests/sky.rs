//! Light of an uneven sky: an even one is its special case, and every other is a sum.

use std::f64::consts::PI;

use super::*;
use crate::residency::UnitKind;

/// A grid of parts, of radiance by direction.
fn parts(radiance: impl Fn([f64; 3]) -> [f32; 3]) -> Vec<SkyPart> {
    let (rows, columns) = (8, 12);
    let mut parts = Vec::new();
    for row in 0..rows {
        let y = 1.0 - (f64::from(row) + 0.5) * 2.0 / f64::from(rows);
        let level = libm::sqrt(1.0 - y * y);
        for column in 0..columns {
            let (sin, cos) = libm::sincos(f64::from(column) * 2.0 * PI / f64::from(columns));
            let towards = [level * cos, y, level * sin];
            let solid_angle = 4.0 * PI / f64::from(rows * columns);
            let fluence = radiance(towards).map(|band| band * solid_angle as f32);
            parts.push(SkyPart { towards, solid_angle, fluence });
        }
    }
    parts
}

fn physical() -> impl Iterator<Item = SunBasis> {
    kinds().into_iter().flatten()
}

fn by_night(sky: f32) -> Daylight {
    Daylight { towards_sun: [0.0, 1.0, 0.0], sun: 0.0, sky }
}

#[test]
fn parts_of_an_even_sky_give_the_light_that_is_stored_for_it() {
    for suns in physical() {
        let library = library(&plant("plant", Some(&suns), LATTICE, 3), Codec::Classed);
        let species = SpeciesLight::load(&library, 0).expect("a sound file");
        let fluence = 0.7;
        let parts = parts(|_| [fluence / (4.0 * PI as f32); 3]);
        let beams = species.sky_beams().expect("a physical file");
        let skies = [species.sky(&parts, &tilted()), beams.sky(&parts, &tilted())];
        let even = species.lit_by_in_model(&by_night(fluence)).expect("a sky");
        for sky in skies.map(|sky| sky.expect("a sky")) {
            let uneven = species.lit_by_in_model(&by_night(0.0)).expect("no sky").with_sky(&sky, [1.0; 3]);
            let mut cursor = uneven.cursor();
            for seed in 0..200 {
                let (expected, found) = (light(&even, point(seed)), light(&uneven, point(seed)));
                let mut kept = [0.0; BANDS];
                cursor.at(point(seed), &mut kept);
                for band in 0..BANDS {
                    let close = |found: f32| (found - expected[band].max(0.0)).abs() < ROUNDING;
                    assert!(
                        close(found[band]) && close(kept[band]),
                        "{suns:?}: {found:?} {kept:?} {expected:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn beams_that_plants_share_bring_the_light_that_is_found_for_each_of_them() {
    for suns in physical() {
        let library = library(&plant("plant", Some(&suns), LATTICE, 3), Codec::Classed);
        let species = SpeciesLight::load(&library, 0).expect("a sound file");
        let beams = species.sky_beams().expect("a physical file");
        let glow = |[x, y, _]: [f64; 3]| [0.1 + (1.0 + x) as f32 / 8.0, 0.1, 0.2 + 0.1 * y as f32];
        for stands in [Transform::IDENTITY, tilted()] {
            let parts = parts(glow);
            let own = species.sky(&parts, &stands).expect("a sky");
            let shared = beams.sky(&parts, &stands).expect("a sky");
            assert_eq!(own.fluence(), shared.fluence());
            let lit = |sky| species.lit_by_in_model(&by_night(0.0)).expect("no sky").with_sky(sky, [1.0; 3]);
            let (own, shared) = (lit(&own), lit(&shared));
            let (mut mean, mut apart, mut turned) = (0.0, 0.0, 0.0);
            for seed in 0..200 {
                for facing in [None, Some([0.6, 0.0, -0.8])] {
                    let at = |lit: &InstanceLight, facing| {
                        let mut out = [0.0; BANDS];
                        lit.at_facing(point(seed), facing, &mut out);
                        f64::from(out[0])
                    };
                    let expected = at(&own, facing);
                    mean += expected;
                    apart += (at(&shared, facing) - expected).abs();
                    turned += (at(&own, facing.map(|n| n.map(|c: f32| -c))) - expected).abs();
                }
            }
            assert!(apart < 0.02 * mean, "{suns:?}: {apart} of {mean}");
            assert!(turned > 3.0 * apart, "the other side of a solid differs by more: {turned} and {apart}");
        }
    }
}

#[test]
fn neighbours_do_to_the_parts_of_an_even_sky_what_they_do_to_an_even_sky() {
    let placed = [Placement { species: 0, transform: Transform::IDENTITY }];
    let fluence = 0.7;
    let parts = parts(|_| [fluence / (4.0 * PI as f32); 3]);
    let day = Daylight { towards_sun: towards_sun(130.0, 35.0), sun: 1.3, sky: fluence };
    for (suns, of_scene) in physical().flat_map(|suns| [(suns.clone(), 0.2), (suns, 0.8)]) {
        let scene_light = scene_light(of_scene);
        let prepared = scene_light.prepare(["oak"]);
        let shade = shade(&prepared, &placed);
        let library = library(&plant("oak", Some(&suns), LATTICE, 3), Codec::Classed);
        let species = SpeciesLight::load(&library, 0).expect("a sound file");
        let beams = species.sky_beams().expect("a physical file");
        let sky = beams.sky(&parts, &Transform::IDENTITY).expect("a sky");
        let even =
            species.lit_by_in_model(&day).expect("a sun").with_neighbours(&shade, 0).expect("three bands");
        let uneven = species.lit_by_in_model(&Daylight { sky: 0.0, ..day }).expect("a sun");
        let uneven = uneven.with_sky(&sky, [1.0; 3]).with_neighbours(&shade, 0).expect("three bands");
        let (mut cursor, mut changed) = (uneven.cursor(), 0);
        for at in (0..60).map(|seed| inside(point(seed))) {
            changed += usize::from(shade.at(0, at) != crate::scene_light::Modulations::UNCHANGED);
            let (expected, found, mut kept) = (light(&even, at), light(&uneven, at), [0.0; BANDS]);
            cursor.at(at, &mut kept);
            for band in 0..BANDS {
                let close =
                    |found: f32| (found - expected[band]).abs() < 10.0 * ROUNDING * (1.0 + expected[band]);
                assert!(close(found[band]) && close(kept[band]), "{suns:?}: {found:?} {kept:?} {expected:?}");
            }
        }
        assert!(changed > 30, "{changed} of 60 points");
    }
}

#[test]
fn a_sky_is_the_sum_of_its_parts_and_turns_with_the_plant() {
    let suns = SunBasis::Harmonics { degree: 2, single: true, leaning: true };
    let library = library(&plant("plant", Some(&suns), LATTICE, 3), Codec::Classed);
    let species = SpeciesLight::load(&library, 0).expect("a sound file");
    let glow = |s: [f64; 3]| {
        let warm = (1.0 + s[0]) as f32 / 8.0;
        [0.1 + warm, 0.1 + warm / 2.0, 0.2]
    };
    let at = |radiance: &dyn Fn([f64; 3]) -> [f32; 3], stands: &Transform, point: [f32; 3], facing| {
        let sky = species.sky(&parts(radiance), stands).expect("a sky");
        let lit = species.lit_by_in_model(&by_night(0.0)).expect("no sky").with_sky(&sky, [1.0; 3]);
        let mut out = [0.0; BANDS];
        lit.at_facing(point, facing, &mut out);
        out
    };
    let half = |s| glow(s).map(|band| band / 2.0);
    let mirrored = |[x, y, z]: [f64; 3]| glow([-x, y, z]);
    // About the vertical by half a turn.
    let turned =
        Transform { rotation: [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]], ..Transform::IDENTITY };
    let (mut differs, mut faces) = (0, 0);
    for seed in 0..40 {
        let point = point(seed);
        for facing in [None, Some([0.6, 0.0, 0.8])] {
            let whole = at(&glow, &Transform::IDENTITY, point, facing);
            let halves = at(&half, &Transform::IDENTITY, point, facing);
            let from_behind = at(&mirrored, &turned, point, facing);
            for band in 0..BANDS {
                assert!((whole[band] - 2.0 * halves[band]).abs() < 2.0 * ROUNDING, "{whole:?} {halves:?}");
                assert!(
                    (whole[band] - from_behind[band]).abs() < 0.01 * (1.0 + whole[band]),
                    "{from_behind:?}"
                );
            }
            let other = at(&mirrored, &Transform::IDENTITY, point, facing);
            differs += usize::from((whole[0] - other[0]).abs() > 0.01);
        }
        let [one, two] =
            [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]].map(|n| at(&glow, &Transform::IDENTITY, point, Some(n)));
        faces += usize::from(one[0] > two[0] + 1e-3);
    }
    assert!(differs > 40, "where the light comes from counts: {differs} of 80");
    assert!(faces > 5, "a solid that faces the glow gets more: {faces} of 40");
}

#[test]
fn what_cannot_have_an_uneven_sky_says_so() {
    let says = |result: Result<SkyLight<'_>, RuntimeError>, words: &[&str]| {
        let text = result.err().expect("an error").to_string();
        assert!(words.iter().all(|word| text.contains(word)), "{text:?} without one of {words:?}");
    };
    let even = parts(|_| [0.1; 3]);
    let paper = library(&plant("plant", None, LATTICE, 3), Codec::Classed);
    let of_paper = SpeciesLight::load(&paper, 0).expect("a sound file");
    says(of_paper.sky(&even, &Transform::IDENTITY), &["paper", "physical"]);
    let suns = SunBasis::Harmonics { degree: 1, single: false, leaning: true };
    let library = library(&plant("plant", Some(&suns), LATTICE, 3), Codec::Classed);
    let species = SpeciesLight::load(&library, 0).expect("a sound file");
    says(species.sky(&even[1..], &Transform::IDENTITY), &["whole sphere", "4 pi"]);
    let mut dark = even.clone();
    dark[3].fluence[1] = f32::NAN;
    says(species.sky(&dark, &Transform::IDENTITY), &["finite"]);
    let resident = without(&library, resident(&library), |kind| matches!(kind, UnitKind::Extinction));
    let streamed = SpeciesLight::streamed(resident.species(0));
    says(streamed.sky(&even, &Transform::IDENTITY), &["not the extinction", "loaded yet", "ask again"]);
    let text = streamed.sky_beams().err().expect("an error").to_string();
    assert!(text.contains("loaded yet"), "{text}");
    let directions = self::library(&plant("plant", Some(&SunBasis::Lattice18), LATTICE, 3), Codec::Classed);
    let resident = self::resident(&directions);
    let streamed = SpeciesLight::streamed(resident.species(0));
    says(streamed.sky(&even, &Transform::IDENTITY), &["species of directions", "loaded whole"]);
    let beams = species.sky_beams().expect("a physical file");
    let mut lost = even.clone();
    lost[5].towards = [f64::NAN, 0.0, 1.0];
    says(beams.sky(&lost, &Transform::IDENTITY), &["NaN", "direction"]);
    says(species.sky(&lost, &Transform::IDENTITY), &["NaN", "direction"]);
    says(beams.sky(&even[1..], &Transform::IDENTITY), &["whole sphere", "4 pi"]);
}

/// What is left when some units are dropped.
fn without(library: &Arc<Library>, mut resident: Resident, dropped: fn(UnitKind) -> bool) -> Resident {
    let stage = Stage::new(Arc::clone(library), ResidencySettings::default()).expect("coded near geometry");
    let units = Arc::clone(stage.residency().units());
    for unit in units.all().filter(|unit| dropped(units.get(*unit).kind)).collect::<Vec<UnitId>>() {
        resident.remove(&units, unit);
    }
    resident
}

#[test]
fn streamed_light_has_the_uneven_sky_of_the_file_and_keeps_it_while_units_go() {
    let glow = |[x, y, _]: [f64; 3]| [0.1 + (1.0 + x) as f32 / 8.0, 0.1, 0.2 + 0.1 * y as f32];
    for suns in physical().filter(|suns| suns.has_near_beam()) {
        let library = library(&plant("plant", Some(&suns), LATTICE, 3), Codec::Classed);
        let species = SpeciesLight::load(&library, 0).expect("a sound file");
        let all = resident(&library);
        let streamed = SpeciesLight::streamed(all.species(0));
        let expected = species.sky(&parts(glow), &tilted()).expect("a sky");
        let beams = streamed.sky_beams().expect("all is loaded");
        let skies = [streamed.sky(&parts(glow), &tilted()), beams.sky(&parts(glow), &tilted())];
        let [own, shared] = skies.map(|sky| sky.expect("a sky"));
        let lit = |light: &SpeciesLight, sky: &SkyLight, at| {
            let lit = light.lit_by_in_model(&by_night(0.0)).expect("no sky").with_sky(sky, [1.0; 3]);
            self::light(&lit, at)
        };
        let blurred = without(&library, resident(&library), |kind| matches!(kind, UnitKind::Detail { .. }));
        let lacking =
            without(&library, resident(&library), |kind| matches!(kind, UnitKind::Averages { base: 2 }));
        let (mut mean, mut apart, mut of_blurred, mut of_lacking) = (0.0, 0.0, 0.0, 0.0);
        for at in (0..60).map(|seed| inside(point(seed))) {
            let file = lit(&species, &expected, at);
            let found = lit(&streamed, &own, at);
            assert!(found.iter().zip(file).all(|(a, b)| (a - b).abs() < ROUNDING), "{found:?} {file:?}");
            mean += file[0];
            apart += (lit(&streamed, &shared, at)[0] - file[0]).abs();
            of_blurred += lit(&SpeciesLight::streamed(blurred.species(0)), &own, at)[0];
            of_lacking += lit(&SpeciesLight::streamed(lacking.species(0)), &own, at)[0];
        }
        assert!(apart < 0.05 * mean, "{suns:?}: {apart} of {mean}");
        for found in [of_blurred, of_lacking] {
            assert!((found / mean - 1.0).abs() < 0.5, "{suns:?}: {found} for {mean}");
        }
    }
}

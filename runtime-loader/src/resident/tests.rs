use std::sync::LazyLock;

use flb_format::Codec;
use proptest::prelude::*;

use super::*;
use crate::physical::PhysicalSampler;
use crate::plants::{BANDS, library_of_three, noise};
use crate::residency::{ResidencySettings, UnitId, UnitKind, Units};
use crate::sampler::SpeciesSampler;
use crate::stream::{Frame, Stage};
use crate::{Daylight, Library, SpeciesLight};

static LIBRARY: LazyLock<Arc<Library>> = LazyLock::new(|| library_of_three(Codec::Classed));

fn stage() -> Stage {
    Stage::new(Arc::clone(&LIBRARY), ResidencySettings::default()).expect("coded near geometry")
}

fn units() -> Units {
    Units::new(LIBRARY.container(), LIBRARY.path()).expect("coded near geometry")
}

/// Reads a unit, whose ground is there, and puts it in its place.
fn load(stage: &Stage, units: &Units, resident: &mut Resident, unit: UnitId) {
    for job in crate::stream::jobs(LIBRARY.container(), units, resident, &[unit]) {
        for (unit, outcome) in stage.read(&job) {
            resident.insert(units, unit, outcome.expect("a sound file")).expect("a sound page");
        }
    }
}

/// What is loaded when the units that `keep` names are.
fn resident(keep: impl Fn(&UnitKind) -> bool) -> Resident {
    let (units, stage) = (units(), stage());
    let mut resident = Resident::new(LIBRARY.container(), &units);
    for unit in units.all().filter(|unit| keep(&units.get(*unit).kind)) {
        load(&stage, &units, &mut resident, unit);
    }
    resident
}

fn point(seed: u32) -> [f32; 3] {
    let along = |axis: u32| noise(seed * 3 + axis, 77);
    [along(0) * 4.0 - 2.0, along(1) * 4.0, along(2) * 4.0 - 2.0]
}

fn light(species: &ResidentSpecies, sun: [f64; 3], sky: f32, point: [f32; 3]) -> [f32; BANDS] {
    let terms = species.terms(sun, 1.0, sky);
    let near = species.near(point, sun, &[]);
    let mut out = [f32::NAN; BANDS];
    species.light(&terms, near, point, &mut out);
    out
}

#[test]
fn with_everything_loaded_light_is_that_of_the_samplers() {
    let resident = resident(|_| true);
    let all: Vec<u8> = (0..19).collect();
    let paper = SpeciesSampler::load(&LIBRARY, 0, &all).expect("it loads");
    let physical = [1, 2].map(|species| PhysicalSampler::load(&LIBRARY, species).expect("it loads"));
    for seed in 0..200 {
        let sun = crate::view::unit(point(seed + 1000).map(|c| c - 0.7)).map(f64::from);
        let at = point(seed);
        let mut expected = [0.0; BANDS];
        paper.indirect(&flb_format::sun::blend(sun).expect("a direction"), 1.0, 0.2, at, &mut expected);
        let expected = expected.map(|value| value.max(0.0));
        assert_eq!(light(resident.species(0), sun, 0.2, at), expected, "paper at {at:?}");
        for (index, sampler) in [1, 2].into_iter().zip(&physical) {
            let terms = sampler.terms(sun).expect("a direction");
            let near = sampler.marcher().near(at, sun, &[]);
            let mut expected = [0.0; BANDS];
            sampler.fluence_of(&terms, near, 1.0, 0.2, at, &mut expected);
            for (found, expected) in light(resident.species(index), sun, 0.2, at).into_iter().zip(expected) {
                // The sky is added last in one and first in the other.
                assert!(
                    (found - expected).abs() < 1e-5 * expected.max(1.0),
                    "{index}: {found} for {expected}"
                );
            }
        }
    }
    let terms = resident.species(0).terms([0.2, 0.9, 0.1], 1.0, 0.2);
    assert_eq!((terms.level, terms.bases().count()), (LightLevel::Whole, 4));
}

#[test]
fn a_cursor_has_the_light_of_whatever_is_loaded() {
    let states: [fn(&UnitKind) -> bool; 4] = [
        |_| true,
        |kind| !matches!(kind, UnitKind::Detail { .. }),
        |kind| matches!(kind, UnitKind::Shared | UnitKind::Averages { base: 0 }),
        |_| false,
    ];
    for keep in states {
        let resident = resident(keep);
        for (index, turn) in (0..3).flat_map(|index| [(index, 3), (index, 4)]) {
            let species = resident.species(index);
            let sun = crate::view::unit(point(turn).map(|c| c - 0.7)).map(f64::from);
            let lit = SpeciesLight::streamed(species);
            let lit = lit.lit_by_in_model(&Daylight { towards_sun: sun, sun: 1.0, sky: 0.2 }).expect("a sun");
            let mut cursor = lit.cursor();
            for seed in 0..200 {
                // Steps of a walk, then anywhere.
                let at = if seed < 100 { point(7).map(|c| c + 0.01 * seed as f32) } else { point(seed) };
                let (mut found, mut expected) = ([f32::NAN; BANDS], [f32::NAN; BANDS]);
                cursor.at(at, &mut found);
                lit.at(at, &mut expected);
                for (found, expected) in found.into_iter().zip(expected) {
                    // Harmonics are larger than the light that is left of them.
                    assert!((found - expected).abs() < 1e-4, "{index}: {found} for {expected}");
                }
            }
        }
    }
}

#[test]
fn bases_that_were_read_with_another_block_map_are_sampled_as_before() {
    let (units, stage, mut resident) = (units(), stage(), resident(|_| true));
    let sun = [0.3, 0.9, 0.2];
    let expected: Vec<_> = (0..50).map(|seed| light(resident.species(0), sun, 0.2, point(seed))).collect();
    // The block map is read anew, and with it the sky's base; the others are as they were.
    for kind in [UnitKind::Shared, UnitKind::Averages { base: 0 }] {
        let is_it = |unit: &UnitId| units.get(*unit).species == 0 && units.get(*unit).kind == kind;
        let unit = units.all().find(is_it).expect("a unit");
        resident.remove(&units, unit);
        load(&stage, &units, &mut resident, unit);
    }
    let sky_s_detail = |unit: &UnitId| {
        units.get(*unit).species == 0 && matches!(units.get(*unit).kind, UnitKind::Detail { base: 0, .. })
    };
    let detail: Vec<UnitId> = units.all().filter(sky_s_detail).collect();
    detail.into_iter().for_each(|unit| load(&stage, &units, &mut resident, unit));
    let species = resident.species(0);
    let [old, new] = [1, 0].map(|base| species.base(base).expect("it is there").shared());
    assert!(!std::ptr::eq(old, new) && old == new);
    let lit = SpeciesLight::streamed(species);
    let lit = lit.lit_by_in_model(&Daylight { towards_sun: sun, sun: 1.0, sky: 0.2 }).expect("a sun");
    let mut cursor = lit.cursor();
    for (seed, expected) in (0..50).zip(expected) {
        assert_eq!(light(species, sun, 0.2, point(seed)), expected);
        let mut found = [f32::NAN; BANDS];
        cursor.at(point(seed), &mut found);
        assert!(found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-4), "{found:?} {expected:?}");
    }
}

#[test]
fn what_is_missing_is_answered_by_what_is_coarser_and_never_black() {
    let sun = crate::view::unit([0.3, 0.9, 0.2]).map(f64::from);
    let blend = flb_format::sun::blend(sun).expect("a direction");
    let of = |base: usize| u16::from(blend.bases[base]);
    let averages_of = |wanted: &[u16], kind: &UnitKind| match kind {
        UnitKind::Averages { base } => wanted.contains(base),
        UnitKind::Detail { .. } => false,
        _ => true,
    };
    let cases = [
        (resident(|_| false), LightLevel::Outside),
        (resident(|kind| matches!(kind, UnitKind::Shared)), LightLevel::Outside),
        (resident(|kind| averages_of(&[0], kind)), LightLevel::Other),
        (resident(|kind| averages_of(&[0, of(0)], kind)), LightLevel::Other),
        (resident(|kind| averages_of(&[of(0), of(1)], kind)), LightLevel::Other),
        (resident(|kind| !matches!(kind, UnitKind::Detail { .. })), LightLevel::Averages),
        (resident(|_| true), LightLevel::Whole),
    ];
    let best = &cases[cases.len() - 1].0;
    for species in 0..2 {
        let mut before = f32::INFINITY;
        for (case, (resident, level)) in cases.iter().enumerate() {
            let terms = resident.species(species).terms(sun, 1.0, 0.05);
            assert_eq!(terms.level, *level, "case {case} of species {species}");
            let mut squares = 0.0;
            for seed in 0..300 {
                let found = light(resident.species(species), sun, 0.05, point(seed));
                let right = light(best.species(species), sun, 0.05, point(seed));
                assert!(found.iter().all(|value| *value > 0.01), "case {case}: {found:?} for {right:?}");
                squares += found.iter().zip(right).map(|(f, r)| (f - r) * (f - r)).sum::<f32>();
            }
            if [2, 5, 6].contains(&case) {
                assert!(squares < before, "case {case} is better than those before: {squares}, {before}");
                before = squares;
            }
        }
    }
    // Harmonics: without the extinction, without some coefficients, without all.
    let without = |missing: &[u16]| {
        resident(
            |kind| !matches!(kind, UnitKind::Averages { base } | UnitKind::Detail { base, .. } if missing.contains(base)),
        )
    };
    let no_extinction = resident(|kind| !matches!(kind, UnitKind::Extinction));
    for (resident, level) in [
        (no_extinction, LightLevel::Other),
        (without(&[3]), LightLevel::Other),
        (without(&[11]), LightLevel::Other),
        (without(&[1]), LightLevel::Other),
        (without(&[0, 1]), LightLevel::Outside),
        (without(&[0]), LightLevel::Other),
    ] {
        assert_eq!(resident.species(2).terms(sun, 1.0, 0.05).level, level);
        for seed in 0..50 {
            let found = light(resident.species(2), sun, 0.05, point(seed));
            assert!(found.iter().all(|value| *value > 0.0 && value.is_finite()), "{found:?}");
        }
    }
}

#[test]
fn averages_of_the_sky_are_brought_to_its_mean_and_detail_is_left_as_it_is() {
    let of_sky = |keep: fn(&UnitKind) -> bool, averages: [f64; BANDS]| {
        let mut resident = resident(keep);
        let mut meta = LIBRARY.container().species()[1].meta.clone();
        meta.mean_light = Some(flb_format::mean_light::MeanLight { sky: vec![1.0; BANDS], sun: Vec::new() });
        meta.sky_averages = Some(averages.to_vec());
        Arc::make_mut(&mut resident.species[1]).mean = Mean::of(&meta);
        let terms = resident.species(1).terms([0.0, 1.0, 0.0], 0.0, 0.8);
        let factors: Vec<f32> = terms.bases().map(|(_, factor)| factor).collect();
        factors[0]
    };
    let averages = |kind: &UnitKind| !matches!(kind, UnitKind::Detail { .. });
    let first_page = |kind: &UnitKind| !matches!(kind, UnitKind::Detail { page, .. } if *page > 0);
    assert_eq!(of_sky(averages, [1.0, 1.25, 1.5]), 0.8 * 0.8);
    assert_eq!(of_sky(|_| true, [1.0, 1.25, 1.5]), 0.8);
    let part = of_sky(first_page, [1.0, 1.25, 1.5]);
    assert!((0.64..=0.8).contains(&part), "{part}");
    for nonsense in [[0.0; BANDS], [-1.0; BANDS], [1e300; BANDS], [1e-300; BANDS]] {
        assert_eq!(of_sky(averages, nonsense), 0.8, "{nonsense:?}");
    }
}

#[test]
fn two_bases_of_three_share_the_weight_of_the_third() {
    let sun = crate::view::unit([0.3, 0.9, 0.2]).map(f64::from);
    let blend = flb_format::sun::blend(sun).expect("a direction");
    let [a, b, _] = blend.bases.map(u16::from);
    let resident = resident(|kind| match kind {
        UnitKind::Averages { base } => [a, b].contains(base),
        _ => matches!(kind, UnitKind::Shared),
    });
    let terms = resident.species(0).terms(sun, 2.0, 0.0);
    let sum: f32 = terms.bases().map(|(_, factor)| factor).sum();
    assert!((sum - 2.0 * blend.weights.iter().sum::<f32>()).abs() < 1e-5, "{terms:?}");
    assert_eq!((terms.bases().count(), terms.level, terms.constant()), (2, LightLevel::Other, [0.0; 3]));
}

#[test]
fn terms_of_a_base_that_was_dropped_since_give_the_light_of_what_is_there() {
    let sun = [0.2, 0.9, 0.1];
    let all = resident(|_| true);
    for species in [0, 2] {
        let before = all.species(species).terms(sun, 1.0, 0.1);
        let (base, _) = before.bases().next().expect("a base");
        let is_dropped = |kind: &UnitKind| matches!(kind, UnitKind::Averages { base: b } | UnitKind::Detail { base: b, .. } if *b == base);
        let now = resident(|kind| !is_dropped(kind));
        let now = now.species(species);
        for at in (0..20).map(point) {
            let near = now.near(at, sun, &[]);
            let [mut found, mut expected] = [[f32::NAN; BANDS]; 2];
            now.light(&before, near, at, &mut found);
            now.light(&now.terms(sun, 1.0, 0.1), near, at, &mut expected);
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{found:?} {expected:?}");
        }
    }
}

#[test]
fn a_sun_of_any_length_is_defined_and_one_without_direction_sends_nothing() {
    let all = resident(|_| true);
    let species = all.species(2);
    let sun = [0.2, 0.9, 0.1];
    for length in [1e-200, 0.5, 3.0, 1e150] {
        let long = sun.map(|c: f64| c * length);
        for at in (0..20).map(point) {
            let [found, expected] = [long, sun].map(|sun| species.near(at, sun, &[[0.3, 0.6, 0.2]]));
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-4), "{length}: {found:?}");
            let [found, expected] = [long, sun].map(|sun| light(species, sun, 0.1, at));
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-3), "{length}: {found:?}");
        }
    }
    for none in [[0.0; 3], [f64::NAN, 1.0, 0.0], [0.0, f64::INFINITY, 0.0]] {
        assert_eq!(species.near(point(1), none, &[[0.3, 0.6, 0.2]]), [0.0; MAX_MEANS]);
        let dark = species.terms([0.0, 1.0, 0.0], 0.0, 0.1);
        let terms = species.terms(none, 1.0, 0.1);
        assert_eq!((terms.bases().collect::<Vec<_>>(), terms.needs_near()), (dark.bases().collect(), false));
    }
}

#[test]
fn threads_may_share_a_streamer() {
    fn is_shared<T: Send + Sync>() {}
    is_shared::<crate::stream::Streamer>();
}

#[test]
fn memory_is_within_what_the_catalogue_says() {
    let units = units();
    let mut bound = 0;
    let mut resident = Resident::new(LIBRARY.container(), &units);
    assert_eq!(resident.size_bytes(), 0);
    let stage = stage();
    for unit in units.all() {
        load(&stage, &units, &mut resident, unit);
        bound += units.get(unit).memory_bytes as usize;
        assert!(
            resident.size_bytes() <= bound,
            "{:?}: {} over {bound}",
            units.get(unit),
            resident.size_bytes()
        );
    }
    // And the bounds are no wild guess.
    assert!(resident.size_bytes() * 4 > bound * 3, "{} of {bound}", resident.size_bytes());
    for unit in units.all().collect::<Vec<_>>().into_iter().rev() {
        resident.remove(&units, unit);
    }
    assert_eq!(resident.size_bytes(), 0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// Whatever came and went before, what is loaded alone decides the light.
    #[test]
    fn light_is_of_what_is_loaded_now(seed: u64, steps in 20usize..200) {
        let units = units();
        let stage = stage();
        let mut resident = Resident::new(LIBRARY.container(), &units);
        let mut there = vec![false; units.len()];
        let all: Vec<UnitId> = units.of_species(1).collect();
        for step in 0..steps {
            let unit = all[(noise(step as u32, seed as u32) * all.len() as f32) as usize];
            let stands = units.stands_on(unit).is_none_or(|below| there[below.index()]);
            if there[unit.index()] {
                for above in units.standing_on(unit) {
                    for page in units.standing_on(above).into_iter().chain([above]) {
                        if std::mem::take(&mut there[page.index()]) {
                            resident.remove(&units, page);
                        }
                    }
                }
                resident.remove(&units, unit);
                there[unit.index()] = false;
            } else if stands {
                load(&stage, &units, &mut resident, unit);
                there[unit.index()] = true;
            }
        }
        let mut fresh = Resident::new(LIBRARY.container(), &units);
        for unit in units.all().filter(|unit| there[unit.index()]) {
            load(&stage, &units, &mut fresh, unit);
        }
        prop_assert_eq!(resident.size_bytes(), fresh.size_bytes());
        for seed in 0..100 {
            let sun = crate::view::unit(point(seed + 500).map(|c| c - 0.3)).map(f64::from);
            let both = [&resident, &fresh].map(|r| light(r.species(1), sun, 0.3, point(seed)));
            prop_assert_eq!(both[0], both[1]);
        }
    }
}

#[test]
fn a_stage_reports_a_page_whose_bytes_are_another_bases() {
    // A sound payload of another length: of the page after it.
    let units = units();
    let mut stage = stage();
    let mut frame = Frame::default();
    let mut need = crate::residency::Need { species: vec![Default::default(); 3] };
    need.species[0] = crate::residency::SpeciesNeed {
        pixels: 100.0,
        bases: vec![1.0; 19],
        detail: vec![1.0; 19],
        is_now: vec![true; 19],
        windows: None,
    };
    let mut wrong = None;
    for _ in 0..10 {
        stage.plan(&need, &mut frame);
        for job in stage.jobs(&frame.requests) {
            for (unit, outcome) in stage.read(&job) {
                let outcome = match (outcome, units.get(unit).kind, wrong) {
                    (Ok(Payload::Detail(mut bytes)), UnitKind::Detail { .. }, None) => {
                        wrong = Some(unit);
                        bytes.truncate(bytes.len() - 4);
                        Ok(Payload::Detail(bytes))
                    }
                    (outcome, ..) => outcome,
                };
                stage.take(unit, outcome, &mut frame);
            }
        }
    }
    let [failure] = &frame.failures[..] else { panic!("{:?}", frame.failures) };
    assert_eq!(Some(failure.unit), wrong);
    assert!(failure.error.to_string().contains("FLB-"), "{}", failure.error);
    assert!(frame.is_final && frame.quality < 1.0);
}

#[test]
fn kept_light_is_that_of_now_or_is_refused() {
    let (units, stage) = (units(), stage());
    let mut resident = Resident::new(LIBRARY.container(), &units).blending_over(3);
    let daylight = Daylight { towards_sun: [0.6, 0.0, 0.8], sun: 1.0, sky: 0.5 };
    let light = |resident: &Resident| -> Vec<crate::light::KeptLight> {
        let species = |species| SpeciesLight::streamed(resident.species(species));
        let lit = |light: &SpeciesLight| light.lit_by_in_model(&daylight).expect("a direction").keep();
        (0..3).map(|index| lit(&species(index))).collect()
    };
    let (mut again, mut anew) = (0, 0);
    let mut check = |resident: &Resident, kept: &[crate::light::KeptLight]| {
        for (index, kept) in kept.iter().enumerate() {
            let now = SpeciesLight::streamed(resident.species(index));
            let fresh = now.lit_by_in_model(&daylight).expect("a direction");
            match now.lit_again(kept) {
                Some(light) => {
                    assert_eq!(light.terms(), fresh.terms());
                    let (mut found, mut expected) = ([0.0; BANDS], [0.0; BANDS]);
                    light.at(point(9), &mut found);
                    fresh.at(point(9), &mut expected);
                    assert_eq!(found, expected);
                    again += 1;
                }
                None => anew += 1,
            }
        }
    };
    for unit in units.all() {
        let kept = light(&resident);
        load(&stage, &units, &mut resident, unit);
        check(&resident, &kept);
        let kept = light(&resident);
        resident.advance();
        check(&resident, &kept);
    }
    for unit in units.all().collect::<Vec<_>>().into_iter().rev() {
        let kept = light(&resident);
        resident.remove(&units, unit);
        check(&resident, &kept);
    }
    assert!(again > 500 && anew > 50, "{again} again, {anew} anew");
}

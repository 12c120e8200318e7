use std::sync::LazyLock;

use flb_format::light::SunBasis;
use flb_format::{Codec, Placement, Transform};
use proptest::prelude::*;

use super::*;
use crate::extinction::Extinction;
use crate::plants::{library, library_of_three, plant};
use crate::view::{Camera, WaterPlane};
use crate::{Daylight, Library, RuntimeError};

mod finding;

static LIBRARY: LazyLock<Arc<Library>> = LazyLock::new(|| library_of_three(Codec::Classed));
static UNITS: LazyLock<Arc<Units>> =
    LazyLock::new(|| Arc::new(Units::new(LIBRARY.container(), LIBRARY.path()).expect("coded near geometry")));

const NO_ROTATION: [[f32; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const PLENTY: ResidencySettings =
    ResidencySettings { budget_bytes: 1 << 30, max_requests: 100_000, max_request_bytes: 1 << 30 };

/// All bases of all species, all detail.
fn everything() -> Need {
    let species = (0..UNITS.species()).map(|species| {
        let bases = vec![1000.0; UNITS.bases(species).len()];
        SpeciesNeed {
            pixels: 1000.0,
            detail: bases.clone(),
            is_now: vec![true; bases.len()],
            bases,
            windows: None,
        }
    });
    Need { species: species.collect() }
}

/// A need of one species, of some of its bases.
fn of(species: usize, bases: &[usize], detail: bool) -> Need {
    let mut need = Need { species: vec![SpeciesNeed::default(); UNITS.species()] };
    let seen = &mut need.species[species];
    seen.pixels = 1000.0;
    seen.bases = vec![0.0; UNITS.bases(species).len()];
    seen.detail = seen.bases.clone();
    seen.is_now = vec![true; seen.bases.len()];
    for base in bases {
        seen.bases[*base] = 1000.0;
        seen.detail[*base] = if detail { 1000.0 } else { 0.0 };
    }
    need
}

fn residency(settings: ResidencySettings) -> Residency {
    Residency::new(Arc::clone(&UNITS), settings)
}

/// Plans and loads at once what is asked for, until nothing is; returns the plans that were not empty.
fn settle(residency: &mut Residency, need: &Need) -> Vec<LoadPlan> {
    let mut plans = Vec::new();
    for _ in 0..1000 {
        let plan = residency.plan(need);
        for unit in &plan.requests {
            residency.loaded(*unit);
        }
        if plan.requests.is_empty() && plan.evictions.is_empty() {
            return plans;
        }
        plans.push(plan);
    }
    panic!("it does not settle");
}

fn memory(units: impl Iterator<Item = UnitId>) -> u64 {
    units.map(|unit| UNITS.get(unit).memory_bytes).sum()
}

fn loaded(residency: &Residency) -> impl Iterator<Item = UnitId> {
    UNITS.all().filter(|unit| residency.is_loaded(*unit))
}

#[test]
fn units_take_no_more_memory_than_the_catalogue_says() {
    for codec in [Codec::Classed, Codec::Haar] {
        let library = library_of_three(codec);
        let (container, source) = (library.container(), library.source());
        let units = Units::new(container, library.path()).expect("coded near geometry");
        let most = |unit: UnitId| units.get(unit).memory_bytes as usize;
        for species in 0..units.species() {
            let shared = container.read_shared(source, species).expect("it reads");
            let map = units.of_species(species).next().expect("the first unit is the block map");
            assert!(shared.size_bytes() <= most(map), "{codec:?}, {species}: the block map");
            if let Some(unit) = units.extinction(species) {
                let turbid = container.read_turbid(source, species).expect("it reads");
                let found = Extinction::of(&turbid).size_bytes();
                assert!(found <= most(unit), "{codec:?}, {species}: extinction of {found} bytes");
            }
            for (place, base) in (0..).zip(units.bases(species)) {
                let is_its_own = |unit: &UnitId| match units.get(*unit).kind {
                    UnitKind::Averages { base } | UnitKind::Detail { base, .. } => base == place,
                    UnitKind::Shared | UnitKind::Extinction => false,
                };
                let is_coarse = |unit: &UnitId| matches!(units.get(*unit).kind, UnitKind::Averages { .. });
                let its_own = units.of_species(species).filter(is_its_own);
                let (averages, pages): (Vec<_>, Vec<_>) = its_own.partition(is_coarse);
                let all = |units: &[UnitId]| units.iter().map(|unit| most(*unit)).sum::<usize>();
                let coded = container.read_coded_base(source, species, base.item, &shared);
                let mut coded = coded.expect("it reads");
                let found = coded.size_bytes();
                assert!(
                    found <= all(&averages) + all(&pages),
                    "{codec:?}, {species}, {place}: {found} bytes"
                );
                assert!(pages.iter().all(|page| coded.remove(units.get(*page).blocks[0])), "all were there");
                let found = coded.size_bytes();
                assert!(found <= all(&averages), "{codec:?}, {species}, {place}: averages of {found} bytes");
            }
        }
    }
}

#[test]
fn the_catalogue_has_every_page_of_light_once_and_bytes_as_in_the_tables() {
    let container = LIBRARY.container();
    let mut pages: Vec<(usize, u32)> = Vec::new();
    for unit in UNITS.all() {
        let of_unit = UNITS.pages_of(container, unit);
        let bytes: u64 = of_unit
            .iter()
            .flat_map(|(section, range)| &container.pages(*section)[range.start as usize..range.end as usize])
            .map(|page| u64::from(page.stored_bytes))
            .sum();
        assert_eq!(bytes, UNITS.get(unit).stored_bytes, "{:?}", UNITS.get(unit));
        pages.extend(of_unit.into_iter().flat_map(|(section, range)| range.map(move |page| (section, page))));
    }
    pages.sort_unstable();
    let wanted = |kind: u32, item: u32, species: u32| match kind {
        4..=6 => true,
        2 => item >= 4 && species == 2, // the near beam's extinctions
        _ => false,
    };
    let mut expected = Vec::new();
    for (section, entry) in container.sections().iter().enumerate() {
        if wanted(entry.key.kind, entry.key.item, entry.key.species) {
            expected.extend((0..container.pages(section).len() as u32).map(|page| (section, page)));
        }
    }
    assert_eq!(pages, expected);
    assert!(UNITS.all().filter(|u| matches!(UNITS.get(*u).kind, UnitKind::Detail { .. })).count() > 60);
}

#[test]
fn species_of_other_codecs_are_refused_by_name() {
    let library = library(&[plant("oak", None, 16, 1)], Codec::RawF16);
    let error = Units::new(library.container(), library.path()).expect_err("refused");
    assert!(matches!(error, RuntimeError::NotStreamed { .. }));
    assert_eq!(
        error.to_string(),
        "plants.flb: species \"oak\" is coded as raw-f16, expected classed or haar: other codecs are loaded whole \
         (`flb pack plants.flb -o NEW.flb --codec classed` codes it anew)"
    );
}

#[test]
fn with_room_everything_is_loaded_once_the_coarse_before_the_fine() {
    let mut residency = residency(PLENTY);
    let plans = settle(&mut residency, &everything());
    let asked: Vec<UnitId> = plans.iter().flat_map(|plan| plan.requests.clone()).collect();
    assert_eq!(asked.len(), UNITS.len(), "each once");
    assert!(plans.iter().all(|plan| plan.evictions.is_empty()));
    let tiers: Vec<u8> = asked.iter().map(|unit| UNITS.get(*unit).tier()).collect();
    assert_eq!(tiers[..3], [0; 3], "block maps first");
    let last_averages = tiers.iter().rposition(|tier| *tier == units::AVERAGES_TIER).expect("there are some");
    let first_detail = tiers.iter().position(|tier| *tier == 3).expect("there is some");
    assert!(last_averages < first_detail);
    let last = residency.plan(&everything());
    assert!(last.is_final && last.is_complete && (last.quality - 1.0).abs() < 1e-6);
    assert_eq!(residency.loaded_bytes(), memory(UNITS.all()));
}

#[test]
fn pages_that_remove_more_error_for_their_bytes_come_first() {
    let mut residency = residency(PLENTY);
    let plans = settle(&mut residency, &of(0, &[4], true));
    let pages: Vec<&Unit> = plans
        .iter()
        .flat_map(|plan| &plan.requests)
        .map(|unit| UNITS.get(*unit))
        .filter(|unit| matches!(unit.kind, UnitKind::Detail { .. }))
        .collect();
    let value = |unit: &Unit| unit.priority / unit.memory_bytes as f32;
    assert!(pages.len() > 2 && pages.windows(2).all(|pair| value(pair[0]) >= value(pair[1]) * 0.999));
    assert!(pages.iter().all(|unit| matches!(unit.kind, UnitKind::Detail { base: 4, .. })));
}

#[test]
fn only_what_the_sun_asks_for_is_loaded() {
    let mut residency = residency(PLENTY);
    settle(&mut residency, &of(1, &[0, 3, 7], false));
    let kinds: Vec<UnitKind> = loaded(&residency).map(|unit| UNITS.get(unit).kind).collect();
    let averages = |base| UnitKind::Averages { base };
    assert_eq!(kinds, [UnitKind::Shared, averages(0), averages(3), averages(7)]);
}

#[test]
fn a_small_budget_is_filled_with_the_coarse_and_never_exceeded() {
    let everything = everything();
    let full = memory(UNITS.all());
    let least = UNITS.all().map(|unit| UNITS.get(unit).memory_bytes).min().expect("there are units");
    for budget_bytes in [0, 1, least, full / 50, full / 10, full / 3, full - 1] {
        let mut residency = residency(ResidencySettings { budget_bytes, ..PLENTY });
        settle(&mut residency, &everything);
        assert!(residency.loaded_bytes() <= budget_bytes);
        let is_page = |unit: &UnitId| matches!(UNITS.get(*unit).kind, UnitKind::Detail { .. });
        if loaded(&residency).any(|unit| is_page(&unit)) {
            // No page is loaded while averages that would fit are not.
            let left = budget_bytes - residency.loaded_bytes();
            // Harmonics that cannot be complete are not begun.
            let is_begun = |unit: &UnitId| UNITS.get(*unit).species != 2 || of_sun_of_2(*unit).is_none();
            let missing = UNITS.all().filter(|unit| !is_page(unit) && !residency.is_loaded(*unit));
            for unit in missing.filter(is_begun) {
                assert!(UNITS.get(unit).memory_bytes > left, "{:?}", UNITS.get(unit));
            }
        }
        assert!(residency.plan(&everything).is_final, "nothing more fits into {budget_bytes}");
    }
}

/// A unit that the sun's light of the species of harmonics needs.
fn of_sun_of_2(unit: UnitId) -> Option<UnitId> {
    let of_sun = UNITS.get(unit).species == 2
        && match UNITS.get(unit).kind {
            UnitKind::Shared => false,
            UnitKind::Extinction => true,
            UnitKind::Averages { base } | UnitKind::Detail { base, .. } => {
                UNITS.bases(2)[base as usize].item > 0
            }
        };
    of_sun.then_some(unit)
}

#[test]
fn the_least_budget_is_complete_and_a_smaller_one_says_what_it_lacks() {
    let need = everything();
    let least = residency(PLENTY).least_budget(&need);
    for (budget_bytes, is_complete) in
        [(least, true), (least + 5000, true), (least - 1, false), (5000, false)]
    {
        let mut residency = residency(ResidencySettings { budget_bytes, ..PLENTY });
        settle(&mut residency, &need);
        let plan = residency.plan(&need);
        assert_eq!((plan.is_complete, plan.is_final), (is_complete, true), "{budget_bytes}");
        assert_eq!(plan.lacks.is_empty(), is_complete, "{budget_bytes}: {:?}", plan.lacks);
    }
    // One byte short: one species lacks one byte of its sun's light. Of harmonics then none is there.
    let mut residency = residency(ResidencySettings { budget_bytes: least - 1, ..PLENTY });
    settle(&mut residency, &need);
    let [lack] = residency.plan(&need).lacks[..] else { panic!("one lack") };
    assert_eq!((lack.essential, lack.bytes), (Essential::Sun, 1));
    assert_eq!(lack.species, 2, "which is the last of as many pixels");
    assert_eq!(loaded(&residency).filter_map(of_sun_of_2).count(), 0);
}

/// The block map of a species, and the averages of its sky.
fn of_sky(species: usize) -> [UnitId; 2] {
    let mut coarse = UNITS.coarse(species);
    let map = coarse.next().expect("the first unit is the block map");
    let is_average = |unit: &UnitId| matches!(UNITS.get(*unit).kind, UnitKind::Averages { base: 0 });
    [map, coarse.find(is_average).expect("each species here has a sky")]
}

/// Loaded units of a species: its block map, and averages of bases.
fn coarse(residency: &Residency, species: u32) -> [usize; 2] {
    let of_kind = |is_kind: fn(UnitKind) -> bool| {
        let of_species = loaded(residency).map(|unit| UNITS.get(unit)).filter(|unit| unit.species == species);
        of_species.filter(|unit| is_kind(unit.kind)).count()
    };
    [of_kind(|kind| kind == UnitKind::Shared), of_kind(|kind| matches!(kind, UnitKind::Averages { .. }))]
}

#[test]
fn one_species_has_light_before_two_have_block_maps_alone() {
    let [[first, _], [second, _]] = [0, 1].map(of_sky);
    let mut need = everything();
    need.species[2] = SpeciesNeed::default();
    let mut residency =
        residency(ResidencySettings { budget_bytes: memory([first, second].into_iter()), ..PLENTY });
    settle(&mut residency, &need);
    let [map, averages] = coarse(&residency, 0);
    assert!(map == 1 && averages > 0, "{averages} averages");
    assert_eq!(coarse(&residency, 1), [0, 0], "for its averages there is no room");
}

#[test]
fn a_species_whose_block_map_was_given_up_wants_no_memory() {
    let (need, first) = (everything(), of_sky(0)[0]);
    let budget_bytes = memory(of_sky(0).into_iter());
    let mut residency = residency(ResidencySettings { budget_bytes, ..PLENTY });
    assert!(residency.plan(&need).requests.contains(&first));
    assert!(residency.failed(first, true), "it is given up");
    settle(&mut residency, &need);
    let [map, averages] = coarse(&residency, 1);
    assert!(map == 1 && averages > 0, "{averages} averages");
    assert!(residency.plan(&need).lacks.iter().all(|lack| lack.species != 0));
}

#[test]
fn no_sun_needs_no_extinction() {
    let mut residency = residency(PLENTY);
    let mut need = of(2, &[0], true);
    need.species[2].is_now[1..].fill(false);
    settle(&mut residency, &need);
    assert!(loaded(&residency).count() > 2, "the sky's light");
    assert!(!residency.is_loaded(UNITS.extinction(2).expect("of harmonics")));
}

#[test]
fn without_room_for_its_block_map_a_species_has_no_extinction_either() {
    let need = of(2, &(0..UNITS.bases(2).len()).collect::<Vec<_>>(), true);
    let map = UNITS.of_species(2).next().expect("the first unit is the block map");
    let extinction = UNITS.extinction(2).expect("of harmonics");
    let budget_bytes = UNITS.get(map).memory_bytes - 1;
    assert!(UNITS.get(extinction).memory_bytes < budget_bytes, "it would have room");
    let mut residency = residency(ResidencySettings { budget_bytes, ..PLENTY });
    settle(&mut residency, &need);
    assert_eq!(residency.plan(&need).lacks[0].essential, Essential::Sky);
    assert_eq!(loaded(&residency).count(), 0);
}

#[test]
fn what_is_not_wanted_stays_until_its_memory_is_and_the_longest_unused_goes_first() {
    let all_of = |species: usize| -> Vec<usize> { (0..UNITS.bases(species).len()).collect() };
    let two = memory(UNITS.of_species(0)) + memory(UNITS.of_species(2));
    let mut residency = residency(ResidencySettings { budget_bytes: two, ..PLENTY });
    settle(&mut residency, &of(0, &all_of(0), true));
    settle(&mut residency, &of(2, &all_of(2), true));
    assert_eq!(residency.loaded_bytes(), two, "both are there though one alone is seen");
    assert_eq!(settle(&mut residency, &of(0, &all_of(0), true)).len(), 0, "and nothing was asked for again");
    // The second species takes the place of the last used one last.
    let plans = settle(&mut residency, &of(1, &[0, 1], false));
    let evicted: Vec<u32> =
        plans.iter().flat_map(|plan| &plan.evictions).map(|unit| UNITS.get(*unit).species).collect();
    assert!(!evicted.is_empty() && evicted.iter().all(|species| *species == 2), "{evicted:?}");
}

#[test]
fn what_stands_on_an_evicted_unit_goes_before_it() {
    let mut residency = residency(PLENTY);
    settle(&mut residency, &everything());
    residency.set_budget(0);
    let plan = residency.plan(&Need::default());
    assert_eq!((plan.evictions.len(), residency.loaded_bytes()), (UNITS.len(), 0));
    let at = |unit: UnitId| plan.evictions.iter().position(|evicted| *evicted == unit).expect("all of them");
    for unit in UNITS.all() {
        assert!(UNITS.stands_on(unit).is_none_or(|below| at(unit) < at(below)));
    }
}

#[test]
fn requests_are_bounded_in_number_and_bytes_and_one_may_always_go() {
    let few = ResidencySettings { max_requests: 3, ..PLENTY };
    let mut some = residency(few);
    let plan = some.plan(&everything());
    assert_eq!(plan.requests.len(), 3);
    assert_eq!(some.plan(&everything()).requests.len(), 0, "until one of them has come");
    some.loaded(plan.requests[0]);
    assert_eq!(some.plan(&everything()).requests.len(), 1);

    let narrow = ResidencySettings { max_request_bytes: 1, ..PLENTY };
    assert_eq!(residency(narrow).plan(&everything()).requests.len(), 1);
}

#[test]
fn a_failure_is_tried_again_after_a_pause_and_given_up_in_the_end() {
    let need = of(1, &[0], false);
    let mut residency = residency(PLENTY);
    let shared = residency.plan(&need).requests[0];
    let mut frames = Vec::new();
    for failures in 1..=ATTEMPTS {
        assert_eq!(residency.failed(shared, false), failures == ATTEMPTS);
        let pause = (1..10_000).find(|_| !residency.plan(&need).requests.is_empty());
        frames.extend(pause);
    }
    assert_eq!(frames, [30, 60, 120, 240], "then never again");
    assert_eq!(residency.given_up().collect::<Vec<_>>(), [shared]);
    assert!(residency.plan(&need).is_final, "nothing is left to be done");

    let mut residency = Residency::new(Arc::clone(&UNITS), PLENTY);
    let shared = residency.plan(&need).requests[0];
    assert!(residency.failed(shared, true), "bytes that are wrong stay wrong");
}

#[test]
fn what_comes_after_the_budget_shrank_or_without_its_ground_is_not_kept() {
    let need = of(0, &[4], true);
    let mut residency = residency(PLENTY);
    let shared = residency.plan(&need).requests[0];
    residency.loaded(shared);
    let plan = residency.plan(&need);
    let (averages, page) = (plan.requests[0], plan.requests[1]);
    assert!(!residency.can_keep(page), "its averages are still on their way");
    residency.failed(averages, false);
    assert!(!residency.can_keep(page));
    residency.lost(page);
    for unit in &plan.requests[2..] {
        residency.lost(*unit);
    }
    residency.plan(&need);
    residency.set_budget(memory([shared].into_iter()));
    assert_eq!(residency.loaded_bytes(), residency.settings().budget_bytes);
    assert!(residency.plan(&need).requests.is_empty());
}

#[test]
fn a_sun_at_the_edge_of_a_triangle_makes_no_bases_take_turns() {
    // Room for the ground and two of three bases.
    let all = of(0, &[1, 2, 3], false);
    let mut everything = residency(PLENTY);
    settle(&mut everything, &all);
    let base = loaded(&everything).nth(1).map(|unit| UNITS.get(unit).memory_bytes).expect("averages");
    let mut residency =
        residency(ResidencySettings { budget_bytes: everything.loaded_bytes() - base, ..PLENTY });
    settle(&mut residency, &all);
    let mut moves = 0;
    for frame in 0..200 {
        let mut need = all.clone();
        // Which of them is worth most changes from frame to frame, by a fifth.
        for base in 1..4 {
            need.species[0].bases[base] *= if (frame + base) % 3 == 0 { 1.2 } else { 1.0 };
        }
        moves += settle(&mut residency, &need).len();
    }
    assert_eq!(moves, 0);
    let mut need = all;
    need.species[0].bases[1..4].copy_from_slice(&[10.0, 4000.0, 4000.0]);
    assert!(settle(&mut residency, &need).len() <= 1);
    assert!(settle(&mut residency, &need).is_empty());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Whatever frames ask for, and whatever becomes of what is asked: the budget holds, nothing is asked for twice,
    /// nothing is loaded without its ground, and evictions are of what is loaded.
    #[test]
    fn any_course_keeps_the_promises(
        steps in prop::collection::vec((any::<u64>(), 0u8..6, 0u64..200), 1..60), share in 0.0f64..1.2
    ) {
        let full = memory(UNITS.all());
        let mut budget_bytes = (full as f64 * share) as u64;
        let mut residency = residency(ResidencySettings { budget_bytes, max_requests: 40, max_request_bytes: 1 << 20 });
        let mut under_way: Vec<UnitId> = Vec::new();
        let mut there = vec![false; UNITS.len()];
        for (seed, what, amount) in steps {
            let mut need = Need { species: vec![SpeciesNeed::default(); UNITS.species()] };
            for (species, seen) in need.species.iter_mut().enumerate() {
                let value = |base: usize, shift: u32| {
                    let bits = seed.rotate_left((base * 7 + species * 13) as u32 + shift);
                    if bits & 3 == 0 { (bits >> 8 & 1023) as f32 } else { 0.0 }
                };
                seen.pixels = if seed >> species & 1 == 1 { 500.0 } else { 0.0 };
                seen.bases = (0..UNITS.bases(species).len()).map(|base| value(base, 0)).collect();
                seen.is_now = seen.bases.iter().map(|need| *need > 500.0).collect();
                seen.detail = (0..UNITS.bases(species).len()).map(|base| value(base, 17)).collect();
            }
            if what == 5 {
                budget_bytes = full * amount / 200;
                residency.set_budget(budget_bytes);
            }
            let plan = residency.plan(&need);
            for unit in &plan.evictions {
                prop_assert!(std::mem::take(&mut there[unit.index()]), "{unit:?} was not there");
            }
            for unit in &plan.requests {
                prop_assert!(!there[unit.index()] && !under_way.contains(unit), "{unit:?} again");
            }
            let held: u64 = memory(UNITS.all().filter(|unit| there[unit.index()]));
            prop_assert_eq!(held, residency.loaded_bytes());
            if !plan.requests.is_empty() {
                let coming = memory(under_way.iter().chain(&plan.requests).copied());
                prop_assert!(held + coming <= budget_bytes, "{held} + {coming} > {budget_bytes}");
            }
            prop_assert!(held <= budget_bytes || what == 5);
            under_way.extend(plan.requests);
            // Some of it comes, some fails.
            for _ in 0..amount.min(under_way.len() as u64) {
                let unit = under_way.swap_remove(seed as usize % under_way.len());
                match what {
                    1 => drop(residency.failed(unit, false)),
                    _ if residency.can_keep(unit) => {
                        residency.loaded(unit);
                        there[unit.index()] = true;
                    }
                    _ => residency.lost(unit),
                }
            }
            for unit in UNITS.all().filter(|unit| there[unit.index()]) {
                prop_assert!(UNITS.stands_on(unit).is_none_or(|below| there[below.index()]));
            }
        }
    }
}

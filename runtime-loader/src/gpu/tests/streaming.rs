//! What a host does with [`GpuLight`]: pages as they come, budgets, and what is refused.

use flb_format::blocks::CodedBase;
use proptest::prelude::*;

use super::super::layout::{BASE_BYTES, MAX_SPECIES, SPECIES_BYTES, TERM_BYTES};
use super::super::{DeviceError, Gpu, GpuError, GpuLight, GpuSpeciesId, LightSettings, Term};
use super::made::{self, Made, Random};
use super::probe::{self, Ask};

const SMALL: LightSettings = LightSettings { budget_bytes: 2 << 20, most_bases: 8, most_terms: 64 };

fn open(settings: LightSettings) -> (Gpu, GpuLight) {
    let gpu = probe::gpu();
    let light = GpuLight::new(&gpu.device, &gpu.queue, settings).unwrap();
    (gpu, light)
}

fn assert_is(gpu: &Gpu, light: &GpuLight, species: GpuSpeciesId, number: u8, base: &CodedBase) {
    let index = light.base(species, number).expect("it was set");
    for component in 0..base.head().components() {
        let ask = Ask { species, first: index, second: component as u32 };
        let found = probe::texels(gpu, light, ask, base.shared().map.len());
        for (rank, found) in found.chunks_exact(64).enumerate() {
            assert_eq!(
                found,
                base.texels(rank, component),
                "base {number}, component {component}, block {rank}"
            );
        }
    }
}

#[test]
fn pages_may_come_in_any_order_go_and_come_again() {
    let (gpu, mut light) = open(SMALL);
    let random = &mut Random(9);
    let shared = made::shared(random, 32, false, false);
    let empty = light.free_bytes();
    let species = light.add_species(&made::grid(32), &shared).unwrap();
    let bases: Vec<Made> = (0..2).map(|_| made::made(random, &shared, 3, 6)).collect();
    for (number, made) in (0..).zip(&bases) {
        light.set_averages(species, number, &made.base).unwrap();
        assert_is(&gpu, &light, species, number, &made.base);
    }
    let averages_alone = light.free_bytes();
    let mut wanted = [[false; 6]; 2];
    for _ in 0..30 {
        let (number, page) = (random.below(2), random.below(6));
        wanted[number][page] = random.below(3) > 0;
        let coded = bases[number].with(|page| wanted[number][page]);
        let (first, count, _) = bases[number].pages[page];
        light.update_page(species, number as u8, first, count, &coded).unwrap();
        for (number, made) in bases.iter().enumerate() {
            assert_is(&gpu, &light, species, number as u8, &made.with(|page| wanted[number][page]));
        }
    }
    for (number, made) in (0..).zip(&bases) {
        for (first, count, _) in &made.pages {
            light.update_page(species, number, *first, *count, &made.base).unwrap();
        }
    }
    assert_eq!(light.free_bytes(), averages_alone);
    light.remove_species(species).unwrap();
    assert_eq!(light.free_bytes(), empty);
}

#[test]
fn a_full_budget_is_refused_with_its_numbers_and_what_is_there_stays() {
    let random = &mut Random(4);
    let shared = made::shared(random, 32, false, true);
    let made: Vec<Made> = (0..6).map(|_| made::made(random, &shared, 3, 4)).collect();
    let tables = u64::from(MAX_SPECIES) * SPECIES_BYTES + 8 * BASE_BYTES + 64 * TERM_BYTES;
    let (gpu, mut light) = open(LightSettings { budget_bytes: tables + 300_000, ..SMALL });
    assert_eq!(light.size_bytes(), tables + 300_000);
    let species = light.add_species(&made::grid(32), &shared).unwrap();
    let mut held = Vec::new();
    for (number, made) in (0..).zip(&made) {
        let whole = made.with(|_| true);
        let free = light.free_bytes();
        match light.set_base(species, number, &whole) {
            Ok(_) => held.push((number, whole)),
            Err(error) => {
                let GpuError::Full { needed, free: left, largest, budget: 300_000 } = error else {
                    panic!("{error}")
                };
                assert!(needed > largest && largest <= left, "{error}");
                let text = error.to_string();
                assert!(text.contains(&needed.to_string()) && text.contains("300000"), "{text}");
                assert_eq!((light.free_bytes(), light.base(species, number)), (free, None));
            }
        }
    }
    assert!((1..6).contains(&held.len()), "{} of 6 fit", held.len());
    held.iter().for_each(|(number, base)| assert_is(&gpu, &light, species, *number, base));
    let taken = 300_000 - light.free_bytes();
    let tables = SPECIES_BYTES + BASE_BYTES * held.len() as u64;
    assert_eq!(light.species_bytes(species).unwrap(), taken + tables);
}

#[test]
fn what_is_not_there_or_does_not_belong_is_refused() {
    let (_gpu, mut light) = open(SMALL);
    let random = &mut Random(2);
    let grid = made::grid(16);
    let [shared, other] = [false, true].map(|haar| made::shared(random, 16, haar, true));
    let base = made::made(random, &shared, 3, 2).with(|_| true);
    let stranger = made::made(random, &other, 3, 2).base;
    let says = |error: GpuError, text: &str| assert!(error.to_string().contains(text), "{error}: {text}");

    says(light.set_base(GpuSpeciesId(0), 0, &base).unwrap_err(), "species 0 is not on the GPU");
    says(light.remove_species(GpuSpeciesId(0)).unwrap_err(), "species 0 is not on the GPU");
    let species = light.add_species(&grid, &shared).unwrap();
    says(light.update_page(species, 3, 0, 1, &base).unwrap_err(), "base 3 of species 0 is not on the GPU");
    says(light.set_base(species, 3, &stranger).unwrap_err(), "another block map or class tables");
    let many = made::made(random, &shared, 4, 1).base;
    says(light.set_base(species, 3, &many).unwrap_err(), "base 3 has 4 bands or components, expected 1 to 3");
    light.set_averages(species, 3, &base).unwrap();
    let another = made::made(random, &shared, 3, 2).with(|_| true);
    says(light.update_page(species, 3, 0, 1, &another).unwrap_err(), "another head");
    says(light.update_page(species, 3, 60, 5, &base).unwrap_err(), "expected at least 1, of 64 stored ones");
    says(light.update_page(species, 3, 6, 0, &base).unwrap_err(), "expected at least 1");
    light.update_page(species, 3, 10, 10, &base).unwrap();
    for (first, count) in [(0, 11), (19, 1), (10, 9), (12, 2), (10, 11)] {
        let error = light.update_page(species, 3, first, count, &base).unwrap_err();
        says(error, "overlap the page of 10 blocks from 10 on");
    }
    light.update_page(species, 3, 0, 10, &base).unwrap();
    light.update_page(species, 3, 20, 1, &base).unwrap();
    says(light.set_terms(64, &[Term { base: 0, factor: 1.0 }]).unwrap_err(), "room for 64 terms");
    (10..17).for_each(|number| assert!(light.set_averages(species, number, &base).is_ok()));
    says(light.set_averages(species, 17, &base).unwrap_err(), "room for 8 bases");
    light.remove_base(species, 3).unwrap();
    says(light.remove_base(species, 3).unwrap_err(), "base 3 of species 0 is not on the GPU");
    assert!(light.set_averages(species, 17, &base).is_ok());
    light.remove_species(species).unwrap();
    (0..MAX_SPECIES)
        .for_each(|number| assert_eq!(light.add_species(&grid, &shared), Ok(GpuSpeciesId(number))));
    says(light.add_species(&grid, &shared).unwrap_err(), "room for 256 species");
}

#[test]
fn a_budget_that_cannot_be_is_refused() {
    let gpu = probe::gpu();
    for budget_bytes in [0, 9000, 200 << 20] {
        let error = GpuLight::new(&gpu.device, &gpu.queue, LightSettings { budget_bytes, ..SMALL });
        let Err(GpuError::Budget { found, least, most }) = error else { panic!("{budget_bytes} was taken") };
        assert!(found == budget_bytes && least < most && (found < least || found > most));
    }
}

#[test]
fn an_adapter_that_is_missing_is_told_with_what_to_install() {
    let none = DeviceError::NoAdapter { looked_for: "VULKAN".to_owned(), message: "none".to_owned() };
    let error = GpuError::from(none);
    assert!(error.to_string().contains("mesa-vulkan-drivers"));
    let old = DeviceError::Refused { adapter: "old".to_owned(), message: "limits".to_owned() };
    let error = GpuError::from(old);
    assert_eq!(error.to_string(), "old: cannot be opened: limits");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]

    #[test]
    fn whatever_is_set_and_removed_the_budget_holds_and_all_comes_back(seed: u64) {
        let random = &mut Random(seed);
        let tables = u64::from(MAX_SPECIES) * SPECIES_BYTES + 8 * BASE_BYTES + 64 * TERM_BYTES;
        let (gpu, mut light) = open(LightSettings { budget_bytes: tables + 60_000, ..SMALL });
        let shared = made::shared(random, 16, seed % 2 == 0, true);
        let made: Vec<Made> = (0..8).map(|_| made::made(random, &shared, 3, 4)).collect();
        let species = light.add_species(&made::grid(16), &shared).expect("it fits");
        let before = light.free_bytes();
        for _ in 0..60 {
            let number = random.below(8);
            let coded = made[number].with(|_| true);
            let (first, count, _) = made[number].pages[random.below(4)];
            // Refusals are part of it.
            match random.below(3) {
                0 => { let _ = light.set_averages(species, number as u8, &made[number].base); }
                1 => { let _ = light.update_page(species, number as u8, first, count, &coded); }
                _ => { let _ = light.remove_base(species, number as u8); }
            }
            prop_assert!(light.species_bytes(species).expect("it is there") <= tables + 60_000);
        }
        (0..8).for_each(|number| { let _ = light.remove_base(species, number); });
        prop_assert_eq!(light.free_bytes(), before);
        prop_assert_eq!(gpu.check(), Ok(()));
    }
}

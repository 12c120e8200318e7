//! Light by a pool of cursors against that of cursors alone.

use std::panic::{AssertUnwindSafe, catch_unwind};

use super::*;
use crate::light::cursors::LightCursors;

/// Plants of two files, more than a thread keeps, one without light among them.
const PLANTS: usize = 12;
const UNLIT: usize = 5;
const POINTS: u32 = 600;

/// Mostly the plant of the point before, as neighbouring pixels have it.
fn asked(seed: u32) -> (usize, [f32; 3]) {
    ((seed / 7) as usize % PLANTS, point(seed / 3).map(|c| c + 0.01 * (seed % 3) as f32))
}

fn bits(light: [f32; BANDS]) -> [u32; BANDS] {
    light.map(f32::to_bits)
}

fn by_pool(cursors: &LightCursors<'_>, seed: u32) -> [u32; BANDS] {
    let ((plant, at), mut out) = (asked(seed), [f32::NAN; BANDS]);
    cursors.at(plant, at, &mut out);
    bits(out)
}

/// The light of [`PLANTS`], and what new cursors say of each point.
fn with_plants(test: impl Fn(&[Option<InstanceLight<'_>>], &[[u32; BANDS]])) {
    let suns = SunBasis::Harmonics { degree: 2, single: true, leaning: true };
    let library = library(&plant("oak", Some(&suns), LATTICE, 3), Codec::Classed);
    let (resident, file) = (resident(&library), SpeciesLight::load(&library, 0).expect("it loads"));
    let streamed = SpeciesLight::streamed(resident.species(0));
    let plants: Vec<_> = (0..PLANTS)
        .map(|number| {
            let species = if number % 2 == 0 { &file } else { &streamed };
            let day = Daylight { towards_sun: towards_sun(30.0 * number as f64, 40.0), ..days()[0] };
            (number != UNLIT).then(|| species.lit_by_in_model(&day).expect("a sun"))
        })
        .collect();
    let alone = |seed| {
        let ((number, at), mut out) = (asked(seed), [0.0; BANDS]);
        if let Some(light) = &plants[number] {
            light.cursor().at(at, &mut out);
        }
        bits(out)
    };
    test(&plants, &(0..POINTS).map(alone).collect::<Vec<_>>());
}

#[test]
fn any_number_of_threads_finds_the_light_of_cursors_alone_to_the_bit() {
    with_plants(|plants, expected| {
        // Fewer slots than threads, too.
        for (threads, slots) in [(1, 1), (2, 2), (3, 8), (5, 2), (8, 1)] {
            let cursors = LightCursors::with_slots(plants, slots);
            std::thread::scope(|scope| {
                for thread in 0..threads {
                    let cursors = &cursors;
                    // Each begins elsewhere.
                    let order = move |i: u32| (i + thread * POINTS / threads) % POINTS;
                    scope.spawn(move || {
                        for seed in (0..POINTS).map(order) {
                            let found = by_pool(cursors, seed);
                            assert_eq!(found, expected[seed as usize], "{threads} threads, {slots} slots");
                        }
                    });
                }
            });
        }
    });
}

#[test]
fn a_thread_that_panics_leaves_the_light_of_others_as_it_is() {
    with_plants(|plants, expected| {
        let cursors = LightCursors::with_slots(plants, 1);
        for seed in 0..60 {
            let short = catch_unwind(AssertUnwindSafe(|| cursors.at(0, point(seed), &mut [0.0; 1])));
            assert!(short.is_err(), "a value per band is needed");
            assert_eq!(by_pool(&cursors, seed), expected[seed as usize]);
        }
    });
}

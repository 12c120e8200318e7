//! Fields judged by traced suns: a planted error is found, and it does not matter how the beam is stored.

use flb_format::light::FieldKind;

use super::super::judge::{Judgement, MAX_SUNS, Truth, photons, suns};
use super::*;
use crate::ordinates::{self, OrdinatesSettings, OrdinatesSolution};

fn judged(
    medium: &TurbidMedium,
    settings: &OrdinatesSettings,
    change: impl Fn(&mut OrdinatesSolution),
) -> Judgement {
    let scatter = alike(0.8, Phase::BiLambert { transmitted: 0.5 });
    let sites = medium.sites();
    let near = [ordinates::near(medium, &sites, settings.suns.needs_single())];
    let mut solution = ordinates::solve(medium, &[scatter], settings, &|_| Ok(())).unwrap();
    change(&mut solution);
    let of_sun = |&sun: &[f64; 3]| {
        let truth = Truth::trace(medium, &near, &[scatter], None, sun, 1 << 16, &|_| Ok(())).unwrap();
        truth.difference(&solution, settings, 0, &sites).unwrap()
    };
    Judgement::over(&suns(3).iter().map(of_sun).collect::<Vec<_>>()).unwrap()
}

#[test]
fn a_planted_error_of_the_fields_is_found() {
    let (medium, settings) = (ball(3.0), OrdinatesSettings::default());
    let good = judged(&medium, &settings, |_| {});
    assert!(good.rms < 0.02 && good.bias.abs() < 0.01 && good.suns == 3, "{good:?}");
    assert!(good.worst >= good.rms && good.rms_error < 0.005, "{good:?}");
    let bright = judged(&medium, &settings, |solution| {
        solution
            .fields
            .iter_mut()
            .for_each(|(_, field)| field.values_mut().iter_mut().for_each(|v| *v *= 1.2));
    });
    // Scattered light is about a third of the total here, and a fifth of that was added.
    assert!(bright.bias > good.bias + 0.04 && bright.rms > 0.04, "{bright:?}");
}

#[test]
fn fields_that_hold_the_beam_are_judged_alike() {
    let (medium, settings) = (ball(1.0), OrdinatesSettings::default());
    let scattered = judged(&medium, &settings, |_| {});
    let total = judged(&medium, &OrdinatesSettings::of_field(FieldKind::Total), |_| {});
    assert!((scattered.rms - total.rms).abs() < 1e-5, "{scattered:?}, {total:?}");
    assert!((scattered.bias - total.bias).abs() < 1e-5, "{scattered:?}, {total:?}");
}

#[test]
fn suns_are_unit_vectors_apart_and_fewer_are_the_first_of_more() {
    let all = suns(MAX_SUNS);
    assert_eq!((all.len(), suns(0).len()), (MAX_SUNS, 0));
    assert_eq!(suns(5), all[..5]);
    for (i, a) in all.iter().enumerate() {
        let dot = |b: &[f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        assert!((dot(a) - 1.0).abs() < 1e-12, "{a:?}");
        assert!(all[..i].iter().all(|b| dot(b) < 0.98), "sun {i} stands beside another");
    }
    assert_eq!(Judgement::over(&[]), None);
}

#[test]
fn larger_plants_are_given_more_photons_within_limits() {
    assert_eq!([1, 40_000, 1 << 30].map(photons), [1 << 16, 1 << 18, 1 << 20]);
}

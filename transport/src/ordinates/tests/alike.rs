//! Many bands, of which a few are solved for every sun.

use super::*;
use crate::ordinates::alike::MIN_BANDS;

/// Leaves and wood from blue to the near infrared: what both scatter grows, and what leaves let through.
fn spectrum(bands: usize) -> Vec<BandScatter> {
    let band = |number: usize| {
        let red = number as f64 / (bands - 1) as f64;
        let scatter = |albedo, transmitted| Scatter { albedo, phase: Phase::BiLambert { transmitted } };
        let bump = libm::exp(-libm::pow((red - 0.35) / 0.1, 2.0));
        BandScatter {
            leaf: scatter(0.06 + 0.2 * bump + 0.8 / (1.0 + libm::exp(25.0 * (0.75 - red))), 0.3 + 0.2 * red),
            wood: scatter(0.1 + 0.4 * red, 0.0),
        }
    };
    (0..bands).map(band).collect()
}

fn tree() -> TurbidMedium {
    let mut medium = clumps(16);
    for (site, wood) in medium.wood_per_m.iter_mut().enumerate().step_by(9) {
        std::mem::swap(wood, &mut medium.leaf_per_m[site]);
    }
    medium
}

fn settings() -> OrdinatesSettings {
    OrdinatesSettings { ordinates: Ordinates::Lebedev50, ..OrdinatesSettings::default() }
}

#[test]
fn many_bands_have_nearly_the_light_that_each_has_alone() {
    let (medium, settings, bands) = (tree(), settings(), spectrum(24));
    let sites = medium.sites();
    let near = near(&medium, &sites, true);
    let together = solve(&medium, &bands, &settings, &|_| Ok(())).unwrap();
    let whole = together.reports.iter().filter(|report| report.solves == settings.solves()).count();
    assert!((4..=12).contains(&whole), "{whole} of 24 bands were solved for every sun");
    let suns = [[0.48, 0.6, 0.64], [0.8, 0.0, -0.6], [0.0, 1.0, 0.0]];
    let (mut passes, mut passes_alone) = (0, 0);
    for (number, band) in (0u32..).zip(&bands) {
        let alone = solved(&medium, *band, &settings);
        for sun in suns {
            let beam = near.beam(sun, BEAM_RAYS);
            let of =
                |solution: &OrdinatesSolution, band| solution.light(&settings.suns, band, &sites, sun, &beam);
            let off = relative_rms(&of(&together, number), &of(&alone, 0), &beam.beam.mean);
            assert!(off < 1e-3, "band {number}: {off}");
        }
        let (reports, alone_passes) = (&together.reports, alone.reports[0].passes);
        let [together, alone] =
            [&together.reports[number as usize], &alone.reports[0]].map(|of| of.suns_rms.unwrap());
        assert!((together / alone - 1.0).abs() < 0.05, "band {number}: stated {together}, alone {alone}");
        assert!(together > 0.0);
        let report = &reports[number as usize];
        assert!(report.converged, "band {number}");
        if report.solves < settings.solves() {
            passes += report.passes;
            passes_alone += alone_passes;
        }
    }
    // They start from a guess.
    assert!(10 * passes < 6 * passes_alone, "{passes} passes, alone {passes_alone}");
}

#[test]
fn a_few_bands_are_each_solved_for_every_sun() {
    let (medium, settings) = (tree(), settings());
    let solution = solve(&medium, &spectrum(MIN_BANDS - 1), &settings, &|_| Ok(())).unwrap();
    assert!(solution.reports.iter().all(|report| report.solves == settings.solves()));
}

#[test]
fn many_bands_of_one_colour_are_solved_once() {
    let (medium, settings) = (tree(), settings());
    let bands = vec![spectrum(3)[1]; MIN_BANDS];
    let solution = solve(&medium, &bands, &settings, &|_| Ok(())).unwrap();
    let solves: Vec<u32> = solution.reports.iter().map(|report| report.solves).collect();
    assert_eq!(solves[0], settings.solves());
    assert_eq!(solves[1..], [6; MIN_BANDS - 1]);
    for (_, field) in &solution.fields {
        for band in 1..MIN_BANDS as u32 {
            let (first, other) = (field.band(0), field.band(band));
            let worst = first.iter().zip(other.iter()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(worst < 2e-3, "{worst}");
        }
    }
}

#[test]
fn many_bands_in_which_nothing_is_scattered_are_dark() {
    let dark = both(0.0, Phase::ISOTROPIC);
    let solution = solve(&tree(), &vec![dark; MIN_BANDS], &settings(), &|_| Ok(())).unwrap();
    // All but the sky's, which is its open part.
    for (_, field) in &solution.fields[1..] {
        assert!(field.values().iter().all(|value| *value == 0.0));
    }
    let empty = medium(16, |_| 0.0);
    let solution = solve(&empty, &spectrum(MIN_BANDS), &settings(), &|_| Ok(())).unwrap();
    assert_eq!(solution.reports.len(), MIN_BANDS);
}

#[test]
fn lists_of_directions_are_blended_from_alike_bands_too() {
    let settings = OrdinatesSettings { suns: ico12(), ..settings() };
    let (medium, bands) = (tree(), spectrum(MIN_BANDS + 3));
    let together = solve(&medium, &bands, &settings, &|_| Ok(())).unwrap();
    assert!(together.reports.iter().any(|report| report.solves < settings.solves()));
    let alone = solved(&medium, bands[7], &settings);
    let (a, b) = (together.fields[5].1.band(7), alone.fields[5].1.band(0));
    let at_sites =
        |values: &[f32]| -> Vec<f32> { medium.sites().iter().map(|&s| values[s as usize]).collect() };
    let direct = near(&medium, &medium.sites(), false).beam(ico_sun(&settings, 4), BEAM_RAYS).beam.mean;
    let off = relative_rms(&at_sites(&a), &at_sites(&b), &direct);
    assert!(off < 1e-3, "{off}");
}

/// A direction of a list.
fn ico_sun(settings: &OrdinatesSettings, number: usize) -> [f64; 3] {
    let SunBasis::Directions(list) = &settings.suns else { unreachable!("it is a list") };
    list.directions()[number]
}

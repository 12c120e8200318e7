//! Sites whose leaves let different shares through.

use super::*;

/// Directions in which light is followed are few: a phase function normalised over them is not quite the sum of two
/// that are.
const NORMALISED: f64 = 2e-3;

fn light(
    medium: &TurbidMedium,
    band: BandScatter,
    transmitted: Option<&[f32]>,
    settings: &OrdinatesSettings,
) -> Vec<f32> {
    let albedos = vec![[band.leaf.albedo as f32, band.wood.albedo as f32]; medium.sites().len()];
    let transmitted = transmitted.map(<[f32]>::to_vec);
    let surroundings = Surroundings {
        albedos: Some(std::slice::from_ref(&albedos)),
        transmitted: transmitted.as_ref().map(std::slice::from_ref),
        ..Surroundings::NONE
    };
    solve_among(medium, &[band], &surroundings, settings, &|_| Ok(())).unwrap().fields[3]
        .1
        .values()
        .into_owned()
}

fn rms_apart(a: &[f32], b: &[f32]) -> f64 {
    let square: f64 = a.iter().zip(b).map(|(a, b)| f64::from(a - b) * f64::from(a - b)).sum();
    let all: f64 = b.iter().map(|b| f64::from(*b) * f64::from(*b)).sum();
    libm::sqrt(square / all)
}

#[test]
fn sites_with_the_share_of_their_band_scatter_as_the_band_does() {
    let medium = clumps(16);
    let leaf = |transmitted: f64| {
        let band = both(0.8, Phase::BiLambert { transmitted });
        BandScatter { wood: Scatter { albedo: 0.8, phase: Phase::BiLambert { transmitted: 0.0 } }, ..band }
    };
    let settings = OrdinatesSettings { ordinates: Ordinates::Lebedev50, ..LATTICE18 };
    for settings in [settings.clone(), OrdinatesSettings { parts: 2, ..settings }] {
        let expected = light(&medium, leaf(0.2), None, &settings);
        let mixed = light(&medium, leaf(0.2), Some(&vec![0.2; medium.sites().len()]), &settings);
        let apart = rms_apart(&mixed, &expected);
        assert!(apart < NORMALISED, "{apart}");
        // What the sites say counts, not what the band says; and it makes a difference that is seen.
        assert_eq!(light(&medium, leaf(0.9), Some(&vec![0.2; medium.sites().len()]), &settings), mixed);
        let through = light(&medium, leaf(0.2), Some(&vec![0.9; medium.sites().len()]), &settings);
        assert!(rms_apart(&through, &expected) > 5.0 * NORMALISED);
    }
}

#[test]
fn shares_out_of_range_are_refused_by_name() {
    let medium = ball(16, 1.0);
    let sites = medium.sites().len();
    let refused = |transmitted: &[Vec<f32>]| {
        let surroundings = Surroundings { transmitted: Some(transmitted), ..Surroundings::NONE };
        let bands = [both(0.5, Phase::ISOTROPIC)];
        solve_among(&medium, &bands, &surroundings, &LATTICE18, &|_| Ok(())).unwrap_err().to_string()
    };
    assert_eq!(
        refused(&[]),
        "transmitted shares of sites is those of 0 bands, expected one list for each band"
    );
    let short =
        format!("list of transmitted shares has 1 values, expected one for each of the {sites} sites");
    assert_eq!(refused(&[vec![0.5]]), short);
    assert_eq!(refused(&[vec![1.5; sites]]), "transmitted share of a site is 1.5, expected 0 to 1");
}

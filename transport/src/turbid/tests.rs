use flb_format::matter::{BandSurfaces, LeafSurface, WoodSurface};

use super::phase::{Phase, legendre};
use super::{Facets, LeafAngles, scatter};

/// Midpoint sum of `f` over 0..=1.
fn mean(f: impl Fn(f64) -> f64) -> f64 {
    const STEPS: usize = 20_000;
    (0..STEPS).map(|i| f((i as f64 + 0.5) / STEPS as f64)).sum::<f64>() / STEPS as f64
}

#[test]
fn every_phase_function_spreads_what_it_scatters_over_the_sphere() {
    for phase in [
        Phase::ISOTROPIC,
        Phase::HenyeyGreenstein { g: 0.5 },
        Phase::HenyeyGreenstein { g: -0.7 },
        Phase::BiLambert { transmitted: 0.0 },
        Phase::BiLambert { transmitted: 0.4 },
        Phase::BiLambert { transmitted: 1.0 },
    ] {
        for l in 0..4 {
            let moment = mean(|t| phase.at(2.0 * t - 1.0) * legendre(l, 2.0 * t - 1.0));
            assert!((moment - phase.moment(l)).abs() < 1e-5, "{phase:?}, degree {l}: {moment}");
        }
    }
}

#[test]
fn facets_scatter_an_even_part_that_all_share_and_an_odd_part_of_what_passes() {
    for step in 0..=200 {
        let cosine = f64::from(step) / 100.0 - 1.0;
        let even = 8.0 / (3.0 * std::f64::consts::PI)
            * (libm::sqrt(1.0 - cosine * cosine) + cosine * libm::asin(cosine));
        for transmitted in [0.0, 0.3, 0.5, 1.0] {
            let expected = even + (2.0 * transmitted - 1.0) * 4.0 / 3.0 * cosine;
            let found = Phase::BiLambert { transmitted }.at(cosine);
            assert!((found - expected).abs() < 1e-12, "{cosine}, {transmitted}: {found}, {expected}");
        }
    }
}

#[test]
fn mean_cosine_of_facets_is_four_ninths_of_what_the_papers_take() {
    let (r, t) = (0.07, 0.055);
    let g = Phase::BiLambert { transmitted: t / (r + t) }.moment(1);
    assert!((g - 4.0 / 9.0 * (t - r) / (t + r)).abs() < 1e-9, "{g}");
}

#[test]
fn leaves_scatter_by_what_they_reflect_and_transmit() {
    let leaf = LeafSurface { reflectance: 0.125, transmittance: 0.150 }; // green, Knapp and Carter (1998)
    let wood = WoodSurface { reflectance: 0.123 };
    let green = scatter(&BandSurfaces { name: "G".to_owned(), leaf, wood });
    assert!((green.leaf.albedo - 0.275).abs() < 1e-15);
    // The papers' g times 4/9 (lighting model, section 9).
    let g = (0.150 - 0.125) / (0.150 + 0.125);
    assert!((green.leaf.phase.moment(1) - 4.0 / 9.0 * g).abs() < 1e-9);
    assert_eq!(green.wood.albedo, 0.123);
    assert_eq!(green.wood.phase, Phase::BiLambert { transmitted: 0.0 });
}

#[test]
fn a_black_leaf_scatters_nothing_and_has_a_phase() {
    let leaf = LeafSurface { reflectance: 0.0, transmittance: 0.0 };
    let wood = WoodSurface { reflectance: 0.0 };
    let black = scatter(&BandSurfaces { name: "R".to_owned(), leaf, wood });
    assert_eq!(black.leaf.albedo, 0.0);
    assert!(black.leaf.phase.at(0.3).is_finite());
}

#[test]
fn facets_scatter_what_leaves_of_their_inclinations_meet() {
    let directions = flb_format::ordinates::Ordinates::Lebedev110.directions();
    for angles in [LeafAngles::planophile(), LeafAngles::erectophile()] {
        let facets = Facets::new(&angles).unwrap();
        for from in &directions {
            let mut sum = [0.0; 2];
            for to in &directions {
                let [through, back] = facets.scattered(from.direction, to.direction);
                let [through_again, _] = facets.scattered(to.direction, from.direction);
                assert!((through - through_again).abs() < 1e-12, "light finds its way back");
                assert_eq!([back, through], facets.scattered(from.direction, to.direction.map(|c| -c)));
                sum[0] += to.weight * through;
                sum[1] += to.weight * back;
            }
            let met = angles.relative(from.direction[1]);
            for side in sum {
                assert!((side / met - 1.0).abs() < 0.02, "{side} of {met} from {:?}", from.direction);
            }
        }
    }
}

#[test]
fn facets_of_any_inclination_are_the_phase_function() {
    // Inclinations as those of a sphere, but for what rounding lets tell apart.
    let mut areas = [1.0; super::INCLINATIONS];
    areas[0] = 1.0 + 1e-9;
    let facets = Facets::new(&LeafAngles::from_areas(areas).unwrap()).unwrap();
    let from = [0.6, 0.0, 0.8];
    for to in [[0.0, 1.0, 0.0], [0.48, 0.6, 0.64], [0.6, 0.0, 0.8], [-0.8, 0.0, 0.6]] {
        let cosine = (0..3).map(|i| from[i] * to[i]).sum::<f64>();
        let expected = [1.0, 0.0].map(|transmitted| Phase::BiLambert { transmitted }.at(cosine));
        for (found, expected) in facets.scattered(from, to).into_iter().zip(expected) {
            assert!((found - expected).abs() < 0.01, "{found}, expected {expected}, towards {to:?}");
        }
    }
}

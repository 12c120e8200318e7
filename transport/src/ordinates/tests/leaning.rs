//! Leaves that favour an inclination meet more of the light that comes across them.

use super::*;

/// A third of the scattered light passes the leaves.
const LEAF: Phase = Phase::BiLambert { transmitted: 0.33 };

fn leaning(medium: TurbidMedium) -> [TurbidMedium; 2] {
    [LeafAngles::planophile(), LeafAngles::erectophile()]
        .map(|angles| TurbidMedium { angles, ..medium.clone() })
}

#[test]
fn light_of_a_sun_agrees_with_monte_carlo_whatever_way_leaves_lean() {
    // Light of the lattice's directions 4, 2 and 8: from straight above, from the side, and from between.
    let suns = [(4, [0.0, 1.0, 0.0]), (2, [1.0, 0.0, 0.0]), (8, [0.5, 0.5, 0.0])];
    for (medium, albedo) in [(ball(32, 3.0), 0.9), (ball(32, 10.0), 0.9), (clumps(32), 0.3)] {
        for medium in leaning(medium) {
            let scatter = both(albedo, LEAF);
            let sites = medium.sites();
            let solution = solved(&medium, scatter, &FINE18);
            for (item, towards) in suns {
                let length = libm::sqrt(towards.iter().map(|c: &f64| c * c).sum());
                let sun = Illumination::Sun(towards.map(|c| c / length));
                let trace = |seed| -> Fluence {
                    let settings = monte_carlo::Settings { photons: 1 << 16, seed, ..Default::default() };
                    monte_carlo::trace(&medium, &scatter, sun, &settings, &|_| Ok(())).unwrap()
                };
                let field = &solution.fields[item].1;
                let found: Vec<f64> =
                    sites.iter().map(|&site| f64::from(field.value(0, site as usize))).collect();
                let traced = [&trace(1), &trace(2)];
                let off = monte_carlo::compare(&found, traced, ComparedLight::Scattered).unwrap();
                let of = format!("albedo {albedo}, {sun:?}, {:?}: {off:?}", medium.angles.relative(1.0));
                assert!(off.bias.abs() < 0.015 && off.rms < 0.05, "{of}");
            }
        }
    }
}

#[test]
fn leaves_that_absorb_nothing_stay_in_balance_with_the_sky() {
    for medium in leaning(clumps(16)) {
        let settings = OrdinatesSettings { tolerance: 1e-5, ..OrdinatesSettings::default() };
        let solution = solved(&medium, both(1.0, LEAF), &settings);
        for site in medium.sites() {
            let sky = solution.fields[0].1.value(0, site as usize);
            assert!((sky - 1.0).abs() < 5e-3, "{sky}");
        }
    }
}

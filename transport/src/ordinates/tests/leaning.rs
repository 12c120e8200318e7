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

#[test]
fn a_near_beam_that_counts_as_often_as_leaves_meet_it_fits_better() {
    for medium in leaning(ball(32, 3.0)) {
        let error = |leaning| {
            let suns = SunBasis::Harmonics { degree: 2, single: true, leaning };
            let settings = OrdinatesSettings { suns, ..OrdinatesSettings::default() };
            solved(&medium, both(0.3, LEAF), &settings).reports[0].suns_rms.unwrap()
        };
        let [once, often] = [false, true].map(error);
        assert!(often < 0.7 * once, "{often} for {once}");
    }
}

#[test]
fn leaves_meet_of_each_beam_what_their_inclinations_say() {
    let [medium, _] = leaning(ball(16, 3.0));
    let sites = medium.sites();
    let near = near(&medium, &sites, false);
    let beyond = solved(&medium, both(0.3, LEAF), &LATTICE18).total.beyond;
    for (item, found) in beyond.iter().enumerate() {
        let sun = SunBasis::Lattice18.sun_of(1 + item as u8).unwrap();
        let more = medium.angles.relative(sun[1]) as f32 - 1.0;
        for (found, beam) in found.iter().zip(near.beam(sun, flb_format::beam::BEAM_RAYS).beam.mean) {
            assert!((found - more * beam).abs() < 1e-6, "{item}: {found}");
        }
    }
    // Of all suns together they meet as much as leaves at random; those behind others less of the steep ones.
    let suns = SunBasis::Harmonics { degree: 1, single: true, leaning: true };
    let settings = OrdinatesSettings { suns, ..OrdinatesSettings::default() };
    let of_all = solved(&medium, both(0.3, LEAF), &settings).total.beyond;
    assert_eq!(of_all.len(), 4);
    assert!(of_all[0].iter().all(|mean| mean.abs() < 0.1), "{:?}", of_all[0]);
    let upright = TurbidMedium { angles: LeafAngles::spherical(), ..medium };
    assert!(solved(&upright, both(0.3, LEAF), &LATTICE18).total.beyond.is_empty());
}

//! What holds whatever the medium: energy, symmetry, one light by two ways, the same bytes.

use super::*;

const SUN: Illumination = Illumination::Sun([0.48, 0.8, 0.36]);

const FACETS: Phase = Phase::BiLambert { transmitted: 0.3 };

/// Bytes that two results must share.
fn bits(fluence: &Fluence) -> Vec<u64> {
    let all = [&fluence.uncollided, &fluence.scattered, &fluence.error];
    all.iter().flat_map(|values| values.iter().map(|value| value.to_bits())).collect()
}

/// Site by site: the squared difference of two independent estimates, in squared standard errors.
fn squared_scores(a: &Fluence, b: &Fluence) -> Vec<f64> {
    let score = |i: usize| (a.scattered[i] - b.scattered[i]) / libm::hypot(a.error[i], b.error[i]);
    (0..a.error.len()).map(|i| score(i) * score(i)).collect()
}

/// Power that meets matter: extinction times fluence, over all sites; in m^2.
fn intercepted(medium: &TurbidMedium, uncollided: &[f64], up: f64) -> f64 {
    let volume = medium.grid.spacing_m * medium.grid.spacing_m * medium.grid.spacing_m;
    let met = |(&site, phi): (&u32, &f64)| medium.extinction_along(site as usize, up) * phi * volume;
    medium.sites().iter().zip(uncollided).map(met).sum()
}

#[test]
fn what_is_intercepted_is_absorbed_or_escapes() {
    for albedo in [0.04, 0.5, 0.9] {
        for light in [SUN, Illumination::Sky] {
            let f = trace(&clumps(), &alike(albedo, FACETS), light, &photons(1 << 16), &quiet).unwrap();
            let escaped: f64 = f.balance.escaped.iter().sum();
            // Absorption is anticorrelated with escape, so escape's error serves for the sum; roulette is all that is
            // left.
            let (sum, expected) = (f.balance.absorbed + escaped, f.balance.intercepted);
            assert_within(
                sum,
                f.balance.escaped_error,
                expected,
                0.01,
                &format!("albedo {albedo}, {light:?}"),
            );
        }
    }
}

#[test]
fn absorption_by_fluence_is_absorption_by_collisions() {
    let medium = ball(4.0);
    let f = trace(&medium, &alike(0.7, Phase::ISOTROPIC), SUN, &photons(1 << 17), &quiet).unwrap();
    let by_fluence = 0.3 * intercepted(&medium, &f.total(), 0.8);
    assert_within(by_fluence, 1e-3 * by_fluence, f.balance.absorbed, 2e-3, "absorbed");
}

#[test]
fn everything_escapes_where_nothing_is_absorbed() {
    for medium in [ball(6.0), clumps()] {
        for phase in [Phase::ISOTROPIC, Phase::HenyeyGreenstein { g: 0.8 }, FACETS] {
            let f = trace(&medium, &alike(1.0, phase), SUN, &photons(1 << 15), &quiet).unwrap();
            assert_eq!(f.balance.absorbed, 0.0);
            let escaped = f.balance.escaped.iter().sum();
            assert_within(
                escaped,
                f.balance.escaped_error,
                f.balance.intercepted,
                0.01,
                &format!("{phase:?}"),
            );
        }
    }
}

#[test]
fn inclined_leaves_conserve_energy_and_shadow_what_they_meet() {
    for angles in [LeafAngles::planophile(), LeafAngles::erectophile()] {
        let medium = TurbidMedium { angles, ..clumps() };
        for light in [Illumination::Sun([0.0, 1.0, 0.0]), SUN] {
            let f = trace(&medium, &alike(1.0, FACETS), light, &photons(1 << 16), &quiet).unwrap();
            let escaped = f.balance.escaped.iter().sum();
            assert_within(escaped, f.balance.escaped_error, f.balance.intercepted, 0.01, "escaped");
            let Illumination::Sun([_, up, _]) = light else { unreachable!() };
            let met = intercepted(&medium, &f.uncollided, up);
            assert!((met / f.balance.intercepted - 1.0).abs() < 2e-3, "{met} {}", f.balance.intercepted);
        }
    }
}

#[test]
fn first_collisions_take_what_the_beam_loses() {
    for medium in [ball(1.0), ball(30.0), clumps()] {
        for toward in [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.48, 0.8, 0.36], [-0.6, -0.48, 0.64]] {
            let light = Illumination::Sun(toward);
            let f = trace(&medium, &alike(0.0, Phase::ISOTROPIC), light, &photons(1 << 16), &quiet).unwrap();
            assert!(f.scattered.iter().all(|&value| value == 0.0));
            let met = intercepted(&medium, &f.uncollided, toward[1]);
            assert!((met / f.balance.intercepted - 1.0).abs() < 2e-3, "{met} {}", f.balance.intercepted);
        }
    }
}

#[test]
fn delta_tracking_finds_the_same_light() {
    let planophile = TurbidMedium { angles: LeafAngles::planophile(), ..clumps() };
    let unlike = BandScatter {
        leaf: Scatter { albedo: 0.9, phase: FACETS },
        wood: Scatter { albedo: 0.5, phase: Phase::HenyeyGreenstein { g: -0.4 } },
    };
    for (medium, light) in [(clumps(), SUN), (clumps(), Illumination::Sky), (planophile, SUN)] {
        let regular = trace(&medium, &unlike, light, &photons(1 << 17), &quiet).unwrap();
        let settings = Settings { tracking: Tracking::Delta, seed: 5, ..photons(1 << 18) };
        let delta = trace(&medium, &unlike, light, &settings, &quiet).unwrap();
        let error = libm::hypot(regular.mean_error, delta.mean_error);
        assert_within(mean(&regular.scattered), error, mean(&delta.scattered), 0.01, "mean");
        // Site by site: the differences in units of their standard error are of unit size in the mean.
        let scores = squared_scores(&regular, &delta);
        // Errors over 32 batches scatter by an eighth, and Student's t is a little wider than a normal's.
        assert!((0.85..1.25).contains(&mean(&scores)), "mean squared score {}", mean(&scores));
    }
}

#[test]
fn errors_shrink_as_photons_grow() {
    let run = |n| trace(&ball(3.0), &alike(0.8, FACETS), SUN, &photons(n), &quiet).unwrap();
    let (few, many) = (run(1 << 14), run(1 << 18));
    let ratio = mean(&few.error) / mean(&many.error);
    assert!((3.4..4.6).contains(&ratio), "16 times the photons, error {ratio} times smaller");
}

#[test]
fn symmetric_plants_have_symmetric_light() {
    let medium = ball(5.0);
    let f =
        trace(&medium, &alike(0.9, FACETS), Illumination::Sun([0.0, 1.0, 0.0]), &photons(1 << 18), &quiet)
            .unwrap();
    let sites = medium.sites();
    let slot = |x: u32, y: u32, z: u32| {
        sites.binary_search(&(medium.grid.index(x, y, z) as u32)).expect("a ball is symmetric")
    };
    let mut scores = vec![];
    for (here, &site) in sites.iter().enumerate() {
        let [x, y, z] = medium.grid.site(site as usize);
        for other in [slot(15 - x, y, z), slot(z, y, x), slot(x, y, 15 - z)] {
            assert!((f.uncollided[here] - f.uncollided[other]).abs() < 1e-12);
            if other != here {
                let difference = f.scattered[here] - f.scattered[other];
                scores.push(
                    difference * difference
                        / (f.error[here] * f.error[here] + f.error[other] * f.error[other]),
                );
            }
        }
    }
    assert!((0.8..1.25).contains(&mean(&scores)), "mean squared score {}", mean(&scores));
    // Lit from above, so darker below: the test would not see a field without shape.
    assert!(f.total()[slot(8, 12, 8)] > 2.0 * f.total()[slot(8, 3, 8)]);
}

#[test]
fn threads_do_not_change_bytes() {
    for light in [SUN, Illumination::Sky] {
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| trace(&clumps(), &alike(0.9, FACETS), light, &photons(5000), &quiet)).unwrap()
        };
        let one = run(1);
        assert_eq!(bits(&one), bits(&run(3)));
        assert_eq!(bits(&one), bits(&run(8)));
        assert_eq!(one.balance, run(5).balance);
    }
}

#[test]
fn seeds_give_independent_light() {
    let run = |seed| {
        trace(&ball(3.0), &alike(0.9, FACETS), SUN, &Settings { seed, ..photons(1 << 14) }, &quiet).unwrap()
    };
    let (a, b) = (run(1), run(2));
    assert_eq!(bits(&a), bits(&run(1)));
    let scores = squared_scores(&a, &b);
    assert!((0.85..1.25).contains(&mean(&scores)), "mean squared score {}", mean(&scores));
}

#[test]
fn progress_ends_at_the_whole() {
    let most = std::sync::Mutex::new(0.0);
    let hear = |share: f64| {
        let mut most = most.lock().unwrap();
        *most = f64::max(*most, share);
        Ok(())
    };
    trace(&ball(1.0), &alike(0.5, FACETS), SUN, &photons(64), &hear).unwrap();
    assert_eq!(*most.lock().unwrap(), 1.0);
}

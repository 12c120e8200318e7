//! Light that can be computed without chance: exponentials, single scattering, Chandrasekhar's half space, equilibrium.

use super::*;

#[test]
fn a_pure_absorber_follows_its_exponential() {
    // A block of 8 sites of optical depth 1.5 each; light along an axis: the mean in site k is known.
    let block = medium(16, |c| if c.iter().all(|c| (4.0..12.0).contains(c)) { 1.5 } else { 0.0 });
    for (axis, sign) in [(0, 1.0), (1, 1.0), (2, -1.0)] {
        let mut toward = [0.0; 3];
        toward[axis] = sign;
        let light = uncollided(&block, toward, 2).unwrap();
        for (&site, phi) in block.sites().iter().zip(light) {
            let at = block.grid.site(site as usize)[axis];
            let passed = f64::from(if sign > 0.0 { 11 - at } else { at - 4 });
            let expected = libm::exp(-1.5 * passed) * (1.0 - libm::exp(-1.5)) / 1.5;
            assert!(
                (phi / expected - 1.0).abs() < 1e-6,
                "axis {axis}, site {at}: {phi}, expected {expected}"
            );
        }
    }
}

#[test]
fn light_across_the_edge_of_a_dense_site_is_its_mean() {
    // At 45 degrees the way in is sqrt 2 min(x, y): the mean over the square is 2 (1/a - (1 - e^-a)/a^2), a = sqrt 2 s.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    for depth in [0.1, 1.0, 5.0, 50.0] {
        let site = medium(16, |c| if c == [4.5, 5.5, 6.5] { depth } else { 0.0 });
        let a = depth / half;
        let expected = 2.0 * (1.0 / a - (1.0 - libm::exp(-a)) / (a * a));
        for (toward, sign) in [([half, half, 0.0], 1.0), ([0.0, half, half], -1.0)] {
            let found = uncollided(&site, toward.map(|c: f64| c * sign), 64).unwrap();
            assert!(
                (found[0] / expected - 1.0).abs() < 1e-3,
                "depth {depth}: {found:?}, expected {expected}"
            );
        }
    }
}

#[test]
fn rays_converge() {
    let sun = [0.48, 0.8, 0.36];
    let [coarse, fine, truth] = [2, 8, 64].map(|rays| uncollided(&clumps(), sun, rays).unwrap());
    let off = |light: &[f64]| {
        let squares: Vec<f64> = light.iter().zip(&truth).map(|(a, b)| (a - b) * (a - b)).collect();
        mean(&squares).sqrt() / mean(&truth)
    };
    assert!(off(&fine) < 2e-3 && off(&coarse) > 2.0 * off(&fine), "{} {}", off(&coarse), off(&fine));
}

/// Sites between two planes: one column of 8 layers that repeats for ever along x and z; per layer `depth`.
fn slab(depth: f64) -> TurbidMedium {
    medium(16, |c| if c[0] == 5.5 && c[2] == 6.5 && (4.0..12.0).contains(&c[1]) { depth } else { 0.0 })
}

/// Scattered light in a slab under a sun at this cosine from the zenith, layers from below.
fn in_slab(slab: &TurbidMedium, scatter: &BandScatter, cosine: f64, settings: &Settings) -> walk::Walked {
    let level = (1.0 - cosine * cosine).sqrt();
    let light = Illumination::Sun([0.6 * level, cosine, -0.8 * level]);
    let sites = sites::Sites::new(slab, [true, false, true]);
    walk::scattered(&sites, &slab.angles, scatter, None, light, settings, &quiet).unwrap()
}

/// Fluence of light scattered once, over the albedo: mean over each of 8 layers from above, by midpoint sums over the
/// depth of the collision and the cosine of the way on; over the layer that receives the light the integral is exact.
/// `into` is the phase function's mean over azimuths, by the cosine of the new direction with the downward vertical.
fn scattered_once(depth: f64, cosine: f64, into: impl Fn(f64) -> f64) -> [f64; 8] {
    const DEPTHS: usize = 200;
    const COSINES: usize = 400;
    let mut light = [0.0; 8];
    for i in 0..8 * DEPTHS {
        let t = (i as f64 + 0.5) / DEPTHS as f64 * depth;
        let lost = libm::exp(-t / cosine) * depth / DEPTHS as f64;
        for j in 0..COSINES {
            let mu = (j as f64 + 0.5) / COSINES as f64;
            let weight = lost / 2.0 / COSINES as f64 / depth;
            for (k, light) in light.iter_mut().enumerate() {
                let (top, bottom) = (k as f64 * depth, (k + 1) as f64 * depth);
                // Of exp(-|tau - t| / mu) / mu, over the part of the layer below, and above, the collision.
                let between = |near: f64, far: f64| libm::exp(-near / mu) - libm::exp(-far / mu);
                if bottom > t {
                    *light += weight * into(mu) * between((top - t).max(0.0), bottom - t);
                }
                if top < t {
                    *light += weight * into(-mu) * between((t - bottom).max(0.0), t - top);
                }
            }
        }
    }
    light
}

#[test]
fn light_scattered_once_in_a_slab_is_the_integral_over_its_source() {
    // With an albedo this small, light that is scattered twice is a millionth of the rest.
    const ALBEDO: f64 = 1e-6;
    let cases = [
        (Phase::ISOTROPIC, 0.5),
        (Phase::ISOTROPIC, 1.0),
        (Phase::HenyeyGreenstein { g: 0.6 }, 1.0),
        (Phase::BiLambert { transmitted: 0.2 }, 1.0),
    ];
    for (phase, cosine) in cases {
        for tracking in [Tracking::Regular, Tracking::Delta] {
            let settings = Settings { tracking, ..photons(1 << 18) };
            let walked = in_slab(&slab(0.4), &alike(ALBEDO, phase), cosine, &settings);
            // Straight from above, the new direction's cosine is the phase function's.
            let expected = scattered_once(0.4, cosine, |mu| phase.at(mu));
            for (layer, expected) in expected.into_iter().enumerate() {
                let (found, error) = (walked.scattered[7 - layer] / ALBEDO, walked.error[7 - layer] / ALBEDO);
                let what = format!("{phase:?} {tracking:?}, sun at {cosine}, layer {layer}");
                assert_within(found, error, expected, 0.04, &what);
            }
        }
    }
}

/// Chandrasekhar's H function for isotropic scattering, at midpoints of 0..1, by iterating 1/H(mu) = sqrt(1 - albedo) +
/// albedo/2 times the integral of mu' H(mu') / (mu + mu') (Radiative Transfer, 1960, section 38).
fn chandrasekhar_h(albedo: f64, mu: f64) -> f64 {
    const STEPS: usize = 400;
    let at = |i: usize| (i as f64 + 0.5) / STEPS as f64;
    let inverse = |mu: f64, h: &[f64]| {
        let integrand = |(i, h): (usize, &f64)| at(i) * h / (mu + at(i));
        (1.0 - albedo).sqrt() + albedo / 2.0 * h.iter().enumerate().map(integrand).sum::<f64>() / STEPS as f64
    };
    let mut h = vec![1.0; STEPS];
    for _ in 0..200 {
        h = (0..STEPS).map(|i| 1.0 / inverse(at(i), &h)).collect();
    }
    // The mean of H is known: (2 / albedo)(1 - sqrt(1 - albedo)).
    assert!((mean(&h) - 2.0 / albedo * (1.0 - (1.0 - albedo).sqrt())).abs() < 1e-3);
    1.0 / inverse(mu, &h)
}

#[test]
fn a_half_space_reflects_what_chandrasekhar_says() {
    // A plane albedo is 1 - H(mu) sqrt(1 - albedo). The diffusion length at an albedo of 0.99 is 5.8, so some e^-10 of
    // the light gets through a depth of 60, and e^-20 would have come back from below.
    for (albedo, cosine) in [(0.5, 1.0), (0.9, 1.0), (0.9, 0.4), (0.99, 0.7)] {
        let expected = 1.0 - chandrasekhar_h(albedo, cosine) * (1.0 - albedo).sqrt();
        let walked = in_slab(&slab(7.5), &alike(albedo, Phase::ISOTROPIC), cosine, &photons(1 << 17));
        let [.., down, up, _, _] = walked.balance.escaped;
        assert!(down < 1e-4);
        let what = format!("albedo {albedo}, sun at {cosine}");
        assert_within(up / cosine, walked.balance.escaped_error / cosine, expected, 0.01, &what);
    }
}

#[test]
fn light_from_everywhere_stays_even_where_nothing_is_absorbed() {
    // Radiance that is the same everywhere and in all directions solves the transport equation of a medium that does
    // not absorb, whatever its sites and its phase functions, if these are reciprocal.
    let facets = Phase::BiLambert { transmitted: 0.3 };
    let unlike = BandScatter {
        leaf: Scatter { albedo: 1.0, phase: facets },
        wood: Scatter { albedo: 1.0, phase: Phase::HenyeyGreenstein { g: 0.5 } },
    };
    for angles in [LeafAngles::spherical(), LeafAngles::planophile(), LeafAngles::erectophile()] {
        let medium = TurbidMedium { angles, ..clumps() };
        let f = trace(&medium, &unlike, Illumination::Sky, &photons(1 << 17), &quiet).unwrap();
        assert_within(mean(&f.total()), f.mean_error, 1.0, 0.01, "mean fluence");
        let score = |i: usize| (f.total()[i] - 1.0) / f.error[i];
        let scores: Vec<f64> = (0..f.error.len()).map(|i| score(i) * score(i)).collect();
        assert!((0.8..1.3).contains(&mean(&scores)), "mean squared score {}", mean(&scores));
    }
}

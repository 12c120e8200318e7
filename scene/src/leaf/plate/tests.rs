use super::*;

/// Fresnel's equations, unpolarised, and the midpoint rule in sin^2: the definition that Stern's form integrates.
fn face_by_quadrature(angle_deg: f64, n: f64) -> f64 {
    const STEPS: usize = 200_000;
    let top = libm::sin(angle_deg.to_radians());
    let transmittance = |i: usize| {
        let s2 = top * top * (i as f64 + 0.5) / STEPS as f64;
        let (outside, inside) = (sqrt(1.0 - s2), sqrt(1.0 - s2 / (n * n)));
        let perpendicular = (outside - n * inside) / (outside + n * inside);
        let parallel = (n * outside - inside) / (n * outside + inside);
        1.0 - (perpendicular * perpendicular + parallel * parallel) / 2.0
    };
    (0..STEPS).map(transmittance).sum::<f64>() / STEPS as f64
}

#[test]
fn the_closed_form_of_a_face_is_the_mean_of_fresnels_equations() {
    for n in [1.05, 1.2, 1.45, 1.5115, 2.0] {
        for angle in [5.0, 40.0, 59.0, 90.0] {
            let (closed, quadrature) = (interface_transmittance(angle, n), face_by_quadrature(angle, n));
            assert!((closed - quadrature).abs() < 1e-6, "n {n}, {angle} degrees: {closed}, {quadrature}");
        }
    }
}

#[test]
fn a_face_lets_light_that_meets_it_steeply_through_as_at_normal_incidence() {
    let n: f64 = 1.5;
    let normal = 4.0 * n / ((n + 1.0) * (n + 1.0));
    assert!((interface_transmittance(2.0, n) - normal).abs() < 1e-4);
}

/// Abramowitz and Stegun, tables 5.1 and 5.2.
#[test]
fn the_exponential_integral_has_its_tabled_values() {
    for (x, value) in [
        (0.01, 4.037_929_576_538_114),
        (0.5, 0.559_773_594_776_160_8),
        (1.0, 0.219_383_934_395_520_3),
        (2.0, 0.048_900_510_708_061_12),
        (10.0, 4.156_968_929_685_324e-6),
    ] {
        let found = exponential_integral(x);
        assert!((found / value - 1.0).abs() < 1e-12, "E1({x}) = {found}");
    }
    let (below, above) = (exponential_integral(1.0), exponential_integral(1.0 + 1e-12));
    assert!((below - above).abs() < 1e-11, "no step where the methods change: {below}, {above}");
}

/// 2 times the integral of e^(-k/mu) mu over mu: what an isotropic beam keeps across the layer.
#[test]
fn a_layer_keeps_the_mean_of_the_exponential_over_a_hemisphere() {
    const STEPS: usize = 100_000;
    for k in [0.01, 0.3, 1.0, 4.0] {
        let part = |i: usize| {
            let mu = (i as f64 + 0.5) / STEPS as f64;
            2.0 * mu * exp(-k / mu) / STEPS as f64
        };
        let quadrature: f64 = (0..STEPS).map(part).sum();
        assert!((layer_transmittance(k) - quadrature).abs() < 1e-8, "{k}");
    }
    assert_eq!(layer_transmittance(0.0), 1.0);
    assert!(layer_transmittance(1e-9) < 1.0 && layer_transmittance(1e-9) > 1.0 - 3e-9);
}

#[test]
fn piles_without_absorption_lose_nothing() {
    for layers in [1.0, 1.5, 2.0, 5.0] {
        for n in [1.43, 1.51] {
            let (r, t) = pile(layers, n, 0.0);
            assert!((r + t - 1.0).abs() < 1e-12 && r > 0.0 && t > 0.0, "{layers}, {n}: {r} + {t}");
        }
    }
}

#[test]
fn one_clear_plate_has_the_closed_form_of_two_faces() {
    let n = 1.45;
    let (top, out) = (interface_transmittance(40.0, n), interface_transmittance(90.0, n) / (n * n));
    let (r, t) = pile(1.0, n, 0.0);
    // Between two faces that reflect 1 - out, out / (1 - (1 - out)^2) = 1 / (2 - out) of what enters goes on.
    assert!((t - top / (2.0 - out)).abs() < 1e-14 && (r - (1.0 - top / (2.0 - out))).abs() < 1e-14);
}

/// Adding plates one by one, by the doubling of two layers, gives what Stokes's formula gives for their number.
#[test]
fn equal_plates_add_up_one_by_one() {
    let (r, t) = (0.22, 0.61);
    let (mut pile_r, mut pile_t) = (r, t);
    for layers in 2..6 {
        let between = 1.0 - pile_r * r;
        (pile_r, pile_t) = (r + t * t * pile_r / between, pile_t * t / between);
        let (stokes_r, stokes_t) = stokes(f64::from(layers), r, t);
        assert!((pile_r - stokes_r).abs() < 1e-13 && (pile_t - stokes_t).abs() < 1e-13, "{layers}");
    }
}

#[test]
fn the_limit_without_absorption_joins_the_general_form() {
    for layers in [0.0, 0.5, 3.0] {
        let (clear, faint) = (stokes(layers, 0.3, 0.7), stokes(layers, 0.3, 0.7 - 1e-9));
        assert!((clear.0 - faint.0).abs() < 1e-7 && (clear.1 - faint.1).abs() < 1e-7, "{clear:?}, {faint:?}");
    }
}

#[test]
fn energy_is_never_made_and_opaque_piles_stay_finite() {
    for layers in [1.0, 1.1, 1.5, 3.0, 5.0] {
        for n in [1.43, 1.47, 1.5115] {
            for k in [0.0, 1e-15, 1e-9, 1e-3, 0.1, 1.0, 10.0, 60.0, 1000.0] {
                let (r, t) = pile(layers, n, k);
                let fits = r >= 0.0 && t >= 0.0 && r + t <= 1.0 + 1e-12;
                assert!(fits, "{layers} plates, {n}, {k}: {r} + {t}");
            }
        }
    }
    assert!(pile(2.0, 1.5, 1000.0).1 < 1e-300, "no light goes through");
}

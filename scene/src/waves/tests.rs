//! Waves: as steep as was measured, as high, as fast; and the same from the same settings.

use super::*;

/// At sea, where the wind has made all the waves that it can.
fn sea(wind_m_s: f64) -> Waves {
    Waves { wind_m_s, fetch_m: 1e6, ..Waves::default() }
}

fn squared(value: f64) -> f64 {
    value * value
}

fn is_near(found: f64, expected: f64, tolerance: f64) -> bool {
    (found / expected - 1.0).abs() <= tolerance
}

#[test]
fn slopes_are_those_that_cox_and_munk_saw_in_the_suns_glitter() {
    for wind_m_s in [5.0, 7.0, 10.0, 14.0] {
        let (found, measured) = (squared(sea(wind_m_s).rms_slope()), 0.003 + 0.00512 * wind_m_s);
        assert!(is_near(found, measured, 0.12), "{found} for {measured} at {wind_m_s} m/s");
    }
}

#[test]
fn waves_of_a_full_sea_are_as_high_and_as_long_as_pierson_and_moskowitz_found() {
    for wind_m_s in [7.0, 10.0, 13.0] {
        let field = sea(wind_m_s).field();
        let square = |[x, z]: [f64; 2]| x * x + z * z;
        let height = |wave: &PlaneWave| square(wave.slope) / square(wave.wave_vector) / 2.0;
        let highest = field.waves.iter().max_by(|a, b| height(a).total_cmp(&height(b))).expect("waves");
        let significant_m = 4.0 * field.waves.iter().map(height).sum::<f64>().sqrt();
        assert!(is_near(significant_m, 0.22 * wind_m_s * wind_m_s / 9.81, 0.15), "{significant_m} m");
        let length_m = TAU / square(highest.wave_vector).sqrt();
        let expected_m = TAU * wind_m_s * wind_m_s / (squared(0.84) * 9.81);
        assert!((0.6..1.1).contains(&(length_m / expected_m)), "{length_m} m for {expected_m} m");
    }
    let pond = Waves { wind_m_s: 7.0, ..Waves::default() };
    assert!(pond.rms_slope() < sea(7.0).rms_slope());
}

#[test]
fn a_field_has_all_slopes_of_its_spectrum_and_shows_them() {
    for waves in [Waves::default(), sea(8.0), Waves { wind_m_s: 0.5, fetch_m: 1.0, ..Waves::default() }] {
        let field = waves.field();
        assert_eq!(field.waves.len(), WAVE_COUNT);
        let drawn: f64 = field.waves.iter().flat_map(|wave| wave.slope).map(|s| s * s / 2.0).sum();
        let whole = squared(waves.rms_slope());
        assert!(
            is_near(drawn + field.rest_variance, whole, 0.01),
            "{drawn} and {} of {whole}",
            field.rest_variance
        );
        let mut draws = Draws(7);
        let points = 20_000;
        let mut at_random = || {
            let [x, z] = field.slope_at([1e4 * draws.share(), -1e4 * draws.share()], 1e3 * draws.share());
            x * x + z * z
        };
        let seen = (0..points).map(|_| at_random()).sum::<f64>() / f64::from(points);
        assert!(is_near(seen, drawn, 0.05), "{seen} for {drawn}");
    }
}

#[test]
fn waves_run_with_their_wind_and_long_ones_outrun_short_ones() {
    // From the west, so that it blows to the east, along +x.
    let field = sea(8.0).field();
    let speed = |wave: &PlaneWave| wave.frequency / libm::hypot(wave.wave_vector[0], wave.wave_vector[1]);
    assert!(field.waves.iter().all(|wave| wave.wave_vector[0] > 0.0));
    let (long, short) = (speed(&field.waves[0]), speed(&field.waves[WAVE_COUNT - 1]));
    assert!(long > 10.0 && short < 0.4, "{long} and {short} m/s");
    let squares = |axis: usize| field.waves.iter().map(|wave| squared(wave.slope[axis])).sum::<f64>();
    assert!(squares(0) > 1.3 * squares(1), "{} and {}", squares(0), squares(1));
    // A crest is found again where its speed has brought it.
    let wave = &field.waves[40];
    let [kx, kz] = wave.wave_vector;
    let way = 2.5 * wave.frequency / (kx * kx + kz * kz);
    let [here, there] =
        [wave.turns_at([3.0, -4.0], 0.0), wave.turns_at([3.0 + kx * way, -4.0 + kz * way], 2.5)];
    assert!((here - there).abs() < 1e-9, "{here} and {there}");
    let turned = Waves { from_deg: 0.0, ..sea(8.0) }.field();
    assert!(turned.waves.iter().all(|wave| wave.wave_vector[1] > 0.0), "from the north it blows to +z");
}

#[test]
fn a_seed_chooses_the_surface_and_a_factor_its_slopes() {
    let point = [12.5, -3.0];
    let slope = |waves: Waves| waves.field().slope_at(point, 4.0);
    let usual = slope(Waves::default());
    assert_eq!(usual, slope(Waves::default()));
    assert_ne!(usual, slope(Waves { seed: 2, ..Waves::default() }));
    assert_eq!(slope(Waves { steepness: 2.0, ..Waves::default() }), usual.map(|s| 2.0 * s));
    let level = Waves { steepness: 0.0, ..Waves::default() }.field();
    assert_eq!((level.slope_at(point, 4.0), level.rest_variance), ([0.0; 2], 0.0));
}

#[test]
fn waves_out_of_range_are_named_and_so_are_those_that_fold_over() {
    let fault =
        |waves: Waves| waves.fault().map(|(name, found, expected)| format!("{name}: {found}, {expected}"));
    assert_eq!(fault(Waves::default()), None);
    for [low, high] in [[WINDS_M_S[0], FETCHES_M[0]], [WINDS_M_S[1], FETCHES_M[1]]] {
        let waves = Waves { wind_m_s: low, fetch_m: high, ..Waves::default() };
        assert_eq!(fault(waves), None, "rms {}", waves.rms_slope());
        assert!(waves.field().waves.iter().flat_map(|wave| wave.slope).all(f64::is_finite));
    }
    for (waves, expected) in [
        (Waves { wind_m_s: 0.0, ..Waves::default() }, "wind_m_s: 0, 0.5 to 30"),
        (Waves { wind_m_s: f64::NAN, ..Waves::default() }, "wind_m_s: NaN"),
        (Waves { from_deg: 400.0, ..Waves::default() }, "from_deg: 400, -360 to 360"),
        (Waves { fetch_m: -1.0, ..Waves::default() }, "fetch_m: -1, 1 to 1000000"),
        (Waves { steepness: -0.5, ..Waves::default() }, "steepness: -0.5, 0 to 10"),
        (Waves { wind_m_s: 12.0, steepness: 3.0, ..Waves::default() }, "steepness: 3, at most 1."),
    ] {
        let found = fault(waves).expect("it is found");
        assert!(found.starts_with(expected), "{found} for {expected}");
    }
}

#[test]
fn slopes_are_the_sum_of_the_waves() {
    let field = sea(6.0).field();
    assert_eq!(WAVE_COUNT % LANES, 0);
    for (point, time_s) in [([0.0, 0.0], 0.0), ([17.3, -250.9], 12.5), ([-1e6, 3e5], -86_400.0)] {
        let mut expected = [0.0; 2];
        for wave in &field.waves {
            let height = libm::cos(TAU * wave.turns_at(point, time_s));
            (0..2).for_each(|axis| expected[axis] += wave.slope[axis] * height);
        }
        let found = field.slope_at(point, time_s);
        let is_same = |axis: usize| (found[axis] - expected[axis]).abs() < 1e-6;
        assert!(is_same(0) && is_same(1), "{found:?} for {expected:?}");
    }
    for turns in [-2.75, -0.5, -0.25, 0.0, 0.1, 0.25, 0.4999, 0.5, 7.2] {
        assert!((cos_turns(turns) - libm::cos(TAU * turns)).abs() < 6e-8, "{turns}");
    }
}

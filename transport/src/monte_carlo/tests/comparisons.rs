//! The distance of a field from the truth, under noise many times as large.

use super::super::draw::Draw;
use super::*;

const SITES: usize = 40_000;

/// A truth of 0.5..1.5; estimates with a noise of +-20 % of the mean, even.
fn estimates() -> (Vec<f64>, [Fluence; 2]) {
    let mut draw = Draw::new(11, 0);
    let truth: Vec<f64> = (0..SITES).map(|_| 0.5 + draw.unit()).collect();
    let mut noisy = || {
        let scattered: Vec<f64> = truth.iter().map(|t| t + 0.4 * (draw.unit() - 0.5)).collect();
        let error = vec![0.4 / 12f64.sqrt(); SITES];
        let mean_error = error[0] / (SITES as f64).sqrt();
        Fluence { uncollided: vec![2.0; SITES], scattered, error, mean_error, balance: Balance::default() }
    };
    let pair = [noisy(), noisy()];
    (truth, pair)
}

#[test]
fn a_planted_error_is_found_below_the_noise() {
    let (truth, [a, b]) = estimates();
    // 2 % up on every second site, 1 % down on the others: bias 0.5 %, rms sqrt(2.5) %.
    let field: Vec<f64> =
        truth.iter().enumerate().map(|(i, t)| t + if i % 2 == 0 { 0.02 } else { -0.01 }).collect();
    let found = compare(&field, [&a, &b], ComparedLight::Scattered).unwrap();
    assert!((found.mean - 1.0).abs() < 0.01);
    assert_within(found.rms, found.rms_error, 2.5f64.sqrt() / 100.0, 0.2, "rms");
    assert_within(found.bias, found.bias_error, 0.005, 0.2, "bias");
    // The same estimate twice would show its noise, 11.5 %, as error.
    let naive = compare(&field, [&a, &a], ComparedLight::Scattered).unwrap();
    assert!(naive.rms > 0.1, "{}", naive.rms);
}

#[test]
fn the_truth_has_no_error_but_noise() {
    let (truth, [a, b]) = estimates();
    let found = compare(&truth, [&a, &b], ComparedLight::Scattered).unwrap();
    assert!(found.rms < 0.015 && found.rms < 3.0 * found.rms_error, "{found:?}");
    assert!(found.bias.abs() < ERRORS * found.bias_error, "{found:?}");
}

#[test]
fn total_light_holds_the_beam() {
    let (truth, [a, b]) = estimates();
    let field: Vec<f64> = truth.iter().map(|t| t + 2.0 + 0.03).collect();
    let found = compare(&field, [&a, &b], ComparedLight::Total).unwrap();
    // Relative to the mean of all light, 3.
    assert_within(found.bias, found.bias_error, 0.01, 0.2, "bias");
    assert!((found.mean - 3.0).abs() < 0.01);
}

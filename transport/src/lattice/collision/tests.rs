#![allow(clippy::needless_range_loop, reason = "Indices are directions here.")]

use flb_format::direction::{DIRECTIONS, WEIGHTS, opposite};
use flb_format::matter::{ClassOptics, Optics};

use super::*;

/// Rounding of an 18-term sum in f64.
const ROUNDING: f64 = 1e-14;

fn asymmetries() -> Vec<f64> {
    let inside = 1.0 - f64::EPSILON / 2.0;
    let mut all = vec![0.0, 1e-300, 0.091, 0.5, 0.9, 1.0 - 1e-4, 1.0 - 1e-9, inside, 1.0];
    all.extend(all.clone().iter().map(|g| -g));
    all
}

#[test]
fn columns_of_omega_sum_to_zero_for_every_g() {
    for g in asymmetries() {
        for sigma_a in [0.0, 0.109, 0.5, 1.0] {
            let omega = omega(ClassOptics { sigma_a, g });
            for j in 0..19 {
                let sum: f64 = omega.iter().map(|row| row[j]).sum();
                assert!(sum.abs() < ROUNDING, "g {g}, sigma_a {sigma_a}, column {j}: {sum}");
            }
        }
    }
}

#[test]
fn phase_is_normalised_and_never_negative_nor_nan() {
    for g in asymmetries() {
        let phase = phase(g);
        for j in 1..19 {
            let sum: f64 = phase.iter().map(|row| row[j]).sum();
            assert!((sum - 1.0).abs() < ROUNDING, "g {g}, column {j}: {sum}");
            assert!(phase.iter().all(|row| row[j] >= 0.0), "g {g}, column {j}");
        }
    }
}

#[test]
fn limits_at_plus_and_minus_one_are_exact() {
    let (forward, back) = (phase(1.0), phase(-1.0));
    for i in 1..19 {
        for j in 1..19 {
            assert_eq!(forward[i][j], if i == j { 1.0 } else { 0.0 });
            assert_eq!(back[i][j], if i == opposite(j) { 1.0 } else { 0.0 });
        }
    }
}

#[test]
fn isotropic_scattering_follows_the_weights() {
    let phase = phase(0.0);
    for i in 1..19 {
        for j in 1..19 {
            assert!((phase[i][j] - WEIGHTS[i]).abs() < ROUNDING);
        }
    }
}

#[test]
fn phase_agrees_with_the_unscaled_formula_away_from_the_ends() {
    let unit = |m: usize| {
        let c = DIRECTIONS[m].map(f64::from);
        let length = c.iter().map(|x| x * x).sum::<f64>().sqrt();
        c.map(|x| x / length)
    };
    for g in [-0.9, -0.333, 0.091, 0.7] {
        let plain = |i: usize, j: usize| {
            let dot: f64 = unit(i).iter().zip(unit(j)).map(|(a, b)| a * b).sum();
            (1.0 - g * g) / libm::pow(1.0 - 2.0 * g * dot + g * g, 1.5)
        };
        let phase = phase(g);
        for j in 1..19 {
            // Eq. 2.18 as printed: axial directions count twice, all over 24.
            let norm: f64 = (1..19).map(|i| plain(i, j) * if i <= 6 { 2.0 } else { 1.0 }).sum::<f64>() / 24.0;
            for i in 1..19 {
                let expected = WEIGHTS[i] * plain(i, j) / norm;
                assert!((phase[i][j] - expected).abs() < 1e-12, "g {g}, {i} {j}");
            }
        }
    }
}

#[test]
fn mirrors_and_axis_permutations_leave_omega_unchanged() {
    let omega = omega(Optics::paper().bands[2].leaf);
    let find = |c: [i32; 3]| DIRECTIONS.iter().position(|d| *d == c).unwrap();
    let moves: [fn([i32; 3]) -> [i32; 3]; 4] =
        [|c| [-c[0], c[1], c[2]], |c| [c[0], c[1], -c[2]], |c| [c[1], c[2], c[0]], |c| [c[1], c[0], c[2]]];
    for moved in moves {
        for i in 0..19 {
            for j in 0..19 {
                let image = omega[find(moved(DIRECTIONS[i]))][find(moved(DIRECTIONS[j]))];
                assert!((omega[i][j] - image).abs() < ROUNDING, "{i} {j}");
            }
        }
    }
}

#[test]
fn gain_gives_all_back_at_wood_and_the_albedo_at_leaf() {
    let optics = ClassOptics { sigma_a: 0.3, g: -0.4 };
    for (keeps_rest, expected) in [(true, 1.0), (false, 0.7)] {
        let gain = gain(optics, keeps_rest);
        for j in 1..19 {
            let sum: f64 = gain.iter().map(|row| row[j]).sum();
            assert!((sum - expected).abs() < ROUNDING);
        }
    }
}

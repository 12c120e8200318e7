use proptest::prelude::*;

use super::*;

/// One axis of four, written out from the definition, as the transform's oracle.
fn forward_line([a, b, c, d]: [f64; 4]) -> [f64; 4] {
    [(a + b + c + d) / 4.0, (a + b - c - d) / 4.0, (a - b) / 2.0, (c - d) / 2.0]
}

/// Rounding of three axes of two levels: some ten operations of half an ulp each on values <= 8 * peak.
const ROUNDING: f32 = 64.0 * f32::EPSILON;

#[test]
fn a_line_of_four_becomes_average_and_details() {
    // 9 7 3 5 is the usual example: averages 8 4, details 1 -1, then 6 and 2.
    let mut values: Vec<f32> = (0..64).map(|i| [9.0, 7.0, 3.0, 5.0][i % 4]).collect();
    forward(&mut values, 1);
    assert_eq!(values[..4], [6.0, 2.0, 1.0, -1.0]);
    assert!(values[4..].iter().all(|v| *v == 0.0));
}

#[test]
fn coefficient_order_is_z_y_x_with_x_fastest() {
    for (stride, position) in [(1, 1), (4, 4), (16, 16)] {
        let mut values: Vec<f32> = (0..64).map(|i| if i / stride % 4 < 2 { 1.0 } else { -1.0 }).collect();
        forward(&mut values, 1);
        let set: Vec<usize> = (0..64).filter(|&i| values[i] != 0.0).collect();
        assert_eq!(set, [position], "a step along the axis of stride {stride}");
    }
}

#[test]
fn basis_table_is_what_the_inverse_does() {
    for position in 0..64 {
        let mut values = vec![0.0; 64];
        values[position] = 1.0;
        inverse(&mut values, 1);
        for (sample, value) in values.iter().enumerate() {
            let along = |stride: usize| BASIS[position / stride % 4][sample / stride % 4];
            assert_eq!(*value, along(16) * along(4) * along(1), "coefficient {position}, sample {sample}");
        }
    }
}

proptest! {
    #[test]
    fn forward_agrees_with_the_definition_in_f64(values in prop::collection::vec(-8.0f32..8.0, 64)) {
        let mut expected: Vec<f64> = values.iter().map(|v| f64::from(*v)).collect();
        for stride in [16, 4, 1] {
            for start in (0..64).filter(|i| i / stride % 4 == 0) {
                let line = forward_line(std::array::from_fn(|k| expected[start + k * stride]));
                for k in 0..4 { expected[start + k * stride] = line[k]; }
            }
        }
        let mut coefficients = values;
        forward(&mut coefficients, 1);
        for (c, e) in coefficients.iter().zip(&expected) {
            prop_assert!((f64::from(*c) - e).abs() <= f64::from(8.0 * ROUNDING), "{c} for {e}");
        }
    }

    #[test]
    fn inverse_undoes_forward_up_to_rounding(values in prop::collection::vec(-8.0f32..8.0, 64 * 3)) {
        let mut again = values.clone();
        forward(&mut again, 3);
        inverse(&mut again, 3);
        for (a, v) in again.iter().zip(&values) {
            prop_assert!((a - v).abs() <= 8.0 * ROUNDING, "{a} for {v}");
        }
    }

    #[test]
    fn inverse_undoes_forward_exactly_on_small_integers(values in prop::collection::vec(-128i16..128, 64)) {
        let values: Vec<f32> = values.iter().map(|v| f32::from(*v)).collect();
        let mut again = values.clone();
        forward(&mut again, 1);
        inverse(&mut again, 1);
        prop_assert_eq!(again, values);
    }

    #[test]
    fn bands_do_not_mix(values in prop::collection::vec(-8.0f32..8.0, 64 * 2)) {
        let mut together = values.clone();
        forward(&mut together, 2);
        for band in 0..2 {
            let mut alone: Vec<f32> = values.iter().skip(band).step_by(2).copied().collect();
            forward(&mut alone, 1);
            let of_both: Vec<f32> = together.iter().skip(band).step_by(2).copied().collect();
            prop_assert_eq!(alone, of_both);
        }
    }
}

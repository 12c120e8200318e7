//! The Pareto front: what no other choice beats.

/// What one number must be above another to count as more. Seconds of two runs differ by as much, and with exact
/// numbers nearly every row would be on the front for a thousandth of something.
const STEP: f64 = 1.1;

/// The number of whole steps up to each value; values of one step count as the same. 0 lies below all.
pub(super) fn in_steps<const N: usize>(values: [f64; N]) -> [f64; N] {
    values.map(|value| match value > 0.0 {
        true => libm::floor(libm::log(value) / libm::log(STEP)),
        false => f64::NEG_INFINITY,
    })
}

/// Whether `a` is nowhere worse than `b` and somewhere better; less is better.
fn beats<const N: usize>(a: &[f64; N], b: &[f64; N]) -> bool {
    let pairs = || a.iter().zip(b);
    pairs().all(|(a, b)| a <= b) && pairs().any(|(a, b)| a < b)
}

/// Returns for each point whether no other is nowhere worse and somewhere better. Less is better; equal points do not
/// beat each other.
pub fn front<const N: usize>(points: &[[f64; N]]) -> Vec<bool> {
    points.iter().map(|point| !points.iter().any(|other| beats(other, point))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_on_the_front_unless_another_beats_it() {
        let points = [[1.0, 5.0], [2.0, 3.0], [2.0, 4.0], [3.0, 3.0], [4.0, 1.0], [4.0, 1.0], [5.0, 5.0]];
        assert_eq!(front(&points), [true, true, false, false, true, true, false]);
    }

    #[test]
    fn being_best_in_one_column_is_enough() {
        let points = [[1.0, 1.0, 1.0, 9.0], [2.0, 2.0, 2.0, 8.0], [2.0, 2.0, 2.0, 9.0]];
        assert_eq!(front(&points), [true, true, false]);
    }

    #[test]
    fn what_differs_by_less_than_a_step_is_the_same() {
        let front_in_steps = |points: [[f64; 2]; 2]| front(&points.map(in_steps));
        assert_eq!(front_in_steps([[1.01, 5.0], [1.02, 4.0]]), [false, true]);
        assert_eq!(front_in_steps([[1.01, 5.0], [1.2, 4.0]]), [true, true]);
        assert_eq!(front_in_steps([[0.0, 1.0], [1e-9, 1.0]]), [true, false]);
    }

    #[test]
    fn nothing_has_an_empty_front() {
        assert_eq!(front::<4>(&[]), Vec::<bool>::new());
    }
}

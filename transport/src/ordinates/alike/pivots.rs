//! Vectors made of a few of them: Cholesky's decomposition of their scalar products, with pivots.

/// Share of the square of the error up to which a vector that is given is a sum of others.
const NOTHING: f64 = 0.01;

/// Pivots of a matrix of scalar products until nothing is left of any vector that is longer than `max_error`, and the
/// rows of its Cholesky factor, `[vector][pivot]`. The first pivots are `given`, unless nothing is left of them.
pub(super) fn pivots(products: &[Vec<f64>], given: &[usize], max_error: f64) -> (Vec<usize>, Vec<Vec<f64>>) {
    let mut left: Vec<f64> = (0..products.len()).map(|i| products[i][i]).collect();
    let mut factors: Vec<Vec<f64>> = vec![Vec::new(); products.len()];
    let mut picks = Vec::new();
    while picks.len() < products.len() {
        // The first of equals.
        let longest = (0..left.len()).rev().max_by(|a, b| left[*a].total_cmp(&left[*b]));
        let of_rest = || longest.filter(|&pivot| left[pivot] > max_error * max_error);
        let given = given
            .iter()
            .copied()
            .find(|pivot| !picks.contains(pivot) && left[*pivot] > NOTHING * max_error * max_error);
        let Some(pivot) = given.or_else(of_rest) else { break };
        let length = libm::sqrt(left[pivot]);
        let of_pivot = factors[pivot].clone();
        for (i, row) in factors.iter_mut().enumerate() {
            let known: f64 = row.iter().zip(&of_pivot).map(|(a, b)| a * b).sum();
            let along = if picks.contains(&i) { 0.0 } else { (products[i][pivot] - known) / length };
            row.push(along);
            left[i] -= along * along;
        }
        left[pivot] = 0.0;
        picks.push(pivot);
    }
    (picks, factors)
}

/// Weights of the pivots that make a vector, of which `factors` has the row.
pub(super) fn back_substituted(picks: &[usize], factors: &[Vec<f64>], row: &[f64]) -> Vec<f64> {
    let mut weights = row.to_vec();
    for k in (0..picks.len()).rev() {
        let later: f64 = (k + 1..picks.len()).map(|i| factors[picks[i]][k] * weights[i]).sum();
        weights[k] = (weights[k] - later) / factors[picks[k]][k];
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_of_three_dimensions_are_made_of_three_of_them() {
        let made = |i: usize| {
            let x = i as f64 / 10.0;
            let of = |j: usize| 1.0 + x * (j % 7) as f64 + libm::sin(x) * (j % 5) as f64;
            (0..40).map(of).collect::<Vec<f64>>()
        };
        let vectors: Vec<Vec<f64>> = (0..12).map(made).collect();
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let products: Vec<Vec<f64>> =
            vectors.iter().map(|a| vectors.iter().map(|b| product(a, b)).collect()).collect();
        let (picks, factors) = pivots(&products, &[], 1e-6);
        assert_eq!(picks.len(), 3, "{picks:?}");
        for (vector, row) in vectors.iter().zip(&factors) {
            let weights = back_substituted(&picks, &factors, row);
            for (j, value) in vector.iter().enumerate() {
                let sum: f64 =
                    picks.iter().zip(&weights).map(|(&pick, weight)| weight * vectors[pick][j]).sum();
                assert!((sum - value).abs() < 1e-3, "{sum} for {value}");
            }
        }
        // A picked vector is made of itself.
        let weights = back_substituted(&picks, &factors, &factors[picks[1]]);
        assert!(weights.iter().zip([0.0, 1.0, 0.0]).all(|(a, b)| (a - b).abs() < 1e-9), "{weights:?}");
    }

    #[test]
    fn vectors_that_have_nothing_in_common_are_all_picked() {
        let products: Vec<Vec<f64>> =
            (0..5).map(|i| (0..5).map(|j| f64::from(u8::from(i == j))).collect()).collect();
        assert_eq!(pivots(&products, &[], 1e-6).0, [0, 1, 2, 3, 4]);
        assert!(pivots(&[], &[], 1e-6).0.is_empty());
    }
}

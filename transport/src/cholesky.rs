//! Small systems of least squares.

/// Solves the first `unknowns` rows of a positive definite system by Cholesky's method, in place of its right side; of
/// `matrix` only the lower triangle is read, and it is used up. A pivot that is not above 0 counts as next to nothing.
///
/// # Panics
/// If there are fewer rows than `unknowns`.
pub fn solve<const N: usize>(matrix: &mut [[f64; N]; N], right: &mut [f64; N], unknowns: usize) {
    factor(matrix, unknowns);
    substitute(matrix, right, unknowns);
}

/// Factors the first `unknowns` rows of a positive definite matrix in place of its lower triangle, for [`substitute`].
///
/// # Panics
/// If there are fewer rows than `unknowns`.
pub fn factor<const N: usize>(matrix: &mut [[f64; N]; N], unknowns: usize) {
    for i in 0..unknowns {
        for j in 0..=i {
            let sum: f64 = matrix[i][j] - (0..j).map(|k| matrix[i][k] * matrix[j][k]).sum::<f64>();
            matrix[i][j] = if i == j { libm::sqrt(sum.max(f64::MIN_POSITIVE)) } else { sum / matrix[j][j] };
        }
    }
}

/// Solves a system whose matrix is factored, in place of its right side.
///
/// # Panics
/// If there are fewer rows than `unknowns`.
pub fn substitute<const N: usize>(matrix: &[[f64; N]; N], right: &mut [f64; N], unknowns: usize) {
    for i in 0..unknowns {
        let sum: f64 = (0..i).map(|k| matrix[i][k] * right[k]).sum();
        right[i] = (right[i] - sum) / matrix[i][i];
    }
    for i in (0..unknowns).rev() {
        let sum: f64 = (i + 1..unknowns).map(|k| matrix[k][i] * right[k]).sum();
        right[i] = (right[i] - sum) / matrix[i][i];
    }
}

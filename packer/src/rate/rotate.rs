//! The rotation across bands of a base: an orthonormal matrix whose first component holds nearly all of the light.

/// Component of the light of all bands.
pub(super) struct Principal {
    /// Eigenvector `[band]` of the second moments, with a sum of at least 0.
    pub row: Vec<f64>,
    /// Eigenvalue of that vector.
    pub moment: f64,
}

/// Components by the second moments `[band][band]`, largest eigenvalue first. Cyclic Jacobi in f64 (Golub and Van Loan,
/// section 8.5) in a fixed order, so the same bits everywhere.
pub(super) fn principal(moments: &[f64], bands: usize) -> Vec<Principal> {
    let mut a = moments.to_vec();
    let mut v = vec![0.0; bands * bands];
    (0..bands).for_each(|i| v[i * bands + i] = 1.0);
    for _ in 0..30 {
        for p in 0..bands {
            for q in p + 1..bands {
                let apq = a[p * bands + q];
                if apq.abs() <= 1e-300 {
                    continue;
                }
                let theta = (a[q * bands + q] - a[p * bands + p]) / (2.0 * apq);
                let t = if theta == 0.0 {
                    1.0
                } else {
                    theta.signum() / (theta.abs() + libm::sqrt(theta * theta + 1.0))
                };
                let c = 1.0 / libm::sqrt(t * t + 1.0);
                let s = t * c;
                for k in 0..bands {
                    turn(&mut a, [k * bands + p, k * bands + q], c, s);
                }
                for k in 0..bands {
                    turn(&mut a, [p * bands + k, q * bands + k], c, s);
                    turn(&mut v, [p * bands + k, q * bands + k], c, s);
                }
            }
        }
    }
    let mut order: Vec<usize> = (0..bands).collect();
    order.sort_by(|x, y| a[y * bands + y].total_cmp(&a[x * bands + x]));
    let rows = order.iter().map(|&i| {
        let row = &v[i * bands..][..bands];
        let sign = if row.iter().sum::<f64>() < 0.0 { -1.0 } else { 1.0 };
        Principal { row: row.iter().map(|x| x * sign).collect(), moment: a[i * bands + i] }
    });
    rows.collect()
}

fn turn(values: &mut [f64], [i, j]: [usize; 2], c: f64, s: f64) {
    let (x, y) = (values[i], values[j]);
    (values[i], values[j]) = (c * x - s * y, s * x + c * y);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_orthonormal_and_the_first_holds_the_most() {
        // Moments of values (2, 1, 1) and (0, 1, -1) / 2.
        let samples = [[2.0, 1.0, 1.0], [0.0, 0.5, -0.5], [1.0, 0.7, 0.4]];
        let mut moments = [0.0; 9];
        for s in samples {
            (0..9).for_each(|i| moments[i] += s[i / 3] * s[i % 3]);
        }
        let components = principal(&moments, 3);
        let rows: Vec<&[f64]> = components.iter().map(|component| component.row.as_slice()).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for i in 0..3 {
            for j in 0..3 {
                assert!((dot(rows[i], rows[j]) - f64::from(u8::from(i == j))).abs() < 1e-12);
            }
        }
        let energy = |row: &[f64]| samples.iter().map(|s| dot(row, s) * dot(row, s)).sum::<f64>();
        let energies: Vec<f64> = rows.iter().map(|r| energy(r)).collect();
        assert!(components.iter().zip(&energies).all(|(component, e)| (component.moment - e).abs() < 1e-12));
        assert!(energies[0] > energies[1] && energies[1] > energies[2], "{energies:?}");
        assert!((energies.iter().sum::<f64>() - (moments[0] + moments[4] + moments[8])).abs() < 1e-12);
    }
}

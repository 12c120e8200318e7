//! Real spherical harmonics of the sun's direction, up to degree 3, as a basis for fields over all suns.
//!
//! `phi(r; s) = sum over k of c_k(r) Y_k(s)` (lighting model, section 9). They are scaled so that the mean of Y_k^2
//! over the sphere is 1; so Y_0 is 1, and c_0 the mean over all suns: the light of an even sky. Within a degree l, k
//! runs over the orders m = -l..=l; axes are model space.

/// Highest degree.
pub const MAX_DEGREE: u8 = 3;

/// Number of harmonics up to a degree: (l + 1)^2.
pub const fn count(degree: u8) -> usize {
    (degree as usize + 1) * (degree as usize + 1)
}

/// `Y_k` of a unit vector for all k up to degree 3; the first `count(degree)` are those of a lower degree.
pub fn evaluate([x, y, z]: [f64; 3]) -> [f64; count(MAX_DEGREE)] {
    let root = libm::sqrt;
    let (xx, yy, zz) = (x * x, y * y, z * z);
    [
        1.0,
        root(3.0) * y,
        root(3.0) * z,
        root(3.0) * x,
        root(15.0) * x * y,
        root(15.0) * y * z,
        root(5.0) / 2.0 * (3.0 * zz - 1.0),
        root(15.0) * x * z,
        root(15.0) / 2.0 * (xx - yy),
        root(35.0 / 8.0) * y * (3.0 * xx - yy),
        root(105.0) * x * y * z,
        root(21.0 / 8.0) * y * (5.0 * zz - 1.0),
        root(7.0) / 2.0 * z * (5.0 * zz - 3.0),
        root(21.0 / 8.0) * x * (5.0 * zz - 1.0),
        root(105.0) / 2.0 * z * (xx - yy),
        root(35.0 / 8.0) * x * (xx - 3.0 * yy),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Evenly spread points: Gauss's rule is not needed where z and the angle are sampled at midpoints finely.
    fn mean(f: impl Fn([f64; 3]) -> f64) -> f64 {
        let (rings, around) = (400, 16);
        let mut sum = 0.0;
        for ring in 0..rings {
            let z = (f64::from(ring) + 0.5) / f64::from(rings) * 2.0 - 1.0;
            let across = libm::sqrt(1.0 - z * z);
            for step in 0..around {
                let (sin, cos) = libm::sincos(f64::from(step) / f64::from(around) * std::f64::consts::TAU);
                sum += f([across * cos, across * sin, z]);
            }
        }
        sum / f64::from(rings * around)
    }

    #[test]
    fn harmonics_are_orthonormal_under_the_mean_over_the_sphere() {
        for a in 0..count(MAX_DEGREE) {
            for b in 0..=a {
                let product = mean(|s| evaluate(s)[a] * evaluate(s)[b]);
                let expected = if a == b { 1.0 } else { 0.0 };
                assert!((product - expected).abs() < 1e-4, "{a}, {b}: {product}");
            }
        }
    }

    #[test]
    fn squares_of_a_degree_sum_to_its_number_of_orders() {
        let point = [0.48, -0.6, 0.64];
        let y = evaluate(point);
        for degree in 0..=MAX_DEGREE {
            let first = if degree == 0 { 0 } else { count(degree - 1) };
            let sum: f64 = y[first..count(degree)].iter().map(|y| y * y).sum();
            assert!((sum - f64::from(2 * degree + 1)).abs() < 1e-12, "degree {degree}: {sum}");
        }
    }
}

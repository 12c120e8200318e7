//! The mean light of a plant: one number per band for the sky, and a few for all suns. A reader has it before any block
//! is there (SPEC.md, section 9.4).

use serde::{Deserialize, Serialize};

use crate::sun::harmonics;

/// Significant decimal digits that are kept.
const DIGITS: usize = 5;

/// Means of a species' light over its matter: each site counts by its extinction, or by its density in `paper`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeanLight {
    /// Mean light of base 0, `[band]`. Empty where the species has none.
    pub sky: Vec<f64>,
    /// Mean light of a sun of irradiance 1, `[harmonic][band]`, as harmonics of its direction in model space, 1, 4, 9
    /// or 16 of them ([`harmonics::evaluate`]). Empty where the species has no suns.
    pub sun: Vec<Vec<f64>>,
}

impl MeanLight {
    /// Numbers of harmonics that [`MeanLight::sun`] may have.
    pub const HARMONICS: [usize; 4] =
        [harmonics::count(0), harmonics::count(1), harmonics::count(2), harmonics::count(3)];

    /// Returns the means rounded to as many digits as are worth their bytes.
    pub fn rounded(&self) -> MeanLight {
        let all = |values: &Vec<f64>| values.iter().copied().map(rounded).collect();
        MeanLight { sky: all(&self.sky), sun: self.sun.iter().map(all).collect() }
    }

    /// Mean light by band of a sun along the unit vector `towards_sun`, never below 0; 0 without suns.
    pub fn of_sun(&self, towards_sun: [f64; 3]) -> impl Fn(usize) -> f64 + '_ {
        let values = harmonics::evaluate(towards_sun);
        move |band| {
            let sum: f64 = self.sun.iter().zip(values).map(|(of_bands, value)| of_bands[band] * value).sum();
            sum.max(0.0)
        }
    }
}

/// A mean rounded to as many digits as are worth their bytes.
pub fn rounded(mean: f64) -> f64 {
    format!("{mean:.*e}", DIGITS - 1).parse().unwrap_or(mean)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_five_digits_and_light_is_not_below_0() {
        let exact =
            MeanLight { sky: vec![0.123_456_789], sun: vec![vec![1.0], vec![-0.9], vec![0.0], vec![0.0]] };
        let mean = exact.rounded();
        assert_eq!((mean.sky[0], mean.sun[1][0]), (0.123_46, -0.9));
        assert_eq!(mean.of_sun([0.0, 1.0, 0.0])(0), 0.0);
        assert!((mean.of_sun([0.0, -1.0, 0.0])(0) - (1.0 + 0.9 * 3.0f64.sqrt())).abs() < 1e-12);
        assert_eq!(MeanLight { sun: vec![], ..exact }.of_sun([0.0, 1.0, 0.0])(0), 0.0);
    }
}

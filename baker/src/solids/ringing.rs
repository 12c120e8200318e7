//! Harmonics that would give light below zero.
//!
//! Light that comes through a narrow mouth is sharp over the suns; harmonics of a low degree swing below zero beside
//! it. Readers cut that off, and what they keep is too bright in the mean over the suns. So all harmonics but the mean
//! shrink by one factor until no sun has less than nothing: the mean stays what it is [PS08].

use flb_format::ordinates::Ordinates;
use flb_format::sun::harmonics;

/// The harmonics at suns all around.
pub(super) struct Ringing {
    values: Vec<[f64; harmonics::count(harmonics::MAX_DEGREE)]>,
}

impl Ringing {
    pub(super) fn new() -> Ringing {
        let directions = Ordinates::Lebedev110.directions().into_iter();
        Ringing { values: directions.map(|of| harmonics::evaluate(of.direction)).collect() }
    }

    /// Largest factor of all coefficients but the first, 0..=1, at which none of the suns has less than nothing.
    pub(super) fn kept(&self, coefficients: &[f32]) -> f32 {
        let Some((mean, others)) = coefficients.split_first() else { return 1.0 };
        let swing = |values: &[f64]| values.iter().zip(others).map(|(y, c)| y * f64::from(*c)).sum::<f64>();
        let least = self.values.iter().map(|values| swing(&values[1..])).fold(0.0, f64::min);
        let mean = f64::from(mean.max(0.0));
        if least < -mean { (mean / -least) as f32 } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_through_a_mouth_keeps_its_mean_and_is_nowhere_below_zero() {
        // Suns within 26 degrees of up have 1, all others nothing; the projection is summed over fine rings.
        let (mut coefficients, rings, around) = ([0.0f64; 9], 2000, 16);
        for ring in 0..rings {
            let y = (f64::from(ring) + 0.5) / f64::from(rings) * 2.0 - 1.0;
            for step in (0..around).filter(|_| y > 0.9) {
                let (sin, cos) = libm::sincos(f64::from(step) / f64::from(around) * std::f64::consts::TAU);
                let across = libm::sqrt(1.0 - y * y);
                let values = harmonics::evaluate([across * cos, y, across * sin]);
                coefficients.iter_mut().zip(values).for_each(|(sum, y)| *sum += y);
            }
        }
        let coefficients = coefficients.map(|sum| (sum / f64::from(rings * around)) as f32);
        assert!((coefficients[0] - 0.05).abs() < 1e-6);
        let ringing = Ringing::new();
        let least = |kept: f32| {
            let light = |values: &[f64; 16]| {
                let part =
                    |(k, y): (usize, &f64)| y * f64::from(coefficients[k] * if k == 0 { 1.0 } else { kept });
                values[..9].iter().enumerate().map(part).sum::<f64>()
            };
            ringing.values.iter().map(light).fold(f64::INFINITY, f64::min)
        };
        assert!(least(1.0) < -0.04, "{}", least(1.0));
        let kept = ringing.kept(&coefficients);
        assert!((0.3..0.7).contains(&kept), "{kept}");
        assert!(least(kept).abs() < 1e-6, "{}", least(kept));
        assert_eq!(ringing.kept(&[1.0, 0.2, 0.1, 0.0]), 1.0);
        assert_eq!(ringing.kept(&[0.0, 0.2, 0.1, 0.0]), 0.0);
    }
}

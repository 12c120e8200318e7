//! Phase functions: how light that a site scatters is spread over directions.
//!
//! A value is relative to isotropic scattering: its mean over all directions is 1.

use std::f64::consts::PI;

/// Phase function: directions of scattered light, by the cosine between the directions of travel before and after.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Phase {
    /// Henyey and Greenstein (1941), with the mean cosine g, -1 < g < 1.
    HenyeyGreenstein {
        /// Mean cosine of the scattering angle.
        g: f64,
    },
    /// Lambertian facets that are oriented at random; the share `transmitted` of what they scatter leaves through the
    /// far side: T / (R + T). Its mean cosine is (4/9)(2 transmitted - 1). (Ross, 1981; Shultis and Myneni, 1988;
    /// opaque facets: the Lambertian sphere.)
    BiLambert {
        /// Transmitted share of the scattered light, 0 (opaque) to 1.
        transmitted: f64,
    },
}

impl Phase {
    /// Light spread evenly.
    pub const ISOTROPIC: Phase = Phase::HenyeyGreenstein { g: 0.0 };

    /// Relative to isotropic scattering, at the cosine of the scattering angle.
    pub fn at(self, cosine: f64) -> f64 {
        let cosine = cosine.clamp(-1.0, 1.0);
        match self {
            Phase::HenyeyGreenstein { g } => {
                let base = 1.0 + g * g - 2.0 * g * cosine;
                (1.0 - g * g) / (base * libm::sqrt(base))
            }
            Phase::BiLambert { transmitted } => {
                (1.0 - transmitted) * lambert_sphere(cosine) + transmitted * lambert_sphere(-cosine)
            }
        }
    }

    /// Mean of the Legendre polynomial of degree `l` in the cosine: 1, g, ... for the degrees 0, 1, ...
    pub fn moment(self, l: usize) -> f64 {
        match self {
            Phase::HenyeyGreenstein { g } => (0..l).fold(1.0, |power, _| power * g),
            Phase::BiLambert { transmitted } => {
                let sign = if l % 2 == 1 { 2.0 * transmitted - 1.0 } else { 1.0 };
                sign * forward_moment(l)
            }
        }
    }
}

/// The phase function of a Lambertian sphere: 8 / (3 pi) (sin b - b cos b), b the scattering angle.
fn lambert_sphere(cosine: f64) -> f64 {
    let angle = libm::acos(cosine);
    8.0 / (3.0 * PI) * (libm::sin(angle) - angle * cosine)
}

/// Moments of light that is transmitted only: Gauss's rule would do, but sin and b make the integrand smooth in the
/// angle, so Simpson's rule over the angle is exact to rounding.
fn forward_moment(l: usize) -> f64 {
    const STEPS: usize = 512;
    let integrand = |i: usize| {
        let angle = PI * i as f64 / STEPS as f64;
        let cosine = libm::cos(angle);
        lambert_sphere(-cosine) * legendre(l, cosine) * libm::sin(angle) / 2.0
    };
    let weight = |i: usize| match i {
        0 | STEPS => 1.0,
        i if i % 2 == 1 => 4.0,
        _ => 2.0,
    };
    (0..=STEPS).map(|i| weight(i) * integrand(i)).sum::<f64>() * PI / STEPS as f64 / 3.0
}

/// P_l(x), by Bonnet's recursion.
pub(crate) fn legendre(l: usize, x: f64) -> f64 {
    let (mut before, mut value) = (1.0, x);
    if l == 0 {
        return before;
    }
    for k in 1..l {
        let k = k as f64;
        (before, value) = (value, ((2.0 * k + 1.0) * x * value - k * before) / (k + 1.0));
    }
    value
}

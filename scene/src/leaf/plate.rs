//! The plate model: a leaf as a pile of flat plates with smooth faces (Allen, Gausman, Richardson and Thomas, 1969, and
//! Allen, Gausman and Richardson, 1970; in the form of Jacquemoud and Baret, 1990).

use libm::{exp, log, pow, sqrt};

/// Widest angle at which light meets the topmost face, degrees: 40 in Jacquemoud and Baret (1990), who fitted it.
const TOP_ANGLE_DEG: f64 = 40.0;

/// Absorption by a pile below which it counts as none: Stokes's formula is 0/0 there, and its limit is exact.
const NO_ABSORPTION: f64 = 1e-12;

/// Hemispherical reflectance and transmittance of a pile of `layers` >= 1 plates of refractive index `index` > 1, each
/// of which has the absorption `k` >= 0 (coefficient times thickness).
///
/// The first plate meets light within a cone, all others light from everywhere; a pile may have a broken number of
/// them.
pub(super) fn pile(layers: f64, index: f64, k: f64) -> (f64, f64) {
    let through = layer_transmittance(k);
    let (top, into) = (interface_transmittance(TOP_ANGLE_DEG, index), interface_transmittance(90.0, index));
    // Light that leaves a hemisphere inside fills one outside: reciprocity divides by the index squared.
    let out = into / (index * index);
    let within = 1.0 - (1.0 - out) * (1.0 - out) * through * through;
    let plate = |enters: f64| {
        let transmitted = enters * through * out / within;
        (1.0 - enters + (1.0 - out) * through * transmitted, transmitted)
    };
    let ((first_r, first_t), (r, t)) = (plate(top), plate(into));
    let (rest_r, rest_t) = stokes(layers - 1.0, r, t);
    let between = 1.0 - rest_r * r;
    (first_r + first_t * rest_r * t / between, first_t * rest_t / between)
}

/// Reflectance and transmittance of `layers` >= 0 equal plates (Stokes, 1862), written with the inverse of his b, which
/// stays finite for opaque plates.
fn stokes(layers: f64, r: f64, t: f64) -> (f64, f64) {
    let absorbed = 1.0 - r - t;
    if absorbed < NO_ABSORPTION {
        let through = t / (t + (1.0 - t) * layers);
        return (1.0 - through, through);
    }
    let root = sqrt((1.0 + r + t) * (1.0 + r - t) * (1.0 - r + t) * absorbed);
    let a = (1.0 + r * r - t * t + root) / (2.0 * r);
    let c = pow(2.0 * t / (1.0 - r * r + t * t + root), layers);
    let below = a * a - c * c;
    (a * (1.0 - c * c) / below, c * (a * a - 1.0) / below)
}

/// Transmittance of a layer of absorption `k` for light from a hemisphere: (1 - k) e^-k + k^2 E1(k).
pub(super) fn layer_transmittance(k: f64) -> f64 {
    if k == 0.0 {
        return 1.0;
    }
    ((1.0 - k) * exp(-k) + k * k * exponential_integral(k)).max(0.0)
}

/// Transmittance of a smooth face between air and a medium of refractive index `n` > 1, in the mean over unpolarised
/// light of equal radiance from all directions up to `angle_deg` off the normal, above 0 up to 90 (Stern, 1964; Allen,
/// 1973).
pub(super) fn interface_transmittance(angle_deg: f64, n: f64) -> f64 {
    let sine = libm::sin(angle_deg.to_radians());
    let (s2, n2) = (sine * sine, n * n);
    let (p, m) = (n2 + 1.0, n2 - 1.0);
    let k = -m * m / 4.0;
    let a = (n + 1.0) * (n + 1.0) / 2.0;
    let b2 = s2 - p / 2.0;
    let b = sqrt((b2 * b2 + k).max(0.0)) - b2;
    // The antiderivatives of both polarisations, perpendicular and parallel, at one end.
    let perpendicular = |x: f64| k * k / (6.0 * x * x * x) + k / x - x / 2.0;
    let parallel = |x: f64| {
        let y = 2.0 * p * x - m * m;
        -2.0 * n2 * x / (p * p) - 2.0 * n2 * p * log(x) / (m * m)
            + n2 / (2.0 * x)
            + 16.0 * n2 * n2 * (n2 * n2 + 1.0) * log(y) / (p * p * p * m * m)
            + 16.0 * n2 * n2 * n2 / (p * p * p * y)
    };
    (perpendicular(b) - perpendicular(a) + parallel(b) - parallel(a)) / (2.0 * s2)
}

/// E1(x), x > 0: the power series up to 1, the continued fraction above (Abramowitz and Stegun, 5.1.11 and 5.1.22, the
/// latter by Lentz's method).
pub(super) fn exponential_integral(x: f64) -> f64 {
    const EULER: f64 = 0.577_215_664_901_532_9;
    if x <= 1.0 {
        let mut sum = -EULER - log(x);
        let mut power = -1.0;
        for k in 1..=20 {
            power *= -x / f64::from(k);
            sum += power / f64::from(k);
        }
        return sum;
    }
    let mut b = x + 1.0;
    let (mut c, mut d) = (f64::MAX, 1.0 / b);
    let mut fraction = d;
    for i in 1..=100 {
        let step = -f64::from(i * i);
        b += 2.0;
        d = 1.0 / (step * d + b);
        c = b + step / c;
        fraction *= c * d;
    }
    fraction * exp(-x)
}

#[cfg(test)]
mod tests;

//! Scattering by leaves that favour an inclination: Lambertian facets whose normals are distributed.

use std::f64::consts::TAU;

use super::{INCLINATIONS, LeafAngles};

/// Azimuths of the normals of each inclination. Those of two neighbours are turned against each other.
const AZIMUTHS: usize = 32;

/// Lambertian facets, and how much of the leaf area has each normal.
pub(crate) struct Facets {
    normals: Vec<([f64; 3], f64)>,
}

impl Facets {
    /// `None` for leaves that favour no direction: there [`super::Phase::BiLambert`] is the mean over all normals.
    pub(crate) fn new(angles: &LeafAngles) -> Option<Facets> {
        if angles.is_spherical() {
            return None;
        }
        let of_bin = |(bin, share): (usize, &f64)| {
            let up = (bin as f64 + 0.5) / INCLINATIONS as f64;
            let (level, share) = (libm::sqrt(1.0 - up * up), share / AZIMUTHS as f64);
            let normal = move |k: usize| {
                let azimuth = TAU * (k as f64 + 0.5 * (bin % 2) as f64) / AZIMUTHS as f64;
                ([level * libm::cos(azimuth), up, level * libm::sin(azimuth)], share)
            };
            (0..AZIMUTHS).map(normal).collect::<Vec<_>>()
        };
        let shown = angles.shares().iter().enumerate().filter(|(_, share)| **share > 0.0);
        Some(Facets { normals: shown.flat_map(of_bin).collect() })
    }

    /// Light of a beam along `from` that leaves along `to` (unit vectors of travel), through the facets and back from
    /// them, where all that comes is scattered: relative to what randomly oriented leaves intercept, spread evenly. The
    /// mean over all `to` is that of the leaf extinction along `from`, relative to its mean over all directions (Ross,
    /// 1981; Shultis and Myneni, 1988).
    pub(crate) fn scattered(&self, from: [f64; 3], to: [f64; 3]) -> [f64; 2] {
        let (mut through, mut back) = (0.0, 0.0);
        for (normal, share) in &self.normals {
            let along = |v: [f64; 3]| normal[0] * v[0] + normal[1] * v[1] + normal[2] * v[2];
            let both = share * along(from) * along(to);
            match both > 0.0 {
                true => through += both,
                false => back -= both,
            }
        }
        // 2 |n . from| are met, relative to the mean over all directions, and leave with 4 |n . to|.
        [8.0 * through, 8.0 * back]
    }
}

/// Places of |y| that functions of the direction are summed at.
const STEPS: usize = 256;

/// Second moment about the vertical of the leaf extinction relative to its mean: mean over all directions of its
/// product with the harmonic sqrt(5) P_2(y).
pub(crate) fn extinction_moment(angles: &LeafAngles) -> f64 {
    let at = |k: usize| {
        let up = (k as f64 + 0.5) / STEPS as f64;
        angles.relative(up) * libm::sqrt(5.0) * (1.5 * up * up - 0.5)
    };
    if angles.is_spherical() { 0.0 } else { (0..STEPS).map(at).sum::<f64>() / STEPS as f64 }
}

/// By how much the leaf extinction along any direction differs from its mean, relative to that.
pub(crate) fn most_unlike_mean(angles: &LeafAngles) -> f64 {
    let off = |k: usize| (angles.relative(k as f64 / STEPS as f64) - 1.0).abs();
    (0..=STEPS).map(off).fold(0.0, f64::max)
}

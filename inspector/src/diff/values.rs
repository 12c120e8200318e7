//! Two arrays of values to the size of their difference.

use flb_format::sample::site_of;
use serde::Serialize;

/// Difference of two arrays of one shape. Sums run in f64 in the arrays' order.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ValueDiff {
    /// Number of values that are not the same number (`-0` and `0` are; two NaN are not).
    pub differing: u64,
    /// Largest difference, in the field's unit; `None` if one is not finite.
    pub max_abs: Option<f64>,
    /// Root of the mean square difference over all values; `None` if a difference is not finite.
    pub rms: Option<f64>,
    /// `rms` divided by the root of the mean square of A; `None` where that is 0 or not finite.
    pub relative_rms: Option<f64>,
    /// `20 log10(peak of A / rms)` in dB; `None` where nothing differs or the peak is 0.
    pub psnr_db: Option<f64>,
    /// Largest magnitude in A.
    pub peak: f64,
    /// Place of the largest difference; `None` if nothing differs.
    pub worst: Option<Worst>,
}

/// The value that is furthest off.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Worst {
    /// Band, 0 for arrays without bands.
    pub band: u32,
    /// Site, `[x, y, z]`.
    pub site: [u32; 3],
    /// Value in the first file; `None` if not finite.
    pub a: Option<f32>,
    /// Value in the second file; `None` if not finite.
    pub b: Option<f32>,
}

impl ValueDiff {
    /// Whether the arrays are the same (`None`), or no value is further off than `tolerance` times the
    /// largest magnitude of A.
    pub fn passes(&self, tolerance: Option<f64>) -> bool {
        match tolerance {
            None => self.differing == 0,
            Some(t) => self.max_abs.is_some_and(|m| m <= t * self.peak),
        }
    }
}

/// Compares `[band][z][y][x]` arrays (or `[z][y][x]`) of a lattice.
///
/// # Panics
/// If the arrays differ in length; callers compare shapes first.
pub fn compare_values(a: &[f32], b: &[f32], lattice: u32) -> ValueDiff {
    assert_eq!(a.len(), b.len(), "arrays of one shape");
    let (mut differing, mut squares, mut a_squares, mut peak) = (0u64, 0.0f64, 0.0f64, 0.0f64);
    let (mut largest, mut worst) = (0.0f64, None);
    for (i, (&x, &y)) in a.iter().zip(b).enumerate() {
        let magnitude = f64::from(x.abs());
        peak = peak.max(magnitude);
        a_squares += magnitude * magnitude;
        if x == y {
            continue;
        }
        differing += 1;
        let difference = (f64::from(x) - f64::from(y)).abs();
        // A NaN counts as infinitely far.
        let difference = if difference.is_nan() { f64::INFINITY } else { difference };
        squares += difference * difference;
        if difference > largest {
            (largest, worst) = (difference, Some(i));
        }
    }
    let count = a.len().max(1) as f64;
    let (rms, a_rms) = ((squares / count).sqrt(), (a_squares / count).sqrt());
    let finite = |v: f64| v.is_finite().then_some(v);
    ValueDiff {
        differing,
        max_abs: finite(largest),
        rms: finite(rms),
        relative_rms: finite(rms / a_rms),
        psnr_db: if rms > 0.0 && peak > 0.0 { finite(20.0 * libm::log10(peak / rms)) } else { None },
        peak,
        worst: worst.map(|i| worst_at(i, lattice, a[i], b[i])),
    }
}

fn worst_at(index: usize, lattice: u32, a: f32, b: f32) -> Worst {
    let sites = (lattice as usize).pow(3);
    let finite = |v: f32| v.is_finite().then_some(v);
    Worst { band: (index / sites) as u32, site: site_of(index % sites, lattice), a: finite(a), b: finite(b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_arrays_have_no_difference() {
        let diff = compare_values(&[1.0, -0.0, 3.0], &[1.0, 0.0, 3.0], 1);
        assert_eq!((diff.differing, diff.max_abs, diff.rms, diff.psnr_db), (0, Some(0.0), Some(0.0), None));
        assert!(diff.passes(None) && diff.passes(Some(0.0)) && diff.worst.is_none());
    }

    #[test]
    fn a_planted_difference_is_found_where_it_is_and_as_large_as_it_is() {
        let a = vec![2.0f32; 2 * 64];
        for (index, band, site) in [(0, 0, [0, 0, 0]), (64 + 7, 1, [3, 1, 0]), (127, 1, [3, 3, 3])] {
            let mut b = a.clone();
            b[index] = 2.5;
            let diff = compare_values(&a, &b, 4);
            assert_eq!(diff.differing, 1);
            assert_eq!(diff.max_abs, Some(0.5));
            assert_eq!(diff.worst, Some(Worst { band, site, a: Some(2.0), b: Some(2.5) }));
            let rms = 0.5 / 128f64.sqrt();
            assert!((diff.rms.unwrap() - rms).abs() < 1e-15);
            assert!((diff.relative_rms.unwrap() - rms / 2.0).abs() < 1e-15);
            assert!((diff.psnr_db.unwrap() - 20.0 * libm::log10(2.0 / rms)).abs() < 1e-9);
            assert!(!diff.passes(None) && !diff.passes(Some(0.2499)) && diff.passes(Some(0.25)));
        }
    }

    #[test]
    fn one_unit_in_the_last_place_is_a_difference() {
        let diff = compare_values(&[1.0], &[f32::from_bits(1.0f32.to_bits() + 1)], 1);
        assert!(diff.differing == 1 && !diff.passes(None) && diff.passes(Some(1e-6)));
    }

    #[test]
    fn nan_never_passes() {
        for (a, b) in [(f32::NAN, 1.0), (1.0, f32::NAN), (f32::NAN, f32::NAN), (1.0, f32::INFINITY)] {
            let diff = compare_values(&[a, 1.0], &[b, 1.0], 1);
            assert!(diff.differing == 1 && !diff.passes(None) && !diff.passes(Some(1e9)), "{a} {b}");
            assert!(
                diff.max_abs.is_none() && serde_json::to_string(&diff).unwrap().contains("\"max_abs\":null")
            );
        }
    }

    #[test]
    fn an_array_of_zeros_has_no_relative_difference() {
        let diff = compare_values(&[0.0], &[0.5], 1);
        assert_eq!((diff.relative_rms, diff.psnr_db, diff.max_abs), (None, None, Some(0.5)));
        assert!(!diff.passes(Some(1.0)), "a tolerance of nothing is nothing");
    }
}

//! Light that can be computed with a pencil, or nearly.

use super::*;

#[test]
fn a_pure_absorber_follows_its_exponential() {
    // A block of 8 sites of optical depth 1.5 each; light along an axis: the mean in site k is known.
    let block = medium(16, |c| if c.iter().all(|c| (4.0..12.0).contains(c)) { 1.5 } else { 0.0 });
    for (axis, sign) in [(0, 1.0), (1, 1.0), (2, -1.0)] {
        let mut toward = [0.0; 3];
        toward[axis] = sign;
        let light = uncollided(&block, toward, 2).unwrap();
        for (&site, phi) in block.sites().iter().zip(light) {
            let at = [site % 16, site / 16 % 16, site / 256][axis];
            let passed = f64::from(if sign > 0.0 { 11 - at } else { at - 4 });
            let expected = libm::exp(-1.5 * passed) * (1.0 - libm::exp(-1.5)) / 1.5;
            assert!(
                (phi / expected - 1.0).abs() < 1e-6,
                "axis {axis}, site {at}: {phi}, expected {expected}"
            );
        }
    }
}

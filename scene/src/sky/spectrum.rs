//! The sun's light through air, as a colour.
//!
//! Spectrum outside the atmosphere, ozone and the extinctions are those of Iqbal (1983) that Preetham, Shirley and
//! Smits (1999), appendix A.1, take. Water vapour and mixed gases absorb above 690 nm, where no eye sees, and are left
//! out.

use libm::{exp, pow};

use crate::leaf::{FROM_XYZ, color_matching};

/// Irradiance outside the atmosphere, W m^-2 nm^-1, from 380 nm on in steps of 10.
const SUN: [f64; 38] = [
    1.127, 1.105, 1.438, 1.762, 1.758, 1.649, 1.822, 2.019, 2.079, 2.046, 2.087, 1.962, 1.954, 1.894, 1.845,
    1.854, 1.794, 1.736, 1.706, 1.723, 1.726, 1.711, 1.677, 1.645, 1.612, 1.580, 1.554, 1.521, 1.496, 1.465,
    1.436, 1.411, 1.378, 1.353, 1.322, 1.298, 1.268, 1.243,
];
/// Absorption by ozone at the same wavelengths, per cm at standard pressure.
const OZONE: [f64; 38] = [
    0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.003, 0.006, 0.009, 0.014, 0.021, 0.030, 0.040, 0.048, 0.063, 0.075,
    0.085, 0.103, 0.120, 0.120, 0.115, 0.125, 0.120, 0.105, 0.090, 0.079, 0.067, 0.057, 0.048, 0.036, 0.028,
    0.023, 0.018, 0.014, 0.011, 0.010, 0.009,
];
/// Ozone overhead, cm at standard pressure.
const OZONE_CM: f64 = 0.35;
/// Lumens per watt at 555 nm.
const LUMENS_PER_W: f64 = 683.0;

/// CIE XYZ of the beam on a plane that faces it, Y in lux, behind so many air masses.
pub(super) fn sun_xyz(air_mass: f64, turbidity: f64) -> [f64; 3] {
    // Angstrom's turbidity of aerosols; its exponent is 1.3.
    let beta = 0.046_083_658 * turbidity - 0.045_860_259;
    let mut sum = [0.0; 3];
    for (step, (sun, ozone)) in SUN.iter().zip(OZONE).enumerate() {
        let nm = 380.0 + 10.0 * step as f64;
        let um = nm / 1000.0;
        let depth = 0.008_735 * pow(um, -4.08) + beta * pow(um, -1.3) + ozone * OZONE_CM;
        let power = sun * exp(-air_mass * depth) * 10.0;
        let sees = color_matching(nm);
        (0..3).for_each(|i| sum[i] += LUMENS_PER_W * power * sees[i]);
    }
    sum
}

/// Linear sRGB; colours outside of it lose what is negative.
pub(super) fn srgb(xyz: [f64; 3]) -> [f64; 3] {
    FROM_XYZ.map(|row| (row[0] * xyz[0] + row[1] * xyz[1] + row[2] * xyz[2]).max(0.0))
}

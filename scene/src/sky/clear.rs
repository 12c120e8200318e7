//! A clear sky and its sun, by the sun's elevation and the turbidity of the air.
//!
//! The sky is that of Preetham, Shirley and Smits (1999): Perez's formula for luminance and chromaticity, its
//! coefficients linear in the turbidity. The sun is its spectrum outside the atmosphere through the air mass of Kasten
//! and Young (1989). Units are the sun's: the beam of the sun overhead at turbidity 3 has luminance 1 (about 93
//! thousand lux). The model holds for the sun above the horizon; at sunset its sky is some ten times too bright. Below
//! the horizon the sky keeps the colours of sunset and fades by a factor of 10 for 1.8 degrees, to the 3.4 lux that
//! civil twilight ends with at 6; at 18 it is dark. Below the sky lies ground, lit by both, without any shade.

use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::RangeInclusive;

use glam::DVec3;
use libm::{acos, asin, exp, pow, tan};

use super::spectrum::{srgb, sun_xyz};
use super::{GROUND_REFLECTANCE, SkyError};

/// Turbidities that the model takes: 2 is very clear, 3 clear, 6 hazy, 10 thick haze.
pub const TURBIDITIES: RangeInclusive<f64> = 2.0..=10.0;
/// A clear day's.
pub const CLEAR_TURBIDITY: f64 = 3.0;

/// Radius of the sun's disc, degrees.
const SUN_RADIUS_DEG: f64 = 0.2665;
/// Decades that twilight loses per degree, from what of the sun's depression it fades to nothing, and where it ends.
const TWILIGHT: [f64; 3] = [0.55, 12.0, 18.0];
/// Rings and points of a ring at which the sky's irradiance on the ground is summed.
const RINGS: [u32; 2] = [32, 64];

/// A clear sky.
#[derive(Debug, Clone, PartialEq)]
pub struct ClearSky {
    /// Irradiance of the sun on a plane that faces it.
    pub sun: [f32; 3],
    /// Towards the brightest part of the sky: the sun, or where the horizon is nearest to it.
    glow: DVec3,
    /// A to E of luminance and of the chromaticities x and y.
    perez: [[f64; 5]; 3],
    /// What Perez's formula is multiplied by for each: luminance, x, y.
    factor: [f64; 3],
    /// Radiance of the ground.
    ground: [f32; 3],
}

impl ClearSky {
    /// Makes the sky of a sun that stands in a direction of any length.
    ///
    /// # Errors
    /// [`SkyError::NoDirection`], [`SkyError::Turbidity`].
    pub fn new(towards_sun: [f64; 3], turbidity: f64) -> Result<ClearSky, SkyError> {
        let towards = DVec3::from(towards_sun).try_normalize();
        let towards = towards.ok_or(SkyError::NoDirection { found: towards_sun })?;
        if !TURBIDITIES.contains(&turbidity) {
            return Err(SkyError::Turbidity { found: turbidity });
        }
        let elevation_deg = asin(towards.y.clamp(-1.0, 1.0)).to_degrees();
        let glow = DVec3::new(towards.x, towards.y.max(0.0), towards.z).normalize_or(DVec3::X);
        let zenith_angle = (90.0 - elevation_deg.max(0.0)).to_radians();
        let perez = coefficients(turbidity);
        let zenith = zenith(turbidity, zenith_angle);
        let unit = sun_xyz(air_mass(90.0), CLEAR_TURBIDITY)[1];
        let mut factor = [0, 1, 2].map(|i| zenith[i] / formula(&perez[i], 1.0, zenith_angle));
        factor[0] *= 1000.0 * twilight(-elevation_deg) / unit;
        let above = ((elevation_deg / SUN_RADIUS_DEG + 1.0) / 2.0).clamp(0.0, 1.0);
        let sun = srgb(sun_xyz(air_mass(elevation_deg), turbidity)).map(|band| (band * above / unit) as f32);
        let mut sky = ClearSky { sun, glow, perez, factor, ground: [0.0; 3] };
        let of_sky = sky.on_level_ground();
        let lit = |band: usize| of_sky[band] + f64::from(sun[band]) * towards.y.max(0.0);
        sky.ground = [0, 1, 2].map(|band| (f64::from(GROUND_REFLECTANCE[band]) * lit(band) / PI) as f32);
        Ok(sky)
    }

    /// Radiance from a direction of unit length: of the sky, or of the ground.
    pub fn radiance(&self, towards: [f32; 3]) -> [f32; 3] {
        if towards[1] < 0.0 { self.ground } else { self.above(towards) }
    }

    /// Radiance of the sky in a direction. One that is not of unit length is taken for one that is.
    pub fn above(&self, towards: [f32; 3]) -> [f32; 3] {
        let towards = glam::Vec3::from(towards).as_dvec3().normalize_or(DVec3::Y);
        let from_sun = acos(towards.dot(self.glow).clamp(-1.0, 1.0));
        let [luminance, x, y] =
            [0, 1, 2].map(|i| self.factor[i] * formula(&self.perez[i], towards.y.max(0.0), from_sun));
        let luminance = luminance.max(0.0);
        let xyz = [x / y * luminance, luminance, (1.0 - x - y) / y * luminance];
        srgb(xyz).map(|band| band as f32)
    }

    /// Irradiance of the sky on level ground.
    fn on_level_ground(&self) -> [f64; 3] {
        let [rings, around] = RINGS.map(f64::from);
        let mut sum = [0.0; 3];
        for ring in 0..RINGS[0] {
            // Even steps of the squared sine have even shares of the cosine.
            let level = libm::sqrt((f64::from(ring) + 0.5) / rings);
            let up = libm::sqrt(1.0 - level * level);
            for step in 0..RINGS[1] {
                let (sin, cos) = libm::sincos(2.0 * PI * (f64::from(step) + 0.5) / around);
                let light = self.above([level * cos, up, level * sin].map(|c| c as f32));
                (0..3).for_each(|band| sum[band] += f64::from(light[band]));
            }
        }
        sum.map(|sum| sum * PI / (rings * around))
    }
}

/// Air masses on the way of the beam: Kasten and Young (1989).
fn air_mass(elevation_deg: f64) -> f64 {
    let up = elevation_deg.max(0.0);
    1.0 / (libm::sin(up.to_radians()) + 0.505_72 * pow(up + 6.079_95, -1.6364))
}

/// What is left of the sky so many degrees after sunset.
fn twilight(depression_deg: f64) -> f64 {
    let [decades, from, to] = TWILIGHT;
    let night = ((depression_deg - from) / (to - from)).clamp(0.0, 1.0);
    pow(10.0, -decades * depression_deg.max(0.0)) * (1.0 - night * night * (3.0 - 2.0 * night))
}

/// Perez's formula, at the cosine of the angle from the zenith and the angle from the sun.
fn formula([a, b, c, d, e]: &[f64; 5], up: f64, from_sun: f64) -> f64 {
    let cosine = libm::cos(from_sun);
    (1.0 + a * exp(b / up.max(1e-4))) * (1.0 + c * exp(d * from_sun) + e * cosine * cosine)
}

/// Preetham, Shirley and Smits (1999), appendix A.2: A to E for luminance, x and y.
fn coefficients(turbidity: f64) -> [[f64; 5]; 3] {
    const LINES: [[[f64; 2]; 5]; 3] = [
        [[0.1787, -1.4630], [-0.3554, 0.4275], [-0.0227, 5.3251], [0.1206, -2.5771], [-0.0670, 0.3703]],
        [[-0.0193, -0.2592], [-0.0665, 0.0008], [-0.0004, 0.2125], [-0.0641, -0.8989], [-0.0033, 0.0452]],
        [[-0.0167, -0.2608], [-0.0950, 0.0092], [-0.0079, 0.2102], [-0.0441, -1.6537], [-0.0109, 0.0529]],
    ];
    LINES.map(|lines| lines.map(|[slope, at_0]| slope * turbidity + at_0))
}

/// The same: luminance of the zenith, thousand cd/m^2, and its chromaticity, for the sun's angle from it.
fn zenith(turbidity: f64, angle: f64) -> [f64; 3] {
    const X: [[f64; 4]; 3] = [
        [0.00166, -0.00375, 0.00209, 0.0],
        [-0.02903, 0.06377, -0.03202, 0.00394],
        [0.11693, -0.21196, 0.06052, 0.25886],
    ];
    const Y: [[f64; 4]; 3] = [
        [0.00275, -0.00610, 0.00317, 0.0],
        [-0.04214, 0.08970, -0.04153, 0.00516],
        [0.15346, -0.26756, 0.06670, 0.26688],
    ];
    let chi = (4.0 / 9.0 - turbidity / 120.0) * 2.0 * (FRAC_PI_2 - angle);
    let luminance = (4.0453 * turbidity - 4.9710) * tan(chi) - 0.2155 * turbidity + 2.4192;
    let polynomial = |rows: &[[f64; 4]; 3]| {
        let of = |row: &[f64; 4]| ((row[0] * angle + row[1]) * angle + row[2]) * angle + row[3];
        (of(&rows[0]) * turbidity + of(&rows[1])) * turbidity + of(&rows[2])
    };
    [luminance, polynomial(&X), polynomial(&Y)]
}

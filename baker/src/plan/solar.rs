//! The sun's declination over days. Over whole days a plan needs nothing else: every hour angle occurs.
//!
//! A plan takes every hour angle at every declination of the days, which is more than the sun's path: at one hour of one day
//! the sun has one declination of the day's up to 0.4 degrees. So a base is kept that the path passes within 0.4 degrees,
//! and none that it reaches is lost.
//!
//! Meeus, Astronomical Algorithms (2nd edition), chapter 25, "low accuracy", which is also the one of NOAA's solar
//! calculator: within 0.01 degrees from 1900 to 2100. Own code, because crates for solar positions give
//! azimuth and elevation at an instant, where a plan needs the range of one angle; and these ten lines keep to `libm`. Refraction
//! and the size of the disc are ignored: the sun is a point, and counts from geometric elevation 0.

use crate::scene::SunPath;

/// What the formula and the steps of [`declinations_deg`] may be off together; the range is widened by it.
pub const DECLINATION_MARGIN_DEG: f64 = 0.02;
/// Steps per day. Near a solstice the declination is a parabola of 0.0035 degrees per day squared, so that
/// its top stands out by less than 1e-4 between two steps; elsewhere the ends of the range decide.
const STEPS_PER_DAY: i64 = 8;
/// After a year and a day the range is the same again.
const DAYS_OF_ALL: i64 = 367;

/// Smallest and largest declination over the days of a path, widened by [`DECLINATION_MARGIN_DEG`].
pub fn declinations_deg(path: &SunPath) -> [f64; 2] {
    let (from, to) = (path.from.since_2000(), path.to.since_2000() + 1);
    let days = (to - from).min(DAYS_OF_ALL);
    let steps = (0..=days * STEPS_PER_DAY).map(|step| from as f64 + step as f64 / STEPS_PER_DAY as f64);
    let (low, high) = steps
        .map(declination_deg)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), d| (low.min(d), high.max(d)));
    [low - DECLINATION_MARGIN_DEG, high + DECLINATION_MARGIN_DEG]
}

/// Apparent declination, days after 2000-01-01 0:00 UTC; the minute between UTC and terrestrial time moves it by less than
/// 1e-3 degrees.
fn declination_deg(days: f64) -> f64 {
    let t = (days - 0.5) / 36_525.0;
    let mean_longitude = 280.466_46 + t * (36_000.769_83 + t * 0.000_303_2);
    let anomaly = (357.529_11 + t * (35_999.050_29 - t * 0.000_153_7)).to_radians();
    let centre = (1.914_602 - t * (0.004_817 + t * 0.000_014)) * libm::sin(anomaly)
        + (0.019_993 - t * 0.000_101) * libm::sin(2.0 * anomaly)
        + 0.000_289 * libm::sin(3.0 * anomaly);
    let node = (125.04 - 1_934.136 * t).to_radians();
    let longitude = (mean_longitude + centre - 0.005_69 - 0.004_78 * libm::sin(node)).to_radians();
    let obliquity = (23.439_291 - 0.013_004_2 * t + 0.002_56 * libm::cos(node)).to_radians();
    libm::asin(libm::sin(obliquity) * libm::sin(longitude)).to_degrees()
}

#[cfg(test)]
pub(super) mod tests;

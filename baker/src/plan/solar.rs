//! The sun's declination over days. Over whole days a plan needs nothing else: every hour angle occurs.
//!
//! A plan takes every hour angle at every declination of the days, which is more than the sun's path: at one hour of
//! one day the sun has one declination of the day's up to 0.4 degrees. So a base is kept that the path passes within
//! 0.4 degrees, and none that it reaches is lost.
//!
//! The formula is that of [`flb_scene::solar`].

use flb_scene::scene::SunPath;
use flb_scene::solar::declination_deg;

/// Largest error of the formula and the steps of [`declinations_deg`] together, degrees; the range is widened by it.
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

#[cfg(test)]
mod tests;

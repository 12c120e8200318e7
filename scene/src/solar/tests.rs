use flb_testkit::psa::psa;

use super::*;
use crate::scene::SunPath;

fn start_of(day: &str) -> f64 {
    let path: SunPath = format!("0,0,{day}").parse().expect("a day");
    path.from.since_2000() as f64
}

#[test]
fn equinoxes_and_solstices_fall_when_the_almanacs_have_them() {
    // Published to the minute (US Naval Observatory, "Earth's Seasons"), UTC. At an equinox the declination crosses 0
    // by 0.4 degrees a day; at a solstice it is the obliquity, 23.44 degrees, and half a day away it is less.
    for (day, hours, minutes, expected) in [
        ("2000-03-20", 7.0, 35.0, 0.0),
        ("2000-06-21", 1.0, 48.0, 23.438),
        ("2000-09-22", 17.0, 27.0, 0.0),
        ("2000-12-21", 13.0, 37.0, -23.438),
        ("2026-03-20", 14.0, 46.0, 0.0),
        ("2026-06-21", 8.0, 24.0, 23.436),
        ("2026-09-23", 0.0, 5.0, 0.0),
        ("2026-12-21", 20.0, 50.0, -23.436),
    ] {
        let at = start_of(day) + (hours + minutes / 60.0) / 24.0;
        let found = declination_deg(at);
        assert!((found - expected).abs() < 0.003, "{day}: {found} for {expected}");
        if expected != 0.0 {
            let less = |days: f64| declination_deg(at + days).abs() < found.abs();
            assert!(less(-0.5) && less(0.5), "{day}");
        }
    }
    // Meeus, example 25.a: 1992 October 13 at 0 TD.
    let found = declination_deg(start_of("1992-10-13"));
    assert!((found - -7.785_07).abs() < 1e-3, "{found}");
}

/// Of the two algorithms together, 1999 to 2015, where PSA is good to 0.01 degrees; degrees of arc.
const APART_DEG: f64 = 0.02;

#[test]
fn the_sun_stands_where_another_algorithm_has_it() {
    let start = start_of("1999-06-01");
    for step in 0..4000 {
        let days = start + f64::from(step) * 1.437_21;
        let latitude = f64::from(step * 37 % 179) - 89.0;
        let longitude = f64::from(step * 101 % 359) - 179.0;
        let [found, expected] =
            [azimuth_elevation_deg(days, latitude, longitude), psa(days, latitude, longitude)]
                .map(|[azimuth, elevation]| flb_format::sun::towards_sun(azimuth, elevation));
        let apart: f64 = found.iter().zip(&expected).map(|(a, b)| (a - b) * (a - b)).sum();
        assert!(
            apart.sqrt().to_degrees() < APART_DEG,
            "{days}, {latitude}, {longitude}: {found:?} {expected:?}"
        );
    }
}

#[test]
fn the_zenith_and_the_poles_are_no_exceptions() {
    // At an equinox the sun passes straight above the equator: 2026-03-20 14:46 UTC, over the meridian that has noon
    // then.
    let days = start_of("2026-03-20") + (14.0 + 46.0 / 60.0) / 24.0;
    let overhead = (-180..=180).map(|longitude| azimuth_elevation_deg(days, 0.0, f64::from(longitude))[1]);
    assert!(overhead.fold(0.0, f64::max) > 89.4);
    for latitude in [90.0, -90.0] {
        for longitude in [-180.0, 0.0, 77.0] {
            let [azimuth, elevation] = azimuth_elevation_deg(days, latitude, longitude);
            assert!((0.0..360.0).contains(&azimuth) && elevation.abs() < 0.01, "{azimuth} {elevation}");
        }
    }
}

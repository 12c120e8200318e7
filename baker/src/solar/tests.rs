use super::*;
use crate::scene::SunPath;

/// Azimuth and elevation at an instant: the PSA algorithm (Blanco-Muriel and others, Solar Energy 70, 2001), which shares
/// nothing with the code under test. Within 0.01 degrees from 1999 to 2015, a few hundredths beyond.
pub fn psa(days_since_2000: f64, latitude_deg: f64, longitude_deg: f64) -> [f64; 2] {
    let elapsed = days_since_2000 - 0.5;
    let hours = 24.0 * (days_since_2000 - days_since_2000.floor());
    let omega = 2.1429 - 0.001_039_459_4 * elapsed;
    let mean_longitude = 4.895_063_0 + 0.017_202_791_698 * elapsed;
    let anomaly = 6.240_060_0 + 0.017_201_969_9 * elapsed;
    let longitude =
        mean_longitude + 0.033_416_07 * libm::sin(anomaly) + 0.000_348_94 * libm::sin(2.0 * anomaly)
            - 0.000_113_4
            - 0.000_020_3 * libm::sin(omega);
    let obliquity = 0.409_092_8 - 6.214e-9 * elapsed + 0.000_039_6 * libm::cos(omega);
    let right_ascension = libm::atan2(libm::cos(obliquity) * libm::sin(longitude), libm::cos(longitude));
    let declination = libm::asin(libm::sin(obliquity) * libm::sin(longitude));
    let greenwich_hours = 6.697_424_324_2 + 0.065_709_828_3 * elapsed + hours;
    let hour_angle = (greenwich_hours * 15.0 + longitude_deg).to_radians() - right_ascension;
    let latitude = latitude_deg.to_radians();
    let up = libm::cos(latitude) * libm::cos(hour_angle) * libm::cos(declination)
        + libm::sin(declination) * libm::sin(latitude);
    let azimuth = libm::atan2(
        -libm::sin(hour_angle),
        libm::tan(declination) * libm::cos(latitude) - libm::sin(latitude) * libm::cos(hour_angle),
    );
    [azimuth.to_degrees(), libm::asin(up.clamp(-1.0, 1.0)).to_degrees()]
}

fn start_of(day: &str) -> f64 {
    let path: SunPath = format!("0,0,{day}").parse().expect("a day");
    path.from.since_2000() as f64
}

#[test]
fn equinoxes_and_solstices_fall_when_the_almanacs_have_them() {
    // Published to the minute (US Naval Observatory, "Earth's Seasons"), UTC. At an equinox the declination crosses 0 by
    // 0.4 degrees a day; at a solstice it is the obliquity, 23.44 degrees, and half a day away it is less.
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
    // At an equinox the sun passes straight above the equator: 2026-03-20 14:46 UTC, over the meridian that has noon then.
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

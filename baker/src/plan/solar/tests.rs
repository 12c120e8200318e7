use super::*;

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

fn path(days: &str) -> SunPath {
    format!("52.5,13.4,{days}").parse().expect("a path")
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
        let at = path(day).from.since_2000() as f64 + (hours + minutes / 60.0) / 24.0;
        let found = declination_deg(at);
        assert!((found - expected).abs() < 0.003, "{day}: {found} for {expected}");
        if expected != 0.0 {
            let less = |days: f64| declination_deg(at + days).abs() < found.abs();
            assert!(less(-0.5) && less(0.5), "{day}");
        }
    }
    // Meeus, example 25.a: 1992 October 13 at 0 TD.
    let found = declination_deg(path("1992-10-13").from.since_2000() as f64);
    assert!((found - -7.785_07).abs() < 1e-3, "{found}");
}

#[test]
fn a_year_ranges_from_solstice_to_solstice() {
    let [low, high] = declinations_deg(&path("2026-01-01..2026-12-31"));
    assert!((low + 23.438 + DECLINATION_MARGIN_DEG).abs() < 0.002, "{low}");
    assert!((high - 23.438 - DECLINATION_MARGIN_DEG).abs() < 0.002, "{high}");
    let [low, high] = declinations_deg(&path("1900-01-01..2100-12-31"));
    assert!(high - low > 46.8 && high - low < 47.0);
    // A single day in March spans what the sun climbs in it, 0.4 degrees.
    let [low, high] = declinations_deg(&path("2026-03-20"));
    assert!((high - low - 2.0 * DECLINATION_MARGIN_DEG - 0.395).abs() < 0.005, "{low} to {high}");
}

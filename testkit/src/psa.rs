//! A second algorithm for the sun's place.

/// Azimuth and elevation at an instant: the PSA algorithm (Blanco-Muriel and others, Solar Energy 70, 2001), which
/// shares nothing with the code under test. Within 0.01 degrees from 1999 to 2015, a few hundredths beyond.
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

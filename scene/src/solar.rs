//! Where the sun stands at an instant, from anywhere on earth.
//!
//! Meeus, Astronomical Algorithms (2nd edition), chapters 12 (sidereal time), 13 (horizontal coordinates) and 25, "low
//! accuracy", which is also the one of NOAA's solar calculator: within 0.01 degrees from 1900 to 2100. Own code,
//! because crates for solar positions give azimuth and elevation at an instant, where a plan needs the range of one
//! angle; and these few lines keep to `libm`. Refraction and the size of the disc are ignored: the sun is a point, and
//! rises and sets at geometric elevation 0.

/// Where the sun stands among the stars, and the earth below it.
struct Apparent {
    /// Degrees.
    right_ascension: f64,
    /// Degrees.
    declination: f64,
    /// Sidereal time at Greenwich, degrees.
    sidereal: f64,
}

/// Apparent declination, days after 2000-01-01 0:00 UTC; the minute between UTC and terrestrial time moves it by less
/// than 1e-3 degrees.
pub fn declination_deg(days: f64) -> f64 {
    apparent(days).declination
}

/// Azimuth (clockwise from north, 0 to 360) and elevation, days after 2000-01-01 0:00 UTC, at a latitude (north is
/// positive) and a longitude (east is positive).
pub fn azimuth_elevation_deg(days: f64, latitude_deg: f64, longitude_deg: f64) -> [f64; 2] {
    let sun = apparent(days);
    let hour_angle = (sun.sidereal + longitude_deg - sun.right_ascension).to_radians();
    let (latitude, declination) = (latitude_deg.to_radians(), sun.declination.to_radians());
    let [sin_latitude, cos_latitude] = [libm::sin(latitude), libm::cos(latitude)];
    let [sin_declination, cos_declination] = [libm::sin(declination), libm::cos(declination)];
    let towards_equator = cos_declination * libm::cos(hour_angle);
    let east = -cos_declination * libm::sin(hour_angle);
    let north = sin_declination * cos_latitude - towards_equator * sin_latitude;
    let up = sin_declination * sin_latitude + towards_equator * cos_latitude;
    // Not by the arcsine, which knows nothing near the zenith.
    let elevation = libm::atan2(up, libm::sqrt(east * east + north * north));
    [libm::atan2(east, north).to_degrees().rem_euclid(360.0), elevation.to_degrees()]
}

fn apparent(days: f64) -> Apparent {
    let since_noon = days - 0.5;
    let t = since_noon / 36_525.0;
    let mean_longitude = 280.466_46 + t * (36_000.769_83 + t * 0.000_303_2);
    let anomaly = (357.529_11 + t * (35_999.050_29 - t * 0.000_153_7)).to_radians();
    let center = (1.914_602 - t * (0.004_817 + t * 0.000_014)) * libm::sin(anomaly)
        + (0.019_993 - t * 0.000_101) * libm::sin(2.0 * anomaly)
        + 0.000_289 * libm::sin(3.0 * anomaly);
    let node = (125.04 - 1_934.136 * t).to_radians();
    let nutation = -0.004_78 * libm::sin(node);
    let longitude = (mean_longitude + center - 0.005_69 + nutation).to_radians();
    let obliquity = (23.439_291 - 0.013_004_2 * t + 0.002_56 * libm::cos(node)).to_radians();
    let mean_sidereal = 280.460_618_37 + 360.985_647_366_29 * since_noon + 0.000_387_933 * t * t;
    Apparent {
        right_ascension: libm::atan2(libm::cos(obliquity) * libm::sin(longitude), libm::cos(longitude))
            .to_degrees(),
        declination: libm::asin(libm::sin(obliquity) * libm::sin(longitude)).to_degrees(),
        sidereal: mean_sidereal + nutation * libm::cos(obliquity),
    }
}

#[cfg(test)]
mod tests;

//! Values of flags that several commands share.

use std::time::Duration;

use clap::builder::{BoolValueParser, OsStringValueParser, TypedValueParser};
use flb_farm::cache::Place;
use flb_files::Existing;

/// Most stops of exposure, up and down.
const MAX_STOPS: f32 = 100.0;

/// Whether `--force` is there.
pub(super) fn existing() -> impl TypedValueParser<Value = Existing> {
    BoolValueParser::new().map(|is_forced| if is_forced { Existing::Replace } else { Existing::Keep })
}

/// A folder or a bucket.
pub(super) fn cache_place() -> impl TypedValueParser<Value = Place> {
    OsStringValueParser::new().try_map(Place::parse)
}

/// A share from 0 up: `1%` or `0.01`.
pub(super) fn share(text: &str) -> Result<f64, String> {
    let (number, unit) = text.strip_suffix('%').map_or((text, 1.0), |number| (number, 100.0));
    let share = number.trim_end().parse().map(|number: f64| number / unit);
    match share {
        Ok(share) if share.is_finite() && share >= 0.0 => Ok(share),
        _ => Err(format!("found {text:?}, expected a share from 0 up, as 1% or 0.01")),
    }
}

/// Stops of exposure.
pub(super) fn exposure(text: &str) -> Result<f32, String> {
    let stops: f32 = text.parse().map_err(|_| format!("found {text:?}, expected a number of stops"))?;
    match stops.abs() <= MAX_STOPS {
        true => Ok(stops),
        false => Err(format!("found {stops}, expected -{MAX_STOPS} to {MAX_STOPS} stops")),
    }
}

/// "AZIMUTH,ELEVATION" in degrees.
pub(super) fn angle_pair(text: &str) -> Result<[f64; 2], String> {
    let expected = || format!("expected AZIMUTH,ELEVATION in degrees, such as 135,30; found {text:?}");
    let (azimuth, elevation) = text.split_once(',').ok_or_else(expected)?;
    let azimuth: f64 = azimuth.trim().parse().map_err(|_| expected())?;
    let elevation: f64 = elevation.trim().parse().map_err(|_| expected())?;
    if !azimuth.is_finite() || azimuth.abs() > 3600.0 {
        return Err(format!("azimuth {azimuth} is outside -3600 to 3600 degrees"));
    }
    if !(-90.0..=90.0).contains(&elevation) {
        return Err(format!("elevation {elevation} is outside -90 to 90 degrees"));
    }
    Ok([azimuth, elevation])
}

/// "WxH" in pixels.
pub(super) fn size(text: &str) -> Result<[u32; 2], String> {
    let expected = || format!("expected WIDTHxHEIGHT in pixels, such as 640x480; found {text:?}");
    let (width, height) = text.split_once(['x', 'X']).ok_or_else(expected)?;
    let pair = [width.parse().map_err(|_| expected())?, height.parse().map_err(|_| expected())?];
    match pair {
        [0, _] | [_, 0] => Err(expected()),
        pair => Ok(pair),
    }
}

/// A number of at most 10^9.
fn quantity(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "expected a number".to_owned())?;
    // No more than keeps every sum of a replay finite and exact enough.
    if value <= 1e9 { Ok(value) } else { Err("expected at most 10^9".to_owned()) }
}

pub(crate) fn at_least_0(text: &str) -> Result<f64, String> {
    quantity(text).and_then(|v| if v >= 0.0 { Ok(v) } else { Err("expected 0 or more".to_owned()) })
}

pub(crate) fn above_0(text: &str) -> Result<f64, String> {
    quantity(text).and_then(|v| if v >= 1e-6 { Ok(v) } else { Err("expected more than 0".to_owned()) })
}

/// A number with a unit behind it.
fn with_unit(text: &str, units: &[(&str, u64)], expected: &str) -> Result<u64, String> {
    let end = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    let (number, unit) = text.split_at(end);
    let size = units.iter().find(|(name, _)| *name == unit).map(|(_, size)| *size);
    let value = number.parse().ok().and_then(|number: u64| number.checked_mul(size?));
    value.ok_or_else(|| format!("found {text:?}, expected {expected}"))
}

/// "50G" in bytes.
pub(super) fn byte_count(text: &str) -> Result<u64, String> {
    let units = [("", 1), ("k", 1000), ("M", 1_000_000), ("G", 1_000_000_000), ("T", 1_000_000_000_000)];
    with_unit(text, &units, "a whole number of bytes, such as 500M or 50G")
}

/// "30d".
pub(super) fn duration(text: &str) -> Result<Duration, String> {
    let hours = with_unit(text, &[("h", 1), ("d", 24), ("w", 168)], "a time, such as 12h, 30d or 4w")?;
    hours.checked_mul(3600).map(Duration::from_secs).ok_or_else(|| format!("found {text:?}, expected less"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_times_have_units() {
        assert_eq!(["7", "50G", "3k"].map(byte_count), [Ok(7), Ok(50_000_000_000), Ok(3000)]);
        assert_eq!(duration("30d"), Ok(Duration::from_secs(30 * 86_400)));
        for bad in ["", "G", "-1G", "1.5G", "50 G", "99999999999T"] {
            assert!(byte_count(bad).unwrap_err().contains("such as 500M"), "{bad}");
        }
        for bad in ["30", "d", "1y", "99999999999999999w"] {
            assert!(duration(bad).unwrap_err().contains("expected"), "{bad}");
        }
    }

    #[test]
    fn sun_angles_outside_the_sky_are_refused() {
        assert_eq!(angle_pair("90,15"), Ok([90.0, 15.0]));
        assert!(angle_pair("90").unwrap_err().contains("AZIMUTH,ELEVATION"));
        assert!(angle_pair("0,91").unwrap_err().contains("elevation 91"));
        assert!(angle_pair("nan,1").unwrap_err().contains("azimuth"));
    }

    #[test]
    fn sizes_are_two_positive_numbers() {
        assert_eq!(size("640x480"), Ok([640, 480]));
        for bad in ["640", "0x5", "-1x5", "axb"] {
            assert!(size(bad).unwrap_err().contains("WIDTHxHEIGHT"), "{bad}");
        }
    }
}

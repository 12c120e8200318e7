//! The sun over some hours at a place: from a day, or two instants, to a sun for each frame of a sequence.
//!
//! Times are UTC. A day is the one that clocks of the place show: its noon is the passage of the sun over the meridian
//! nearest to 12:00 of local mean time, UTC plus 4 minutes for a degree of longitude. Else a day in Sydney would begin
//! in the afternoon, and its sunset would come before its sunrise.

use std::fmt::{Display, Formatter};
use std::str::FromStr;

use toml::value::{Datetime, Offset};

use super::{Day, SunPath, check_place, place_and_time};
use crate::solar::azimuth_elevation_deg;

/// Halvings of half a day between a sun below the horizon and one above: to a microsecond.
const HALVINGS: u32 = 36;
/// Corrections of the time of noon, each of which leaves a hundredth of the error or less.
const NOON_STEPS: u32 = 4;

/// The sun at a place, from one instant to a later one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SunHours {
    latitude_deg: f64,
    longitude_deg: f64,
    from: Instant,
    to: Instant,
}

/// Days since 2000-01-01 0:00 UTC.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Instant(f64);

/// The sun at an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SunAt {
    /// Time.
    pub instant: Instant,
    /// Azimuth (clockwise from north, 0 to 360) and elevation, degrees.
    pub sun_deg: [f64; 2],
}

impl SunHours {
    /// Returns the hours from sunrise to sunset of the first day of a path; where the sun does not set, to midnight,
    /// and from it where it was up already.
    ///
    /// # Errors
    /// Where the sun does not rise that day.
    pub fn of_first_day(path: &SunPath) -> Result<SunHours, String> {
        let &SunPath { latitude_deg, longitude_deg, from: day, .. } = path;
        let elevation = |days: f64| azimuth_elevation_deg(days, latitude_deg, longitude_deg)[1];
        let noon = noon(day, longitude_deg);
        if elevation(noon) <= 0.0 {
            return Err(format!(
                "found {day} at latitude {latitude_deg}, when the sun does not rise, expected a day with a sunrise, \
                 or times such as {day}T10:00..{day}T14:00"
            ));
        }
        let [from, to] = [noon - 0.5, noon + 0.5].map(|midnight| {
            if elevation(midnight) > 0.0 {
                return midnight;
            }
            let (mut below, mut above) = (midnight, noon);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (below + above);
                *if elevation(middle) > 0.0 { &mut above } else { &mut below } = middle;
            }
            above
        });
        Ok(SunHours { latitude_deg, longitude_deg, from: Instant(from), to: Instant(to) })
    }

    /// The sun at a share of the time, 0 to 1.
    pub fn at(&self, share: f64) -> SunAt {
        let (Instant(from), Instant(to)) = (self.from, self.to);
        let days = if share < 1.0 { from + (to - from) * share } else { to };
        let sun_deg = azimuth_elevation_deg(days, self.latitude_deg, self.longitude_deg);
        SunAt { instant: Instant(days), sun_deg }
    }
}

/// When the sun passes the meridian on a day, days since 2000-01-01 0:00 UTC.
fn noon(day: Day, longitude_deg: f64) -> f64 {
    let mut noon = day.since_2000() as f64 + 0.5 - longitude_deg / 360.0;
    for _ in 0..NOON_STEPS {
        // At the pole the azimuth is 180 degrees and the hour angle, whatever the season.
        let [azimuth, _] = azimuth_elevation_deg(noon, 90.0, longitude_deg);
        noon -= (azimuth - 180.0) / 360.0;
    }
    noon
}

/// `LAT,LON,FROM..TO` with two times, or `LAT,LON,DATE` from sunrise to sunset, as on the command line.
impl FromStr for SunHours {
    type Err = String;

    fn from_str(text: &str) -> Result<SunHours, String> {
        let expected = || {
            format!(
                "found {text:?}, expected LAT,LON,FROM..TO in UTC, \
                 such as 52.5,13.4,2026-06-21T05:00..2026-06-21T19:00, \
                 or LAT,LON,DATE from sunrise to sunset"
            )
        };
        let (latitude_deg, longitude_deg, time) = place_and_time(text).ok_or_else(expected)?;
        let (from, to) = time.split_once("..").unwrap_or((time, time));
        let [from, to] =
            [from, to].map(|end| end.trim().parse::<Datetime>().ok().filter(|end| end.date.is_some()));
        let (from, to) = from.zip(to).ok_or_else(expected)?;
        match (from.time, to.time) {
            (None, None) if from == to => {
                let day = Day::from_toml(from)?;
                SunHours::of_first_day(&SunPath::new(latitude_deg, longitude_deg, day, day)?)
            }
            (None, None) => Err(format!(
                "found {from}..{to} without times, expected one date, or times such as {from}T05:00..{from}T19:00"
            )),
            (Some(_), Some(_)) if !time.contains("..") => Err(expected()),
            (Some(_), Some(_)) => {
                check_place(latitude_deg, longitude_deg)?;
                let [from_instant, to_instant] = [Instant::from_toml(from)?, Instant::from_toml(to)?];
                if from_instant >= to_instant {
                    return Err(format!("found {from} to {to}, expected the earlier time first"));
                }
                Ok(SunHours { latitude_deg, longitude_deg, from: from_instant, to: to_instant })
            }
            _ => Err(format!("found {from}..{to}, expected a time at both ends, or one date")),
        }
    }
}

impl Instant {
    /// Without an offset it is UTC.
    fn from_toml(found: Datetime) -> Result<Instant, String> {
        let day = Day::from_toml(Datetime { time: None, offset: None, ..found })?;
        let time = found.time.ok_or_else(|| format!("found {found}, expected a time of the day"))?;
        let minutes = f64::from(time.hour) * 60.0 + f64::from(time.minute);
        let seconds = f64::from(time.second.unwrap_or(0)) + f64::from(time.nanosecond.unwrap_or(0)) * 1e-9;
        let east_minutes = match found.offset {
            None | Some(Offset::Z) => 0.0,
            Some(Offset::Custom { minutes }) => f64::from(minutes),
        };
        Ok(Instant(day.since_2000() as f64 + (minutes - east_minutes + seconds / 60.0) / 1440.0))
    }
}

/// To the nearest second, as `2026-06-21T05:00:00Z`.
impl Display for Instant {
    fn fmt(&self, f: &mut Formatter) -> std::fmt::Result {
        let seconds = libm::round(self.0 * 86_400.0) as i64;
        let (days, second) = (seconds.div_euclid(86_400), seconds.rem_euclid(86_400));
        let [year, month, day] = civil(days);
        let [hour, minute, second] = [second / 3600, second / 60 % 60, second % 60];
        write!(f, "{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
    }
}

/// Year, month and day of a day since 2000-01-01: what [`Day::since_2000`] undoes, after the same source.
fn civil(days: i64) -> [i64; 3] {
    let days = days + 730_425;
    let (era, of_era) = (days.div_euclid(146_097), days.rem_euclid(146_097));
    let year = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year + year / 4 - year / 100);
    let month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * month + 2) / 5 + 1;
    let (month, next) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    [era * 400 + year + next, month, day]
}

#[cfg(test)]
mod tests;

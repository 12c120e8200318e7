use super::*;

/// The earth's tilt in 2026, degrees (Astronomical Almanac).
const TILT_DEG: f64 = 23.436;
/// Of the algorithm, and of noon lying up to twelve hours from a solstice.
const TOLERANCE_DEG: f64 = 0.02;

fn hours(text: &str) -> SunHours {
    text.parse().unwrap_or_else(|message| panic!("{text}: {message}"))
}

/// Of a whole day: sunrise, noon, sunset.
fn day(text: &str) -> [SunAt; 3] {
    let day = hours(text);
    [0.0, 0.5, 1.0].map(|share| day.at(share))
}

#[track_caller]
fn close(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() < tolerance, "{found} for {expected}");
}

#[test]
fn the_sun_of_a_solstice_is_as_high_at_noon_as_latitude_and_tilt_say() {
    for latitude in [-66.0, -33.9, 0.0, 10.0, 23.0, 40.0, 52.5, 66.0] {
        for (date, declination) in [("2026-06-21", TILT_DEG), ("2026-12-21", -TILT_DEG)] {
            let from_zenith: f64 = latitude - declination;
            let [_, noon, _] = day(&format!("{latitude},13.4,{date}"));
            close(noon.sun_deg[1], 90.0 - from_zenith.abs(), TOLERANCE_DEG);
        }
    }
}

#[test]
fn the_sun_of_an_equinox_rises_due_east_and_sets_due_west() {
    for latitude in [-52.5, -20.0, 0.0, 35.0, 60.0] {
        for date in ["2026-03-20", "2026-09-23"] {
            let [rise, _, set] = day(&format!("{latitude},0,{date}"));
            // The declination moves by 0.2 degrees in half a day, which a latitude of 60 doubles.
            close(rise.sun_deg[0], 90.0, 0.8);
            close(set.sun_deg[0], 270.0, 0.8);
            let Instant(length) = Instant(set.instant.0 - rise.instant.0);
            close(length, 0.5, 0.004);
        }
    }
}

#[test]
fn a_solstice_day_is_its_own_mirror_image() {
    let whole = hours("52.5,13.4,2026-06-21");
    for step in 0..=20 {
        let share = f64::from(step) / 20.0;
        let ([morning, up], [evening, down]) = (whole.at(share).sun_deg, whole.at(1.0 - share).sun_deg);
        close(morning + evening, 360.0, 0.05);
        close(up, down, 0.02);
    }
}

#[test]
fn a_day_runs_from_sunrise_to_sunset_as_the_place_counts_days() {
    // Sunrises and sunsets without refraction and for the disc's middle, some five minutes inside of those of almanacs
    // (which have, for Berlin's, 02:43 and 19:33 UTC; for Sydney's, 7:00 and 16:54 in UTC+10).
    for (text, rise, set) in [
        ("52.5,13.4,2026-06-21", "2026-06-21T02:5", "2026-06-21T19:2"),
        ("-33.87,151.21,2026-06-21", "2026-06-20T21:0", "2026-06-21T06:4"),
    ] {
        let [from, noon, to] = day(text);
        let [from_text, to_text] = [from, to].map(|end| end.instant.to_string());
        assert!(from_text.starts_with(rise) && to_text.starts_with(set), "{from_text} {to_text}");
        // The sun is up in every frame, and but just at the ends.
        for end in [from, to] {
            assert!((0.0..1e-6).contains(&end.sun_deg[1]), "{:?}", end.sun_deg);
        }
        assert!(noon.sun_deg[1] > 30.0);
    }
    let same: SunHours = hours("52.5,13.4,2026-06-21..2026-06-21");
    assert_eq!(same, hours("52.5,13.4,2026-06-21"));
    let path: SunPath = "52.5,13.4,2026-06-21..2026-08-01".parse().expect("a path");
    assert_eq!(SunHours::of_first_day(&path), Ok(same));
}

#[test]
fn where_the_sun_stays_up_a_day_runs_from_midnight_to_midnight() {
    let midsummer = hours("78.2,15.6,2026-06-21");
    let Instant(length) = Instant(midsummer.to.0 - midsummer.from.0);
    close(length, 1.0, 1e-9);
    close(midsummer.at(0.0).sun_deg[1], 78.2 + TILT_DEG - 90.0, TOLERANCE_DEG);
    let message = "78.2,15.6,2026-12-21".parse::<SunHours>().expect_err("polar night");
    assert!(message.contains("2026-12-21 at latitude 78.2, when the sun does not rise"), "{message}");
    // At the pole the sun of the year rises on a day in March and does not set.
    let pole = hours("90,0,2026-03-21");
    assert!(pole.at(1.0).sun_deg[1] > 0.0 && pole.at(0.0).sun_deg[1] >= 0.0);
}

#[test]
fn times_are_utc_or_say_their_offset() {
    let utc = hours("52.5,13.4,2026-06-21T05:00..2026-06-21T21:00");
    let ends = [0.0, 0.25, 1.0].map(|share| utc.at(share).instant.to_string());
    assert_eq!(ends, ["2026-06-21T05:00:00Z", "2026-06-21T09:00:00Z", "2026-06-21T21:00:00Z"]);
    for same in [
        "52.5,13.4,2026-06-21T05:00:00Z..2026-06-21T21:00:00.000Z",
        "52.5,13.4,2026-06-21T07:00+02:00..2026-06-21T16:00-05:00",
    ] {
        assert_eq!(hours(same), utc, "{same}");
    }
    // Elevations below the horizon are given as they are: at 21:00 UTC Berlin is dark.
    assert!(utc.at(1.0).sun_deg[1] < -5.0);
    // Earlier than 2000, over a leap day, and rounded up into another year.
    let far = hours("0,0,1904-02-28T12:00..2099-12-31T23:59:59.9");
    assert_eq!(
        [far.at(0.0), far.at(1.0)].map(|end| end.instant.to_string()),
        ["1904-02-28T12:00:00Z", "2100-01-01T00:00:00Z"]
    );
    let leap = hours("0,0,2024-02-28T12:00..2024-03-01T12:00");
    assert_eq!(leap.at(0.5).instant.to_string(), "2024-02-29T12:00:00Z");
}

#[test]
fn what_is_no_stretch_of_time_is_refused_with_an_example() {
    for (text, expected) in [
        ("", "such as 52.5,13.4,2026-06-21T05:00..2026-06-21T19:00"),
        ("52.5,13.4", "expected LAT,LON,FROM..TO"),
        ("52.5,13.4,noon", "expected LAT,LON,FROM..TO"),
        ("52.5,13.4,05:00..21:00", "expected LAT,LON,FROM..TO"),
        ("52.5,13.4,2026-02-30", "expected LAT,LON,FROM..TO"),
        ("91,13.4,2026-06-21", "found latitude 91, expected -90 to 90"),
        ("0,inf,2026-06-21T05:00..2026-06-21T06:00", "found longitude inf"),
        ("0,0,1850-06-21", "expected a year from 1900 to 2100"),
        ("0,0,1850-06-21T05:00..2026-06-21T06:00", "expected a year from 1900 to 2100"),
        ("0,0,2026-06-21..2026-06-22", "such as 2026-06-21T05:00..2026-06-21T19:00"),
        ("0,0,2026-06-21T05:00..2026-06-22", "expected a time at both ends"),
        ("0,0,2026-06-21T05:00", "expected LAT,LON,FROM..TO in UTC"),
        ("0,0,2026-06-21T05:00..2026-06-21T04:59", "expected the earlier time first"),
    ] {
        let message = text.parse::<SunHours>().expect_err(text);
        assert!(message.contains(expected), "{message} for {expected}");
    }
}

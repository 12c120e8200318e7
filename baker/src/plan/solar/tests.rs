use super::*;

fn path(days: &str) -> SunPath {
    format!("52.5,13.4,{days}").parse().expect("a path")
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

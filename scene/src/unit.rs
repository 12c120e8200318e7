//! Units of mesh files.

/// Units by their word, in metres.
pub const UNITS: [(&str, f64); 5] = [("m", 1.0), ("cm", 0.01), ("mm", 0.001), ("in", 0.0254), ("ft", 0.3048)];

/// Metres per unit: of a word of [`UNITS`], or a number of metres.
///
/// # Errors
/// What was found and what was expected.
pub fn parse_unit(word: &str) -> Result<f64, String> {
    if let Some((_, unit_m)) = UNITS.iter().find(|(name, _)| *name == word) {
        return Ok(*unit_m);
    }
    match word.parse::<f64>() {
        Ok(unit_m) if unit_m.is_finite() && unit_m > 0.0 => Ok(unit_m),
        _ => {
            Err(format!("found {word:?}, expected m, cm, mm, in, ft, or metres per unit as a number above 0"))
        }
    }
}

/// A word of [`UNITS`].
///
/// # Errors
/// What was found and what was expected.
pub fn parse_name(word: &str) -> Result<&'static str, String> {
    let found = UNITS.iter().find(|(name, _)| *name == word);
    found.map(|(name, _)| *name).ok_or_else(|| format!("found {word:?}, expected m, cm, mm, in or ft"))
}

/// Metres in a word of [`UNITS`]; 1 for another.
pub fn metres_in(word: &str) -> f64 {
    UNITS.iter().find(|(name, _)| *name == word).map_or(1.0, |(_, unit_m)| *unit_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_is_a_word_or_a_number_of_metres() {
        let found = ["m", "cm", "mm", "in", "ft", "0.01", "1e3"].map(parse_unit);
        assert_eq!(found, [1.0, 0.01, 0.001, 0.0254, 0.3048, 0.01, 1000.0].map(Ok));
        for word in ["", "CM", "yard", "0", "-1", "nan", "inf", "1 m", "1,5"] {
            let error = parse_unit(word).unwrap_err();
            assert!(error.contains(&format!("found {word:?}, expected m, cm, mm, in, ft")), "{error}");
        }
        assert_eq!((parse_name("ft"), metres_in("ft")), (Ok("ft"), 0.3048));
        assert!(parse_name("yard").is_err());
    }
}

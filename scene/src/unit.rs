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

/// Words of exporters for the units of [`UNITS`], in their order.
const LONG_WORDS: [&[&str]; 5] = [
    &["m", "meter", "meters", "metre", "metres"],
    &["cm", "centimeter", "centimeters", "centimetre", "centimetres"],
    &["mm", "millimeter", "millimeters", "millimetre", "millimetres"],
    &["inch", "inches"],
    &["ft", "foot", "feet"],
];

/// The unit that a comment tells, such as "# Units: inches": the first word for one behind "unit" or "units".
pub(crate) fn unit_in_comment(comment: &str) -> Option<&'static str> {
    let lower = comment.to_ascii_lowercase();
    let words = lower.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    let of_unit = |word: &str| LONG_WORDS.iter().position(|words| words.contains(&word));
    let at = words.skip_while(|word| !["unit", "units"].contains(word)).skip(1).take(4).find_map(of_unit)?;
    Some(UNITS[at].0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_of_exporters_tell_a_unit() {
        let found =
            ["# Units: centimeters", "#File units = inches", "# unit mm", "# model units are in feet"];
        assert_eq!(found.map(unit_in_comment), ["cm", "in", "mm", "ft"].map(Some));
        assert_eq!(unit_in_comment("# Units: meters"), Some("m"));
        for none in ["# made by hand", "# 12 units high", "# cm", "# United 3 cm", ""] {
            assert_eq!(unit_in_comment(none), None, "{none}");
        }
    }

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

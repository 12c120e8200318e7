//! Words of a scene file that is written: texts, paths, numbers.

use std::path::{Path, PathBuf};

use crate::exit::{Failure, INPUT_OUTPUT, USAGE};

/// A basic string: JSON's escapes are TOML's too, and TOML wants one more.
pub(crate) fn toml_string(text: &str) -> String {
    serde_json::Value::from(text).to_string().replace('\u{7f}', "\\u007F")
}

/// A path as the scene file `output`, in whose folder it starts, has to name it.
pub(crate) fn toml_path(output: &Path, path: &Path) -> Result<String, Failure> {
    let is_beside = output.parent().is_none_or(|folder| folder.as_os_str().is_empty());
    let path: PathBuf = match is_beside || path.is_absolute() {
        true => path.to_owned(),
        false => std::path::absolute(path).map_err(|error| Failure::new(INPUT_OUTPUT, error).at(path))?,
    };
    match path.to_str() {
        Some(text) => Ok(toml_string(text)),
        None => Err(Failure::new(USAGE, "the name is not UTF-8, which a scene file needs").at(&path)),
    }
}

/// A number rounded to so many decimals, without zeros that say nothing.
pub(crate) fn decimal(value: f64, places: usize) -> String {
    let text = format!("{value:.places$}");
    let text = match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => &text,
    };
    format!("{}{}", if text == "-0" { "0" } else { text }, if text.contains('.') { "" } else { ".0" })
}

/// A list of these.
pub(crate) fn decimals<const N: usize>(values: [f64; N], places: usize) -> String {
    format!("[{}]", values.map(|value| decimal(value, places)).join(", "))
}

/// A number rounded to 7 digits, wherever its point is.
pub(crate) fn digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.6e}").parse().unwrap_or(value);
    format!("{rounded:?}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_and_short_and_floats_of_toml() {
        let table =
            [(1.0, "1.0"), (-0.0, "0.0"), (-1e-9, "0.0"), (0.1 + 0.2, "0.3"), (-12.3456789, "-12.345679")];
        for (value, expected) in table.into_iter().chain([(1e9, "1000000000.0"), (100.0, "100.0")]) {
            assert_eq!(decimal(value, 6), expected);
        }
        assert_eq!(decimals([0.5, 100.25], 1), "[0.5, 100.2]");
        let table =
            [(f64::from(1.05f32), "1.05"), (1e-6, "1e-6"), (1e6, "1000000.0"), (1.0 / 3.0, "0.3333333")];
        for (value, expected) in table {
            assert_eq!(digits(value), expected);
        }
    }
}

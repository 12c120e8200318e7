//! Names of types in what parsers of TOML say, in the words of those who write it.

/// Puts the type that a parser expects, in the last line of what it says, into the words of TOML: `expected f64`
/// becomes `expected a number`.
pub fn in_words(said: &str) -> String {
    const EXPECTED: &str = "expected ";
    let last = said.rfind('\n').map_or(0, |at| at + 1);
    let Some(at) = said[last..].rfind(EXPECTED) else { return said.to_owned() };
    let (before, found) = said.split_at(last + at + EXPECTED.len());
    let length = || found.strip_prefix("an array of length ").filter(|number| number.parse::<u32>().is_ok());
    let words = match found {
        "f32" | "f64" => "a number".to_owned(),
        "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number from 0 up".to_owned(),
        "i32" | "i64" | "isize" => "a whole number".to_owned(),
        "a sequence" => "a list".to_owned(),
        "a map" => "a table".to_owned(),
        _ if found.starts_with("struct ") => "a table".to_owned(),
        _ if found.starts_with("enum ") => "a word".to_owned(),
        _ => match length() {
            Some(number) => format!("a list of {number}"),
            None => found.to_owned(),
        },
    };
    format!("{before}{words}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_rust_become_words_in_the_last_line_alone() {
        for (said, expected) in [
            ("1 | expected f64\ninvalid type: string \"x\", expected f64", "string \"x\", expected a number"),
            ("invalid type: integer `3`, expected struct RawWaves", "`3`, expected a table"),
            ("invalid length 1, expected an array of length 2", "length 1, expected a list of 2"),
            ("unknown field `a`, expected `b` or `c`", "expected `b` or `c`"),
            ("invalid type: string \"expected u32\", expected u32", "expected a whole number from 0 up"),
            ("no such word", "no such word"),
        ] {
            let found = in_words(said);
            assert!(found.ends_with(expected), "{found}");
            assert_eq!(found.lines().count(), said.lines().count());
        }
        assert!(in_words("1 | expected f64\nexpected f64").starts_with("1 | expected f64\n"));
    }
}

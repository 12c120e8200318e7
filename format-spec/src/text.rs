//! Characters that a reader of a name cannot see, or that change what is around them; and URLs, of which a message
//! shows the host alone.

use std::borrow::Cow;

pub mod url;

/// First and last character of each range, ascending: control characters (Unicode category Cc), what steers the
/// direction of text, separators of lines and paragraphs, and what is drawn as nothing (Default_Ignorable_Code_Point
/// and interlinear annotation). SPEC.md section 9 lists the same.
pub const HIDDEN: [(char, char); 19] = [
    ('\u{0}', '\u{1f}'),
    ('\u{7f}', '\u{9f}'),
    ('\u{ad}', '\u{ad}'),
    ('\u{34f}', '\u{34f}'),
    ('\u{61c}', '\u{61c}'),
    ('\u{115f}', '\u{1160}'),
    ('\u{17b4}', '\u{17b5}'),
    ('\u{180b}', '\u{180f}'),
    ('\u{200b}', '\u{200f}'),
    ('\u{2028}', '\u{202e}'),
    ('\u{2060}', '\u{206f}'),
    ('\u{3164}', '\u{3164}'),
    ('\u{fe00}', '\u{fe0f}'),
    ('\u{feff}', '\u{feff}'),
    ('\u{ffa0}', '\u{ffa0}'),
    ('\u{fff0}', '\u{fffb}'),
    ('\u{1bca0}', '\u{1bca3}'),
    ('\u{1d173}', '\u{1d17a}'),
    ('\u{e0000}', '\u{e0fff}'),
];

/// Whether a character is in [`HIDDEN`]: names do not hold it, and messages show it by its number.
pub fn is_hidden(character: char) -> bool {
    // Most text is plain.
    if (' '..='~').contains(&character) {
        return false;
    }
    let range = HIDDEN.partition_point(|&(_, last)| last < character);
    HIDDEN.get(range).is_some_and(|&(first, _)| first <= character)
}

/// A text whose hidden characters, but those that stay, are written by their numbers.
pub fn escaped(text: &str, stays: impl Fn(char) -> bool) -> Cow<'_, str> {
    let must_go = |c: char| is_hidden(c) && !stays(c);
    if !text.chars().any(must_go) {
        return Cow::Borrowed(text);
    }
    let mut clean = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match c {
            c if !must_go(c) => clean.push(c),
            '\n' | '\r' | '\t' => clean.extend(c.escape_default()),
            c => clean.extend(c.escape_unicode()),
        }
    }
    Cow::Owned(clean)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hidden_characters_are_escaped_but_those_that_stay() {
        assert!(matches!(escaped("plain", |_| false), Cow::Borrowed("plain")));
        assert_eq!(escaped("a\n\u{202e}b\t", |c| c == '\n'), "a\n\\u{202e}b\\t");
    }

    #[test]
    fn the_ranges_ascend() {
        assert!(HIDDEN.iter().all(|(first, last)| first <= last));
        assert!(HIDDEN.windows(2).all(|pair| pair[0].1 < pair[1].0));
    }

    #[test]
    fn the_specification_and_the_independent_reader_list_the_same() {
        let (spec, reader) = (include_str!("../SPEC.md"), include_str!("../metadata.py"));
        for (first, last) in HIDDEN.map(|(first, last)| (first as u32, last as u32)) {
            let range = if first == last {
                format!("U+{first:04X},")
            } else {
                format!("U+{first:04X} to U+{last:04X}")
            };
            assert!(spec.contains(&range), "{range}");
            let range = format!("(0x{first:X}, 0x{last:X})");
            assert!(reader.contains(&range), "{range}");
        }
        let listed =
            reader.split("HIDDEN = (").nth(1).and_then(|rest| rest.split("))").next()).expect("a list");
        assert_eq!(listed.matches("(0x").count(), HIDDEN.len());
    }

    #[test]
    fn what_cannot_be_seen_is_hidden_and_letters_of_any_script_are_not() {
        for hidden in
            ['\0', '\u{1b}', '\n', '\r', '\u{7f}', '\u{9b}', '\u{202e}', '\u{2066}', '\u{200b}', '\u{feff}']
        {
            assert!(is_hidden(hidden), "{hidden:?}");
        }
        for (first, last) in HIDDEN {
            assert!(is_hidden(first) && is_hidden(last));
        }
        assert!(
            char::from_u32(0)
                .into_iter()
                .chain('\u{1}'..='\u{10ffff}')
                .filter(|c| c.is_control())
                .all(is_hidden)
        );
        for plain in " az~\u{a0}äé\u{301}шあ木א🌲\u{fffd}".chars() {
            assert!(!is_hidden(plain), "{plain:?}");
        }
    }
}

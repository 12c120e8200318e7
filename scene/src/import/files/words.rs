//! From bytes that a file or a folder holds to text, so that names which differ stay different, and from a name to
//! what it has in common with other spellings of it.

use std::borrow::Cow;
use std::ffi::OsStr;

use unicode_normalization::{UnicodeNormalization, is_nfc_quick};

/// The text of bytes: UTF-8 where they are valid, else [`latin`].
pub(crate) fn decoded(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => Cow::Owned(latin(bytes)),
    }
}

/// A name that the system gives, as text.
pub(crate) fn of_system(name: &OsStr) -> Cow<'_, str> {
    decoded(name.as_encoded_bytes())
}

/// The text of bytes in Windows-1252, which has Latin-1 within it. Each byte is a letter of its own, so that no two
/// names become one.
pub(crate) fn latin(bytes: &[u8]) -> String {
    bytes
        .iter()
        .map(|&byte| if let 0x80..0xA0 = byte { HIGH[byte as usize - 0x80] } else { byte.into() })
        .collect()
}

/// What a name is whose UTF-8 was read as Windows-1252, as where one odd line made a file to be read like that.
pub(crate) fn reread(name: &str) -> Option<String> {
    let byte = |letter: char| match HIGH.iter().position(|&high| high == letter) {
        Some(place) => Some(0x80 + place as u8),
        None => u8::try_from(letter).ok(),
    };
    if name.is_ascii() {
        return None;
    }
    String::from_utf8(name.chars().map(byte).collect::<Option<Vec<u8>>>()?).ok()
}

/// The name with its letters composed (NFC): macOS writes `a` and a mark of its own where others write `ä`.
pub(crate) fn composed(name: &str) -> Cow<'_, str> {
    match is_nfc_quick(name.chars()) {
        unicode_normalization::IsNormalized::Yes => Cow::Borrowed(name),
        _ => Cow::Owned(name.nfc().collect()),
    }
}

/// The name composed and without case.
pub(crate) fn caseless(name: &str) -> String {
    composed(&composed(name).to_lowercase()).into_owned()
}

/// Bytes 80 to 9F of Windows-1252. Those that it leaves undefined are the control characters of their number, as
/// browsers read them.
const HIGH: [char; 32] = [
    '\u{20AC}', '\u{81}', '\u{201A}', '\u{192}', '\u{201E}', '\u{2026}', '\u{2020}', '\u{2021}', '\u{2C6}',
    '\u{2030}', '\u{160}', '\u{2039}', '\u{152}', '\u{8D}', '\u{17D}', '\u{8F}', '\u{90}', '\u{2018}',
    '\u{2019}', '\u{201C}', '\u{201D}', '\u{2022}', '\u{2013}', '\u{2014}', '\u{2DC}', '\u{2122}', '\u{161}',
    '\u{203A}', '\u{153}', '\u{9D}', '\u{17E}', '\u{178}',
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_bytes_become_one_letter_and_utf8_is_found_again() {
        let all: Vec<u8> = (0..=255).collect();
        let text = latin(&all);
        let letters: std::collections::HashSet<char> = text.chars().collect();
        assert_eq!(letters.len(), 256);
        assert_eq!(latin(b"B\xe4ume \x80"), "Bäume €");
        for name in ["Bäume", "葉", "Ärger „leise“", "\u{9d}ä"] {
            assert_eq!(reread(&latin(name.as_bytes())).as_deref(), Some(name));
        }
        assert_eq!((reread("leaf"), reread("Bäume"), reread("葉")), (None, None, None));
    }

    #[test]
    fn names_are_the_same_composed_and_without_case() {
        assert_eq!(composed("Bla\u{308}tter"), "Blätter");
        assert_eq!(caseless("BLA\u{308}TTER"), "blätter");
        assert_eq!(caseless("BL\u{c4}TTER"), "blätter");
        assert_ne!(composed("L\u{e4}rche"), composed("L\u{f6}rche"));
    }
}

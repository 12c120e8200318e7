use flb_format::text::{HIDDEN, is_hidden};

use super::*;

/// Numbers that are the same in every run (Knuth's MMIX generator).
struct Random(u64);

impl Random {
    fn next(&mut self, below: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) % below
    }

    /// Text of anything, with what must not be printed in every third place.
    fn text(&mut self) -> String {
        let length = self.next(6000);
        let letter = |random: &mut Random| match random.next(3) {
            0 => {
                let (first, last) = HIDDEN[random.next(HIDDEN.len() as u64) as usize];
                let span = u64::from(last as u32 - first as u32 + 1);
                char::from_u32(first as u32 + random.next(span) as u32).unwrap_or('x')
            }
            1 => char::from_u32(random.next(0x11_0000) as u32).unwrap_or('y'),
            _ => char::from(b' ' + random.next(95) as u8),
        };
        (0..length).map(|_| letter(self)).collect()
    }
}

#[test]
fn no_message_holds_what_cannot_be_seen_and_none_is_longer_than_the_limit() {
    let mut random = Random(20);
    for _ in 0..2000 {
        let text = random.text();
        let message = message(&text);
        assert!(message.len() <= MAX_MESSAGE_BYTES && message.ends_with('\n'), "{} bytes", message.len());
        assert!(message.chars().all(|c| c == '\n' || !is_hidden(c)), "{message:?}");
        let mut lines = message.trim_end_matches('\n').split('\n');
        assert!(lines.next().is_some_and(|first| first.starts_with("flb: ")));
        assert!(lines.all(|line| line.starts_with("   | ")), "{message:?}");
        assert!(shown(&text).chars().all(|c| c == '\n' || !is_hidden(c)));
    }
}

#[test]
fn a_message_says_the_same_in_other_letters() {
    assert_eq!(message("a \u{1b}[31m \u{202e} b\u{7}\rc"), "flb: a \\u{1b}[31m \\u{202e} b\\u{7}\\rc\n");
    assert_eq!(message("Grün, 木, é\u{301}: fine\n"), "flb: Grün, 木, é\u{301}: fine\n");
}

#[test]
fn a_line_break_in_a_name_forges_no_message() {
    let text = message("oak\nflb: error: all is lost");
    assert_eq!(text, "flb: oak\n   | flb: error: all is lost\n");
}

#[test]
fn a_long_message_ends_with_its_length() {
    let text = message(&"ä".repeat(200_000));
    assert!(text.ends_with(" ... (400006 bytes in all)\n") && text.len() <= MAX_MESSAGE_BYTES);
}

#[test]
fn times_are_told_in_the_unit_that_fits() {
    assert_eq!([7.4, 600.0, 9000.0].map(duration), ["7 s", "10 min", "2.5 h"]);
}

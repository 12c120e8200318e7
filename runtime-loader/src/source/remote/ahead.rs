//! Which bytes to ask for, and the ones that came: a bounded read-ahead cache.
//!
//! A read that goes on where the last request ended is followed by more of its kind, so each such request asks for
//! twice as much as the one before, up to a limit. Any other read gets what it asks for and no more.

use std::collections::VecDeque;
use std::ops::Range;

/// The first request to read ahead asks for this much.
const FIRST_AHEAD_BYTES: u64 = 64 << 10;
/// The last one for this much.
const MAX_AHEAD_BYTES: u64 = 1 << 20;
/// No request is for less, whatever is read: its headers are of that order.
const MIN_BYTES: u64 = 4 << 10;
/// No request is for more, whatever is read: the largest page.
pub(super) const MAX_BYTES: u64 = 4 << 20;
/// A read that begins this close behind the last request goes on from it.
const NEAR_BYTES: u64 = 4 << 10;
/// What is kept at most; the longest unused goes first.
pub(super) const KEPT_BYTES: usize = 8 << 20;
/// Requests whose bytes are kept at most.
const KEPT_WINDOWS: usize = 64;

/// The bytes of earlier requests.
#[derive(Debug)]
pub(super) struct ReadAhead {
    /// The most recently used last.
    windows: VecDeque<Window>,
    /// End of the last request.
    last_end: u64,
    /// What the next request asks for if it goes on from there.
    ahead_bytes: u64,
}

#[derive(Debug)]
struct Window {
    start: u64,
    bytes: Vec<u8>,
}

impl ReadAhead {
    /// Nothing kept; the file has been read up to `end`.
    pub(super) fn new(end: u64) -> ReadAhead {
        ReadAhead { windows: VecDeque::new(), last_end: end, ahead_bytes: FIRST_AHEAD_BYTES }
    }

    /// What is kept from `at` on.
    pub(super) fn find(&mut self, at: u64) -> Option<&[u8]> {
        let holds = |window: &Window| (window.start..window.start + window.bytes.len() as u64).contains(&at);
        let found = self.windows.iter().position(holds)?;
        let window = self.windows.remove(found)?;
        let skip = (at - window.start) as usize;
        self.windows.push_back(window);
        self.windows.back().map(|window| &window.bytes[skip..])
    }

    /// The range to ask for, from `at` on, where `needed` bytes are wanted and nothing is kept, in a file of `length`
    /// bytes. It may be shorter than `needed`.
    pub(super) fn plan(&mut self, at: u64, needed: u64, length: u64) -> Range<u64> {
        let goes_on = (self.last_end..=self.last_end + NEAR_BYTES).contains(&at);
        let ahead = if goes_on { self.ahead_bytes } else { MIN_BYTES };
        self.ahead_bytes =
            if goes_on { (self.ahead_bytes * 2).min(MAX_AHEAD_BYTES) } else { FIRST_AHEAD_BYTES };
        let kept = self.windows.iter().map(|window| window.start).filter(|start| *start > at).min();
        let end = (at + needed.max(ahead).min(MAX_BYTES)).min(length).min(kept.unwrap_or(length));
        self.last_end = end;
        at..end
    }

    /// Keeps what came for a plan.
    pub(super) fn keep(&mut self, start: u64, bytes: Vec<u8>) {
        self.windows.push_back(Window { start, bytes });
        let mut kept: usize = self.windows.iter().map(|window| window.bytes.len()).sum();
        while kept > KEPT_BYTES || self.windows.len() > KEPT_WINDOWS {
            kept -= self.windows.pop_front().map_or(0, |window| window.bytes.len());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MB: u64 = 1 << 20;

    #[test]
    fn a_lone_read_gets_what_it_asks_for() {
        let mut ahead = ReadAhead::new(65_536);
        assert_eq!(ahead.plan(5 * MB, 100_000, 10 * MB), 5 * MB..5 * MB + 100_000);
        assert_eq!(ahead.plan(MB, 10, 10 * MB), MB..MB + MIN_BYTES);
        assert_eq!(ahead.plan(10 * MB - 5, 5, 10 * MB), 10 * MB - 5..10 * MB);
        assert_eq!(ahead.plan(2 * MB, 9 * MB, 20 * MB), 2 * MB..6 * MB);
    }

    #[test]
    fn reads_that_follow_each_other_ask_for_more_and_more_up_to_a_limit() {
        let mut ahead = ReadAhead::new(65_536);
        let (mut at, mut sizes) = (65_536 + 7, Vec::new());
        for _ in 0..7 {
            let range = ahead.plan(at, 10, 100 * MB);
            sizes.push((range.end - range.start) >> 10);
            at = range.end + NEAR_BYTES;
        }
        assert_eq!(sizes, [64, 128, 256, 512, 1024, 1024, 1024]);
        assert_eq!(ahead.plan(50 * MB, 10, 100 * MB), 50 * MB..50 * MB + MIN_BYTES);
        assert_eq!(ahead.plan(50 * MB + MIN_BYTES, 10, 100 * MB).end, 50 * MB + MIN_BYTES + (64 << 10));
    }

    #[test]
    fn what_is_kept_is_found_and_not_asked_for_again() {
        let mut ahead = ReadAhead::new(0);
        ahead.keep(1000, vec![7; 500]);
        assert_eq!(ahead.find(1499), Some(&[7][..]));
        assert!(ahead.find(999).is_none() && ahead.find(1500).is_none());
        assert_eq!(ahead.plan(900, 800, MB), 900..1000);
    }

    #[test]
    fn the_longest_unused_is_let_go_and_the_limit_holds() {
        let mut ahead = ReadAhead::new(0);
        for i in 0..9 {
            ahead.keep(i * MB, vec![0; MB as usize]);
            assert!(ahead.find(0).is_some(), "used every time, so kept: {i}");
        }
        assert!(ahead.find(MB).is_none() && ahead.find(2 * MB).is_some());
        assert!(ahead.windows.iter().map(|window| window.bytes.len()).sum::<usize>() <= KEPT_BYTES);
        for i in 0..100 {
            ahead.keep(20 * MB + i, vec![0]);
        }
        assert_eq!(ahead.windows.len(), KEPT_WINDOWS);
    }
}

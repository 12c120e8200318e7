//! Which words of the light's buffer are taken: first fit, and what is given back joins its free neighbours.
//!
//! First fit keeps the low end dense, so that a library that is streamed in order leaves one large hole at the end.
//! Spans are neither copied nor cloned: who holds one owns its words, and gives them back once.

use std::collections::BTreeMap;

/// Words that are taken.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Span {
    first: u32,
    count: u32,
}

impl Span {
    /// First word.
    pub(super) fn first(&self) -> u32 {
        self.first
    }

    /// Words, at least one.
    pub(super) fn count(&self) -> u32 {
        self.count
    }
}

/// The words of a buffer, taken and free.
#[derive(Debug)]
pub(super) struct Pool {
    words: u32,
    /// First word of each hole to its words. Invariant: holes neither overlap, nor touch, nor are empty.
    holes: BTreeMap<u32, u32>,
    free: u32,
}

impl Pool {
    /// All free.
    pub(super) fn new(words: u32) -> Pool {
        let holes = if words > 0 { BTreeMap::from([(0, words)]) } else { BTreeMap::new() };
        Pool { words, holes, free: words }
    }

    /// Words in all.
    pub(super) fn words(&self) -> u32 {
        self.words
    }

    /// Free words.
    pub(super) fn free(&self) -> u32 {
        self.free
    }

    /// Words of the largest hole: what a span can have at most.
    pub(super) fn largest(&self) -> u32 {
        self.holes.values().copied().max().unwrap_or(0)
    }

    /// Takes words that follow one another, from the lowest hole that has as many. `None` if no hole has, or for 0
    /// words.
    pub(super) fn take(&mut self, count: u32) -> Option<Span> {
        if count == 0 {
            return None;
        }
        let (&first, &words) = self.holes.iter().find(|(_, words)| **words >= count)?;
        self.holes.remove(&first);
        if words > count {
            self.holes.insert(first + count, words - count);
        }
        self.free -= count;
        Some(Span { first, count })
    }

    /// Takes a span of this pool back.
    pub(super) fn give_back(&mut self, span: Span) {
        let Span { mut first, mut count } = span;
        self.free += count;
        if let Some(words) = self.holes.remove(&(first + count)) {
            count += words;
        }
        if let Some((&before, &words)) = self.holes.range(..first).next_back()
            && before + words == first
        {
            first = before;
            count += words;
        }
        self.holes.insert(first, count);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Takes and gives back by turns; a plain list of owners is the oracle.
    fn run(words: u32, steps: &[(bool, u32)]) -> Result<(), TestCaseError> {
        let mut pool = Pool::new(words);
        let mut owner = vec![false; words as usize];
        let mut held: Vec<Span> = Vec::new();
        for &(takes, number) in steps {
            if takes {
                let hole = owner.split(|taken| *taken).map(<[bool]>::len).max().unwrap_or(0);
                prop_assert_eq!(pool.largest() as usize, hole);
                match pool.take(number) {
                    Some(span) => {
                        prop_assert_eq!(span.count(), number);
                        let range = span.first() as usize..(span.first() + number) as usize;
                        prop_assert!(range.end <= owner.len(), "{span:?} of {words}");
                        prop_assert!(!owner[range.clone()].contains(&true), "{span:?} overlaps");
                        owner[range].fill(true);
                        held.push(span);
                    }
                    None => prop_assert!(number == 0 || hole < number as usize, "{number} fit {hole}"),
                }
            } else if !held.is_empty() {
                let span = held.swap_remove(number as usize % held.len());
                owner[span.first() as usize..][..span.count() as usize].fill(false);
                pool.give_back(span);
            }
            prop_assert_eq!(pool.free() as usize, owner.iter().filter(|taken| !**taken).count());
        }
        held.into_iter().for_each(|span| pool.give_back(span));
        prop_assert_eq!((pool.free(), pool.largest()), (words, words));
        prop_assert!(pool.holes.len() <= 1);
        Ok(())
    }

    proptest! {
        #[test]
        fn spans_never_overlap_nor_pass_the_end_and_all_come_back(
            words in 0_u32..200,
            steps in prop::collection::vec((any::<bool>(), 0_u32..40), 0..200),
        ) {
            run(words, &steps)?;
        }
    }

    #[test]
    fn the_lowest_hole_that_fits_is_taken() {
        let mut pool = Pool::new(100);
        let spans: Vec<Span> = (0..5).map(|_| pool.take(20).expect("it fits")).collect();
        assert!(pool.take(1).is_none());
        let [first, _second, third, fourth, _fifth] = spans.try_into().expect("five");
        pool.give_back(fourth);
        pool.give_back(first);
        pool.give_back(third);
        assert_eq!((pool.free(), pool.largest()), (60, 40));
        assert_eq!(pool.take(21).map(|span| span.first()), Some(40));
        assert_eq!(pool.take(20).map(|span| span.first()), Some(0));
    }
}

//! A set of base numbers: which of the 19 a solve makes, a file holds or a scene needs.

use std::fmt;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::direction::MOVING;

/// Some of the bases 0..=18. In JSON a list of numbers, ascending, each once.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct BaseSet(u32);

impl BaseSet {
    /// Number of bases that there are: ambient and one per direction.
    pub const COUNT: usize = MOVING + 1;
    /// Set of all 19 bases.
    pub const ALL: BaseSet = BaseSet((1 << Self::COUNT) - 1);
    /// Empty set.
    pub const NONE: BaseSet = BaseSet(0);

    /// Returns the set with `base` added.
    ///
    /// # Panics
    /// If `base` is above 18.
    #[must_use]
    pub fn with(self, base: u8) -> BaseSet {
        assert!(usize::from(base) < Self::COUNT, "base {base}, expected 0 to 18");
        BaseSet(self.0 | 1 << base)
    }

    /// Whether `base` is in the set.
    pub fn contains(self, base: u8) -> bool {
        self.0.checked_shr(u32::from(base)).is_some_and(|rest| rest & 1 == 1)
    }

    /// Returns the set of bases 0..=18 that are not in this set.
    #[must_use]
    pub fn missing(self) -> BaseSet {
        BaseSet(Self::ALL.0 & !self.0)
    }

    /// Returns the union of both sets.
    #[must_use]
    pub fn union(self, other: BaseSet) -> BaseSet {
        BaseSet(self.0 | other.0)
    }

    /// Returns the intersection of both sets.
    #[must_use]
    pub fn intersection(self, other: BaseSet) -> BaseSet {
        BaseSet(self.0 & other.0)
    }

    /// Number of bases in the set.
    pub fn len(self) -> usize {
        self.0.count_ones() as usize
    }

    /// Whether the set is empty.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The numbers, ascending.
    pub fn iter(self) -> impl Iterator<Item = u8> {
        (0..Self::COUNT as u8).filter(move |&base| self.contains(base))
    }
}

/// # Panics
/// If a number is above 18.
impl FromIterator<u8> for BaseSet {
    fn from_iter<I: IntoIterator<Item = u8>>(bases: I) -> BaseSet {
        bases.into_iter().fold(BaseSet::NONE, BaseSet::with)
    }
}

impl fmt::Debug for BaseSet {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_set().entries(self.iter()).finish()
    }
}

impl Serialize for BaseSet {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.iter())
    }
}

impl<'de> Deserialize<'de> for BaseSet {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<BaseSet, D::Error> {
        let list = Vec::<u8>::deserialize(deserializer)?;
        let rises = list.windows(2).all(|pair| pair[0] < pair[1]);
        if !rises || list.last().is_some_and(|&base| usize::from(base) >= Self::COUNT) {
            let message = format!("bases {list:?}: expected numbers from 0 to 18, ascending, each once");
            return Err(serde::de::Error::custom(message));
        }
        Ok(list.into_iter().collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holds_what_was_put_in_and_knows_what_is_missing() {
        let some: BaseSet = [18, 0, 4].into_iter().collect();
        assert_eq!(some.iter().collect::<Vec<_>>(), [0, 4, 18]);
        assert_eq!((some.len(), some.missing().len(), BaseSet::ALL.len()), (3, 16, 19));
        assert!(some.contains(18) && !some.contains(1) && !some.contains(19) && !some.contains(255));
        assert_eq!(some.union(some.missing()), BaseSet::ALL);
        assert!(some.intersection(some.missing()).is_empty());
    }

    #[test]
    fn json_is_a_rising_list_and_nothing_else() {
        let some: BaseSet = [18, 0, 4].into_iter().collect();
        assert_eq!(serde_json::to_string(&some).unwrap(), "[0,4,18]");
        assert_eq!(serde_json::from_str::<BaseSet>("[0,4,18]").unwrap(), some);
        for wrong in ["[4,0]", "[4,4]", "[19]", "[-1]", "[256]", "{}"] {
            assert!(serde_json::from_str::<BaseSet>(wrong).is_err(), "{wrong}");
        }
    }
}

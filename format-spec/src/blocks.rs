//! The block codings `classed` and `haar`: non-overlapped blocks of 4^3 texels near geometry, integer coefficients, and
//! every length known before a field is read.
//!
//! A species shares a [`BlockMap`] and a [`Coding`]; a base has a [`Head`], [`Averages`] and pages of detail. A base is
//! readable from its averages on, at a quarter of its resolution, and refined by its pages in any order
//! ([`CodedBase`]). All of a block's arithmetic is in `i32` and cannot overflow, so that every reader gets the same
//! integers; only the last step, integer to light, is in `f32`.
//!
//! The parsers are total: any bytes give a value or a [`BlockFault`], and one content has one encoding.
//! SPEC.md, section 8.5, is normative.

pub mod averages;
pub mod base;
pub mod bits;
pub mod classes;
pub mod coarse;
pub mod cursor;
pub mod detail;
pub mod head;
mod lanes;
pub mod map;
pub mod sample;
pub mod transform;

pub use averages::Averages;
pub use base::{CodedBase, Shared};
pub use classes::{ClassTable, Classes};
pub use cursor::Cursor;
pub use detail::{CodedBlock, Coding};
pub use head::Head;
pub use map::BlockMap;
pub use sample::{At, SpeciesPoint};
pub use transform::{EDGE, TEXELS};

use std::fmt;

/// Widest field of a coefficient, bits.
pub const MAX_WIDTH: u8 = 11;
/// Largest number of halvings of a block's steps.
pub const MAX_HALVINGS: u32 = 3;

/// A rule of the specification that a payload can break.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rule {
    /// Length of a block map.
    MapLength = 40,
    /// A block map has a block.
    MapEmpty = 41,
    /// Length of class tables.
    ClassesLength = 42,
    /// A width of a class.
    ClassWidth = 43,
    /// Order of classes.
    ClassOrder = 44,
    /// Length of a head.
    HeadLength = 45,
    /// A field of a head.
    HeadField = 46,
    /// Length of averages, and 0 behind them.
    AveragesLength = 47,
    /// A Rice parameter or an escape that is not the shortest.
    AveragesCode = 48,
    /// An average out of range.
    AverageRange = 49,
    /// Blocks of a page of detail: in the map, at least one, none twice.
    DetailBlocks = 50,
    /// Length of a page of detail, and 0 behind its fields.
    DetailLength = 51,
    /// Class of a block.
    BlockClass = 52,
    /// Width or mask of a block.
    BlockMask = 53,
    /// Detail of a base in all.
    DetailSize = 54,
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "M{}", *self as u32)
    }
}

/// A broken rule, what was read and what was expected. The container adds the place.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{rule}: {what} is {found}, expected {expected}")]
pub struct BlockFault {
    /// Rule that is broken.
    pub rule: Rule,
    /// Value that breaks the rule, with its index where there are several.
    pub what: String,
    /// Value as read.
    pub found: String,
    /// Value that the rule requires.
    pub expected: String,
}

impl BlockFault {
    fn new(
        rule: Rule,
        what: impl Into<String>,
        found: impl ToString,
        expected: impl Into<String>,
    ) -> BlockFault {
        BlockFault { rule, what: what.into(), found: found.to_string(), expected: expected.into() }
    }

    fn length(rule: Rule, what: &str, found: usize, expected: impl ToString) -> BlockFault {
        BlockFault::new(rule, format!("the length of {what} in bytes"), found, expected.to_string())
    }
}

#[cfg(test)]
mod tests;

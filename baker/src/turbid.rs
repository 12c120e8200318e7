//! The turbid medium of the `physical` model with its optics: what leaf and wood do with the light that they intercept.
//!
//! The medium itself is part of the file ([`flb_format::turbid`]).

mod phase;

pub use flb_format::turbid::{INCLINATIONS, LeafAngles, Turbid};
pub use phase::Phase;

/// What one kind of matter does with the light that it intercepts, in one band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scatter {
    /// Share of it that goes on, 0..=1; the rest is absorbed.
    pub albedo: f64,
    /// Where it goes.
    pub phase: Phase,
}

/// Both kinds of matter in one band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BandScatter {
    /// Leaves.
    pub leaf: Scatter,
    /// Wood.
    pub wood: Scatter,
}

#[cfg(test)]
mod tests;

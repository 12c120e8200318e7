//! Suns that are carried side by side, as SIMD lanes. Sixteen are no faster than eight.

/// Suns of a group.
pub(super) const LANES: usize = 8;

/// One number per sun.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(align(32))]
pub(super) struct Lanes(pub [f32; LANES]);

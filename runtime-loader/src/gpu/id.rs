//! The number of a species on a GPU, apart from the place that it has in its library.

use std::fmt;

/// A species that was sent to a [`GpuLight`](super::GpuLight), which makes it: shaders take its [`word`](Self::word)
/// for `flb_sample` and `flb_near`. In its library the same species has another number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct GpuSpeciesId(pub(super) u32);

impl GpuSpeciesId {
    /// Number of the species as shaders take it.
    pub fn word(self) -> u32 {
        self.0
    }

    pub(super) fn index(self) -> usize {
        self.0 as usize
    }
}

impl fmt::Display for GpuSpeciesId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

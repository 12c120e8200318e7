//! What can go wrong with light on a GPU.

use flb_gpu::DeviceError;

use super::GpuSpeciesId;

/// Errors of light on a GPU.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// The device cannot be had, or failed.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// A budget that the buffers cannot be made for.
    #[error("a budget of {found} bytes for light on the GPU, expected {least} to {most}")]
    Budget {
        /// Budget that was asked for, bytes.
        found: u64,
        /// Bytes of the buffers beside that of words, and one word.
        least: u64,
        /// Bytes where the buffer of words is the largest that can be bound.
        most: u64,
    },
    /// More species, bases or terms than there is room for.
    #[error("room for {most} {what}, asked for one more")]
    NoRoom {
        /// "species", "bases" or "terms".
        what: &'static str,
        /// Largest number that fits.
        most: u32,
    },
    /// The budget holds no more; something must go first.
    #[error(
        "{needed} bytes do not fit: {free} of {budget} bytes for words of light are free, {largest} of them together"
    )]
    Full {
        /// Bytes that were asked for.
        needed: u64,
        /// Bytes that are free.
        free: u64,
        /// Bytes of the largest hole.
        largest: u64,
        /// Bytes of the buffer of words.
        budget: u64,
    },
    /// A number of bands that a colour does not have.
    #[error(
        "base {base} has {found} bands or components, expected 1 to 3: light on the GPU is red, green and blue; draw it on \
         the CPU, or bake with three bands"
    )]
    Bands {
        /// The base.
        base: u8,
        /// Number of bands of the base.
        found: u32,
    },
    /// A species that was not added, or was removed.
    #[error("species {species} is not on the GPU")]
    NoSpecies {
        /// Number of the species.
        species: GpuSpeciesId,
    },
    /// A base that was not set, or was removed.
    #[error("base {base} of species {species} is not on the GPU")]
    NoBase {
        /// Number of the species.
        species: GpuSpeciesId,
        /// The base.
        base: u8,
    },
    /// A base of another species, or with another head than the one that was set.
    #[error("base {base} of species {species} was given another {what} than the one on the GPU")]
    OtherBase {
        /// Number of the species.
        species: GpuSpeciesId,
        /// The base.
        base: u8,
        /// "block map or class tables" or "head".
        what: &'static str,
    },
    /// Extinction of another species.
    #[error("species {species} was given extinction on another lattice than that of its light")]
    OtherExtinction {
        /// Number of the species.
        species: GpuSpeciesId,
    },
    /// Blocks that the map does not store, or that overlap a page without being it.
    #[error("{count} blocks from {first} on are no page: {reason}")]
    NoPage {
        /// Rank of the first block.
        first: u32,
        /// Blocks.
        count: u32,
        /// Relation of the blocks to the map's pages.
        reason: String,
    },
    /// An atlas that is larger than it may be.
    #[error(
        "the atlas of species {species} with {blocks} blocks takes {needed} bytes, expected at most {budget}"
    )]
    AtlasBudget {
        /// Number of the species.
        species: GpuSpeciesId,
        /// Stored blocks of the species.
        blocks: usize,
        /// Bytes of its texture.
        needed: u64,
        /// Bytes that were allowed.
        budget: u64,
    },
}

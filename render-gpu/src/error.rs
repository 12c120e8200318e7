//! What can go wrong with a forest on a GPU.

use flb_gpu::DeviceError;
use flb_render::RenderError;
use flb_runtime::RuntimeError;

/// Errors of a forest on a GPU.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ForestError {
    /// The GPU is missing, was lost, is full or failed.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// Light could not be put on the GPU.
    #[error(transparent)]
    Light(#[from] flb_runtime::gpu::GpuError),
    /// The scene, the view or the daylight is none.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A species' file could not be read.
    #[error(transparent)]
    Runtime(#[from] RuntimeError),
    /// A list that no buffer holds.
    #[error(
        "{what} take {needed} bytes on the GPU, expected at most {limit}; render on the CPU, or {remedy}"
    )]
    TooLarge {
        /// Name of the list.
        what: &'static str,
        /// Bytes of all of it.
        needed: u64,
        /// Bytes of the largest buffer, or of the budget.
        limit: u64,
        /// Advice.
        remedy: &'static str,
    },
    /// More items than the shaders have room for.
    #[error("{found} {what}, expected at most {most} on the GPU; render on the CPU")]
    TooMany {
        /// Name of the items.
        what: &'static str,
        /// Number of items.
        found: u64,
        /// Largest number of items.
        most: u64,
    },
    /// The light of a species is stored in a way that is not evaluated on the GPU.
    #[error(
        "species {species:?}: {found}, which is not lit on the GPU; render on the CPU, or code it anew by `flb pack FILE \
         -o NEW.flb --codec classed`"
    )]
    Unlit {
        /// Name of the species.
        species: String,
        /// Storage of the species' light.
        found: String,
    },
    /// A sun that a species' file has no base for.
    #[error("species {species:?} has no base {base}, which this sun needs")]
    NoBase {
        /// Name of the species.
        species: String,
        /// The base.
        base: u8,
    },
    /// Sources of light for another number of species than the forest has.
    #[error("light for {found} species, expected {expected} as the forest has")]
    Species {
        /// Sources.
        found: usize,
        /// Species of the forest.
        expected: usize,
    },
    /// Scene light for another number of plants than stand in the forest.
    #[error("scene light for {found} plants, expected {expected} as the forest has")]
    Neighbours {
        /// Plants of the scene light.
        found: usize,
        /// Plants of the forest.
        expected: usize,
    },
    /// A fleet without members.
    #[error("no GPU to draw on, expected one at least")]
    NoGpu,
    /// No view was traced yet.
    #[error("nothing was traced, so there is nothing to light: trace a view first")]
    NotTraced,
}

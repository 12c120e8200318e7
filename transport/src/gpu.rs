//! The GPU that solves, of either solver: its name, and why there is no solution from it.

#[cfg(feature = "gpu")]
pub(crate) mod buffers;
#[cfg(feature = "gpu")]
pub(crate) mod pipelines;
#[cfg(feature = "gpu")]
pub(crate) mod share;
#[cfg(all(test, feature = "gpu"))]
pub(crate) mod wgsl;

use thiserror::Error;

/// Name of the GPU on which light will be solved.
///
/// # Errors
/// [`GpuError::NotBuilt`], [`GpuError::NoAdapter`].
pub fn find_gpu() -> Result<String, GpuError> {
    #[cfg(feature = "gpu")]
    return Ok(flb_gpu::find()?.name);
    #[cfg(not(feature = "gpu"))]
    Err(GpuError::NotBuilt)
}

/// Names of the GPUs that share a solve, at most so many: the one that [`find_gpu`] names, and others of its kind, so
/// that the light is the same whichever does a part of it.
///
/// # Errors
/// As [`find_gpu`].
#[cfg_attr(not(feature = "gpu"), expect(unused_variables, reason = "without GPUs there is nothing to count"))]
pub fn find_gpus(most: usize) -> Result<Vec<String>, GpuError> {
    #[cfg(feature = "gpu")]
    return Ok(flb_gpu::find_alike(most)?.into_iter().map(|found| found.name).collect());
    #[cfg(not(feature = "gpu"))]
    Err(GpuError::NotBuilt)
}

/// Reason why there is no solution from a GPU.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum GpuError {
    /// Built without it.
    #[error("this build has no GPU solver; build it with the feature `gpu`, or solve on the CPU")]
    NotBuilt,
    /// No GPU, and no software that stands in for one.
    #[error(
        "no GPU: looked for an adapter of {looked_for}: {message}. Install the GPU's Vulkan driver, or the software one (Debian: `apt-get install mesa-vulkan-drivers libvulkan1`), or solve on the CPU"
    )]
    NoAdapter {
        /// The interfaces asked.
        looked_for: String,
        /// Errors of the interfaces.
        message: String,
    },
    /// The GPU has not what WebGPU promises everywhere.
    #[error("{adapter}: cannot be opened: {message}")]
    Refused {
        /// Name of the adapter.
        adapter: String,
        /// The reason.
        message: String,
    },
    /// A single solve is too large for it.
    #[error(
        "{adapter}: the light of one solve over {sites} non-empty sites takes {needed} bytes, expected at most the {limit} that a shader can bind; solve on the CPU, or with a smaller lattice"
    )]
    TooLarge {
        /// Name of the GPU.
        adapter: String,
        /// Non-empty sites.
        sites: usize,
        /// Bytes of the largest buffer for a single lane.
        needed: u64,
        /// Bytes that a buffer may have.
        limit: u64,
    },
    /// The GPU's memory is full.
    #[error("{adapter}: out of memory: {message}; solve on the CPU, or with a smaller lattice")]
    OutOfMemory {
        /// Name of the adapter.
        adapter: String,
        /// Message of the driver.
        message: String,
    },
    /// The GPU was lost on the way, or its driver failed.
    #[error("{adapter}: {message}")]
    Failed {
        /// Name of the adapter.
        adapter: String,
        /// Message of the driver.
        message: String,
    },
}

#[cfg(feature = "gpu")]
impl From<flb_gpu::DeviceError> for GpuError {
    fn from(error: flb_gpu::DeviceError) -> GpuError {
        use flb_gpu::DeviceError;
        match error {
            DeviceError::NoAdapter { looked_for, message } => GpuError::NoAdapter { looked_for, message },
            DeviceError::Refused { adapter, message } => GpuError::Refused { adapter, message },
            DeviceError::OutOfMemory { adapter, message } => GpuError::OutOfMemory { adapter, message },
            DeviceError::Failed { adapter, message } => GpuError::Failed { adapter, message },
        }
    }
}

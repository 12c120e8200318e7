//! Reasons why light cannot be judged.

use flb_baker::BakeError;
use flb_baker::voxelise::VoxelError;
use flb_format::colors::BandsError;
use flb_format::size_text::bytes;
use flb_packer::PackError;
use flb_render::RenderError;
use flb_runtime::RuntimeError;
use flb_scene::alpha::AlphaError;
use flb_transport::monte_carlo::MonteCarloError;

/// Error of a judgement.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EvalError {
    /// The mesh has no surface of leaf or wood.
    #[error("found no point of leaf or wood to judge light at, expected some surface")]
    NoSurface,
    /// The file has no light of the sky.
    #[error("found no light of the sky (base 0 was left out), which light is judged by")]
    NoSky,
    /// The file does not say what leaves reflect and transmit, as those of the model `paper`.
    #[error(
        "found a paper file, which does not say what leaves reflect and transmit, expected a physical one"
    )]
    NoReflectance,
    /// The fields hold the sun's own beam.
    #[error("found fields that hold the sun's beam as well (field total), expected those of scattered light")]
    TotalField,
    /// The bands are not red, green and blue.
    #[error(transparent)]
    Bands(#[from] BandsError),
    /// A texture cannot be cut.
    #[error(transparent)]
    Alpha(#[from] AlphaError),
    /// Paths or pictures cannot be traced.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The light of a file cannot be read.
    #[error(transparent)]
    Runtime(#[from] RuntimeError),
    /// Fields cannot be coded.
    #[error(transparent)]
    Pack(#[from] PackError),
    /// The plant cannot be cut into voxels.
    #[error(transparent)]
    Voxels(#[from] VoxelError),
    /// The plant cannot be baked.
    #[error(transparent)]
    Bake(#[from] BakeError),
    /// Photons cannot be traced.
    #[error(transparent)]
    MonteCarlo(#[from] MonteCarloError),
    /// The file that all others are compared with stores no near beam.
    #[error("the finest file stores no near beam")]
    NoNearBeam,
    /// Even the coarsest lattice needs more memory than may be used.
    #[error("{solve} would need {} of memory, at most {} may be used", bytes(*.needed_bytes), bytes(*.limit_bytes))]
    Memory {
        /// The solve that needs it.
        solve: String,
        /// Bytes that it needs.
        needed_bytes: u64,
        /// Bytes that may be used.
        limit_bytes: u64,
    },
}

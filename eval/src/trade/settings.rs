//! Choices of a trade, and how they are measured.

/// Choices to try, and how to measure them.
#[derive(Debug, Clone, PartialEq)]
pub struct TradeSettings {
    /// Sites along each edge: powers of two, 16 to 256, each once.
    pub lattices: Vec<u32>,
    /// Whether to try fewer choices.
    pub quick: bool,
    /// Voxels along each edge of the fine grid: a multiple of every lattice.
    pub voxels: u32,
    /// Whether leaf cards count whole, whatever the alpha of their textures.
    pub ignore_alpha: bool,
    /// Suns to measure the light under, 1 to [`MAX_SUNS`](flb_transport::monte_carlo::judge::MAX_SUNS).
    pub suns: usize,
    /// Points of the plant's surface to measure the light at, at most.
    pub points: u32,
    /// Memory that no choice may need more of, as predicted, in bytes.
    pub limit_bytes: u64,
}

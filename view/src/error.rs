//! What can go wrong with a view.

/// Errors of a view.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ViewError {
    /// The scene, its light or its GPU.
    #[error(transparent)]
    Stage(#[from] flb_stage::StageError),
    /// The device failed.
    #[error(transparent)]
    Device(#[from] flb_gpu::DeviceError),
    /// No window can be opened.
    #[error("cannot open a window: {0}; `--screenshot` needs none")]
    Window(String),
    /// A size that a texture cannot have.
    #[error("a window of {width} x {height} pixels, expected 1 to {most} each")]
    Size {
        /// Pixels per row.
        width: u32,
        /// Rows.
        height: u32,
        /// Largest width or height of the device's textures.
        most: u32,
    },
}

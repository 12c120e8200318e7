//! What can go wrong with a view.

/// Errors of a view.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ViewError {
    /// The scene cannot be drawn.
    #[error(transparent)]
    Render(#[from] flb_render::RenderError),
    /// Its light cannot be read.
    #[error(transparent)]
    Runtime(#[from] flb_runtime::RuntimeError),
    /// The device failed.
    #[error(transparent)]
    Device(#[from] flb_gpu::DeviceError),
    /// The GPU cannot draw it.
    #[error(transparent)]
    Forest(#[from] flb_render_gpu::ForestError),
    /// No species has light.
    #[error(
        "no species of the scene has light, and a GPU follows that of a file: name one with `light`, or draw on the CPU"
    )]
    Unlit,
    /// A GPU samples the light of one file alone.
    #[error(
        "the species' light lies in {0} files, and a GPU follows one: pack them into one with flb pack, or draw on the CPU"
    )]
    Libraries(usize),
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
        /// Of the device.
        most: u32,
    },
}

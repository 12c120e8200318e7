//! What can go wrong with a device.

/// Errors of a GPU, whatever it is used for.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DeviceError {
    /// No GPU, and no software that stands in for one.
    #[error(
        "no GPU: looked for an adapter of {looked_for}: {message}. Install the GPU's Vulkan driver, or the software one (Debian: `apt-get install mesa-vulkan-drivers libvulkan1`)"
    )]
    NoAdapter {
        /// The interfaces asked.
        looked_for: String,
        /// Errors of the interfaces.
        message: String,
    },
    /// The GPU has not what was asked of it.
    #[error("{adapter}: cannot be opened: {message}")]
    Refused {
        /// Name of the adapter.
        adapter: String,
        /// The reason.
        message: String,
    },
    /// The GPU's memory is full.
    #[error("{adapter}: out of memory: {message}")]
    OutOfMemory {
        /// Name of the adapter.
        adapter: String,
        /// Message of the driver.
        message: String,
    },
    /// The GPU was lost on the way, its driver failed, or it does not answer.
    #[error("{adapter}: {message}")]
    Failed {
        /// Name of the adapter.
        adapter: String,
        /// Message of the driver.
        message: String,
    },
}

/// An error and its causes, in one line.
pub(crate) fn chain(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text = format!("{text}: {error}");
        cause = error.source();
    }
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

//! What can go wrong while a file is inspected.

use flb_format::FormatError;

/// Errors of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum InspectError {
    /// The file could not be read, or does not keep what SPEC.md promises.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// The PNG encoder failed.
    #[error("PNG: {0}")]
    Png(String),
    /// The EXR encoder failed.
    #[error("EXR: {0}")]
    Exr(String),
}

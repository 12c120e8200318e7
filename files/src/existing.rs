//! What becomes of a file that lies where an output is to be.

/// Fate of a file that has the name of an output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Existing {
    /// The file stays, and the output is refused ([`FileError::Exists`](crate::FileError::Exists)).
    Keep,
    /// The output takes the place of the file.
    Replace,
}

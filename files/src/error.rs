//! Everything that keeps a file from being written.

use std::io;
use std::path::PathBuf;

/// Reason why nothing was written.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the fields repeat the messages")]
#[non_exhaustive]
pub enum FileError {
    #[error("cannot write {path}: {source}")]
    Write { path: PathBuf, source: io::Error },
    #[error("{path}: exists already; use --force to overwrite it")]
    Exists { path: PathBuf },
    #[error("{path} is {found}, expected a regular file or a new name")]
    NotAFile { path: PathBuf, found: &'static str },
    #[error("{path} is read-only (mode {mode:03o}), expected a file that may be written")]
    ReadOnly { path: PathBuf, mode: u32 },
    #[error("the output {output} is the input {input} itself")]
    OutputIsInput { output: PathBuf, input: PathBuf },
    #[error("{second} is the file {first}, named as two outputs at once")]
    TwoOutputs { first: PathBuf, second: PathBuf },
}

impl FileError {
    /// Whether another word on the command line mends the error, and no other state of the disk.
    pub fn is_usage(&self) -> bool {
        matches!(self, FileError::OutputIsInput { .. } | FileError::TwoOutputs { .. })
    }
}

//! Exit codes, and the error that carries one to `main`.

use std::fmt::Display;
use std::path::Path;

/// Negative verdict: invalid, differs.
pub const VERDICT: u8 = 1;
/// Wrong flags, patterns or settings.
pub const USAGE: u8 = 2;
/// Finished, with loss.
pub const LOSS: u8 = 3;
/// A file cannot be read or written.
pub const INPUT_OUTPUT: u8 = 4;
/// Unsupported version, feature or extension.
pub const UNSUPPORTED: u8 = 5;
/// A limit was hit.
pub const LIMIT: u8 = 6;
/// A fault of ours.
pub const INTERNAL: u8 = 70;

/// Why a command ended early.
#[derive(Debug)]
pub struct Failure {
    /// Exit code.
    pub code: u8,
    /// One or more lines for stderr, without the leading "flb: ".
    pub message: String,
    /// Nothing is printed: the reader of our stdout has gone away.
    pub quiet: bool,
}

impl Failure {
    /// A failure with a message.
    pub fn new(code: u8, message: impl Display) -> Failure {
        Failure { code, message: message.to_string(), quiet: false }
    }

    /// Puts the file's name before the message, unless the message already names it.
    pub fn at(mut self, path: &Path) -> Failure {
        let name = path.display().to_string();
        if !self.message.contains(&name) {
            self.message = format!("{name}: {}", self.message);
        }
        self
    }
}

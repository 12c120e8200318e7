//! The corruption kit: sound files of the format made into bad ones whose digests are sound, so that the checks behind
//! the digests are reached. For tests, fuzzing and `flb torture`; only the feature `testing` compiles it.
//!
//! ```text
//! sound file -Parts::of-> records, pages -a change, lay_out, seal-> bad file
//!   torture     any sound file: each kind of corruption, with the code that a reader must give
//!   forgeries   golden files: promises that not every file has, with code and words of the message
//!   damage      any sound file: one place changed by a fuzzer
//! ```

pub mod damage;
mod dice;
pub mod forgeries;
mod golden;
mod parts;
pub mod torture;

use crate::container::verify;
use crate::{FormatError, Source};

pub use dice::Dice;
pub use golden::{GOLDEN, golden};
pub use parts::{Digests, Page, Parts};

/// Checks all that SPEC.md promises of a file, at level decode.
///
/// # Errors
/// The first broken promise.
pub fn check(file: &dyn Source) -> Result<(), FormatError> {
    verify::check(file, verify::Level::Decode)
}

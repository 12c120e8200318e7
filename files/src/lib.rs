//! The one door to the files of this machine.
//!
//! - [`open_regular`] opens what is read: regular files only, never a pipe that would wait for its writer.
//! - [`publish`] writes a file whole or not at all.
//! - After [`guard_inputs`] no file that was read through the first can be overwritten through the second. The guard
//!   learns of a file by the read itself, so that a texture, a buffer or a material library counts as well as a file
//!   that the command line names.
//! - [`open_own`] and [`publish_own`] are for files that the program keeps for itself, such as those of a cache. They
//!   follow no link, and replace no input and no output either.
#![forbid(unsafe_code)]
#![deny(clippy::print_stdout, clippy::print_stderr)] // cli/src/print.rs alone prints

mod error;
mod existing;
mod guard;
mod open;
mod output;
mod publish;

pub use error::FileError;
pub use existing::Existing;
pub use guard::{check_unread, guard_input, guard_inputs};
pub use open::{OpenError, open_own, open_regular};
pub use output::{check_distinct, check_output};
pub use publish::{names_in, publish, publish_own, stop_publishing};

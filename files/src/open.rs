//! Opens regular files for reading, and lets the guard know of each.

use std::fs::{File, Metadata};
use std::io;
use std::path::Path;

use crate::guard::{self, Owner};

/// Reason why a file was not opened. The caller knows its name.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The system's word.
    #[error("cannot {action}: {source}")]
    Io {
        /// Operation that failed.
        action: &'static str,
        /// Error of the operating system.
        source: io::Error,
    },
    /// Reading it might wait for ever, or never end.
    #[error("found {found}, expected a regular file")]
    NotAFile {
        /// A folder; a pipe, device or socket.
        found: &'static str,
    },
}

/// Opens a regular file for reading.
///
/// # Errors
/// A file that is missing or may not be read; a folder, pipe, device or socket.
pub fn open_regular(path: &Path) -> Result<(File, Metadata), OpenError> {
    // Asked before opening too, because opening a pipe waits for its writer.
    check_regular(&std::fs::metadata(path).map_err(failed("open"))?)?;
    open_checked(path, Owner::User)
}

/// Opens a file that the program keeps for itself, such as one of a cache: [`publish_own`](crate::publish_own) may
/// replace it afterwards. A link is none of ours, for what it leads to may be an input or an output.
///
/// # Errors
/// As [`open_regular`]; a link.
pub fn open_own(path: &Path) -> Result<(File, Metadata), OpenError> {
    let found = std::fs::symlink_metadata(path).map_err(failed("open"))?;
    if found.is_symlink() {
        return Err(OpenError::NotAFile { found: "a link" });
    }
    check_regular(&found)?;
    open_checked(path, Owner::Program)
}

fn failed(action: &'static str) -> impl Fn(io::Error) -> OpenError {
    move |source| OpenError::Io { action, source }
}

fn open_checked(path: &Path, owner: Owner) -> Result<(File, Metadata), OpenError> {
    let file = open(path, owner).map_err(failed("open"))?;
    let metadata = file.metadata().map_err(failed("ask for the length of"))?;
    check_regular(&metadata)?;
    guard::note_read(path, &metadata, owner);
    Ok((file, metadata))
}

/// Without waiting, for what was a regular file may be a pipe by now. What is our own may be a link by now.
fn open(path: &Path, owner: Owner) -> io::Result<File> {
    let mut options = File::options();
    #[cfg(unix)]
    {
        use rustix::fs::OFlags;
        use std::os::unix::fs::OpenOptionsExt;
        let follows = if owner == Owner::Program { OFlags::NOFOLLOW } else { OFlags::empty() };
        options.custom_flags((OFlags::NONBLOCK | follows).bits() as i32);
    }
    #[cfg(not(unix))]
    let _ = owner;
    options.read(true).open(path)
}

fn check_regular(metadata: &Metadata) -> Result<(), OpenError> {
    match metadata.is_file() {
        true => Ok(()),
        false if metadata.is_dir() => Err(OpenError::NotAFile { found: "a folder" }),
        false => Err(OpenError::NotAFile { found: "a pipe, device or socket" }),
    }
}

//! Opens regular files for reading, and lets the guard know of each.

use std::fs::{File, Metadata};
use std::io;
use std::path::Path;

use crate::guard;

/// Why a file was not opened. The caller knows its name.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The system's word.
    #[error("cannot {action}: {source}")]
    Io {
        /// What failed.
        action: &'static str,
        /// What the system says.
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
    let failed = |action| move |source| OpenError::Io { action, source };
    // Asked before opening too, because opening a pipe waits for its writer.
    check_regular(&std::fs::metadata(path).map_err(failed("open"))?)?;
    let file = open(path).map_err(failed("open"))?;
    let metadata = file.metadata().map_err(failed("ask for the length of"))?;
    check_regular(&metadata)?;
    guard::note_read(path, &metadata);
    Ok((file, metadata))
}

/// Without waiting, for what was a regular file may be a pipe by now.
fn open(path: &Path) -> io::Result<File> {
    let mut options = File::options();
    #[cfg(unix)]
    {
        use std::os::unix::fs::OpenOptionsExt;
        options.custom_flags(rustix::fs::OFlags::NONBLOCK.bits() as i32);
    }
    options.read(true).open(path)
}

fn check_regular(metadata: &Metadata) -> Result<(), OpenError> {
    match metadata.is_file() {
        true => Ok(()),
        false if metadata.is_dir() => Err(OpenError::NotAFile { found: "a folder" }),
        false => Err(OpenError::NotAFile { found: "a pipe, device or socket" }),
    }
}

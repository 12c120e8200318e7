//! The ways to the bytes of a file: [`FileSource`] reads at positions, [`MappedSource`] maps; with the feature
//! `remote`, `RemoteSource` reads behind a URL. The first two take regular, non-empty files only, so that a pipe, a
//! folder or `/dev/zero` is refused by name.

use std::fs::File;
use std::io;
use std::path::Path;

use flb_files::OpenError;
use flb_format::Source;

use crate::RuntimeError;

mod mapped;
#[cfg(feature = "remote")]
pub(crate) mod remote;
mod replaced;

pub use mapped::MappedSource;
#[cfg(feature = "remote")]
#[doc(hidden)]
pub use remote::replay;
#[cfg(feature = "remote")]
pub use remote::{
    Bucket, BucketError, EnvironmentError, HEAD_BYTES, Listed, MAX_OBJECT_BYTES, RemoteError, RemoteSettings,
    RemoteSource, RemoteUrl, is_private,
};
pub use replaced::{ATTEMPTS, Replaced, is_replaced, retry_replaced};

/// Requests and bytes fetched of a file behind a URL.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Traffic {
    /// HTTP requests, repeated ones and those for credentials included.
    pub requests: u64,
    /// Bytes of the file, headers left out.
    pub bytes: u64,
}

/// A file read by positioned reads; the tools use it. Needs no address space, and a file that shrinks or changes while
/// it is read gives an error (of its length, or of the digest of a page), never a signal and never wrong data. It has
/// no position of its own, so threads share it.
#[derive(Debug)]
pub struct FileSource {
    file: File,
}

impl FileSource {
    /// Opens a regular, non-empty file for reading.
    pub fn open(path: &Path) -> Result<FileSource, RuntimeError> {
        Ok(FileSource { file: open_regular(path)?.0 })
    }
}

impl From<File> for FileSource {
    /// Takes a file that is open, whatever it is.
    fn from(file: File) -> FileSource {
        FileSource { file }
    }
}

impl Source for FileSource {
    /// Length now, not that at opening.
    fn len_bytes(&self) -> io::Result<u64> {
        Ok(self.file.metadata()?.len())
    }

    fn read_exact_at(&self, offset_bytes: u64, buffer: &mut [u8]) -> io::Result<()> {
        read_exact_at(&self.file, offset_bytes, buffer)
    }
}

#[cfg(unix)]
fn read_exact_at(file: &File, offset_bytes: u64, buffer: &mut [u8]) -> io::Result<()> {
    std::os::unix::fs::FileExt::read_exact_at(file, buffer, offset_bytes)
}

/// Windows has no exact form, and may read less than asked for.
#[cfg(windows)]
fn read_exact_at(file: &File, mut offset_bytes: u64, mut buffer: &mut [u8]) -> io::Result<()> {
    use std::os::windows::fs::FileExt;
    while !buffer.is_empty() {
        match file.seek_read(buffer, offset_bytes) {
            Ok(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
            Ok(read) => {
                buffer = &mut buffer[read..];
                offset_bytes += read as u64;
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

/// Where a place can be read only by going there, as in wasm32: one read at a time, since a file has one place.
#[cfg(not(any(unix, windows)))]
use read_by_seeking as read_exact_at;

#[cfg(any(test, not(any(unix, windows))))]
fn read_by_seeking(mut file: &File, offset_bytes: u64, buffer: &mut [u8]) -> io::Result<()> {
    use std::io::{Read, Seek, SeekFrom};
    static ONE_READ: std::sync::Mutex<()> = std::sync::Mutex::new(());
    let _one = ONE_READ.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    file.seek(SeekFrom::Start(offset_bytes))?;
    file.read_exact(buffer)
}

/// Opens a file and returns it with its length in bytes, which is not 0.
fn open_regular(path: &Path) -> Result<(File, u64), RuntimeError> {
    let path = path.to_owned();
    match flb_files::open_regular(&path) {
        Ok((_, metadata)) if metadata.len() == 0 => Err(RuntimeError::Empty { path }),
        Ok((file, metadata)) => Ok((file, metadata.len())),
        Err(OpenError::Io { action, source }) => Err(RuntimeError::Io { path, action, source }),
        Err(OpenError::NotAFile { found }) => Err(RuntimeError::NotAFile { path, found }),
    }
}

#[cfg(test)]
mod tests;

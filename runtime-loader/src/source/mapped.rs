//! A file mapped into memory. One of the two files of the project with `unsafe`.
//!
//! # Contract
//!
//! A mapping shows the file as it IS, not as it was. So:
//!
//! - While a [`MappedSource`] lives, no program may write to the file or shorten it. The tools of this project
//!   keep that by themselves: they publish a file by renaming a finished one over it, which leaves a mapped
//!   old file whole until its last user closes it.
//! - If another program shortens the file, touching a page past the new end raises SIGBUS on Unix, which
//!   ends the process: no error handling catches it. Every read therefore asks for the file's length first
//!   and fails with an error if it has changed. What remains is a file that is shortened while a read copies.
//!   (Windows refuses to shorten a mapped file.)
//! - If another program writes into the file, reads return bytes of both. Every page carries a digest that is
//!   checked on the copy, so this is found, and never decoded.
//! - A file that was shortened before it is opened is refused then: its header says how long it is.
//! - Who cannot keep others from the file takes [`FileSource`](super::FileSource), where all of this is an error and
//!   never a signal: every command of `flb` does. `tests/it/changing.rs` does these things to both.
//! - No reference into the mapping leaves this file: reads copy, so that what was checked is what is used.

#![allow(unsafe_code, reason = "a mapping is memory that the kernel fills")]

use std::fs::File;
use std::io;
use std::path::Path;

use flb_format::Source;
use memmap2::Mmap;

use crate::RuntimeError;

/// A file mapped read-only; the runtime uses it. See the module for what others may not do to the file.
#[derive(Debug)]
pub struct MappedSource {
    /// Kept to ask for its length.
    file: File,
    map: Mmap,
}

impl MappedSource {
    /// Maps a regular, non-empty file.
    pub fn open(path: &Path) -> Result<MappedSource, RuntimeError> {
        let (file, _) = super::open_regular(path)?;
        // SAFETY: the map is read-only, and its bytes are only ever copied out, by `read_exact_at`, after a
        // check that the file still is as long as the map. That no program changes the file while a read copies
        // is the caller's part of the module's contract; no type can keep it.
        let map = unsafe { Mmap::map(&file) }.map_err(|source| RuntimeError::Io {
            path: path.to_owned(),
            action: "map",
            source,
        })?;
        Ok(MappedSource { file, map })
    }
}

impl Source for MappedSource {
    /// Length at opening.
    fn len_bytes(&self) -> io::Result<u64> {
        Ok(self.map.len() as u64)
    }

    fn read_exact_at(&self, offset_bytes: u64, buffer: &mut [u8]) -> io::Result<()> {
        let length_now = self.file.metadata()?.len();
        if length_now != self.map.len() as u64 {
            let message =
                format!("the file is {length_now} bytes long, and was {} when it was mapped", self.map.len());
            return Err(io::Error::new(io::ErrorKind::UnexpectedEof, message));
        }
        Source::read_exact_at(&self.map[..], offset_bytes, buffer)
    }
}

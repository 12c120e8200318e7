//! Where bytes come from: a mapped file, a file read by positioned reads, a slice in memory.

use std::io;

/// Random access to the bytes of a container. Implementations live in `flb-runtime`; slices here.
pub trait Source: Send + Sync {
    /// Total length in bytes.
    fn len_bytes(&self) -> io::Result<u64>;

    /// Fills `buffer` with the bytes from `offset_bytes` on; an error if they are not all there.
    fn read_exact_at(&self, offset_bytes: u64, buffer: &mut [u8]) -> io::Result<()>;

    /// Fills `buffer` with bytes that will be asked for once, from `offset_bytes` on: a source that reads ahead or
    /// keeps what it read does neither, and threads do not wait for each other.
    fn read_once_at(&self, offset_bytes: u64, buffer: &mut [u8]) -> io::Result<()> {
        self.read_exact_at(offset_bytes, buffer)
    }
}

impl Source for [u8] {
    fn len_bytes(&self) -> io::Result<u64> {
        Ok(self.len() as u64)
    }

    fn read_exact_at(&self, offset_bytes: u64, buffer: &mut [u8]) -> io::Result<()> {
        let bytes = usize::try_from(offset_bytes)
            .ok()
            .and_then(|start| self.get(start..start.checked_add(buffer.len())?))
            .ok_or(io::ErrorKind::UnexpectedEof)?;
        buffer.copy_from_slice(bytes);
        Ok(())
    }
}

impl Source for Vec<u8> {
    fn len_bytes(&self) -> io::Result<u64> {
        self.as_slice().len_bytes()
    }

    fn read_exact_at(&self, offset_bytes: u64, buffer: &mut [u8]) -> io::Result<()> {
        self.as_slice().read_exact_at(offset_bytes, buffer)
    }
}

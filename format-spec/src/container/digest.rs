//! Digests: xxh3-64 of tables and pages against accidents, one BLAKE3 root over the file for its
//! identity. SPEC.md section 6.

use xxhash_rust::xxh3::{Xxh3, xxh3_64};

use super::records::{ROOT_HEAD_BYTES, SectionKey};

/// xxh3-64, seed 0, of the bytes.
pub fn plain(bytes: &[u8]) -> u64 {
    xxh3_64(bytes)
}

/// Digest of a page: xxh3-64, seed 0, of kind, species, item and page index (u32 little-endian
/// each) followed by the stored bytes. A page thus belongs to its place: swapped pages are caught.
pub fn page(key: SectionKey, page: u32, stored: &[u8]) -> u64 {
    let mut state = Xxh3::new();
    for number in [key.kind, key.species, key.item, page] {
        state.update(&number.to_le_bytes());
    }
    state.update(stored);
    state.digest()
}

/// The BLAKE3 root in the making: bytes 0..80 of the header, then every byte of the file from the
/// end of the header on, in order.
pub struct Root(blake3::Hasher);

impl Root {
    /// Starts from the header (its root, reserved field and digest are not covered by the root;
    /// the header's digest covers the root).
    pub fn new(header: &[u8]) -> Root {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&header[..ROOT_HEAD_BYTES]);
        Root(hasher)
    }

    /// Takes in the next bytes of the file.
    pub fn update(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }

    /// The root.
    pub fn finish(&self) -> [u8; 32] {
        *self.0.finalize().as_bytes()
    }
}

//! What stages made, compressed: voxels and crowns shrink to a tenth, fields to two thirds.
//!
//! An entry that is none of zstd's is taken as it is: small ones are not worth it.

use std::io::Read;

/// Level of zstd: the quickest.
const LEVEL: i32 = 1;
/// Entries up to this many bytes are kept as they are.
const SMALL_BYTES: usize = 4096;
/// First bytes of a frame of zstd (RFC 8878, section 3.1.1).
const MAGIC: [u8; 4] = 0xFD2F_B528_u32.to_le_bytes();
/// Most bytes that an entry unpacks to.
const MAX_BYTES: u64 = 16 << 30;

/// The bytes as they are kept; `None`: as they are.
pub(super) fn pack(bytes: &[u8]) -> Option<Vec<u8>> {
    let is_worth_it = bytes.len() > SMALL_BYTES || bytes.starts_with(&MAGIC);
    is_worth_it.then(|| zstd::bulk::compress(bytes, LEVEL).ok()).flatten()
}

/// The bytes as they were.
///
/// # Errors
/// A sentence without a subject on what cannot be unpacked.
pub(super) fn unpack(bytes: Vec<u8>) -> Result<Vec<u8>, String> {
    if !bytes.starts_with(&MAGIC) {
        return Ok(bytes);
    }
    let refuse = |error: std::io::Error| format!("cannot be unpacked: {error}");
    let mut unpacked = Vec::new();
    let decoder = zstd::stream::Decoder::new(&bytes[..]).map_err(refuse)?;
    decoder.take(MAX_BYTES + 1).read_to_end(&mut unpacked).map_err(refuse)?;
    match unpacked.len() as u64 > MAX_BYTES {
        true => Err(format!("unpacks to more than {MAX_BYTES} bytes")),
        false => Ok(unpacked),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_packed_is_smaller_and_comes_back_and_damage_is_told() {
        let bytes: Vec<u8> = (0..100_000_u32).flat_map(|number| (number / 7).to_le_bytes()).collect();
        let packed = pack(&bytes).expect("worth it");
        assert!(packed.len() * 4 < bytes.len() && unpack(packed.clone()).as_ref() == Ok(&bytes));
        assert_eq!(pack(b"small"), None);
        assert_eq!(unpack(b"small".to_vec()).as_deref(), Ok(&b"small"[..]));
        // What looks like a frame is packed, however small.
        let odd = [&MAGIC[..], b"odd"].concat();
        assert_eq!(unpack(pack(&odd).expect("worth it")), Ok(odd.clone()));
        assert!(unpack(odd).is_err_and(|told| told.starts_with("cannot be unpacked: ")));
        for cut in [5, packed.len() / 2, packed.len() - 1] {
            assert!(unpack(packed[..cut].to_vec()).is_err(), "{cut}");
        }
    }
}

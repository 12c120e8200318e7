//! Kind 59: single bits of header and tables flipped, no digest made to fit. A sample of them; the tests flip every
//! one.

use super::{Cases, Dice};
use crate::container::records::{HEADER_BYTES, Header, VERSION};

/// Bits flipped in the header, and in the tables.
const FLIPS: usize = 24;

pub(super) fn cases(cases: &mut Cases) {
    let header = *cases.subject.container.header();
    let (head, tables_end) = (HEADER_BYTES as usize, header.tables_end as usize);
    let mut dice = Dice(!cases.subject.seed);
    let mut bits: Vec<usize> = (0..FLIPS).map(|_| dice.below(8 * head)).collect();
    bits.extend((0..FLIPS).map(|_| 8 * head + dice.below(8 * (tables_end - head))));
    bits.sort_unstable();
    bits.dedup();
    for bit in bits {
        let mut bytes = cases.subject.file.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        let code = code_of_flip(&bytes, bit / 8, head + header.contents_bytes as usize);
        let done = format!("bit {} of byte {} flipped", bit % 8, bit / 8);
        cases.give(59, &format!("bit-{bit}"), &done, code, bytes);
    }
}

/// The code of a file with a flipped bit in this byte of header or tables: SPEC.md section 11, order of checks.
///
/// # Panics
/// If the file is shorter than a header.
pub fn code_of_flip(flipped: &[u8], byte: usize, contents_end: usize) -> u32 {
    let (header, _) = Header::from_bytes(flipped.first_chunk().expect("a header"));
    match byte {
        0..8 => 1002, // magic
        8..10 if header.version.0 > VERSION.0 => 1003,
        12..16 => 1006, // the header's size
        8..128 => 1005,
        _ if byte < contents_end => 2002,
        _ => 3002,
    }
}

//! Kind 59: single bits of header and tables flipped, no digest made to fit. A sample of them; the tests flip every
//! one.

use flb_format::records::{HEADER_BYTES, VERSION};

use super::draft::header;
use super::{Cases, Dice};

/// Bits flipped in the header, and in the tables.
const FLIPS: usize = 24;

pub(super) fn cases(cases: &mut Cases) {
    let file = cases.subject.file.clone();
    let contents = cases.subject.container.header().contents_bytes as usize;
    let (head, tables_end) = (HEADER_BYTES as usize, cases.subject.container.header().tables_end as usize);
    let mut dice = Dice(!cases.subject.seed);
    let mut bits: Vec<usize> = (0..FLIPS).map(|_| dice.below(8 * head)).collect();
    bits.extend((0..FLIPS).map(|_| 8 * head + dice.below(8 * (tables_end - head))));
    bits.sort_unstable();
    bits.dedup();
    for bit in bits {
        let mut bytes = file.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        let expected = code_of_flip(&bytes, bit / 8, head + contents);
        let done = format!("bit {} of byte {} flipped", bit % 8, bit / 8);
        cases.give(59, &format!("bit-{bit}"), done, expected, bytes);
    }
}

/// The code of a file with a flipped bit in this byte of header or tables; SPEC.md section 11, order of checks.
pub fn code_of_flip(flipped: &[u8], byte: usize, contents_end: usize) -> u32 {
    let major = u16::from_le_bytes([flipped[header::MAJOR], flipped[header::MAJOR + 1]]);
    match byte {
        ..header::MAJOR => 1002,
        header::MAJOR..header::MINOR if major > VERSION.0 => 1003,
        header::HEADER_BYTES..header::REQUIRED => 1006,
        header::MAJOR..header::HEADER_BYTES | header::REQUIRED..128 => 1005,
        _ if byte < contents_end => 2002,
        _ => 3002,
    }
}

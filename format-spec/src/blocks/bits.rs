//! Fields of bits in 32-bit words, lowest bit first, little-endian: what CPU, WGSL and scripts can all read. A payload
//! of them is filled up with 0 to whole words, of which it has one at least.

use super::{BlockFault, Rule};

/// Appends fields of up to 32 bits.
#[derive(Debug, Default, Clone)]
pub struct BitWriter {
    bytes: Vec<u8>,
    /// Bits of the last, unfinished word.
    pending: u64,
    /// Bits in `pending`, below 32.
    held: u32,
}

impl BitWriter {
    /// Appends the low `width` bits, 0..=32, of a value that has no others.
    pub fn push(&mut self, value: u32, width: u32) {
        debug_assert!(width <= 32 && u64::from(value) >> width == 0, "{value} in {width} bits");
        self.pending |= u64::from(value) << self.held;
        self.held += width;
        if self.held >= 32 {
            self.bytes.extend((self.pending as u32).to_le_bytes());
            self.pending >>= 32;
            self.held -= 32;
        }
    }

    /// The payload, filled up to whole words, one at least.
    pub fn finish(mut self) -> Vec<u8> {
        if self.held > 0 || self.bytes.is_empty() {
            self.bytes.extend((self.pending as u32).to_le_bytes());
        }
        self.bytes
    }
}

/// Reads fields one after another.
#[derive(Debug, Clone)]
pub struct BitReader<'a> {
    bytes: &'a [u8],
    /// Index of the next bit.
    pub at: u64,
}

impl<'a> BitReader<'a> {
    /// Makes a reader from the first bit of a payload.
    pub fn new(bytes: &'a [u8]) -> BitReader<'a> {
        BitReader::from(bytes, 0)
    }

    /// Makes a reader from bit `at` on.
    pub fn from(bytes: &'a [u8], at: u64) -> BitReader<'a> {
        BitReader { bytes, at }
    }

    /// The next 32 bits without taking them; bits past the end are 0.
    #[inline]
    pub fn peek(&self) -> u32 {
        let first = (self.at / 8).min(self.bytes.len() as u64) as usize;
        let mut window = [0; 8];
        match self.bytes[first..].first_chunk::<8>() {
            Some(all) => window = *all,
            None => window[..self.bytes.len() - first].copy_from_slice(&self.bytes[first..]),
        }
        (u64::from_le_bytes(window) >> (self.at % 8)) as u32
    }

    /// The next field of `width` bits, 0..=32; `None` past the end.
    #[inline]
    pub fn take(&mut self, width: u32) -> Option<u32> {
        let value = self.peek();
        self.skip(width)?;
        Some(if width == 32 { value } else { value & ((1 << width) - 1) })
    }

    /// Passes over bits; `None` past the end.
    #[inline]
    pub fn skip(&mut self, width: u32) -> Option<()> {
        self.at += u64::from(width);
        (self.at <= 8 * self.bytes.len() as u64).then_some(())
    }

    /// Copies the next `width` bits to whole bytes, the last filled up with 0. They are there.
    pub fn copy(&mut self, width: u32, bytes: &mut Vec<u8>) {
        for first in (0..width).step_by(32) {
            let bits = 32.min(width - first);
            let word = self.take(bits).expect("the length was checked");
            bytes.extend(&word.to_le_bytes()[..bits.div_ceil(8) as usize]);
        }
    }

    /// Checks that the payload ends here: in this word, with bits of 0.
    pub fn finish(mut self, rule: Rule, what: &str) -> Result<(), BlockFault> {
        let expected = self.at.div_ceil(32).max(1) * 4;
        if self.bytes.len() as u64 != expected {
            return Err(BlockFault::length(rule, what, self.bytes.len(), expected));
        }
        let left = (8 * expected - self.at) as u32;
        match self.take(left) {
            Some(0) => Ok(()),
            found => Err(BlockFault::new(rule, format!("filling behind {what}"), found.unwrap_or(0), "0")),
        }
    }
}

//! What pages hold, before compression: plain floats, runs of blocks, and sparse arrays; encode and
//! decode side by side. SPEC.md section 8.

use half::f16;

use super::records::MAX_MAGNITUDE;
use crate::error::{FormatError, Place};

/// Properties that a page's payload must agree with.
#[derive(Debug, Clone, Copy)]
pub struct PageContext {
    /// Place named in errors.
    pub place: Place,
    /// First unit of the page in its section.
    pub first: u64,
    /// Units of the page.
    pub count: u32,
}

impl PageContext {
    fn length_error(&self, found: usize, expected: u64) -> FormatError {
        FormatError::PayloadLength { place: self.place, found: found as u64, expected }
    }

    /// Checks a number of a base; `index` is its position in the page.
    fn check_value(&self, index: usize, value: f32) -> Result<(), FormatError> {
        // Written so that NaN fails. -0 has one spelling too many.
        if value.abs() <= MAX_MAGNITUDE && value.to_bits() != (-0.0f32).to_bits() {
            return Ok(());
        }
        Err(FormatError::Value {
            place: self.place,
            index: index as u64,
            found: value,
            expected: "a number of magnitude up to 2^96, and 0 written as +0",
        })
    }
}

/// Reads a page of a codec whose units are values: [`decode_raw`], [`decode_raw_f16`].
pub type DecodeRaw = fn(&[u8], PageContext, &mut [f32]) -> Result<(), FormatError>;

/// Appends values as codec 1 (`raw-f32`) stores them; -0 becomes +0.
pub fn encode_raw(values: &[f32], out: &mut Vec<u8>) {
    out.extend(values.iter().flat_map(|value| (value + 0.0).to_le_bytes()));
}

/// Reads a page of codec 1 into `values`, which is as long as the page has units.
pub fn decode_raw(bytes: &[u8], context: PageContext, values: &mut [f32]) -> Result<(), FormatError> {
    let expected = 4 * u64::from(context.count);
    if bytes.len() as u64 != expected {
        return Err(context.length_error(bytes.len(), expected));
    }
    for (index, (value, field)) in values.iter_mut().zip(bytes.as_chunks::<4>().0).enumerate() {
        *value = f32::from_le_bytes(*field);
        context.check_value(index, *value)?;
    }
    Ok(())
}

/// Appends values as codec 6 (`raw-f16`) stores them: the nearest binary16, of two equally near the one with the even
/// last bit; -0 becomes +0. Magnitudes are at most [`MAX_MAGNITUDE_F16`](super::records::MAX_MAGNITUDE_F16).
pub fn encode_raw_f16(values: &[f32], out: &mut Vec<u8>) {
    out.extend(values.iter().flat_map(|value| to_f16(*value).to_le_bytes()));
}

/// Rounds a value as codec 6 (`raw-f16`) does.
pub fn rounded_f16(value: f32) -> f32 {
    to_f16(value).to_f32_const()
}

/// By `half`'s integer arithmetic: its other conversions pick an instruction of the CPU at run time.
fn to_f16(value: f32) -> f16 {
    let rounded = f16::from_f32_const(value);
    if rounded.to_bits() == f16::NEG_ZERO.to_bits() { f16::ZERO } else { rounded }
}

/// Reads a page of codec 6 into `values`, which is as long as the page has units.
pub fn decode_raw_f16(bytes: &[u8], context: PageContext, values: &mut [f32]) -> Result<(), FormatError> {
    let expected = 2 * u64::from(context.count);
    if bytes.len() as u64 != expected {
        return Err(context.length_error(bytes.len(), expected));
    }
    for (index, (value, field)) in values.iter_mut().zip(bytes.as_chunks::<2>().0).enumerate() {
        *value = f16::from_le_bytes(*field).to_f32_const();
        context.check_value(index, *value)?;
    }
    Ok(())
}

/// A page of codec 2 (`haar-paper`): consecutive blocks in `[z][y][x]` order, x fastest.
///
/// Invariant of one that was read: `index` is the running sum of the masks' bits, and
/// `coefficients` is as long as all masks' bits times the bands.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BlockPage {
    /// Index of the first block in its base.
    pub first_block: u32,
    /// `[block]` which coefficients are kept.
    pub masks: Vec<u64>,
    /// `[block]` first coefficient of the block, in units of `bands` floats.
    pub index: Vec<u32>,
    /// Values of the kept coefficients, `[kept][band]`.
    pub coefficients: Vec<f32>,
}

/// Bytes of a block's mask and index.
const BLOCK_HEAD_BYTES: u64 = 12;

impl BlockPage {
    /// Bytes of a block with this mask.
    pub fn block_bytes(mask: u64, bands: u32) -> u32 {
        BLOCK_HEAD_BYTES as u32 + 4 * mask.count_ones() * bands
    }

    /// Adds a block with its kept coefficients, `[kept][band]`.
    pub fn push(&mut self, mask: u64, coefficients: &[f32], bands: usize) {
        self.masks.push(mask);
        self.index.push((self.coefficients.len() / bands) as u32);
        self.coefficients.extend_from_slice(coefficients);
    }

    /// Of `all` bands these alone, in this order.
    pub(super) fn with_bands(self, all: usize, bands: &[usize]) -> BlockPage {
        let kept = self.coefficients.chunks_exact(all);
        let coefficients = kept.flat_map(|values| bands.iter().map(|&band| values[band])).collect();
        BlockPage { coefficients, ..self }
    }

    /// The mask and the kept coefficients of the page's `i`-th block.
    pub fn block(&self, i: usize, bands: usize) -> (u64, &[f32]) {
        let mask = self.masks[i];
        let kept = mask.count_ones() as usize * bands;
        (mask, &self.coefficients[self.index[i] as usize * bands..][..kept])
    }

    /// The payload: all masks, all indices, all coefficients.
    pub fn to_bytes(&self) -> Vec<u8> {
        let size = self.masks.len() * BLOCK_HEAD_BYTES as usize + self.coefficients.len() * 4;
        let mut bytes = Vec::with_capacity(size);
        bytes.extend(self.masks.iter().flat_map(|mask| mask.to_le_bytes()));
        bytes.extend(self.index.iter().flat_map(|index| index.to_le_bytes()));
        encode_raw(&self.coefficients, &mut bytes);
        bytes
    }

    /// Reads and checks a payload. `threshold` is absolute, in the field's unit.
    pub fn from_bytes(
        bytes: &[u8],
        context: PageContext,
        bands: u32,
        threshold: f32,
    ) -> Result<BlockPage, FormatError> {
        let count = context.count as usize;
        let head = BLOCK_HEAD_BYTES * u64::from(context.count);
        if (bytes.len() as u64) < head {
            return Err(context.length_error(bytes.len(), head));
        }
        let (masks, rest) = bytes.split_at(8 * count);
        let (index, coefficients) = rest.split_at(4 * count);
        let masks: Vec<u64> = masks.as_chunks().0.iter().map(|b| u64::from_le_bytes(*b)).collect();
        let index: Vec<u32> = index.as_chunks().0.iter().map(|b| u32::from_le_bytes(*b)).collect();

        let mut kept = 0u64;
        for (i, (mask, found)) in masks.iter().zip(&index).enumerate() {
            if u64::from(*found) != kept {
                let block = (context.first + i as u64) as u32;
                return Err(FormatError::BlockIndex {
                    place: context.place,
                    block,
                    found: *found,
                    expected: kept,
                });
            }
            kept += u64::from(mask.count_ones());
        }
        let expected = head + 4 * kept * u64::from(bands);
        if bytes.len() as u64 != expected {
            return Err(context.length_error(bytes.len(), expected));
        }
        let coefficients: Vec<f32> =
            coefficients.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
        for (i, value) in coefficients.iter().enumerate() {
            context.check_value(i, *value)?;
        }
        let page = BlockPage { first_block: context.first as u32, masks, index, coefficients };
        page.check_kept(context.place, bands as usize, threshold)?;
        Ok(page)
    }

    /// Bit 0 is set only for an average that is not 0, others only above the threshold.
    fn check_kept(&self, place: Place, bands: usize, threshold: f32) -> Result<(), FormatError> {
        let mut kept = self.coefficients.chunks_exact(bands);
        for (i, &mask) in self.masks.iter().enumerate() {
            let mut left = mask;
            while left != 0 {
                let coefficient = left.trailing_zeros();
                left &= left - 1;
                let values = kept.next().expect("the masks' bits were counted");
                let limit = if coefficient == 0 { 0.0 } else { threshold };
                if !values.iter().any(|value| value.abs() > limit) {
                    let block = self.first_block + i as u32;
                    let expected = format!("a magnitude above {limit} in some band");
                    return Err(FormatError::Coefficient { place, block, coefficient, expected });
                }
            }
        }
        Ok(())
    }
}

/// The absolute threshold of a base: its value in empty space
/// ([`Model::empty_value`](crate::model::Model::empty_value)) times the relative one, in f32.
pub fn absolute_threshold(empty_value: f32, relative: f32) -> f32 {
    relative * empty_value
}

/// Values under one mask of a sparse page.
pub const SPARSE_GROUP: usize = 64;

/// A value that a sparse array holds.
///
/// Two kinds exist: f32 (codec 3) and u8 (codec 4).
pub trait SparseValue: Copy + Default {
    /// Bytes of a value.
    const BYTES: usize;
    /// Whether the value is left out of the stream.
    fn is_zero(self) -> bool;
    /// Appends the value.
    fn write(self, out: &mut Vec<u8>);
    /// Reads the value from `BYTES` bytes.
    fn read(bytes: &[u8]) -> Self;
    /// Whether the value may stand in the stream.
    fn check(self) -> Result<(), (f32, &'static str)>;
}

impl SparseValue for f32 {
    const BYTES: usize = 4;

    fn is_zero(self) -> bool {
        self == 0.0
    }

    fn write(self, out: &mut Vec<u8>) {
        out.extend(self.to_le_bytes());
    }

    fn read(bytes: &[u8]) -> f32 {
        f32::from_le_bytes(bytes.try_into().expect("four bytes were split off"))
    }

    fn check(self) -> Result<(), (f32, &'static str)> {
        let fits = self > 0.0 && self <= MAX_MAGNITUDE;
        if fits { Ok(()) } else { Err((self, "a number above 0, up to 2^96")) }
    }
}

impl SparseValue for u8 {
    const BYTES: usize = 1;

    fn is_zero(self) -> bool {
        self == 0
    }

    fn write(self, out: &mut Vec<u8>) {
        out.push(self);
    }

    fn read(bytes: &[u8]) -> u8 {
        bytes[0]
    }

    fn check(self) -> Result<(), (f32, &'static str)> {
        let fits = self == 1 || self == 2;
        if fits { Ok(()) } else { Err((f32::from(self), "class 1 (leaf) or 2 (wood)")) }
    }
}

/// Bytes of one group of a sparse page.
pub fn sparse_group_bytes<T: SparseValue>(group: &[T]) -> usize {
    8 + T::BYTES * group.iter().filter(|value| !value.is_zero()).count()
}

/// The payload of a sparse page: a mask per 64 values, then the values that are not 0.
/// `values` is a multiple of 64 long.
pub fn encode_sparse<T: SparseValue>(values: &[T]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for group in values.chunks_exact(SPARSE_GROUP) {
        let mask = (0..SPARSE_GROUP).filter(|&i| !group[i].is_zero()).fold(0u64, |m, i| m | 1 << i);
        bytes.extend(mask.to_le_bytes());
    }
    for value in values.iter().filter(|value| !value.is_zero()) {
        value.write(&mut bytes);
    }
    bytes
}

/// Reads a sparse page into `values`, which is as long as the page has units.
pub fn decode_sparse<T: SparseValue>(
    bytes: &[u8],
    context: PageContext,
    values: &mut [T],
) -> Result<(), FormatError> {
    let head = values.len() / SPARSE_GROUP * 8;
    if bytes.len() < head {
        return Err(context.length_error(bytes.len(), head as u64));
    }
    let (masks, stream) = bytes.split_at(head);
    let masks = masks.as_chunks().0.iter().map(|b| u64::from_le_bytes(*b));
    let kept: u64 = masks.clone().map(|mask| u64::from(mask.count_ones())).sum();
    let expected = head as u64 + kept * T::BYTES as u64;
    if bytes.len() as u64 != expected {
        return Err(context.length_error(bytes.len(), expected));
    }
    let mut stream = stream.chunks_exact(T::BYTES);
    for (g, (group, mask)) in values.chunks_exact_mut(SPARSE_GROUP).zip(masks).enumerate() {
        for (i, value) in group.iter_mut().enumerate() {
            *value = T::default();
            if mask >> i & 1 == 1 {
                *value = T::read(stream.next().expect("the masks' bits were counted"));
                value.check().map_err(|(found, expected)| FormatError::Value {
                    place: context.place,
                    index: (g * SPARSE_GROUP + i) as u64,
                    found,
                    expected,
                })?;
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;

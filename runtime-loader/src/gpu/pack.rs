//! Blocks of a [`CodedBase`] to the words that light.wgsl evaluates.
//!
//! ```text
//! record: 1 + components words
//!   word 0      place of its nibbles in the buffer (bits 0 to 24), whether it goes on (25), shift (26 to 31)
//!   word 1 + c  average (low half, i16); mask of component c (high half)
//! nibbles of a record: the words of component 0, of component 1, ...
//!   where it goes on, then a record of the digits above, which has averages of 0, and its nibbles
//! ```
//!
//! A file's fields have any width, so that one is found by its class; that costs a GPU a fetch for each coefficient.
//! Here eight coefficients that follow one another (an octet: two rows along x) are a word of eight signed nibbles,
//! lowest first. Larger values have a word for each of their digits in base 16, from -8 to 7: the planes, two in a
//! record. Bit `8 * plane + octet` of a mask says that a word is there; words are in the order of their bits. So each
//! word that is fetched gives eight coefficients, no table is needed, and a block without detail is its record.
//! `classed` and `haar` differ in their rows alone. Coefficients are in their own order and not in that of the base's
//! axes: 5 % more words, and weights that all bases share.
//!
//! On the built-in oak at lattice 128, 19 bases of two components (three bands, the third component dropped), a block
//! takes 12 bytes of record and 33 of nibbles; the CPU's 12 and 10.

use flb_format::blocks::{CodedBase, Coding, MAX_HALVINGS, TEXELS};

/// Coefficients of a word.
pub(super) const OCTET: usize = 8;
/// Octets of a block.
pub(super) const OCTETS: u32 = 8;
/// Bits of a place.
pub(super) const PLACE_BITS: u32 = 25;
/// Bit of a record that says that it goes on: with a record behind its nibbles.
pub(super) const WIDE: u32 = 1 << PLACE_BITS;
/// First bit of a record's shift.
pub(super) const SHIFT: u32 = PLACE_BITS + 1;
/// Digits of a record.
const PLANES: u32 = 2;

/// Blocks of a page, packed.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub(super) struct PackedPage {
    /// `[block][1 + component]`; places count from the first of `nibbles`, until they are moved.
    pub records: Vec<u32>,
    /// Words of all blocks.
    pub nibbles: Vec<u32>,
    /// Places in `nibbles` of further records.
    further: Vec<usize>,
}

impl PackedPage {
    /// Moves the nibbles from the first word of a buffer to another.
    pub(super) fn place(&mut self, components: usize, first_word: u32) {
        self.records.iter_mut().step_by(1 + components).for_each(|word| *word += first_word);
        self.further.iter().for_each(|at| self.nibbles[*at] += first_word);
    }
}

/// Packs `count` blocks from rank `first` on, which the base has; those whose detail was not added are their averages.
pub(super) fn pack_page(base: &CodedBase, first: usize, count: usize) -> PackedPage {
    let mut page = PackedPage::default();
    (first..first + count).for_each(|rank| pack_block(base, rank, &mut page));
    page
}

fn pack_block(base: &CodedBase, rank: usize, page: &mut PackedPage) {
    // `haar` stores whole steps, which are even half steps.
    let shift = MAX_HALVINGS - base.halvings(rank) + u32::from(base.shared().coding == Coding::Haar);
    let mut values = vec![[0; TEXELS]; base.head().components()];
    if base.is_detailed(rank) {
        for (component, values) in values.iter_mut().enumerate() {
            *values = base.coefficients(rank, component).map(|value| value >> shift);
            values[0] = 0;
        }
    }
    let (mut record, words) = pack_digits(&mut values, page.nibbles.len(), shift);
    for (component, word) in record[1..].iter_mut().enumerate() {
        *word |= u32::from(base.average(rank, component) as u16);
    }
    page.nibbles.extend(words);
    if values.iter().flatten().any(|value| *value != 0) {
        record[0] |= WIDE;
        let at = page.nibbles.len();
        let (further, words) = pack_digits(&mut values, at + record.len(), shift + 4 * PLANES);
        page.further.push(at);
        page.nibbles.extend(further);
        page.nibbles.extend(words);
    }
    page.records.extend(record);
}

/// A record of the lowest two digits of each component, without averages, and its words; leaves the digits above.
fn pack_digits(values: &mut [[i32; TEXELS]], place: usize, shift: u32) -> (Vec<u32>, Vec<u32>) {
    let (mut record, mut words) = (vec![place as u32 | shift << SHIFT], Vec::new());
    record.extend(values.iter_mut().map(|values| pack_planes(values, &mut words) << 16));
    (record, words)
}

/// Appends the words of the lowest two digits of a component's values, tells their mask, and leaves the digits above.
fn pack_planes(values: &mut [i32], words: &mut Vec<u32>) -> u32 {
    let mut mask = 0;
    for plane in 0..PLANES {
        for (octet, values) in values.chunks_exact_mut(OCTET).enumerate() {
            let mut word = 0;
            for (lane, value) in values.iter_mut().enumerate() {
                let digit = ((*value + 8) & 15) - 8;
                *value = (*value - digit) >> 4;
                word |= (digit as u32 & 15) << (4 * lane);
            }
            if word != 0 {
                mask |= 1 << (OCTETS * plane + octet as u32);
                words.push(word);
            }
        }
    }
    mask
}

#[cfg(test)]
pub(super) mod twin {
    //! What light.wgsl reads of a record, in Rust.

    use super::*;

    /// Coefficients by index, in sixteenths of a step, of a component of a record at a word of the buffer.
    pub(crate) fn coefficients(
        words: &[u32],
        record: usize,
        components: usize,
        component: usize,
    ) -> [i32; TEXELS] {
        let head = words[record];
        let mut at = (head & (WIDE - 1)) as usize;
        let mut values = [0; TEXELS];
        for c in 0..components {
            let mask = words[record + 1 + c] >> 16;
            for bit in (0..PLANES * OCTETS).filter(|bit| mask >> bit & 1 == 1) {
                let (plane, octet) = (bit / OCTETS, (bit % OCTETS) as usize);
                for lane in (0..OCTET).filter(|_| c == component) {
                    let digit = (words[at] << (28 - 4 * lane)) as i32 >> 28;
                    values[OCTET * octet + lane] += digit << (4 * plane + (head >> SHIFT));
                }
                at += 1;
            }
        }
        values[0] = i32::from(words[record + 1 + component] as u16 as i16) * 16;
        if head & WIDE != 0 {
            let further = coefficients(words, at, components, component);
            values.iter_mut().zip(further).for_each(|(value, further)| *value += further);
        }
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_of_every_value_add_up_to_it() {
        for value in -2048..=2047 {
            let mut values = [0; TEXELS];
            values[13] = value;
            let mut sum = 0;
            for first_plane in [0, PLANES] {
                let mut words = Vec::new();
                let mask = pack_planes(&mut values, &mut words);
                assert_eq!(words.len(), mask.count_ones() as usize);
                let planes = (0..PLANES).filter(|plane| mask >> (OCTETS * plane + 1) & 1 == 1);
                sum += planes
                    .zip(&words)
                    .map(|(p, w)| ((w << 8) as i32 >> 28) << (4 * (first_plane + p)))
                    .sum::<i32>();
            }
            assert_eq!(sum, value);
            assert!(values.iter().all(|left| *left == 0));
        }
    }
}

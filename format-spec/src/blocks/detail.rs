//! Pages of detail: the coefficients of a range of stored blocks but for their averages, in one of two codings.
//!
//! `classed`: class numbers of all blocks, component by component; then the fields of block after block. `haar`: widths
//! of all blocks, component by component; a mask for every block and component of a width above 0; then the fields.
//! Fields follow one another without gaps, so that the first bit of a block is a sum of lengths before it.

use super::bits::{BitReader, BitWriter};
use super::classes::{Classes, fields};
use super::transform::{self, Rows};
use super::{BlockFault, MAX_WIDTH, Rule, TEXELS};

/// Coding of the detail of a species' bases.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Coding {
    /// Classes of blocks over [`transform::SMOOTH`].
    Classed(Classes),
    /// A mask and a width for each block over [`transform::HAAR`].
    Haar,
}

/// The detail of one component of one block, as an encoder chose it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CodedBlock {
    /// Class in the component's table; the width of `haar`.
    pub class: u16,
    /// Coefficients by index, in half steps of the block; `[0]` is the average in whole steps of the base.
    pub values: [i16; TEXELS],
}

/// Bits of a width of `haar`.
const WIDTH_BITS: u32 = 4;

impl Coding {
    /// Rows of the transform.
    pub fn rows(&self) -> &'static Rows {
        match self {
            Coding::Classed(_) => &transform::SMOOTH,
            Coding::Haar => &transform::HAAR,
        }
    }

    /// Class or width that stands for a block whose detail was not read: no fields.
    pub fn none(&self) -> u16 {
        match self {
            Coding::Classed(classes) => classes.none(),
            Coding::Haar => 0,
        }
    }
}

/// The detail of a page, ready to be read from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Detail {
    /// `[block][component]`: number of the class over both tables; the width of `haar`.
    pub classes: Vec<u16>,
    /// `[block][component]` of `haar`: bit `place` says that a coefficient is stored. Empty for `classed`.
    pub masks: Vec<u64>,
    /// `[block]` first bit of its fields in the payload.
    pub starts: Vec<u64>,
}

/// The field of a coefficient of `haar`, which is even and not 0: its half, less one if it is above 0, from the lowest.
fn mask_field(value: i16, width: u32) -> u32 {
    let half = i32::from(value) / 2;
    (half - i32::from(half > 0) + (1 << (width - 1))) as u32
}

/// The coefficient of `haar`, in half steps, of a field.
#[inline]
pub fn mask_value(field: u32, width: u32) -> i32 {
    let value = field as i32 - (1 << (width - 1));
    2 * (value + i32::from(value >= 0))
}

/// The payload of a page; `blocks` is `[block][component]`, `order` that of [`super::Head::order`].
///
/// # Panics
/// If a value does not fit its width, or the blocks are no multiple of the components.
pub fn encode(coding: &Coding, order: &[u8; TEXELS], components: usize, blocks: &[CodedBlock]) -> Vec<u8> {
    assert_eq!(blocks.len() % components, 0, "whole blocks");
    let mut out = BitWriter::default();
    let classes = (0..components)
        .flat_map(|c| blocks.chunks_exact(components).map(move |block| (c, u32::from(block[c].class))));
    match coding {
        Coding::Classed(tables) => {
            classes.for_each(|(c, class)| out.push(class, tables.tables[Classes::table(c)].class_bits()));
            for (i, block) in blocks.iter().enumerate() {
                let table = &tables.tables[Classes::table(i % components)];
                for (place, width) in fields(&table.widths()[usize::from(block.class)]) {
                    let value = i32::from(block.values[usize::from(order[place as usize])]);
                    let bits = (value + (1 << width) - 1) >> 1;
                    assert!(bits >> width == 0 && value & 1 == 1, "{value}: an odd value in {width} bits");
                    out.push(bits as u32, width);
                }
            }
        }
        Coding::Haar => {
            classes.for_each(|(_, width)| out.push(width, WIDTH_BITS));
            let stored = |block: &CodedBlock| {
                let values = block.values;
                (1..TEXELS).filter(move |place| values[usize::from(order[*place])] != 0)
            };
            for block in blocks.iter().filter(|b| b.class > 0) {
                let mask = stored(block).fold(0u64, |mask, place| mask | 1 << place);
                out.push(mask as u32, 32);
                out.push((mask >> 32) as u32, 32);
            }
            for block in blocks {
                for place in stored(block) {
                    let (value, width) = (block.values[usize::from(order[place])], u32::from(block.class));
                    let field = mask_field(value, width);
                    assert_eq!(mask_value(field, width), i32::from(value), "an even value in its width");
                    out.push(field, width);
                }
            }
        }
    }
    out.finish()
}

/// Reads the heads of a payload of `count` blocks and checks that it has their fields and nothing else.
///
/// # Errors
/// [`Rule::DetailLength`], [`Rule::BlockClass`], [`Rule::BlockMask`].
pub fn parse(coding: &Coding, components: usize, count: usize, bytes: &[u8]) -> Result<Detail, BlockFault> {
    let mut reader = BitReader::new(bytes);
    let head_bits: u64 = match coding {
        Coding::Classed(tables) => (0..components)
            .map(|c| u64::from(tables.tables[Classes::table(c)].class_bits()) * count as u64)
            .sum(),
        Coding::Haar => u64::from(WIDTH_BITS) * (components * count) as u64,
    };
    let cut = |bits: u64| {
        let expected = format!("{} or more", bits.div_ceil(32) * 4);
        BlockFault::length(Rule::DetailLength, "a page of detail", bytes.len(), expected)
    };
    if 8 * (bytes.len() as u64) < head_bits {
        return Err(cut(head_bits));
    }
    let mut classes = vec![0; components * count];
    for c in 0..components {
        for block in 0..count {
            classes[block * components + c] = read_class(coding, c, block, &mut reader)?;
        }
    }
    let (masks, lengths) = match coding {
        Coding::Classed(tables) => {
            (Vec::new(), classes.iter().map(|number| u64::from(tables.bits(*number))).collect::<Vec<_>>())
        }
        Coding::Haar => {
            let masks = read_masks(&classes, components, &mut reader, cut)?;
            let bits = |(mask, width): (&u64, &u16)| u64::from(mask.count_ones()) * u64::from(*width);
            let lengths = masks.iter().zip(&classes).map(bits).collect();
            (masks, lengths)
        }
    };
    let mut starts = Vec::with_capacity(count);
    for block in lengths.chunks_exact(components) {
        starts.push(reader.at);
        reader.at += block.iter().sum::<u64>();
    }
    if *coding == Coding::Haar {
        check_widths(&classes, &masks, &starts, components, bytes)?;
    }
    reader.finish(Rule::DetailLength, "a page of detail")?;
    Ok(Detail { classes, masks, starts })
}

/// A class over both tables, or a width; its bits are there.
fn read_class(coding: &Coding, c: usize, block: usize, reader: &mut BitReader) -> Result<u16, BlockFault> {
    let width = match coding {
        Coding::Classed(tables) => tables.tables[Classes::table(c)].class_bits(),
        Coding::Haar => WIDTH_BITS,
    };
    let found = reader.take(width).expect("the length of the heads was checked");
    match coding {
        Coding::Classed(tables) => {
            let count = tables.tables[Classes::table(c)].widths().len();
            if found as usize >= count {
                let what = format!("the class of component {c} of block {block}");
                return Err(BlockFault::new(Rule::BlockClass, what, found, format!("below {count}")));
            }
            Ok(tables.number(c, found))
        }
        Coding::Haar if found > u32::from(MAX_WIDTH) => {
            let what = format!("the width of component {c} of block {block}");
            Err(BlockFault::new(Rule::BlockMask, what, found, format!("0 to {MAX_WIDTH}")))
        }
        Coding::Haar => Ok(found as u16),
    }
}

fn read_masks(
    widths: &[u16],
    components: usize,
    reader: &mut BitReader,
    cut: impl Fn(u64) -> BlockFault,
) -> Result<Vec<u64>, BlockFault> {
    let mut masks = Vec::with_capacity(widths.len());
    for (i, width) in widths.iter().enumerate() {
        if *width == 0 {
            masks.push(0);
            continue;
        }
        let at = reader.at;
        let (Some(low), Some(high)) = (reader.take(32), reader.take(32)) else { return Err(cut(at + 64)) };
        let mask = u64::from(low) | u64::from(high) << 32;
        if mask == 0 || mask & 1 == 1 {
            let what = format!("the mask of component {} of block {}", i % components, i / components);
            let expected = "at least one bit, and not bit 0";
            return Err(BlockFault::new(Rule::BlockMask, what, format!("{mask:#018x}"), expected));
        }
        masks.push(mask);
    }
    Ok(masks)
}

/// Widths are the least that hold their values: a magnitude is above half of the largest.
fn check_widths(
    widths: &[u16],
    masks: &[u64],
    starts: &[u64],
    components: usize,
    bytes: &[u8],
) -> Result<(), BlockFault> {
    for (block, start) in starts.iter().enumerate() {
        let mut reader = BitReader::from(bytes, *start);
        for c in 0..components {
            let width = u32::from(widths[block * components + c]);
            let mut largest = 0;
            for _ in 0..masks[block * components + c].count_ones() {
                let Some(field) = reader.take(width) else { return Ok(()) }; // the length is refused next
                largest = largest.max(mask_value(field, width).abs() / 2);
            }
            if width > 1 && largest <= 1 << (width - 2) {
                let what = format!("the width of component {c} of block {block}");
                let expected = format!("the least that holds {largest}");
                return Err(BlockFault::new(Rule::BlockMask, what, width, expected));
            }
        }
    }
    Ok(())
}

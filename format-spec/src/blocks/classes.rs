//! Classes of the coding `classed`: for each, how many bits every coefficient of a block has. A block's length and the
//! place of every field follow from its class, so no mask is stored and nothing is parsed.

use super::{BlockFault, MAX_WIDTH, Rule, TEXELS};

/// Coefficients that a class speaks of: all but the average.
pub const DETAILS: usize = TEXELS - 1;
/// Largest number of classes of a table.
pub const MAX_CLASSES: usize = 256;
/// Bytes of a class: 63 widths of 4 bits, and 4 bits of 0.
const CLASS_BYTES: usize = 32;
/// Bytes of the counts of both tables.
const COUNT_BYTES: usize = 4;

/// Bytes of a payload, least and most.
pub const BYTES: std::ops::RangeInclusive<u64> =
    (COUNT_BYTES + 2 * CLASS_BYTES) as u64..=(COUNT_BYTES + 2 * MAX_CLASSES * CLASS_BYTES) as u64;

/// Widths in bits, `[place - 1]`; places are in the order of [`super::Head::order`].
pub type Widths = [u8; DETAILS];

/// Fields that are read at once.
pub const LANES: usize = 8;
/// Bytes from the first of a group's fields on in which all of them lie.
pub const GROUP_BYTES: usize = 16;

/// Fields of a class in their order, the widest first, then by place: `(place, width)`.
pub fn fields(widths: &Widths) -> impl Iterator<Item = (u32, u32)> {
    (1..=MAX_WIDTH).rev().flat_map(move |width| {
        (1..).zip(widths).filter(move |(_, w)| **w == width).map(move |(place, _)| (place, u32::from(width)))
    })
}

/// Bits of a block of a class.
pub fn bits(widths: &Widths) -> u32 {
    widths.iter().map(|w| u32::from(*w)).sum()
}

/// The classes of a table.
///
/// Invariant: 1 to 256, no width above [`MAX_WIDTH`], strictly ascending by (bits, widths).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClassTable {
    widths: Vec<Widths>,
}

impl ClassTable {
    /// A table of these classes, in its order and each once.
    ///
    /// # Panics
    /// If there is none, more than 256, or a width above [`MAX_WIDTH`].
    pub fn new(mut widths: Vec<Widths>) -> ClassTable {
        widths.sort_unstable_by_key(|w| (bits(w), *w));
        widths.dedup();
        assert!((1..=MAX_CLASSES).contains(&widths.len()), "{} classes, expected 1 to 256", widths.len());
        assert!(widths.iter().flatten().all(|w| *w <= MAX_WIDTH), "widths up to {MAX_WIDTH}");
        ClassTable { widths }
    }

    /// Widths of each class, `[class]`.
    pub fn widths(&self) -> &[Widths] {
        &self.widths
    }

    /// Bits of a class's number.
    pub fn class_bits(&self) -> u32 {
        usize::BITS - (self.widths.len() - 1).leading_zeros()
    }
}

/// The two tables of a species: for the first component of each base, and for all others.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Classes {
    /// Class tables as stored.
    pub tables: [ClassTable; 2],
    programs: Programs,
}

/// How blocks of all classes are read: those of the first table, then of the second, then one class without fields.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Programs {
    /// `[class]`: first and end in `groups`, and bits.
    classes: Vec<[u32; 3]>,
    groups: Vec<FieldGroup>,
}

/// Fields that are read at once: eight that follow one another, the last of a class filled up with fields of no bits.
///
/// Invariant: its fields lie within 16 bytes from [`FieldGroup::first_byte`] on, since a field has at most
/// [`MAX_WIDTH`] bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(align(32))]
pub struct FieldGroup {
    /// `[lane][byte]`: which bytes behind the first one hold a field.
    pub bytes: [[u8; 4]; LANES],
    /// `[lane]`: place (bits 0 to 5), bits below the field in its bytes (8 to 10), the group's first byte (16 to 23),
    /// and the highest bit of the place again (31).
    pub code: [u32; LANES],
    /// `[lane]`: 2^width - 1; 0 of filling.
    pub mask: [u32; LANES],
}

impl FieldGroup {
    /// Of fields `(place, width)`, the first of them at a bit of the block's component.
    fn new(first_bit: u32, fields: &[(u32, u32)]) -> FieldGroup {
        let first_byte = first_bit / 8;
        let mut group =
            FieldGroup { bytes: [[0; 4]; LANES], code: [first_byte << 16; LANES], mask: [0; LANES] };
        let mut bit = first_bit;
        for (lane, (place, width)) in fields.iter().enumerate() {
            let byte = (bit / 8 - first_byte) as u8;
            group.bytes[lane] = [byte, byte + 1, byte + 2, byte + 3];
            group.code[lane] |= place | (bit % 8) << 8 | (place >> 5) << 31;
            group.mask[lane] = (1 << width) - 1;
            bit += width;
        }
        group
    }

    /// First byte of the block's component that the fields lie in.
    #[inline(always)]
    pub fn first_byte(&self) -> usize {
        (self.code[0] >> 16 & 255) as usize
    }

    /// Place of a lane's coefficient, 1..=63; 0 of filling.
    #[inline(always)]
    pub fn place(&self, lane: usize) -> usize {
        (self.code[lane] & 63) as usize
    }

    /// A lane's coefficient in half steps, `2 u + 1 - 2^width` of the field `u`: odd, of magnitude below 2^width; 0 of
    /// filling. `window` begins with the group's first byte.
    #[inline(always)]
    pub fn value(&self, lane: usize, window: &[u8; GROUP_BYTES]) -> i32 {
        let word = u32::from_le_bytes(self.bytes[lane].map(|byte| window[usize::from(byte) % GROUP_BYTES]));
        (2 * (word >> (self.code[lane] >> 8 & 7) & self.mask[lane])) as i32 - self.mask[lane] as i32
    }
}

impl Classes {
    /// Memory that they take.
    pub fn size_bytes(&self) -> usize {
        let tables: usize = self.tables.iter().map(|table| size_of_val(&table.widths[..])).sum();
        tables + size_of_val(&self.programs.classes[..]) + size_of_val(&self.programs.groups[..])
    }

    /// Builds the reading programs of two tables.
    pub fn new(tables: [ClassTable; 2]) -> Classes {
        let mut programs = Programs { classes: Vec::new(), groups: Vec::new() };
        for widths in tables.iter().flat_map(|t| &t.widths).chain(&[[0; DETAILS]]) {
            let first = programs.groups.len() as u32;
            let fields: Vec<(u32, u32)> = fields(widths).collect();
            let mut bit = 0;
            for fields in fields.chunks(LANES) {
                programs.groups.push(FieldGroup::new(bit, fields));
                bit += fields.iter().map(|(_, width)| width).sum::<u32>();
            }
            programs.classes.push([first, programs.groups.len() as u32, bit]);
        }
        Classes { tables, programs }
    }

    /// Index of the table that serves a component.
    pub fn table(component: usize) -> usize {
        component.min(1)
    }

    /// Number over both tables of a component's class.
    pub fn number(&self, component: usize, class: u32) -> u16 {
        (Classes::table(component) * self.tables[0].widths.len()) as u16 + class as u16
    }

    /// Number of the class without fields, which stands for detail that was not read.
    pub fn none(&self) -> u16 {
        (self.programs.classes.len() - 1) as u16
    }

    /// Bits of a block of a class, by its number.
    #[inline(always)]
    pub fn bits(&self, number: u16) -> u32 {
        self.programs.classes[usize::from(number)][2]
    }

    /// Bytes of a block's component of a class, by its number, where it begins and ends with a byte.
    #[inline(always)]
    pub fn bytes(&self, number: u16) -> usize {
        self.bits(number).div_ceil(8) as usize
    }

    /// Fields of a class, by its number.
    #[inline(always)]
    pub fn groups(&self, number: u16) -> &[FieldGroup] {
        let [first, end, _] = self.programs.classes[usize::from(number)];
        &self.programs.groups[first as usize..end as usize]
    }

    /// The payload: two counts of 16 bits, then the classes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes: Vec<u8> =
            self.tables.iter().flat_map(|t| (t.widths.len() as u16).to_le_bytes()).collect();
        for widths in self.tables.iter().flat_map(|t| &t.widths) {
            let width = |i: usize| widths.get(i).copied().unwrap_or(0);
            bytes.extend((0..CLASS_BYTES).map(|i| width(2 * i) | width(2 * i + 1) << 4));
        }
        bytes
    }

    /// Reads a payload.
    ///
    /// # Errors
    /// [`Rule::ClassesLength`], [`Rule::ClassWidth`], [`Rule::ClassOrder`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Classes, BlockFault> {
        let Some((counts, rest)) = bytes.split_first_chunk::<COUNT_BYTES>() else {
            let expected = format!("{COUNT_BYTES} or more");
            return Err(BlockFault::length(Rule::ClassesLength, "the class tables", bytes.len(), expected));
        };
        let counts =
            [[counts[0], counts[1]], [counts[2], counts[3]]].map(|c| usize::from(u16::from_le_bytes(c)));
        for (table, count) in counts.iter().enumerate() {
            if !(1..=MAX_CLASSES).contains(count) {
                let what = format!("the number of classes of table {table}");
                return Err(BlockFault::new(Rule::ClassesLength, what, count, "1 to 256"));
            }
        }
        let expected = COUNT_BYTES + CLASS_BYTES * (counts[0] + counts[1]);
        if bytes.len() != expected {
            return Err(BlockFault::length(Rule::ClassesLength, "the class tables", bytes.len(), expected));
        }
        let (first, second) = rest.as_chunks::<CLASS_BYTES>().0.split_at(counts[0]);
        Ok(Classes::new([read_table(first, 0)?, read_table(second, 1)?]))
    }
}

fn read_table(classes: &[[u8; CLASS_BYTES]], table: usize) -> Result<ClassTable, BlockFault> {
    let mut widths: Vec<Widths> = Vec::with_capacity(classes.len());
    for (class, bytes) in classes.iter().enumerate() {
        let width = |i: usize| bytes[i / 2] >> (4 * (i % 2)) & 15;
        for i in 0..2 * CLASS_BYTES {
            let most = if i < DETAILS { MAX_WIDTH } else { 0 };
            if width(i) > most {
                let what = format!("width {i} of class {class} of table {table}");
                return Err(BlockFault::new(Rule::ClassWidth, what, width(i), format!("0 to {most}")));
            }
        }
        let next: Widths = std::array::from_fn(width);
        if let Some(last) = widths.last()
            && (bits(last), last) >= (bits(&next), &next)
        {
            let what = format!("class {class} of table {table} of {} bits", bits(&next));
            return Err(BlockFault::new(
                Rule::ClassOrder,
                what,
                "not above the one before",
                "ascending order",
            ));
        }
        widths.push(next);
    }
    Ok(ClassTable { widths })
}

//! The averages of a base's blocks: what it can be read from before any detail, at a quarter of the resolution.
//!
//! An average is predicted from the stored neighbours before it, and the differences are in Rice codes (Rice and Plaunt
//! 1971), whose parameter is chosen for every [`GROUP`]. A reader expands them when it loads a base, so nothing here is
//! addressed by itself. The coarse averages ([`super::coarse`]) go first, coded in the same way.

use super::bits::{BitReader, BitWriter};
use super::coarse::COARSE_EDGE;
use super::map::BlockMap;
use super::{BlockFault, EDGE, Rule};

/// Averages that share a Rice parameter.
pub const GROUP: usize = 32;
/// A quotient of this or more is written as this many ones, and the whole number follows.
const ESCAPE: u32 = 20;
/// Bits of a number that follows an escape: the zigzag of a difference of two `i16`.
const ESCAPED_BITS: u32 = 17;
/// Bits of a Rice parameter, and the largest one.
const PARAMETER_BITS: u32 = 5;
const MAX_PARAMETER: u32 = 17;

/// Largest size of the payload of head and averages of a base, in bytes: 37 bits a value, and 5 for 32 of them, are
/// below 5 bytes each.
pub fn most_bytes(lattice: u32, bands: u32) -> u64 {
    let cubes = |edge: usize| (u64::from(lattice) / edge as u64).pow(3);
    let bands = u64::from(bands);
    36 + 4 * bands * bands + 5 * bands * (cubes(EDGE) + cubes(COARSE_EDGE as usize))
}

/// Averages of all components of a base, in steps.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Averages {
    /// Averages of the blocks, `[component][rank]`, in steps.
    pub blocks: Vec<Vec<i16>>,
    /// `[component][Morton code]` over the grid of [`coarse::edge`](super::coarse::edge); empty where the map is full.
    pub coarse: Vec<Vec<i16>>,
}

impl Averages {
    /// The payload.
    ///
    /// # Panics
    /// If a component is not as long as the map or its coarse grid.
    pub fn to_bytes(&self, map: &BlockMap) -> Vec<u8> {
        let mut out = BitWriter::default();
        let grid = coarse_map(map);
        for (grid, values) in grid.iter().cycle().zip(&self.coarse) {
            assert_eq!(values.len(), grid.len(), "an average for each coarse place");
            write(grid, values, &mut out);
        }
        for values in &self.blocks {
            assert_eq!(values.len(), map.len(), "an average for each stored block");
            write(map, values, &mut out);
        }
        out.finish()
    }

    /// Reads the payload of a base of `components` components.
    ///
    /// # Errors
    /// [`Rule::AveragesLength`], [`Rule::AveragesCode`], [`Rule::AverageRange`].
    pub fn from_bytes(bytes: &[u8], map: &BlockMap, components: usize) -> Result<Averages, BlockFault> {
        let grid = coarse_map(map);
        let count = components as u64 * (map.len() + grid.as_ref().map_or(0, BlockMap::len)) as u64;
        // A code has a bit at least: what is allocated below is bounded by what is there.
        if 8 * (bytes.len() as u64) < count {
            let least = count.div_ceil(8);
            return Err(BlockFault::length(
                Rule::AveragesLength,
                "the averages",
                bytes.len(),
                format!("{least} or more"),
            ));
        }
        let mut reader = BitReader::new(bytes);
        let coarse = match &grid {
            Some(grid) => (0..components).map(|_| read(grid, &mut reader)).collect::<Result<_, _>>()?,
            None => Vec::new(),
        };
        let blocks = (0..components).map(|_| read(map, &mut reader)).collect::<Result<_, _>>()?;
        reader.finish(Rule::AveragesLength, "the averages")?;
        Ok(Averages { blocks, coarse })
    }
}

/// The coarse averages as a full map of blocks, of which each has a quarter of its true edge.
fn coarse_map(map: &BlockMap) -> Option<BlockMap> {
    (!map.is_full()).then(|| BlockMap::all(map.lattice() * EDGE as u32 / COARSE_EDGE))
}

/// Mean of the stored neighbours at -x, -y, -z, rounded down; the average before where there is none, 0 at first.
fn predict(map: &BlockMap, averages: &[i16]) -> i32 {
    let at = map.block(averages.len());
    let (mut sum, mut count) = (0, 0);
    for axis in 0..3 {
        let mut before = at;
        before[axis] = before[axis].wrapping_sub(1);
        let rank = if at[axis] > 0 { map.rank(before) } else { None };
        if let Some(rank) = rank {
            sum += i32::from(averages[rank as usize]);
            count += 1;
        }
    }
    match count {
        0 => averages.last().copied().map_or(0, i32::from),
        _ => i32::div_euclid(sum, count),
    }
}

/// The cheapest Rice parameter of a group, of equally cheap ones the smallest.
fn parameter(group: &[u32]) -> u32 {
    let cost = |k: u32| -> u64 {
        let bits = |z: &u32| match z >> k {
            quotient if quotient < ESCAPE => quotient + 1 + k,
            _ => ESCAPE + ESCAPED_BITS,
        };
        group.iter().map(|z| u64::from(bits(z))).sum()
    };
    (0..=MAX_PARAMETER).min_by_key(|k| cost(*k)).expect("there are parameters")
}

fn write(map: &BlockMap, averages: &[i16], out: &mut BitWriter) {
    let zigzag: Vec<u32> = (0..averages.len())
        .map(|i| {
            let difference = i32::from(averages[i]) - predict(map, &averages[..i]);
            ((difference << 1) ^ (difference >> 31)) as u32
        })
        .collect();
    for group in zigzag.chunks(GROUP) {
        let k = parameter(group);
        out.push(k, PARAMETER_BITS);
        for z in group {
            let quotient = z >> k;
            if quotient < ESCAPE {
                out.push((1 << quotient) - 1, quotient + 1); // ones, then a zero
                out.push(z & ((1 << k) - 1), k);
            } else {
                out.push((1 << ESCAPE) - 1, ESCAPE);
                out.push(*z, ESCAPED_BITS);
            }
        }
    }
}

fn read(map: &BlockMap, reader: &mut BitReader) -> Result<Vec<i16>, BlockFault> {
    let mut averages = Vec::with_capacity(map.len());
    let mut group = Vec::with_capacity(GROUP);
    while averages.len() < map.len() {
        let size = GROUP.min(map.len() - averages.len());
        group.clear();
        let Some(k) = read_group(reader, size, &mut group) else {
            let what = format!("the average of block {}", averages.len() + group.len());
            return Err(BlockFault::new(Rule::AveragesLength, what, "cut off", "a whole code"));
        };
        let numbers: Vec<u32> = group.iter().map(|z| z & !ESCAPED).collect();
        let expected = parameter(&numbers);
        if k != expected {
            let what = format!("the Rice parameter of the group at block {}", averages.len());
            return Err(BlockFault::new(Rule::AveragesCode, what, k, expected.to_string()));
        }
        for (i, (z, escaped)) in group.iter().map(|z| (*z & !ESCAPED, z & ESCAPED != 0)).enumerate() {
            let block = averages.len();
            if escaped && z >> k < ESCAPE {
                let what = format!("the quotient of escaped number {i} of the group at block {}", block - i);
                return Err(BlockFault::new(Rule::AveragesCode, what, z >> k, format!("{ESCAPE} or more")));
            }
            let average = predict(map, &averages) + ((z >> 1) as i32 ^ -((z & 1) as i32));
            let Ok(average) = i16::try_from(average) else {
                let what = format!("the average of block {block}");
                return Err(BlockFault::new(Rule::AverageRange, what, average, "-32768 to 32767"));
            };
            averages.push(average);
        }
    }
    Ok(averages)
}

/// Marks a number that was read behind an escape.
const ESCAPED: u32 = 1 << 31;

/// Reads a parameter and a group of codes; `None` past the end.
fn read_group(reader: &mut BitReader, size: usize, group: &mut Vec<u32>) -> Option<u32> {
    let k = reader.take(PARAMETER_BITS)?;
    for _ in 0..size {
        let quotient = reader.peek().trailing_ones().min(ESCAPE);
        if quotient == ESCAPE {
            reader.skip(ESCAPE)?;
            group.push(reader.take(ESCAPED_BITS)? | ESCAPED);
        } else {
            reader.skip(quotient + 1)?;
            // A parameter over the largest is refused when the group is whole; its numbers are then of no account.
            group.push((quotient << k.min(MAX_PARAMETER)) | (reader.take(k)? & ((1 << MAX_PARAMETER) - 1)));
        }
    }
    Some(k)
}

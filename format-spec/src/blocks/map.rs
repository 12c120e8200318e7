//! Which blocks are stored: one bit for each block of the lattice in Morton order, shared by all bases of a species.
//!
//! Stored are the blocks that a surface can sample, so those that hold a texel within one site of a non-empty site. The
//! place of a block among the stored ones is its rank.

use super::{BlockFault, EDGE, Rule};
use crate::field::site_of;

/// The stored blocks of a lattice. At least one is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BlockMap {
    lattice: u32,
    /// Bits of 32 blocks each, with the number of stored blocks before them.
    words: Vec<[u32; 2]>,
    /// Morton codes of the stored blocks, ascending.
    stored: Vec<u32>,
}

impl BlockMap {
    /// Blocks that hold a texel within one site of a non-empty site; `non_empty` is `[z][y][x]`. All blocks if no site
    /// is.
    ///
    /// # Panics
    /// If `non_empty` is not `lattice^3` long or `lattice` no multiple of 4.
    pub fn near(lattice: u32, non_empty: &[bool]) -> BlockMap {
        let n = lattice as usize;
        assert_eq!(non_empty.len(), n * n * n, "a value for each site");
        let mut near = vec![false; (n / EDGE).pow(3)];
        for site in (0..non_empty.len()).filter(|s| non_empty[*s]) {
            let at = site_of(site, lattice).map(|c| c as usize);
            // The 27 neighbours lie in the blocks of these two ends of each axis.
            let ends = at.map(|c| [c.saturating_sub(1) / EDGE, (c + 1).min(n - 1) / EDGE]);
            for corner in 0..8 {
                let block = std::array::from_fn(|axis| ends[axis][corner >> axis & 1] as u32);
                near[encode(block) as usize] = true;
            }
        }
        if near.iter().any(|b| *b) {
            BlockMap::of(lattice, |code| near[code as usize])
        } else {
            BlockMap::all(lattice)
        }
    }

    /// Every block of a lattice, whose edge is a multiple of 4.
    pub fn all(lattice: u32) -> BlockMap {
        BlockMap::of(lattice, |_| true)
    }

    fn of(lattice: u32, is_stored: impl Fn(u32) -> bool) -> BlockMap {
        assert_eq!(lattice % EDGE as u32, 0, "whole blocks along an edge");
        let blocks = (lattice / EDGE as u32).pow(3);
        let mut words = Vec::with_capacity(blocks.div_ceil(32) as usize);
        let mut stored = Vec::new();
        for first in (0..blocks).step_by(32) {
            let before = stored.len() as u32;
            stored.extend((first..blocks.min(first + 32)).filter(|code| is_stored(*code)));
            let bits = stored[before as usize..].iter().fold(0, |bits, code| bits | 1 << (code - first));
            words.push([bits, before]);
        }
        BlockMap { lattice, words, stored }
    }

    /// Reads a payload for a lattice of `lattice` sites, a power of two from 16 to 256.
    ///
    /// # Errors
    /// [`Rule::MapLength`], [`Rule::MapEmpty`].
    pub fn from_bytes(bytes: &[u8], lattice: u32) -> Result<BlockMap, BlockFault> {
        let expected = (lattice as usize / EDGE).pow(3) / 8;
        if bytes.len() != expected {
            return Err(BlockFault::length(Rule::MapLength, "the block map", bytes.len(), expected));
        }
        if bytes.iter().all(|byte| *byte == 0) {
            return Err(BlockFault::new(Rule::MapEmpty, "the number of stored blocks", 0, "at least 1"));
        }
        Ok(BlockMap::of(lattice, |code| bytes[code as usize / 8] >> (code % 8) & 1 == 1))
    }

    /// The payload.
    pub fn to_bytes(&self) -> Vec<u8> {
        self.words.iter().flat_map(|[bits, _]| bits.to_le_bytes()).collect()
    }

    /// For each 32 blocks in Morton order their bits, and the number of stored blocks before them.
    pub fn words(&self) -> &[[u32; 2]] {
        &self.words
    }

    /// Sites of the lattice along an edge.
    pub fn lattice(&self) -> u32 {
        self.lattice
    }

    /// Number of stored blocks.
    pub fn len(&self) -> usize {
        self.stored.len()
    }

    /// Never: a map has a block.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// Memory that it takes.
    pub fn size_bytes(&self) -> usize {
        size_of_val(&self.words[..]) + size_of_val(&self.stored[..])
    }

    /// Whether every block of the lattice is stored.
    pub fn is_full(&self) -> bool {
        self.stored.len() == (self.lattice as usize / EDGE).pow(3)
    }

    /// Rank of block `[x, y, z]`, which lies in the lattice; `None` if it is not stored.
    #[inline(always)]
    pub fn rank(&self, block: [u32; 3]) -> Option<u32> {
        let code = encode(block);
        let [bits, before] = *self.words.get(code as usize / 32)?;
        let bit = 1 << (code % 32);
        (bits & bit != 0).then(|| before + (bits & (bit - 1)).count_ones())
    }

    /// Block `[x, y, z]` of a rank.
    ///
    /// # Panics
    /// If the rank is not below [`BlockMap::len`].
    pub fn block(&self, rank: usize) -> [u32; 3] {
        decode(self.stored[rank])
    }

    /// First texel `[x, y, z]` of a rank's block.
    pub fn first_texel(&self, rank: usize) -> [usize; 3] {
        self.block(rank).map(|b| b as usize * EDGE)
    }
}

/// Morton code: bits of x, y and z interleaved, x lowest; each is below 1024.
#[inline(always)]
pub fn encode(at: [u32; 3]) -> u32 {
    spread(at[0]) | spread(at[1]) << 1 | spread(at[2]) << 2
}

/// The inverse of [`encode`].
pub fn decode(code: u32) -> [u32; 3] {
    std::array::from_fn(|axis| (0..10).map(|bit| (code >> (3 * bit + axis) & 1) << bit).sum())
}

#[inline(always)]
fn spread(v: u32) -> u32 {
    let v = (v | v << 16) & 0x0300_00FF;
    let v = (v | v << 8) & 0x0300_F00F;
    let v = (v | v << 4) & 0x030C_30C3;
    (v | v << 2) & 0x0924_9249
}

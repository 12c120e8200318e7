//! The coarse level: one average for 16^3 texels over the whole lattice, so that a stray sample in a block that is not
//! stored is dim but right. A base of a full map has none.

use super::EDGE;
use super::map::{self, BlockMap};
use super::transform::AVERAGE_TEXEL;

/// Texels of a coarse average along an axis.
pub const COARSE_EDGE: u32 = 16;
/// Parts of a coarse edge that interpolation counts in; a texel is two.
const PARTS: i32 = 32;

/// Coarse averages of one component, in steps like the averages of blocks.
#[derive(Debug, Clone, Copy)]
pub struct Coarse<'a> {
    /// Averages along an edge, N / 16.
    pub edge: u32,
    /// Averages in Morton order, in steps.
    pub averages: &'a [i16],
}

/// Coarse averages along an edge of a map's lattice; 0 where the map is full.
pub fn edge(map: &BlockMap) -> u32 {
    if map.is_full() { 0 } else { map.lattice() / COARSE_EDGE }
}

impl Coarse<'_> {
    /// Value of texel `[x, y, z]`, in the integers of texels.
    pub fn texel(&self, at: [u32; 3]) -> i32 {
        // A weight of 1 is 2^15, an average below 2^15: the sum stays within an i32.
        (self.sum(at.map(|x| 2 * x as i32 + 1 - PARTS / 2)) >> 11) * (AVERAGE_TEXEL / 16)
    }

    /// Average of block `[x, y, z]` at its centre, in the integers of texels.
    pub fn block(&self, at: [u32; 3]) -> i32 {
        (self.sum(at.map(|b| 2 * (EDGE as i32 * b as i32 + 2) - PARTS / 2)) >> 11) * (AVERAGE_TEXEL / 16)
    }

    /// Trilinear sum times 2^15 at a place in parts from the centre of the first average, clamped to the centres.
    fn sum(&self, place: [i32; 3]) -> i32 {
        let last = self.edge as i32 - 1;
        let place = place.map(|p| p.clamp(0, last * PARTS));
        let first = place.map(|p| p / PARTS);
        let mut sum = 0;
        for corner in 0..8 {
            let mut weight = 1;
            let at = std::array::from_fn(|axis| {
                let upper = corner >> axis & 1;
                let part = place[axis] % PARTS;
                weight *= if upper == 1 { part } else { PARTS - part };
                (first[axis] + upper).min(last) as u32
            });
            sum += weight * i32::from(self.averages[map::encode(at) as usize]);
        }
        sum
    }
}

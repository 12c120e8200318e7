//! Files with blocks near geometry as no writer of this project makes them, put together from SPEC.md
//! section 8.5 and not from the codec: any axes, widths, masks and averages, pages of any number of blocks,
//! and a lattice of 32, where coarse averages have neighbours.

use std::collections::BTreeSet;

use crate::container::records::*;
use crate::testing::{Digests, Page, Parts, golden};

const LATTICE: u32 = 32;
pub(super) const BLOCKS: usize = 512;
pub(super) const CUBES: usize = 8;
pub(super) const BANDS: usize = 3; // of the golden file

/// xorshift64*, which never leaves a seed other than 0.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D)
    }

    fn below(&mut self, sides: u64) -> u64 {
        (self.roll() >> 16) % sides
    }

    /// From -1 to 1.
    fn share(&mut self) -> f32 {
        self.below(2001) as f32 / 1000.0 - 1.0
    }
}

/// A bit payload in the making.
#[derive(Default)]
pub(super) struct Bits(Vec<bool>);

impl Bits {
    pub(super) fn put(&mut self, value: u64, width: u32) {
        self.0.extend((0..width).map(|bit| value >> bit & 1 == 1));
    }

    pub(super) fn bytes(mut self) -> Vec<u8> {
        self.0.resize(self.0.len().max(1).next_multiple_of(32), false);
        self.0
            .chunks(8)
            .map(|bits| bits.iter().rev().fold(0, |byte, bit| byte << 1 | u8::from(*bit)))
            .collect()
    }
}

/// Averages as numbers so small that no path through all of them leaves 16 bits; some need 17 bits each.
fn sequence(bits: &mut Bits, dice: &mut Dice, count: usize) {
    let numbers: Vec<u64> =
        (0..count).map(|_| if dice.below(8) == 0 { dice.below(121) } else { dice.below(3) }).collect();
    for group in numbers.chunks(32) {
        let length = |k: u32| -> u64 {
            group.iter().map(|z| if z >> k < 20 { (z >> k) + 1 + u64::from(k) } else { 37 }).sum()
        };
        let best = (0..18).min_by_key(|k| length(*k)).expect("there are 18");
        bits.put(best.into(), 5);
        for z in group {
            let quotient = (z >> best) as u32;
            if quotient < 20 {
                bits.put((1 << quotient) - 1, quotient + 1);
                bits.put(z & ((1 << best) - 1), best);
            } else {
                bits.put((1 << 20) - 1, 20);
                bits.put(*z, 17);
            }
        }
    }
}

/// A head of three components, with averages for so many blocks.
fn averages(dice: &mut Dice, blocks: usize) -> Vec<u8> {
    let axes = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]][dice.below(6) as usize];
    let mut payload = [&[BANDS as u8], axes.as_slice()].concat();
    let unit = 0.001 * (dice.share() + 2.0);
    payload.extend(unit.to_le_bytes());
    payload.extend([40i32, 20, 5].map(i32::to_le_bytes).concat());
    payload.extend([1f32, 0.0, 0.0].map(f32::to_le_bytes).concat());
    payload.extend((0..BANDS * BANDS).flat_map(|_| dice.share().to_le_bytes()));
    let mut bits = Bits::default();
    let coarse = if blocks < BLOCKS { CUBES } else { 0 };
    for count in [coarse; BANDS].into_iter().chain([blocks; BANDS]) {
        sequence(&mut bits, dice, count);
    }
    payload.extend(bits.bytes());
    payload
}

/// Classes of one table: length, then the widths of places 1 to 63.
type Table = Vec<(u32, Vec<u8>)>;

fn table(dice: &mut Dice, classes: usize) -> Table {
    let mut table = BTreeSet::new();
    while table.len() < classes {
        let highest = dice.below(12) + 1;
        let widths: Vec<u8> = (0..63).map(|_| dice.below(highest) as u8).collect();
        table.insert((widths.iter().map(|w| u32::from(*w)).sum(), widths));
    }
    table.into_iter().collect()
}

fn table_payload(tables: &[Table; 2]) -> Vec<u8> {
    let mut payload: Vec<u8> = tables.iter().flat_map(|table| (table.len() as u16).to_le_bytes()).collect();
    for (_, widths) in tables.iter().flatten() {
        let numbers = [widths.as_slice(), &[0]].concat();
        payload.extend(numbers.chunks(2).map(|pair| pair[0] | pair[1] << 4));
    }
    payload
}

fn classed_page(dice: &mut Dice, blocks: usize, tables: &[Table; 2]) -> Vec<u8> {
    let (mut bits, mut lengths) = (Bits::default(), 0);
    for component in 0..BANDS {
        let table = &tables[component.min(1)];
        for _ in 0..blocks {
            let class = dice.below(table.len() as u64);
            bits.put(class, (table.len() - 1).checked_ilog2().map_or(0, |bit| bit + 1));
            lengths += table[class as usize].0;
        }
    }
    (0..lengths).for_each(|_| bits.put(dice.below(2), 1)); // every bit makes a sound coefficient
    bits.bytes()
}

fn haar_page(dice: &mut Dice, blocks: usize) -> Vec<u8> {
    let mut bits = Bits::default();
    let widths: Vec<u32> = (0..BANDS * blocks).map(|_| dice.below(12) as u32).collect();
    widths.iter().for_each(|width| bits.put((*width).into(), 4));
    let coded: Vec<(u32, u64)> = (0..blocks)
        .flat_map(|block| (0..BANDS).map(move |component| component * blocks + block))
        .filter(|at| widths[*at] > 0)
        .map(|at| (widths[at], (dice.roll() & dice.roll() & !1) | 1 << 40))
        .collect();
    coded.iter().for_each(|(_, mask)| bits.put(*mask, 64));
    for (width, mask) in coded {
        bits.put(0, width); // the least value, which no smaller width holds
        (1..mask.count_ones()).for_each(|_| bits.put(dice.below(1 << width), width));
    }
    bits.bytes()
}

/// Bytes in two pages.
fn halves(payload: &[u8]) -> [Page; 2] {
    let (one, two) = payload.split_at(payload.len() / 2);
    [one, two].map(|half| Page::plain(half, half.len() as u32))
}

/// A file of lattice 32 with this block map, these class tables (codec 7) and, for each base, the payload of
/// its averages and the pages of its detail.
pub(super) fn file(
    codec: u32,
    map: &[u8],
    tables: &[u8],
    mut base: impl FnMut() -> (Vec<u8>, Vec<Page>),
) -> Vec<u8> {
    let mut parts = Parts::of(&golden("classed"));
    for at in (0..parts.sections.len()).rev() {
        let section = &mut parts.sections[at];
        let classes = (section.key.kind, section.key.item) == (KIND_BLOCKS, BLOCKS_CLASSES);
        if section.key.species > 0 || (classes && codec == CODEC_HAAR) {
            parts.remove(at);
        } else if section.key.kind > KIND_METADATA {
            section.lattice = LATTICE;
            section.codec = if section.key.kind == KIND_DETAIL { codec } else { section.codec };
        }
    }
    let text = String::from_utf8(parts.stored(0, 0).to_vec()).expect("metadata are UTF-8");
    parts.set_payload(0, 0, text.replace("\"lattice\":16", "\"lattice\":32").as_bytes());
    let empty = Page::plain(&[0; BLOCKS * 8], BLOCKS as u32 * 64);
    for at in 0..parts.sections.len() {
        match parts.sections[at].key {
            SectionKey { kind: KIND_MEDIUM, .. } => parts.set_pages(at, std::slice::from_ref(&empty)),
            SectionKey { kind: KIND_BLOCKS, item: BLOCKS_MAP, .. } => parts.set_pages(at, &halves(map)),
            SectionKey { kind: KIND_BLOCKS, .. } => parts.set_pages(at, &halves(tables)),
            SectionKey { kind: KIND_AVERAGES, item, .. } => {
                let (averages, detail) = base();
                parts.set_pages(at, &halves(&averages));
                parts.set_pages(parts.find(KIND_DETAIL, item), &detail);
            }
            _ => {}
        }
    }
    parts.lay_out();
    parts.seal(Digests::Pages)
}

/// A sound file that stores each block with a chance of so many in 8.
pub(super) fn any(seed: u64, codec: u32, eighths: u64) -> Vec<u8> {
    let dice = &mut Dice(seed);
    let stored: Vec<bool> = (0..BLOCKS).map(|_| dice.below(8) < eighths).collect();
    let mut map = Bits::default();
    stored.iter().for_each(|bit| map.put((*bit).into(), 1));
    let count = stored.iter().filter(|bit| **bit).count();
    let tables = [table(dice, 37), table(dice, 1)];
    file(codec, &map.bytes(), &table_payload(&tables), || {
        let averages = averages(dice, count);
        let (mut pages, mut left) = (Vec::new(), count);
        while left > 0 {
            let own = left.min(1 + dice.below(200) as usize);
            let haar = codec == CODEC_HAAR;
            let payload = if haar { haar_page(dice, own) } else { classed_page(dice, own, &tables) };
            pages.push(Page::plain(&payload, own as u32));
            left -= own;
        }
        (averages, pages)
    })
}

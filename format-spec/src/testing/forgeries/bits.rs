//! Heads, averages and detail that break M46 to M53, bit for bit as SPEC.md section 8.5 lays them out.

use super::List;
use super::blocks::{BANDS, BLOCKS, Bits, CUBES, file};
use crate::container::records::*;
use crate::testing::Page;

/// A value and its width.
type Put = (u64, u32);

fn payload(fields: &[Put]) -> Vec<u8> {
    let mut bits = Bits::default();
    fields.iter().for_each(|(value, width)| bits.put(*value, *width));
    bits.bytes()
}

fn two_to(exponent: u32) -> f32 {
    f32::from_bits((127 + exponent) << 23)
}

/// One component, unit 1, all in the first band.
fn head() -> Vec<u8> {
    let mut head = vec![1, 0, 1, 2];
    head.extend(1f32.to_le_bytes());
    head.extend([30i32, 20, 10].map(i32::to_le_bytes).concat());
    head.extend([1f32, 0.0, 0.0].map(f32::to_le_bytes).concat());
    let rotation: [f32; BANDS] = [1.0, 0.0, 0.0];
    head.extend(rotation.map(f32::to_le_bytes).concat());
    head
}

fn head_with(at: usize, bytes: &[u8]) -> Vec<u8> {
    let mut head = head();
    head[at..at + bytes.len()].copy_from_slice(bytes);
    head
}

/// Two stored blocks, with coarse averages of 0 before this group of averages.
fn near(codec: u32, head: &[u8], group: &[Put], detail: &[Put]) -> Vec<u8> {
    with_tables(codec, &tables(), head, group, detail)
}

/// Classes of table 0: nothing, place 1 in 1 bit, place 1 in 2 bits; of table 1: nothing.
fn tables() -> Vec<u8> {
    let mut tables = vec![0; 4 + 4 * 32];
    (tables[0], tables[2], tables[4 + 32], tables[4 + 64]) = (3, 1, 1, 2);
    tables
}

fn with_tables(codec: u32, tables: &[u8], head: &[u8], group: &[Put], detail: &[Put]) -> Vec<u8> {
    let mut map = vec![0; BLOCKS / 8];
    map[0] = 3;
    let coarse = [(0, 5), (0, CUBES as u32)];
    let averages = [head, &payload(&[&coarse, group].concat())].concat();
    file(codec, &map, tables, || (averages.clone(), vec![Page::plain(&payload(detail), 2)]))
}

const NO_AVERAGES: [Put; 2] = [(0, 5), (0, 2)];
const NO_CLASSED: [Put; 2] = [(0, 2), (0, 2)];
const NO_HAAR: [Put; 2] = [(0, 4), (0, 4)];

/// Sound files, from which each case departs by one thing.
pub(super) fn sound() -> [Vec<u8>; 4] {
    [
        near(CODEC_CLASSED, &head(), &NO_AVERAGES, &NO_CLASSED),
        near(CODEC_HAAR, &head(), &NO_AVERAGES, &NO_HAAR),
        // -15 in both blocks, which are halved twice.
        near(
            CODEC_CLASSED,
            &head(),
            &[(3, 5), (0b111, 4), (5, 3), (0, 4)],
            &[(2, 2), (1, 2), (3, 2), (1, 1)],
        ),
        // -2^15, then 2^15 - 1, with the largest unit.
        near(
            CODEC_HAAR,
            &head_with(4, &two_to(88).to_le_bytes()),
            &[(16, 5), (0, 1), (65535, 16), (1, 2), (65534, 16)],
            &NO_HAAR,
        ),
    ]
}

pub(super) fn add(list: &mut List) {
    let wrong =
        |at: usize, bytes: &[u8]| near(CODEC_CLASSED, &head_with(at, bytes), &NO_AVERAGES, &NO_CLASSED);
    let float = |at, value: f32| wrong(at, &value.to_le_bytes());
    let averages = |group: &[Put]| near(CODEC_CLASSED, &head(), group, &NO_CLASSED);
    let classed = |fields: &[Put]| near(CODEC_CLASSED, &head(), &NO_AVERAGES, fields);
    let haar = |fields: &[Put]| near(CODEC_HAAR, &head(), &NO_AVERAGES, fields);
    // So many classes in tables 0 and 1; their order is looked at later.
    let classes = |counts: [u16; 2]| {
        let mut tables = counts.map(u16::to_le_bytes).concat();
        tables.resize(4 + 32 * usize::from(counts[0] + counts[1]), 0);
        with_tables(CODEC_CLASSED, &tables, &head(), &NO_AVERAGES, &NO_CLASSED)
    };
    // In this many bits of 1, q of them and a 0, or 20 of them and 17 bits.
    let (ones, twenty) = (|q: u32| ((1 << q) - 1, q + 1), (0xF_FFFF, 20));
    for (code, words, bytes) in [
        (5011, "M42: ", classes([0, 2])),
        (5011, "M42: ", classes([257, 1])),
        (5012, "M46: ", wrong(0, &[0])),
        (5012, "M46: ", wrong(1, &[0, 2, 2])),
        (5012, "M46: ", wrong(1, &[0, 1, 3])),
        (5012, "M46: ", float(4, two_to(88) * 1.5)),
        (5012, "M46: ", float(4, f32::NAN)),
        (5012, "M46: ", wrong(8, &32769i32.to_le_bytes())),
        (5012, "M46: ", wrong(12, &31i32.to_le_bytes())),
        (5012, "M46: ", wrong(16, &(-1i32).to_le_bytes())),
        (5012, "M46: ", float(20, -0.0)),
        (5012, "M46: ", float(24, f32::INFINITY)),
        (5012, "M46: ", float(28, two_to(97))),
        (5012, "M46: ", float(32, 1.5)),
        (5012, "M46: ", float(36, -0.0)),
        (5012, "M46: ", float(40, f32::NAN)),
        (5013, "M48: ", averages(&[(1, 5), (0, 2), (0, 2)])), // 1 bit each would do
        (5013, "M48: ", averages(&[(1, 5), ones(1), (0, 1), ones(1), (0, 1)])), // as long as with 0
        (5013, "M48: ", averages(&[(18, 5), (0, 19), (0, 19)])),
        (5013, "M48: ", averages(&[(0, 5), twenty, (3, 17), (0, 1)])),
        (5013, "M49: ", averages(&[(14, 5), ones(4), (0, 14), (0, 15)])), // 2^16 stands for 2^15
        (5014, "M51: ", classed(&[(1, 2), (1, 2), (0, 1), (0, 1), (1, 1)])),
        (5014, "M52: ", classed(&[(0, 2), (3, 2)])),
        (5014, "M53: ", haar(&[(12, 4), (0, 4), (2, 64), (0, 12)])),
        (5014, "M53: ", haar(&[(1, 4), (0, 4), (0, 64)])),
        (5014, "M53: ", haar(&[(1, 4), (0, 4), (3, 64), (0, 2)])),
        (5014, "M53: ", haar(&[(2, 4), (0, 4), (2, 64), (1, 2)])), // -1 fits in 1 bit
        (5014, "M53: ", haar(&[(3, 4), (0, 4), (6, 64), (2, 3), (5, 3)])), // -2 and 1 in 2
        (5014, "M51: ", haar(&[(11, 4), (11, 4), (2, 64)])),
    ] {
        list.give(code, words, bytes);
    }
}

//! Every rule broken once, with the message that says so.

use super::*;

fn map() -> BlockMap {
    let mut non_empty = vec![false; 16usize.pow(3)];
    non_empty[0] = true;
    non_empty[4095] = true;
    BlockMap::near(16, &non_empty)
}

fn head() -> Head {
    Head {
        bands: 2,
        axes: [1, 0, 2],
        unit: 0.5,
        thresholds: [8, 4, 0],
        peak: 1.0,
        rms_error: 0.0,
        dark_error: 0.0,
        rotation: vec![1.0, 0.0],
    }
}

fn classes() -> Classes {
    let mut wide = [0; DETAILS];
    wide[..2].copy_from_slice(&[3, 2]);
    Classes::new([
        ClassTable::new(vec![[0; DETAILS], [1; DETAILS], wide]),
        ClassTable::new(vec![[1; DETAILS]]),
    ])
}

/// The rule and the whole message.
fn refused<T: std::fmt::Debug>(result: Result<T, BlockFault>, rule: Rule, message: &str) {
    let fault = result.expect_err(message);
    assert_eq!((fault.rule, fault.to_string().as_str()), (rule, message));
}

#[test]
fn broken_maps_are_refused() {
    let good = map().to_bytes();
    refused(
        BlockMap::from_bytes(&good[..7], 16),
        Rule::MapLength,
        "M40: the length of the block map in bytes is 7, expected 8",
    );
    refused(
        BlockMap::from_bytes(&[0; 8], 16),
        Rule::MapEmpty,
        "M41: the number of stored blocks is 0, expected at least 1",
    );
}

#[test]
fn broken_classes_are_refused() {
    let good = classes().to_bytes();
    assert_eq!(Classes::from_bytes(&good), Ok(classes()));
    refused(
        Classes::from_bytes(&good[..3]),
        Rule::ClassesLength,
        "M42: the length of the class tables in bytes is 3, expected 4 or more",
    );
    let with = |at: usize, byte: u8| {
        let mut bytes = good.clone();
        bytes[at] = byte;
        Classes::from_bytes(&bytes)
    };
    refused(with(2, 0), Rule::ClassesLength, "M42: the number of classes of table 1 is 0, expected 1 to 256");
    refused(
        with(0, 2),
        Rule::ClassesLength,
        "M42: the length of the class tables in bytes is 132, expected 100",
    );
    refused(with(4, 0xC0), Rule::ClassWidth, "M43: width 1 of class 0 of table 0 is 12, expected 0 to 11");
    refused(with(35, 0x10), Rule::ClassWidth, "M43: width 63 of class 0 of table 0 is 1, expected 0 to 0");
    refused(
        with(36, 0),
        Rule::ClassOrder,
        "M44: class 1 of table 0 of 0 bits is not above the one before, expected ascending order",
    );
}

#[test]
fn broken_heads_are_refused() {
    let good = head().to_bytes();
    assert_eq!(Head::from_bytes(&good, 2), Ok(head()));
    refused(
        Head::from_bytes(&[], 2),
        Rule::HeadLength,
        "M45: the number of components is 0, expected 1 to 2",
    );
    refused(
        Head::from_bytes(&good[..39], 2),
        Rule::HeadLength,
        "M45: the length of the head of a base in bytes is 39, expected 40",
    );
    let with = |at: usize, bytes: &[u8]| {
        let mut head = good.clone();
        head[at..][..bytes.len()].copy_from_slice(bytes);
        Head::from_bytes(&head, 2)
    };
    let number = |at: usize, value: f32| with(at, &value.to_le_bytes());
    let m46 = Rule::HeadField;
    refused(with(0, &[3]), m46, "M46: the number of components is 3, expected 1 to 2");
    refused(with(1, &[0]), m46, "M46: the order of axes is [0, 0, 2], expected a permutation of 0, 1, 2");
    refused(number(4, 0.0), m46, "M46: the unit is 0, expected 2^-126 to 2^88");
    refused(number(4, f32::NAN), m46, "M46: the unit is NaN, expected 2^-126 to 2^88");
    refused(
        with(8, &[2, 0, 0, 0]),
        m46,
        "M46: the thresholds is [2, 4, 0], expected descending, from 32768 to 0",
    );
    refused(number(20, -0.0), m46, "M46: the peak is -0.0, expected from +0 to 2^96");
    refused(number(24, f32::INFINITY), m46, "M46: the mean error is inf, expected from +0 to 2^96");
    refused(number(28, -1.0), m46, "M46: the dark error is -1.0, expected from +0 to 2^96");
    refused(
        number(36, -0.0),
        m46,
        "M46: number 1 of the rotation is -0.0, expected from -1 to 1, and 0 written as +0",
    );
    refused(
        number(32, 1.5),
        m46,
        "M46: number 0 of the rotation is 1.5, expected from -1 to 1, and 0 written as +0",
    );
}

/// The averages of two blocks of a map without coarse level, from fields of (value, width).
fn averages(fields: &[(u32, u32)]) -> Result<Averages, BlockFault> {
    let map = BlockMap::all(16);
    let mut out = bits::BitWriter::default();
    fields.iter().for_each(|(value, width)| out.push(*value, *width));
    Averages::from_bytes(&out.finish(), &map, 1)
}

#[test]
fn broken_averages_are_refused() {
    // Two groups of 32 zeros: a parameter of 0, then a bit each.
    assert_eq!(averages(&[(0, 5), (0, 32), (0, 5), (0, 32)]).map(|a| a.blocks), Ok(vec![vec![0; 64]]));
    let length = Rule::AveragesLength;
    refused(
        averages(&[(0, 32)]),
        length,
        "M47: the length of the averages in bytes is 4, expected 8 or more",
    );
    refused(
        averages(&[(0, 5), (0, 32), (0, 5), (0, 32), (0, 32)]),
        length,
        "M47: the length of the averages in bytes is 16, expected 12",
    );
    refused(
        averages(&[(0, 5), (0, 32), (0, 5), (0, 32), (1, 3)]),
        length,
        "M47: filling behind the averages is 1, expected 0",
    );
    refused(
        averages(&[(0, 5), (0, 31), (u32::MAX, 32)]),
        length,
        "M47: the average of block 50 is cut off, expected a whole code",
    );
    let code = Rule::AveragesCode;
    refused(
        averages(&[(1, 5), (0, 32), (0, 32), (0, 32)]),
        code,
        "M48: the Rice parameter of the group at block 0 is 1, expected 0",
    );
    refused(
        averages(&[(31, 5), (0, 32), (0, 32), (0, 32)].into_iter().chain([(0, 32); 40]).collect::<Vec<_>>()),
        code,
        "M48: the Rice parameter of the group at block 0 is 31, expected 0",
    );
    let escaped = |z: u32| averages(&[(0, 5), ((1 << 20) - 1, 20), (z, 17), (0, 31), (0, 5), (0, 32)]);
    refused(
        escaped(2),
        code,
        "M48: the quotient of escaped number 0 of the group at block 0 is 2, expected 20 or more",
    );
    refused(
        escaped(65536 + 65535),
        Rule::AverageRange,
        "M49: the average of block 0 is -65536, expected -32768 to 32767",
    );
    assert_eq!(escaped(65535).map(|a| a.blocks[0][0]), Ok(-32768));
}

#[test]
fn broken_details_are_refused() {
    let shared = std::sync::Arc::new(Shared { map: map(), coding: Coding::Classed(classes()) });
    let averages = Averages { blocks: vec![vec![0, 0]], coarse: vec![vec![0]] };
    let mut base = CodedBase::new(&shared, head(), averages);
    let page = |fields: &[(u32, u32)]| {
        let mut out = bits::BitWriter::default();
        fields.iter().for_each(|(value, width)| out.push(*value, *width));
        out.finish()
    };
    let blocks = Rule::DetailBlocks;
    let good = page(&[(1, 2), (7, 5)]);
    for (first, count) in [(0, 0), (0, 3), (u32::MAX, u32::MAX), (2, 1)] {
        let message = format!(
            "M50: the blocks of a page of detail is {count} from {first}, expected at least 1, of 2 stored ones"
        );
        refused(base.add(first, count, &good), blocks, &message);
    }
    refused(
        base.add(0, 1, &[]),
        Rule::DetailLength,
        "M51: the length of a page of detail in bytes is 0, expected 4 or more",
    );
    refused(
        base.add(0, 1, &page(&[(1, 2), (7, 5), (0, 32)])),
        Rule::DetailLength,
        "M51: the length of a page of detail in bytes is 8, expected 4",
    );
    refused(
        base.add(0, 1, &page(&[(1, 2), (1 << 5, 6)])),
        Rule::DetailLength,
        "M51: filling behind a page of detail is 1, expected 0",
    );
    refused(
        base.add(0, 1, &page(&[(3, 2)])),
        Rule::BlockClass,
        "M52: the class of component 0 of block 0 is 3, expected below 3",
    );
    refused(
        base.add(0, 1, &vec![0; (1 << 28) + 1]),
        Rule::DetailSize,
        "M54: the length of the detail of a base in bytes is 268435457, expected up to 268435456",
    );
    assert_eq!(base.add(1, 1, &good), Ok(()));
    refused(
        base.add(0, 1, &vec![0; (1 << 28) - 3]),
        Rule::DetailSize,
        "M54: the length of the detail of a base in bytes is 268435457, expected up to 268435456",
    );
    refused(
        base.add(0, 2, &good),
        blocks,
        "M50: a block of a page of detail is 1, expected one whose detail was not read before",
    );
}

#[test]
fn broken_masks_are_refused() {
    let read = |fields: &[(u32, u32)]| {
        let mut out = bits::BitWriter::default();
        fields.iter().for_each(|(value, width)| out.push(*value, *width));
        detail::parse(&Coding::Haar, 1, 1, &out.finish())
    };
    let mask = Rule::BlockMask;
    // One coefficient of -2 halves in 2 bits.
    assert!(read(&[(2, 4), (2, 32), (0, 32), (0, 2)]).is_ok());
    assert!(read(&[(0, 4)]).is_ok());
    refused(read(&[(12, 4)]), mask, "M53: the width of component 0 of block 0 is 12, expected 0 to 11");
    for (bits, written) in [(0, "0x0000000000000000"), (3, "0x0000000000000003")] {
        let message = format!(
            "M53: the mask of component 0 of block 0 is {written}, expected at least one bit, and not bit 0"
        );
        refused(read(&[(2, 4), (bits, 32), (0, 32), (0, 4)]), mask, &message);
    }
    refused(
        read(&[(2, 4), (2, 32), (0, 32), (1, 2)]),
        mask,
        "M53: the width of component 0 of block 0 is 2, expected the least that holds 1",
    );
    refused(
        read(&[(2, 4), (2, 32)]),
        Rule::DetailLength,
        "M51: the length of a page of detail in bytes is 8, expected 12 or more",
    );
}

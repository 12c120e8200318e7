//! Random bases through both codings, and everything that a payload can have wrong.

use std::sync::Arc;

use proptest::prelude::*;

use super::classes::{DETAILS, Widths};
use super::transform::{HAAR, SMOOTH, forward, inverse};
use super::*;
use crate::Field;

mod faults;
mod samples;

/// Of each property; Miri takes a thousand times as long.
const CASES: u32 = if cfg!(miri) { 1 } else { 24 };
/// Sites of the test lattice along an edge: 8^3 blocks, 2^3 coarse averages.
const LATTICE: u32 = 32;

/// SplitMix64 (Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut h = self.0;
        h = (h ^ (h >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        h = (h ^ (h >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        h ^ (h >> 31)
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }

    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// A base as an encoder has it.
struct Made {
    shared: Arc<Shared>,
    head: Head,
    averages: Averages,
    /// `[block][component]`
    blocks: Vec<CodedBlock>,
}

fn widths(random: &mut Random, most: usize) -> Widths {
    std::array::from_fn(|_| random.below(most + 1) as u8)
}

/// A random base whose averages are of magnitude up to `average` and widths up to `width`.
fn made(seed: u64, haar: bool, average: usize, width: usize) -> Made {
    let random = &mut Random(seed);
    let density = 1 + random.below(400);
    let non_empty: Vec<bool> = (0..LATTICE.pow(3)).map(|_| random.below(density) == 0).collect();
    let map = if random.below(8) == 0 { BlockMap::all(LATTICE) } else { BlockMap::near(LATTICE, &non_empty) };
    made_on(map, random, haar, average, width)
}

/// The same of a map.
fn made_on(map: BlockMap, random: &mut Random, haar: bool, average: usize, width: usize) -> Made {
    let bands = 1 + random.below(7) as u32;
    let components = 1 + random.below(bands as usize);
    let coding = if haar {
        Coding::Haar
    } else {
        let table = |random: &mut Random, count: usize| {
            ClassTable::new((0..count).map(|_| widths(random, width)).collect())
        };
        let (first, second) = (1 + random.below(256), 1 + random.below(5));
        Coding::Classed(Classes::new([table(random, first), table(random, second)]))
    };
    let axes = [[0, 1, 2], [2, 0, 1], [1, 0, 2], [2, 1, 0]][random.below(4)];
    let head = Head {
        bands,
        axes,
        unit: 1.0 / 64.0,
        thresholds: [average as i32 / 2, average as i32 / 4, 0],
        peak: 1.5,
        rms_error: 0.01,
        dark_error: 0.1,
        rotation: (0..components * bands as usize).map(|_| random.unit() as f32).collect(),
    }
    .checked()
    .expect("a sound head");
    let mut any = |count: usize| -> Vec<i16> {
        (0..count).map(|_| (random.below(2 * average + 1) as i32 - average as i32) as i16).collect()
    };
    let averages = Averages {
        blocks: (0..components).map(|_| any(map.len())).collect(),
        coarse: (0..if map.is_full() { 0 } else { components })
            .map(|_| any((map.lattice() as usize / 16).pow(3)))
            .collect(),
    };
    let blocks = (0..map.len() * components)
        .map(|i| {
            coded_block(
                random,
                &coding,
                &head,
                i % components,
                averages.blocks[i % components][i / components],
                width,
            )
        })
        .collect();
    Made { shared: Arc::new(Shared { map, coding }), head, averages, blocks }
}

fn coded_block(
    random: &mut Random,
    coding: &Coding,
    head: &Head,
    component: usize,
    average: i16,
    width: usize,
) -> CodedBlock {
    let mut values = [0; TEXELS];
    values[0] = average;
    let order = head.order();
    let class = match coding {
        Coding::Classed(classes) => {
            let table = &classes.tables[Classes::table(component)];
            let class = random.below(table.widths().len());
            for (i, width) in table.widths()[class].iter().enumerate().filter(|(_, w)| **w > 0) {
                let codes = 1 << width;
                values[usize::from(order[i + 1])] =
                    (2 * random.below(codes) as i32 + 1 - codes as i32) as i16;
            }
            class
        }
        Coding::Haar => {
            let most = random.below((1 << width) / 2 + 1) as i32;
            for value in &mut values[1..] {
                if random.below(4) == 0 {
                    *value = 2 * (random.below(2 * most as usize + 1) as i32 - most) as i16;
                }
            }
            let largest = values[1..].iter().map(|v| v.unsigned_abs() / 2).max().expect("values");
            if largest == 0 { 0 } else { 1 + (usize::from(largest).next_power_of_two().ilog2() as usize) }
        }
    };
    CodedBlock { class: class as u16, values }
}

/// Pages of random sizes: first block, number of blocks, payload.
fn pages(made: &Made, random: &mut Random) -> Vec<(u32, u32, Vec<u8>)> {
    let components = made.head.components();
    let mut pages = Vec::new();
    let mut first = 0;
    while first < made.shared.map.len() {
        let count = 1 + random.below(made.shared.map.len() - first);
        let blocks = &made.blocks[first * components..][..count * components];
        let payload = detail::encode(&made.shared.coding, &made.head.order(), components, blocks);
        pages.push((first as u32, count as u32, payload));
        first += count;
    }
    pages
}

/// The base as a reader gets it, before any detail.
fn bare(made: &Made) -> CodedBase {
    let mut bytes = made.head.to_bytes();
    bytes.extend(made.averages.to_bytes(&made.shared.map));
    CodedBase::from_bytes(&made.shared, made.head.bands, &bytes).expect("sound payloads")
}

/// The base as a reader gets it, its pages in random order.
fn read(made: &Made, random: &mut Random) -> CodedBase {
    let mut base = bare(made);
    let mut pages = pages(made, random);
    while !pages.is_empty() {
        assert!(!base.is_whole());
        let (first, count, payload) = pages.swap_remove(random.below(pages.len()));
        base.add(first, count, &payload).expect("a sound page");
    }
    assert!(base.is_whole());
    base
}

/// Texels from what was coded, by the definition: each the sum over all coefficients of three rows' products.
fn expected(made: &Made, rank: usize, component: usize) -> [i32; TEXELS] {
    let components = made.head.components();
    let rows = made.shared.coding.rows();
    let values = &made.blocks[rank * components + component].values;
    let halvings = made.head.halvings(made.averages.blocks[0][rank]);
    let texel = |t: usize| -> i64 {
        let product = |k: usize| -> i64 {
            (0..3).map(|axis| i64::from(rows[k >> (2 * axis) & 3][t >> (2 * axis) & 3])).product()
        };
        let scale = |k: usize| if k == 0 { 16 } else { 1 << (3 - halvings) };
        (0..TEXELS).map(|k| i64::from(values[k]) * scale(k) * product(k)).sum()
    };
    std::array::from_fn(|t| i32::try_from(texel(t)).expect("texels fit an i32"))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(CASES))]

    #[test]
    fn a_page_that_is_taken_back_leaves_averages_and_may_come_again(seed: u64, haar: bool) {
        let made = made(seed, haar, 3000, 11);
        let random = &mut Random(!seed);
        let pages = pages(&made, random);
        let (bare, mut base) = (bare(&made), bare(&made));
        let mut is_in = vec![false; pages.len()];
        for _ in 0..40 {
            let at = random.below(pages.len());
            let (first, count, payload) = &pages[at];
            if is_in[at] {
                prop_assert!(base.remove(*first) && !base.remove(*first));
            } else {
                base.add(*first, *count, payload).expect("a sound page");
            }
            is_in[at] = !is_in[at];
        }
        for (at, (first, count, _)) in pages.iter().enumerate() {
            for rank in *first as usize..(first + count) as usize {
                for component in 0..made.head.components() {
                    let wanted = match is_in[at] {
                        true => expected(&made, rank, component),
                        false => bare.texels(rank, component),
                    };
                    prop_assert_eq!(base.texels(rank, component), wanted);
                }
            }
        }
        for (at, (first, ..)) in pages.iter().enumerate() {
            prop_assert_eq!(base.remove(*first), is_in[at]);
        }
        prop_assert_eq!(base.size_bytes(), bare.size_bytes());
        prop_assert!(!base.is_whole());
    }

    #[test]
    fn a_base_reads_back_as_it_was_coded_whatever_the_order_of_its_pages(seed: u64, haar: bool) {
        let made = made(seed, haar, 3000, 11);
        let base = read(&made, &mut Random(!seed));
        prop_assert_eq!(base.head(), &made.head);
        prop_assert_eq!(base.coarse_averages(), &made.averages.coarse);
        for (component, averages) in made.averages.blocks.iter().enumerate() {
            let found: Vec<_> = (0..averages.len()).map(|rank| base.average(rank, component)).collect();
            prop_assert_eq!(&found, averages);
        }
        for rank in 0..made.shared.map.len() {
            for c in 0..made.head.components() {
                prop_assert_eq!(base.texels(rank, c), expected(&made, rank, c), "block {} component {}", rank, c);
            }
        }
    }

    #[test]
    fn map_and_classes_read_back_as_they_were_written(seed: u64) {
        let made = made(seed, false, 10, 11);
        let map = &made.shared.map;
        prop_assert_eq!(&BlockMap::from_bytes(&map.to_bytes(), LATTICE).expect("a map"), map);
        let Coding::Classed(classes) = &made.shared.coding else { unreachable!("asked for classes") };
        prop_assert_eq!(&Classes::from_bytes(&classes.to_bytes()).expect("tables"), classes);
    }

    #[test]
    fn random_bytes_are_read_or_refused(seed: u64, bytes in prop::collection::vec(any::<u8>(), 0..2000), haar: bool) {
        let made = made(seed, haar, 10, 3);
        let map = &made.shared.map;
        if let Ok(map) = BlockMap::from_bytes(&bytes[..bytes.len().min(64)], LATTICE) {
            prop_assert_eq!(map.to_bytes(), &bytes[..64]);
        }
        if let Ok(classes) = Classes::from_bytes(&bytes) {
            prop_assert_eq!(classes.to_bytes(), &bytes[..]);
        }
        if let Ok(head) = Head::from_bytes(&bytes, 3) {
            prop_assert_eq!(head.to_bytes(), &bytes[..]);
        }
        if let Ok(averages) = Averages::from_bytes(&bytes, map, 1) {
            prop_assert_eq!(averages.to_bytes(map), &bytes[..]);
        }
        let mut base = CodedBase::new(&made.shared, made.head.clone(), made.averages.clone());
        let before = base.field();
        let count = 1 + bytes.len() as u32 % map.len() as u32;
        match base.add(0, count, &bytes) {
            Ok(()) => prop_assert_eq!(base.field().values().len(), before.values().len()),
            Err(_) => prop_assert_eq!(base.field(), before),
        }
    }

    #[test]
    fn a_changed_bit_is_refused_or_is_another_content(seed: u64, haar: bool) {
        let made = made(seed, haar, 300, 6);
        let map = &made.shared.map;
        let random = &mut Random(seed);
        let mut changed = |mut bytes: Vec<u8>| {
            let at = random.below(bytes.len());
            bytes[at] ^= 1 << random.below(8);
            bytes
        };
        for _ in 0..40 {
            let bytes = changed(made.averages.to_bytes(map));
            if let Ok(averages) = Averages::from_bytes(&bytes, map, made.head.components()) {
                prop_assert_ne!(&averages, &made.averages);
                prop_assert_eq!(averages.to_bytes(map), bytes);
            }
            let bytes = changed(made.head.to_bytes());
            if let Ok(head) = Head::from_bytes(&bytes, made.head.bands) {
                prop_assert_ne!(&head, &made.head);
                prop_assert_eq!(head.to_bytes(), bytes);
            }
            if let Coding::Classed(classes) = &made.shared.coding {
                let bytes = changed(classes.to_bytes());
                if let Ok(classes) = Classes::from_bytes(&bytes) {
                    prop_assert_eq!(classes.to_bytes(), bytes);
                }
            }
        }
    }

    #[test]
    fn payloads_of_any_other_length_are_refused(seed: u64, haar: bool) {
        let made = made(seed, haar, 300, 4);
        let (map, components) = (&made.shared.map, made.head.components());
        let random = &mut Random(seed);
        let mut others = |bytes: &[u8]| {
            let mut longer = bytes.to_vec();
            longer.extend([0; 4]);
            let shorter = (0..20).map(|_| bytes[..random.below(bytes.len())].to_vec());
            shorter.chain([longer, bytes[..bytes.len() - 1].to_vec()]).collect::<Vec<_>>()
        };
        for bytes in others(&map.to_bytes()) {
            prop_assert_eq!(BlockMap::from_bytes(&bytes, LATTICE).expect_err("length").rule, Rule::MapLength);
        }
        for bytes in others(&made.head.to_bytes()) {
            let fault = Head::from_bytes(&bytes, made.head.bands).expect_err("length");
            prop_assert_eq!(fault.rule, Rule::HeadLength);
        }
        for bytes in others(&made.averages.to_bytes(map)) {
            prop_assert!(Averages::from_bytes(&bytes, map, components).is_err());
        }
        if let Coding::Classed(classes) = &made.shared.coding {
            for bytes in others(&classes.to_bytes()) {
                prop_assert_eq!(Classes::from_bytes(&bytes).expect_err("length").rule, Rule::ClassesLength);
            }
        }
        let payload = detail::encode(&made.shared.coding, &made.head.order(), components, &made.blocks);
        if !payload.is_empty() {
            for bytes in others(&payload) {
                prop_assert!(detail::parse(&made.shared.coding, components, map.len(), &bytes).is_err());
            }
        }
    }
}

/// Two roundings at most for each of 64 coefficients and 8 corners, in f32.
const ROUNDING: f32 = 2.0 * 64.0 * 8.0 * f32::EPSILON;

#[test]
fn rows_are_orthogonal_and_inverse_undoes_forward() {
    for rows in [SMOOTH, HAAR] {
        for (i, a) in rows.iter().enumerate() {
            for (j, b) in rows.iter().enumerate() {
                let product: i32 = a.iter().zip(b).map(|(a, b)| a * b).sum();
                assert_eq!(product != 0, i == j, "rows {i} and {j}");
            }
        }
        for unit in 0..TEXELS {
            let mut values = [0; TEXELS];
            values[unit] = 1;
            inverse(&rows, &mut values);
            let mut texels = values.map(|v| v as f32);
            forward(&rows, &mut texels);
            for (i, v) in texels.iter().enumerate() {
                let expected = f32::from(u8::from(i == unit));
                assert!((v - expected).abs() < 1e-5, "coefficient {i} of unit {unit}: {v}");
            }
        }
    }
}

/// Overflow panics in tests, so this is a proof for the largest numbers that payloads can hold.
#[test]
fn the_largest_integers_do_not_overflow() {
    for rows in [SMOOTH, HAAR] {
        for seed in 0..200 {
            let random = &mut Random(seed);
            let mut values = [(); TEXELS].map(|()| if random.below(2) == 0 { 2048 << 3 } else { -2048 << 3 });
            values[0] = if random.below(2) == 0 { -32768 * 16 } else { 32767 * 16 };
            inverse(&rows, &mut values);
        }
    }
    let grid = [i16::MIN; 8];
    let coarse = coarse::Coarse { edge: 2, averages: &grid };
    assert_eq!(coarse.texel([13, 8, 25]), i32::from(i16::MIN) * transform::AVERAGE_TEXEL);
    assert_eq!(coarse.block([3, 0, 7]), i32::from(i16::MIN) * transform::AVERAGE_TEXEL);
}

#[test]
fn blocks_near_geometry_are_those_that_a_point_in_a_site_can_sample() {
    for seed in 0..20 {
        let random = &mut Random(seed);
        let non_empty: Vec<bool> = (0..16usize.pow(3)).map(|_| random.below(300) == 0).collect();
        let map = BlockMap::near(16, &non_empty);
        let mut near = std::collections::BTreeSet::new();
        for site in (0..non_empty.len() as i32).filter(|s| non_empty[*s as usize]) {
            for d in 0..27 {
                let at = [site % 16 + d % 3 - 1, site / 16 % 16 + d / 3 % 3 - 1, site / 256 + d / 9 - 1];
                if at.iter().all(|c| (0..16).contains(c)) {
                    near.insert(map::encode(at.map(|c| c as u32 / 4)));
                }
            }
        }
        assert_eq!(
            near.into_iter().map(map::decode).collect::<Vec<_>>(),
            (0..map.len()).map(|r| map.block(r)).collect::<Vec<_>>()
        );
        for code in 0..64 {
            let block = map::decode(code);
            let rank = map.rank(block);
            assert_eq!(rank.map(|r| map.block(r as usize)), rank.map(|_| block));
        }
        assert_eq!(
            (0..map.len()).map(|r| map.rank(map.block(r))).collect::<Vec<_>>(),
            (0..map.len() as u32).map(Some).collect::<Vec<_>>()
        );
    }
    assert_eq!(BlockMap::near(16, &[false; 4096]), BlockMap::all(16));
}

#[test]
fn a_quarter_is_the_mean_of_stored_blocks_and_needs_no_detail() {
    let made = made(7, false, 500, 4);
    let whole = read(&made, &mut Random(7)).field();
    let quarter = CodedBase::new(&made.shared, made.head.clone(), made.averages.clone()).quarter();
    assert_eq!(quarter.lattice, LATTICE / 4);
    let mean = |field: &Field, band: u32, block: [u32; 3]| {
        let n = LATTICE as usize;
        let texels = (0..TEXELS).map(|t| [t % 4, t / 4 % 4, t / 16]);
        let at = texels.map(|t| [0, 1, 2].map(|a| block[a] as usize * 4 + t[a]));
        at.map(|[x, y, z]| f64::from(field.band(band)[(z * n + y) * n + x])).sum::<f64>() / 64.0
    };
    let peak = whole.values().iter().fold(0.0f32, |p, v| p.max(v.abs()));
    for rank in 0..made.shared.map.len() {
        let [x, y, z] = made.shared.map.block(rank);
        for band in 0..whole.bands {
            let value = quarter.band(band)[((z * LATTICE / 4 + y) * LATTICE / 4 + x) as usize];
            let expected = mean(&whole, band, [x, y, z]);
            assert!(
                (f64::from(value) - expected).abs() <= f64::from(ROUNDING * peak),
                "{value}, expected {expected}"
            );
        }
    }
}

#[test]
fn an_even_coarse_level_is_even_light_in_blocks_that_are_not_stored() {
    let mut made = made(3, false, 500, 4);
    assert!(!made.shared.map.is_full());
    made.averages.coarse.iter_mut().flatten().for_each(|v| *v = -77);
    let base = CodedBase::new(&made.shared, made.head.clone(), made.averages.clone());
    let colors = made.head.colors();
    for (field, edge) in [(base.field(), 4), (base.quarter(), 1)] {
        for band in 0..field.bands {
            let expected = colors.chunks_exact(field.bands as usize).fold(0.0, |sum, colors| {
                sum + colors[band as usize] * (-77 * transform::AVERAGE_TEXEL) as f32
            });
            for (i, value) in (0u32..).zip(field.band(band).iter()) {
                let at = [i % field.lattice, i / field.lattice % field.lattice, i / field.lattice.pow(2)];
                if made.shared.map.rank(at.map(|c| c / edge)).is_none() {
                    assert_eq!(*value, expected, "texel {at:?} band {band}");
                }
            }
        }
    }
}

#[test]
fn coarse_light_goes_linearly_from_one_average_to_the_next() {
    // 2^3 averages: 0 below and 320 above along x.
    let grid = std::array::from_fn::<i16, 8, _>(|code| 320 * (code & 1) as i16);
    let coarse = coarse::Coarse { edge: 2, averages: &grid };
    let texels: Vec<i32> = (0..32).map(|x| coarse.texel([x, 9, 20]) / transform::AVERAGE_TEXEL).collect();
    // Centres lie at 8 and 24, texel x at x + 1/2: 20 an edge of a texel.
    let expected: Vec<i32> = (0..32).map(|x| (20 * x - 150).clamp(0, 320)).collect();
    assert_eq!(texels, expected);
}

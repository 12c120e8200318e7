//! Samples straight from bits, one by one, and by a cursor, against the decoded texels.

use super::*;
use crate::sample;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(CASES))]

    #[test]
    fn a_sample_at_the_centre_of_a_texel_is_the_texel_to_the_bit(seed: u64, haar: bool) {
        // Small enough that no sum reaches 2^24.
        let made = made(seed, haar, 500, 4);
        let base = read(&made, &mut Random(seed));
        let field = base.field();
        let mut out = vec![0.0f32; field.bands as usize];
        for site in 0..LATTICE.pow(3) {
            let at = [site % LATTICE, site / LATTICE % LATTICE, site / LATTICE.pow(2)];
            base.sample(at.map(|c| f64::from(c) + 0.5), &mut out);
            for (band, value) in out.iter().enumerate() {
                let texel = field.band(band as u32)[site as usize];
                prop_assert_eq!(value.to_bits(), texel.to_bits(), "{:?} band {}: {} {}", at, band, value, texel);
            }
        }
    }

    #[test]
    fn a_cursor_adds_up_bases_whatever_it_sampled_before(seed: u64, haar: bool) {
        let made = made(seed, haar, 500, 4);
        let random = &mut Random(seed);
        let one = read(&made, random);
        // The other reads the same fields in another order, with colours and a unit of its own.
        let [first, second, third] = made.head.axes;
        let rotation = made.head.rotation.iter().map(|share| 0.5 - share).collect();
        let head = Head { axes: [third, first, second], unit: 0.75 * made.head.unit, rotation, ..made.head.clone() };
        let mut two = CodedBase::new(&made.shared, head.checked().expect("a sound head"), made.averages.clone());
        for (first, count, payload) in pages(&made, random) {
            two.add(first, count, &payload).expect("a sound page");
        }
        let peaks = [&one, &two].map(peak_of);
        let sums = vec![vec![(&one, 0.75), (&two, -0.5)], vec![(&two, 1.5)]];
        let mut cursor = Cursor::of_sums(sums.clone());
        let bands = made.head.bands as usize;
        let (mut found, mut again, mut one) = (vec![0.0; 2 * bands], vec![0.0; 2 * bands], vec![0.0; bands]);
        for _ in 0..500 {
            let point = [(); 3].map(|()| random.unit() * f64::from(LATTICE + 2) - 1.0);
            cursor.sample(point, &mut found);
            Cursor::of_sums(sums.clone()).sample(point, &mut again);
            prop_assert_eq!(&found, &again);
            for (sum, found) in sums.iter().zip(found.chunks(bands)) {
                let mut expected = vec![0.0; bands];
                for (base, factor) in sum {
                    base.sample(point, &mut one);
                    expected.iter_mut().zip(&one).for_each(|(sum, value)| *sum += factor * value);
                }
                for (a, b) in found.iter().zip(&expected) {
                    prop_assert!((a - b).abs() <= 2.0 * ROUNDING * (peaks[0] + peaks[1]), "{point:?}: {a}, expected {b}");
                }
            }
        }
        // A whole block has the bits of its texels' samples, stored or not.
        let mut texels = vec![0.0; TEXELS * found.len()];
        for _ in 0..20 {
            let block = [(); 3].map(|()| random.below(LATTICE as usize / 4) as u32);
            cursor.block(block, &mut texels);
            for (texel, texels) in texels.chunks_exact(found.len()).enumerate() {
                let inside = [texel % 4, texel / 4 % 4, texel / 16];
                let point = std::array::from_fn(|axis| f64::from(4 * block[axis]) + inside[axis] as f64 + 0.5);
                cursor.sample(point, &mut found);
                prop_assert_eq!(&found[..], texels, "{:?} {}", block, texel);
            }
        }
    }

    #[test]
    fn samples_between_texels_are_those_of_the_decoded_field(seed: u64, haar: bool) {
        let made = made(seed, haar, 500, 4);
        let random = &mut Random(seed);
        let base = read(&made, random);
        let field = base.field();
        let peak = peak_of(&base);
        let mut cursor = Cursor::new(&base);
        let mut samples = vec![vec![0.0; field.bands as usize]; 4];
        for _ in 0..2000 {
            let point = [(); 3].map(|()| random.unit() * f64::from(LATTICE + 2) - 1.0);
            let [straight, scalar, expanded, oracle] = &mut samples[..] else { unreachable!("four") };
            base.sample(point, straight);
            base.sample_with(lanes::Scalar, &SpeciesPoint::new(base.shared(), point), scalar);
            cursor.sample(point, expanded);
            sample::trilinear(&field, point, oracle);
            // Eight lanes at once or one after the other: the same bits.
            prop_assert_eq!(&straight, &scalar);
            for (band, b) in oracle.iter().enumerate() {
                for a in [straight[band], expanded[band]] {
                    prop_assert!((a - b).abs() <= ROUNDING * peak, "{point:?}: {a}, expected {b}");
                }
            }
        }
    }
}

/// Texels read one by one from a base of all blocks, in the largest lattice too: no coarse level, the longest of maps.
#[test]
fn samples_of_full_maps_are_their_texels() {
    for (lattice, points) in [(16, 4096), (256, 20_000)] {
        let made = made_on(BlockMap::all(lattice), &mut Random(5), lattice == 16, 500, 4);
        assert!(made.averages.coarse.is_empty());
        let random = &mut Random(6);
        let base = read(&made, random);
        let mut cursor = Cursor::new(&base);
        let bands = made.head.bands as usize;
        let colors = made.head.colors();
        let peak = peak_of(&base);
        let (mut straight, mut expanded) = (vec![0.0f32; bands], vec![0.0f32; bands]);
        for i in 0..points {
            // Both ends of the lattice, then anywhere.
            let site = if i < 2 {
                [i * (lattice - 1); 3]
            } else {
                [(); 3].map(|()| random.below(lattice as usize) as u32)
            };
            let rank = made.shared.map.rank(site.map(|c| c / 4)).expect("all blocks are stored") as usize;
            let texel = site.iter().rev().fold(0, |at, c| 4 * at + (c % 4) as usize);
            base.sample(site.map(|c| f64::from(c) + 0.5), &mut straight);
            cursor.sample(site.map(|c| f64::from(c) + 0.5), &mut expanded);
            for band in 0..bands {
                let light = (0..made.head.components()).fold(0.0f32, |sum, c| {
                    sum + colors[c * bands + band] * base.texels(rank, c)[texel] as f32
                });
                assert_eq!(straight[band], light, "{site:?} band {band}");
                let apart = (expanded[band] - light).abs();
                assert!(apart <= ROUNDING * peak, "{site:?} band {band}: {apart}");
            }
        }
    }
}

fn peak_of(base: &CodedBase) -> f32 {
    base.field().values().iter().fold(0.0f32, |peak, value| peak.max(value.abs()))
}

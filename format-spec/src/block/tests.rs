use proptest::prelude::*;

use super::*;

/// Six levels of one rounding each on values of magnitude 20 and their partial sums.
const ROUNDING: f32 = 20.0 * 64.0 * f32::EPSILON;

fn coded(texels: &[f32], bands: usize, threshold: f32) -> (u64, Vec<f32>) {
    let mut coefficients = Vec::new();
    let mask = encode(texels, bands, threshold, &mut coefficients);
    assert_eq!(coefficients.len(), mask.count_ones() as usize * bands);
    (mask, coefficients)
}

fn decoded(mask: u64, coefficients: &[f32], bands: usize) -> Vec<f32> {
    let mut texels = vec![f32::NAN; TEXELS * bands];
    decode(mask, coefficients, bands, &mut texels);
    texels
}

/// Each site a value of its own.
fn counting_field(lattice: u32, bands: u32) -> Field {
    let mut field = Field::zeros(lattice, bands);
    field.values_mut().iter_mut().enumerate().for_each(|(i, v)| *v = i as f32);
    field
}

#[test]
fn blocks_cover_every_pair_of_texels_and_no_more() {
    for lattice in 2..=256 {
        let last = blocks_per_axis(lattice) - 1;
        assert!(last * 3 <= lattice - 2, "the last block of {lattice} holds a pair");
        assert!(last * 3 + 3 >= lattice - 1, "the last pair of {lattice} is in the last block");
    }
    assert_eq!([16, 32, 64, 128, 256].map(blocks_per_axis), [5, 11, 21, 43, 85]);
}

#[test]
fn gather_repeats_the_edge_texel() {
    let field = counting_field(6, 2);
    let mut texels = vec![0.0; 128];
    gather(&field, [0, 1, 1], &mut texels);
    for (i, texel) in texels.chunks_exact(2).enumerate() {
        let (x, y, z) = (i % 4, (3 + i / 4 % 4).min(5), (3 + i / 16).min(5));
        let site = (z * 6 + y) * 6 + x;
        assert_eq!(texel, [site as f32, (216 + site) as f32]);
    }
}

#[test]
fn scatter_undoes_gather_in_any_order() {
    for lattice in [2, 3, 4, 5, 6, 7, 16] {
        let field = counting_field(lattice, 2);
        let mut again = Field::zeros(lattice, 2);
        let edge = blocks_per_axis(lattice);
        let mut texels = vec![0.0; 128];
        for b in (0..edge.pow(3)).rev() {
            let block = [b % edge, b / edge % edge, b / edge / edge];
            gather(&field, block, &mut texels);
            scatter(&mut again, block, &texels);
        }
        assert_eq!(again, field, "lattice {lattice}");
    }
}

#[test]
fn a_shared_layer_belongs_to_the_block_that_it_begins() {
    let write = |order: [u32; 2]| {
        let mut field = Field::zeros(7, 1);
        for x in order {
            scatter(&mut field, [x, 0, 0], &[1.0 + x as f32; 64]);
        }
        field.values()[..7].to_vec()
    };
    assert_eq!(write([0, 1]), [1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0]);
    assert_eq!(write([1, 0]), write([0, 1]));
}

#[test]
fn a_constant_block_is_one_value_and_an_empty_block_none() {
    let constant: Vec<f32> = (0..64).flat_map(|_| [0.3, 0.0, 18.8]).collect();
    assert_eq!(coded(&constant, 3, 0.0), (1, vec![0.3, 0.0, 18.8]));
    assert_eq!(decoded(1, &[0.3, 0.0, 18.8], 3), constant);
    assert_eq!(coded(&[0.0; 192], 3, 0.0), (0, vec![]));
    assert_eq!(coded(&[-0.0; 192], 3, 0.0), (0, vec![]));
    assert!(decoded(0, &[], 3).iter().all(|v| v.to_bits() == 0));
}

#[test]
fn no_negative_zero_is_written() {
    // The average of band 1 is (-0 + -0) / 2, beside a band that keeps the coefficient.
    let texels: Vec<f32> = (0..64).flat_map(|_| [1.0, -0.0]).collect();
    let (mask, coefficients) = coded(&texels, 2, 0.0);
    assert_eq!(mask, 1);
    assert_eq!(coefficients[1].to_bits(), 0);
}

#[test]
fn the_average_is_kept_below_the_threshold_and_a_detail_at_it_is_not() {
    // 0.5 +- 0.25 along x: average 0.5, one detail of exactly 0.25.
    let texels: Vec<f32> = (0..64).map(|i| if i % 4 < 2 { 0.75 } else { 0.25 }).collect();
    assert_eq!(coded(&texels, 1, 0.25), (1, vec![0.5]));
    assert_eq!(coded(&texels, 1, 1000.0), (1, vec![0.5]));
    assert_eq!(coded(&texels, 1, 0.2499), (0b11, vec![0.5, 0.25]));
}

#[test]
fn one_band_over_the_threshold_keeps_all_bands() {
    let texels: Vec<f32> = (0..64).flat_map(|i| [1.0, if i % 4 < 2 { 1.5 } else { 0.5 }, 1.0]).collect();
    assert_eq!(coded(&texels, 3, 0.4), (0b11, vec![1.0, 1.0, 1.0, 0.0, 0.5, 0.0]));
}

#[test]
fn a_nan_is_kept_so_that_it_can_be_found() {
    let mut texels = [1.0; 64];
    texels[63] = f32::NAN;
    let (mask, coefficients) = coded(&texels, 1, 10.0);
    assert!(mask != 1 && coefficients.iter().any(|c| c.is_nan()));
}

#[test]
#[should_panic(expected = "mask 0000000000000003")]
fn decode_wants_as_many_coefficients_as_bits() {
    decode(0b11, &[1.0], 1, &mut [0.0; 64]);
}

fn texels(bands: usize) -> impl Strategy<Value = Vec<f32>> {
    let smooth = prop::collection::vec(-1.0f32..1.0, 4).prop_map(move |c| {
        (0..TEXELS * bands)
            .map(|i| {
                let (t, b) = (i / bands, (i % bands) as f32);
                c[0] * 10.0 + c[1] * (t % 4) as f32 + c[2] * (t / 4 % 4) as f32 * b + c[3] * (t / 16) as f32
            })
            .collect()
    });
    prop_oneof![prop::collection::vec(-20.0f32..20.0, TEXELS * bands), smooth]
}

proptest! {
    #[test]
    fn decode_undoes_encode_at_threshold_zero((bands, texels) in (1usize..6).prop_flat_map(|b| (Just(b), texels(b)))) {
        let (mask, coefficients) = coded(&texels, bands, 0.0);
        for (again, texel) in decoded(mask, &coefficients, bands).iter().zip(&texels) {
            prop_assert!((again - texel).abs() <= ROUNDING, "{again} for {texel}");
        }
    }

    #[test]
    fn error_is_within_the_sum_of_what_was_dropped(texels in texels(3), threshold in 0.0f32..4.0) {
        let (mask, coefficients) = coded(&texels, 3, threshold);
        let bound = (64 - mask.count_ones()) as f32 * threshold + ROUNDING;
        for (again, texel) in decoded(mask, &coefficients, 3).iter().zip(&texels) {
            prop_assert!((again - texel).abs() <= bound, "{again} for {texel}, bound {bound}");
        }
    }

    #[test]
    fn a_higher_threshold_never_keeps_more(texels in texels(3), low in 0.0f32..2.0, more in 0.0f32..2.0) {
        let (fine, coarse) = (coded(&texels, 3, low).0, coded(&texels, 3, low + more).0);
        prop_assert_eq!(coarse & !fine, 0);
    }

    #[test]
    fn coding_a_decoded_block_again_changes_nothing_to_speak_of(texels in texels(3), threshold in 0.0f32..4.0) {
        let (mask, coefficients) = coded(&texels, 3, threshold);
        let once = decoded(mask, &coefficients, 3);
        let mut twice = Vec::new();
        let mask = encode(&once, 3, threshold * 0.999, &mut twice);
        for (a, b) in decoded(mask, &twice, 3).iter().zip(&once) {
            prop_assert!((a - b).abs() <= 2.0 * ROUNDING + 64.0 * 0.001 * threshold, "{a} for {b}");
        }
    }
}

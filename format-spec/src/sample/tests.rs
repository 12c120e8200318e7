use proptest::prelude::*;

use super::*;
use crate::block::{TEXELS, decode, encode, gather, scatter};

/// Up to 64 products of coefficients <= 8 and weights <= 1, added in another order than the oracle's.
const ROUNDING: f32 = 8.0 * 128.0 * f32::EPSILON;

/// Trilinear in the 64 texels of one block, written out with eight products.
fn oracle(texels: &[f32], bands: usize, local: [f32; 3], band: usize) -> f32 {
    let first = local.map(|l| (l as usize).min(2));
    let mut sum = 0.0f64;
    for corner in 0..8 {
        let offset: [usize; 3] = std::array::from_fn(|axis| corner >> axis & 1);
        let weight: f64 = (0..3)
            .map(|axis| {
                let t = f64::from(local[axis]) - first[axis] as f64;
                if offset[axis] == 1 { t } else { 1.0 - t }
            })
            .product();
        let [x, y, z] = std::array::from_fn(|axis| first[axis] + offset[axis]);
        sum += weight * f64::from(texels[((z * EDGE + y) * EDGE + x) * bands + band]);
    }
    sum as f32
}

fn local() -> impl Strategy<Value = [f32; 3]> {
    let along =
        prop_oneof![0.0f32..=3.0, prop::sample::select(vec![0.0f32, 1.0, 2.0, 3.0, 0.99999994, 2.9999998])];
    prop::array::uniform3(along)
}

#[test]
fn a_texel_centre_samples_to_its_texel() {
    let texels: Vec<f32> = (0..64).map(|i| i as f32).collect();
    let mut coefficients = Vec::new();
    let mask = encode(&texels, 1, 0.0, &mut coefficients);
    for (i, texel) in texels.iter().enumerate() {
        let mut out = [f32::NAN];
        sample(mask, &coefficients, 1, [i % 4, i / 4 % 4, i / 16].map(|c| c as f32), &mut out);
        assert_eq!(out[0], *texel, "texel {i}");
    }
}

#[test]
fn a_constant_block_samples_to_its_value_everywhere() {
    for local in [[0.0, 1.3, 2.9], [3.0; 3], [0.1, 0.7, 1.9]] {
        let mut out = [f32::NAN; 3];
        sample(1, &[0.3, 0.7, 18.8], 3, local, &mut out);
        assert_eq!(out, [0.3, 0.7, 18.8], "at {local:?}");
        sample(0, &[], 3, local, &mut out);
        assert_eq!(out, [0.0; 3]);
    }
}

#[test]
fn points_outside_take_the_nearest_texel() {
    let mut field = Field::zeros(16, 1);
    field.values_mut().iter_mut().enumerate().for_each(|(i, v)| *v = i as f32);
    let mut out = [0.0];
    trilinear(&field, [-5.0, 0.2, -1e300], &mut out);
    assert_eq!(out[0], 0.0);
    trilinear(&field, [99.0, 15.9, f64::INFINITY], &mut out);
    assert_eq!(out[0], 4095.0);
    trilinear(&field, [f64::NAN, 0.5, 0.5], &mut out);
    assert_eq!(out[0], 0.0);
    assert_eq!(locate(16, [99.0; 3]), BlockPoint { block: [4; 3], local: [3.0; 3] });
    assert_eq!(locate(128, [127.6; 3]), BlockPoint { block: [42; 3], local: [1.0; 3] });
    assert_eq!(locate(16, [-1.0, 0.5, 3.5]), BlockPoint { block: [0, 0, 1], local: [0.0; 3] });
}

#[test]
fn block_index_runs_x_fastest() {
    let at = BlockPoint { block: [1, 2, 3], local: [0.0; 3] };
    assert_eq!(at.block_index(16), 1 + 5 * (2 + 5 * 3));
}

proptest! {
    #[test]
    fn sample_from_coefficients_is_full_decode_then_trilinear(
        bands in 1usize..5, mask: u64, seed in prop::collection::vec(-8.0f32..8.0, 64 * 4), local in local()
    ) {
        let mut texels = vec![0.0; TEXELS * bands];
        let coefficients = &seed[..mask.count_ones() as usize * bands];
        decode(mask, coefficients, bands, &mut texels);
        let mut out = vec![f32::NAN; bands];
        sample(mask, coefficients, bands, local, &mut out);
        for (band, found) in out.iter().enumerate() {
            let expected = oracle(&texels, bands, local, band);
            prop_assert!((found - expected).abs() <= ROUNDING, "band {band}: {found} for {expected}");
        }
    }

    #[test]
    fn a_block_answers_like_the_field_that_it_was_cut_from(
        values in prop::collection::vec(-8.0f32..8.0, 7 * 7 * 7), point in prop::array::uniform3(-0.5f64..7.5)
    ) {
        let field = Field::new(7, 1, values);
        let at = locate(7, point);
        let mut texels = vec![0.0; 64];
        gather(&field, at.block, &mut texels);
        let (mut expected, mut again) = ([0.0], Field::zeros(7, 1));
        trilinear(&field, point, &mut expected);
        prop_assert!((oracle(&texels, 1, at.local, 0) - expected[0]).abs() <= ROUNDING);
        scatter(&mut again, at.block, &texels);
        let mut coefficients = Vec::new();
        let mask = encode(&texels, 1, 0.0, &mut coefficients);
        let mut out = [0.0];
        sample(mask, &coefficients, 1, at.local, &mut out);
        prop_assert!((out[0] - expected[0]).abs() <= 2.0 * ROUNDING, "{} for {}", out[0], expected[0]);
    }

    #[test]
    fn add_scales_and_accumulates(mask: u64, seed in prop::collection::vec(-8.0f32..8.0, 64 * 3), local in local()) {
        let coefficients = &seed[..mask.count_ones() as usize * 3];
        let mut out = [0.0; 3];
        sample(mask, coefficients, 3, local, &mut out);
        let mut sum = [1.0, 2.0, 3.0];
        Weights::at(local).add(mask, coefficients, 0.5, &mut sum);
        prop_assert_eq!(sum, [1.0 + 0.5 * out[0], 2.0 + 0.5 * out[1], 3.0 + 0.5 * out[2]]);
    }
}

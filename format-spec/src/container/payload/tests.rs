use super::super::records::{KIND_BASE, MAX_MAGNITUDE_F16, SectionKey};
use super::*;

/// Finite binary16 of this pattern, from its definition (IEEE 754, 3.4): sign, 5 bits of exponent, 10 of fraction.
fn value_of(bits: u16) -> f32 {
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f32::from(bits & 1023));
    let magnitude = match exponent {
        0 => fraction * power_of_2(-24),
        _ => (1024.0 + fraction) * power_of_2(exponent - 25),
    };
    if bits >> 15 == 1 { -magnitude } else { magnitude }
}

fn power_of_2(exponent: i32) -> f32 {
    f32::from_bits(((exponent + 127) as u32) << 23)
}

fn stored(value: f32) -> u16 {
    let mut bytes = Vec::new();
    encode_raw_f16(&[value], &mut bytes);
    u16::from_le_bytes(bytes.try_into().expect("two bytes a value"))
}

fn read(bits: u16) -> Result<f32, FormatError> {
    let place = Place::page(0, SectionKey { kind: KIND_BASE, species: 0, item: 0 }, 0);
    let mut value = [f32::NAN];
    decode_raw_f16(&bits.to_le_bytes(), PageContext { place, first: 0, count: 1 }, &mut value)?;
    Ok(value[0])
}

/// Infinity has this pattern, and is the first that is not finite.
const INFINITE: u16 = 0x7C00;
const SIGN: u16 = 0x8000;
/// Miri, a thousand times slower, tries some of the patterns.
const STEP: usize = if cfg!(miri) { 61 } else { 1 };

#[test]
fn every_finite_binary16_is_read_as_its_value_and_stored_as_itself() {
    for bits in (0..INFINITE).chain(SIGN + 1..SIGN + INFINITE).step_by(STEP) {
        let value = read(bits).expect("it is finite, and not -0");
        assert_eq!(value.to_bits(), value_of(bits).to_bits(), "{bits:#06x}");
        assert_eq!(stored(value), bits, "{value}");
        assert_eq!(rounded_f16(value), value);
    }
    assert_eq!(value_of(INFINITE - 1), MAX_MAGNITUDE_F16);
}

#[test]
fn values_between_two_binary16_go_to_the_nearer_and_halfway_to_the_even_one() {
    for below in (0..INFINITE - 1).step_by(STEP) {
        let above = below + 1;
        // Exact: both have 11 bits at most, and the exponents of binary32 reach further down.
        let middle = (value_of(below) + value_of(above)) / 2.0;
        let even = if below % 2 == 0 { below } else { above };
        for (value, expected) in [(middle, even), (middle.next_down(), below), (middle.next_up(), above)] {
            assert_eq!(stored(value), expected, "{value}");
            // The mirror image, but for zero, which has one spelling.
            let mirrored = if expected == 0 { 0 } else { expected | SIGN };
            assert_eq!(stored(-value), mirrored, "-{value}");
            assert_eq!(rounded_f16(-value).to_bits(), value_of(mirrored).to_bits());
        }
    }
    assert_eq!(stored(-0.0), 0);
}

#[test]
fn binary16_that_are_not_finite_or_minus_zero_are_refused() {
    for bits in (INFINITE..=0x7FFF).chain(SIGN + INFINITE..=0xFFFF).chain([SIGN]) {
        let error = read(bits).expect_err("no value of a base");
        assert_eq!(error.code(), 5006, "{bits:#06x}: {error}");
    }
    let text = read(SIGN).expect_err("-0").to_string();
    assert!(text.ends_with("value 0 is -0, expected a number of magnitude up to 2^96, and 0 written as +0"));
}

#[test]
fn a_page_of_another_length_is_refused() {
    let place = Place::page(64, SectionKey { kind: KIND_BASE, species: 0, item: 3 }, 0);
    let context = PageContext { place, first: 0, count: 3 };
    for length in [0, 5, 7, 12] {
        let error = decode_raw_f16(&vec![0; length], context, &mut [0.0; 3]).expect_err("not 6 bytes");
        assert_eq!(error.code(), 4003);
        let text = error.to_string();
        assert!(
            text.contains(&length.to_string()) && text.contains('6') && text.contains("base 3"),
            "{text}"
        );
    }
}

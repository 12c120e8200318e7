//! Pictures that the command wrote: their values, and how far two of them are apart.

use std::io::Cursor;

/// Values of a PNG, `[y][x][band]`.
pub(crate) fn pixels(png: &[u8]) -> Vec<u8> {
    let mut reader = png::Decoder::new(Cursor::new(png)).read_info().expect("a PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a small picture")];
    reader.next_frame(&mut pixels).expect("a whole PNG");
    pixels
}

/// Root mean square of the differences of two pictures, of 255.
pub(crate) fn rms(one: &[u8], other: &[u8]) -> f64 {
    assert_eq!(one.len(), other.len());
    let squares = one.iter().zip(other).map(|(a, b)| f64::from(a.abs_diff(*b)) * f64::from(a.abs_diff(*b)));
    (squares.sum::<f64>() / one.len() as f64).sqrt()
}

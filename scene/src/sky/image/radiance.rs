//! Skies of Radiance HDR files: their header is read here, with the primaries, the colour correction and the order of
//! pixels that it states; their pixels by the crate `image`, which knows one order.

use std::io::{Cursor, Read};

use image::ImageDecoder;
use image::codecs::hdr::HdrDecoder;

use super::{Faults, Raw, SkyError};
use crate::sky::primaries::ToSrgb;

/// Bytes of a header.
const HEADER_BYTES: usize = 1 << 16;

/// What a header says (Radiance file formats, "Picture file format").
struct Header {
    /// Bytes of it, the line of the size included.
    length: usize,
    to_srgb: ToSrgb,
    /// What colours were multiplied by.
    correction: [f32; 3],
    order: Order,
}

/// How scanlines lie in the picture.
struct Order {
    /// Scanlines, and pixels of each.
    lines: [usize; 2],
    /// Whether a scanline is a row; else it is a column.
    are_rows: bool,
    /// Whether x and y grow towards the right and downwards.
    forward: [bool; 2],
}

pub(super) fn read(bytes: &[u8], faults: &Faults) -> Result<Raw, SkyError> {
    let header = Header::read(bytes, faults)?;
    let order = &header.order;
    let [count, length] = order.lines;
    let size @ [width, height] = order.size();
    faults.check_size(width, height)?;
    // The decoder's order: a scanline is a row from left to right.
    let head = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {count} +X {length}\n");
    let whole = Cursor::new(head).chain(&bytes[header.length..]);
    let decoder = HdrDecoder::new(whole).map_err(|error| faults.damaged(error.to_string()))?;
    let mut raw = vec![0; count * length * 12];
    decoder.read_image(&mut raw).map_err(|error| faults.damaged(error.to_string()))?;
    let value = |bytes: &[u8]| f32::from_ne_bytes(bytes.try_into().expect("four bytes"));
    let pixel = |bytes: &[u8]| [0, 1, 2].map(|band| value(&bytes[4 * band..][..4]) / header.correction[band]);
    let read: Vec<[f32; 3]> = raw.chunks_exact(12).map(pixel).collect();
    drop(raw);
    let pixels = match order {
        Order { are_rows: true, forward: [true, true], .. } => read,
        _ => (0..width * height).map(|at| read[order.place(at % width, at / width)]).collect(),
    };
    Ok(Raw { size, pixels, to_srgb: header.to_srgb })
}

impl Header {
    fn read(bytes: &[u8], faults: &Faults) -> Result<Header, SkyError> {
        let mut lines = bytes[..bytes.len().min(HEADER_BYTES)].split_inclusive(|byte| *byte == b'\n');
        let mut length = 0;
        let mut next = || {
            let line = lines.next().filter(|line| line.ends_with(b"\n"))?;
            length += line.len();
            Some((String::from_utf8_lossy(line).trim().to_owned(), length))
        };
        let (mut to_srgb, mut correction) = (ToSrgb::SAME, [1.0f32; 3]);
        let cut = || faults.damaged("its header has no end".to_owned());
        loop {
            let (line, _) = next().ok_or_else(cut)?;
            if line.is_empty() {
                break;
            }
            let Some((key, value)) = line.split_once('=').filter(|_| !line.starts_with('#')) else {
                continue;
            };
            let value = value.trim();
            match key.trim() {
                "FORMAT" if value == "32-bit_rle_rgbe" => {}
                "FORMAT" if value == "32-bit_rle_xyze" => to_srgb = ToSrgb::of_xyz(),
                "PRIMARIES" => {
                    let found: [f64; 8] =
                        numbers(value).ok_or_else(|| faults.header(&line, "eight numbers"))?;
                    // Photoshop writes zeros for what it does not know.
                    if found != [0.0; 8] {
                        let primaries = std::array::from_fn(|k| [found[2 * k], found[2 * k + 1]]);
                        to_srgb = faults.to_srgb(&primaries, "PRIMARIES")?;
                    }
                }
                "COLORCORR" => {
                    let found =
                        numbers::<3>(value).filter(|all| all.iter().all(|one| (1e-6..=1e6).contains(one)));
                    let found =
                        found.ok_or_else(|| faults.header(&line, "three numbers from 1e-6 to 1e6"))?;
                    (0..3).for_each(|band| correction[band] *= found[band] as f32);
                }
                "GAMMA" if numbers(value) == Some([1.0]) => {}
                "FORMAT" => {
                    return Err(faults.header(&line, "FORMAT=32-bit_rle_rgbe or FORMAT=32-bit_rle_xyze"));
                }
                "GAMMA" => return Err(faults.header(&line, "GAMMA=1: linear light")),
                // EXPOSURE multiplies all alike, and the unit of a sky is not known.
                _ => {}
            }
        }
        let (line, length) = next().ok_or_else(cut)?;
        let order = Order::of(&line).ok_or_else(|| {
            faults.header(&line, "a size such as -Y 1024 +X 2048, in any of its eight orders")
        })?;
        Ok(Header { length, to_srgb, correction, order })
    }
}

impl Order {
    fn of(line: &str) -> Option<Order> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [outer, count, inner, length] = words[..] else { return None };
        let axis = |word: &str| match word {
            "-Y" => Some((false, true)),
            "+Y" => Some((false, false)),
            "+X" => Some((true, true)),
            "-X" => Some((true, false)),
            _ => None,
        };
        let ((is_x, outer_forward), (inner_is_x, inner_forward)) = (axis(outer)?, axis(inner)?);
        let lines = [count.parse().ok()?, length.parse().ok()?];
        let forward = if is_x { [outer_forward, inner_forward] } else { [inner_forward, outer_forward] };
        (is_x != inner_is_x).then_some(Order { lines, are_rows: !is_x, forward })
    }

    /// Width and height of the picture.
    fn size(&self) -> [usize; 2] {
        let [count, length] = self.lines;
        if self.are_rows { [length, count] } else { [count, length] }
    }

    /// Where a pixel of the picture is among the scanlines.
    fn place(&self, x: usize, y: usize) -> usize {
        let [width, height] = self.size();
        let x = if self.forward[0] { x } else { width - 1 - x };
        let y = if self.forward[1] { y } else { height - 1 - y };
        let [line, at] = if self.are_rows { [y, x] } else { [x, y] };
        line * self.lines[1] + at
    }
}

fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let found: Option<Vec<f64>> = text.split_whitespace().map(|word| word.parse().ok()).collect();
    found?.try_into().ok()
}

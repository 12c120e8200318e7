//! Pictures before and after, and their difference.

use std::io::Cursor;
use std::path::Path;

use flb_format::Source;
use flb_render::picture::png_of;
use flb_runtime::source::FileSource;
use png::{BitDepth, ColorType, Decoder, Limits};

/// Factor on the difference of two pictures, byte by byte.
pub(super) const FACTOR: u8 = 8;
/// Bytes of a picture; those of a build have a tenth of it.
const MAX_FILE_BYTES: u64 = 1 << 20;
/// Pixels along an edge.
const MAX_EDGE: u32 = 4096;
/// Pixels of a picture.
const MAX_PIXELS: u64 = 1 << 18;

/// Two pictures and their difference, as PNG files.
pub(super) struct Pictures {
    pub size: [u32; 2],
    pub files: [Vec<u8>; 3],
}

/// Reads both; `None` where one is missing or no picture that a build writes, and where they differ in size.
pub(super) fn pictures([old, new]: [&Path; 2]) -> Option<Pictures> {
    let (old_file, new_file) = (read(old)?, read(new)?);
    let ((size, old), (other, new)) = (decode(&old_file)?, decode(&new_file)?);
    if size != other {
        return None;
    }
    let difference: Vec<u8> =
        old.iter().zip(&new).map(|(old, new)| old.abs_diff(*new).saturating_mul(FACTOR)).collect();
    Some(Pictures { size, files: [old_file, new_file, png_of(size, &difference).ok()?] })
}

fn read(path: &Path) -> Option<Vec<u8>> {
    let source = FileSource::open(path).ok()?;
    let length = source.len_bytes().ok().filter(|length| *length <= MAX_FILE_BYTES)?;
    let mut bytes = vec![0; length as usize];
    source.read_exact_at(0, &mut bytes).ok()?;
    Some(bytes)
}

/// Size and bytes of the pixels, red, green and blue.
fn decode(file: &[u8]) -> Option<([u32; 2], Vec<u8>)> {
    let limits = Limits { bytes: 4 * MAX_PIXELS as usize };
    let mut reader = Decoder::new_with_limits(Cursor::new(file), limits).read_info().ok()?;
    let info = reader.info();
    let (size, kind) = ([info.width, info.height], (info.color_type, info.bit_depth));
    let is_small = size.iter().all(|edge| *edge <= MAX_EDGE)
        && size.iter().map(|edge| u64::from(*edge)).product::<u64>() <= MAX_PIXELS;
    if !is_small || kind != (ColorType::Rgb, BitDepth::Eight) {
        return None;
    }
    let mut pixels = vec![0; 3 * size[0] as usize * size[1] as usize];
    reader.next_frame(&mut pixels).ok()?;
    Some((size, pixels))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_difference_is_amplified_and_bad_pictures_are_none() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, bytes: &[u8]| {
            let path = folder.path().join(name);
            std::fs::write(&path, bytes).unwrap();
            path
        };
        let old = file("old.png", &png_of([2, 1], &[10, 20, 30, 40, 50, 60]).unwrap());
        let new = file("new.png", &png_of([2, 1], &[11, 18, 30, 90, 50, 60]).unwrap());
        let found = pictures([&old, &new]).unwrap();
        assert_eq!(decode(&found.files[2]).unwrap().1, [8, 16, 0, 255, 0, 0]);
        let wide = file("wide.png", &png_of([1, 1], &[1, 2, 3]).unwrap());
        let bad = file("bad.png", b"\x89PNG\r\n\x1a\nno");
        let gone = folder.path().join("gone.png");
        for other in [&wide, &bad, &gone] {
            assert!(pictures([&old, other]).is_none(), "{other:?}");
        }
    }
}

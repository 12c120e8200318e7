//! PNG without what says nothing about its texels. A colour profile and a text are compressed: a file of some hundred
//! kilobytes may hold hundreds of megabytes, which the decoder would unpack before it looks at a texel.

use std::borrow::Cow;

/// Kinds of chunks that are left out: colour profiles, texts, Exif.
const LEFT_OUT: [&[u8; 4]; 5] = [b"iCCP", b"tEXt", b"zTXt", b"iTXt", b"eXIf"];
const SIGNATURE: &[u8; 8] = b"\x89PNG\r\n\x1a\n";
/// Of a chunk's length, kind and check sum.
const FRAME_BYTES: usize = 12;

/// Takes those chunks out of a PNG, in place where the bytes are owned. What is no PNG, or is cut within a chunk, stays
/// as it is from there on.
pub(crate) fn leave_out_metadata(bytes: &mut Cow<'_, [u8]>) {
    if !bytes.starts_with(SIGNATURE) || !chunks(bytes).any(|(_, is_left_out)| is_left_out) {
        return;
    }
    let bytes = bytes.to_mut();
    let (mut read, mut written) = (SIGNATURE.len(), SIGNATURE.len());
    while let Some((length, is_left_out)) = chunk(&bytes[read..]) {
        if !is_left_out {
            bytes.copy_within(read..read + length, written);
            written += length;
        }
        read += length;
    }
    let end = bytes.len();
    bytes.copy_within(read..end, written);
    bytes.truncate(written + end - read);
}

/// Length of each whole chunk, frame included, and whether it is left out.
fn chunks(bytes: &[u8]) -> impl Iterator<Item = (usize, bool)> {
    let mut rest = &bytes[SIGNATURE.len()..];
    std::iter::from_fn(move || {
        let found = chunk(rest)?;
        rest = &rest[found.0..];
        Some(found)
    })
}

fn chunk(bytes: &[u8]) -> Option<(usize, bool)> {
    let (length, kind) = (bytes.first_chunk::<4>()?, bytes.get(4..8)?);
    let length = usize::try_from(u32::from_be_bytes(*length)).ok()?.checked_add(FRAME_BYTES)?;
    (length <= bytes.len()).then(|| (length, LEFT_OUT.iter().any(|left_out| left_out[..] == *kind)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn made(chunks: &[(&[u8; 4], usize)]) -> Vec<u8> {
        let mut bytes = SIGNATURE.to_vec();
        for (i, (kind, length)) in chunks.iter().enumerate() {
            bytes.extend((*length as u32).to_be_bytes());
            bytes.extend(kind.iter().copied());
            bytes.extend(std::iter::repeat_n(i as u8, length + 4));
        }
        bytes
    }

    #[test]
    fn chunks_of_metadata_are_left_out_and_all_others_stay() {
        let all = made(&[
            (b"IHDR", 13),
            (b"iCCP", 9),
            (b"gAMA", 4),
            (b"zTXt", 0),
            (b"IDAT", 7),
            (b"iTXt", 3),
            (b"IEND", 0),
        ]);
        let mut kept = made(&[(b"IHDR", 13)]);
        for (i, (kind, length)) in [(2, (b"gAMA", 4)), (4, (b"IDAT", 7)), (6, (b"IEND", 0))] {
            kept.extend((length as u32).to_be_bytes());
            kept.extend(kind);
            kept.extend(std::iter::repeat_n(i, length + 4));
        }
        for mut bytes in [Cow::Borrowed(&all[..]), Cow::Owned(all.clone())] {
            leave_out_metadata(&mut bytes);
            assert_eq!(bytes, kept);
            leave_out_metadata(&mut bytes);
            assert_eq!(bytes, kept);
        }
        let mut borrowed = Cow::Borrowed(&kept[..]);
        leave_out_metadata(&mut borrowed);
        assert!(matches!(borrowed, Cow::Borrowed(_)), "nothing is copied for nothing");
    }

    #[test]
    fn what_is_cut_or_no_png_stays_from_there_on() {
        let all = made(&[(b"IHDR", 13), (b"tEXt", 9), (b"iCCP", 9)]);
        for end in 0..all.len() {
            let mut bytes = Cow::Borrowed(&all[..end]);
            leave_out_metadata(&mut bytes);
            let text = 8 + 25;
            let expected = if end < text + 21 {
                all[..end].to_vec()
            } else {
                [&all[..text], &all[text + 21..end]].concat()
            };
            assert_eq!(bytes, expected, "{end}");
        }
    }
}

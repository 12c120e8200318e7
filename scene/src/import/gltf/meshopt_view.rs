//! Unpacks a buffer view of EXT_meshopt_compression. The codec is meshoptimizer's own, by the
//! `meshopt` crate, whose decoders bear hostile bytes; sizes are checked here because its C side
//! only asserts them.

use serde::Deserialize;

use crate::import::error::ImportError;
use crate::import::files::Files;
use crate::import::limits;

/// The extension's JSON.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Compressed {
    /// Buffer with the packed bytes.
    pub buffer: usize,
    /// First packed byte.
    #[serde(default)]
    pub byte_offset: u64,
    /// Packed bytes.
    pub byte_length: u64,
    byte_stride: u64,
    count: u64,
    mode: Mode,
    #[serde(default)]
    filter: Filter,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
enum Mode {
    Attributes,
    Triangles,
    Indices,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
enum Filter {
    #[default]
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Color,
}

impl Compressed {
    /// Bytes after unpacking, once stride, count and filter are known to fit each other.
    pub(super) fn unpacked_bytes(&self, files: &Files, place: &str) -> Result<u64, ImportError> {
        let stride = self.byte_stride;
        let stride_fits = match self.mode {
            Mode::Attributes => (4..=256).contains(&stride) && stride.is_multiple_of(4),
            Mode::Triangles | Mode::Indices => stride == 2 || stride == 4,
        };
        let filter_fits = match self.filter {
            Filter::None => true,
            Filter::Octahedral | Filter::Color => {
                self.mode == Mode::Attributes && (stride == 4 || stride == 8)
            }
            Filter::Quaternion => self.mode == Mode::Attributes && stride == 8,
            Filter::Exponential => self.mode == Mode::Attributes,
        };
        if !stride_fits || !filter_fits {
            let found = format!("byteStride {stride} with mode {:?} and filter {:?}", self.mode, self.filter);
            return Err(files.malformed(place, found, "a stride that mode and filter allow"));
        }
        if self.mode == Mode::Triangles && !self.count.is_multiple_of(3) {
            return Err(files.malformed(place, format!("count {}", self.count), "a multiple of 3"));
        }
        files.limit(format!("{place}: count"), self.count, 3 * limits::TRIANGLES)?;
        Ok(self.count * stride)
    }
}

/// The unpacked bytes. [`Compressed::unpacked_bytes`] must have been asked before.
pub(super) fn unpack(
    files: &Files,
    place: &str,
    view: &Compressed,
    packed: &[u8],
) -> Result<Vec<u8>, ImportError> {
    let count = view.count as usize;
    let bytes = match (view.mode, view.byte_stride) {
        (Mode::Attributes, stride) => decode_rows(stride / 4, packed, count).map(|mut bytes| {
            apply_filter(view.filter, stride, &mut bytes);
            bytes
        }),
        (Mode::Triangles, 2) => {
            meshopt::decode_index_buffer(packed, count).map(|v| bytes_of(&v, u16::to_le_bytes)).ok()
        }
        (Mode::Triangles, _) => {
            meshopt::decode_index_buffer(packed, count).map(|v| bytes_of(&v, u32::to_le_bytes)).ok()
        }
        (Mode::Indices, 2) => {
            meshopt::decode_index_sequence(packed, count).map(|v| bytes_of(&v, u16::to_le_bytes)).ok()
        }
        (Mode::Indices, _) => {
            meshopt::decode_index_sequence(packed, count).map(|v| bytes_of(&v, u32::to_le_bytes)).ok()
        }
    };
    bytes.ok_or_else(|| {
        let found = format!("{} packed bytes that do not decode", packed.len());
        files.malformed(place, found, format!("{count} elements of mode {:?}", view.mode))
    })
}

/// One element of `WORDS` words: the decoder takes its element size from a type.
#[derive(Clone)]
struct Row<const WORDS: usize>([u32; WORDS]);

impl<const WORDS: usize> Default for Row<WORDS> {
    fn default() -> Self {
        Row([0; WORDS])
    }
}

fn decode_rows(words: u64, packed: &[u8], count: usize) -> Option<Vec<u8>> {
    fn rows<const WORDS: usize>(packed: &[u8], count: usize) -> Option<Vec<u8>> {
        let rows = meshopt::decode_vertex_buffer::<Row<WORDS>>(packed, count).ok()?;
        let mut bytes = Vec::with_capacity(rows.len() * 4 * WORDS);
        for word in rows.iter().flat_map(|row| &row.0) {
            bytes.extend_from_slice(&word.to_ne_bytes());
        }
        Some(bytes)
    }
    macro_rules! by_size {
        ($($words:literal)*) => {
            match words {
                $($words => rows::<$words>(packed, count),)*
                _ => None,
            }
        };
    }
    by_size!(1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32
        33 34 35 36 37 38 39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62 63 64)
}

fn bytes_of<T: Copy, const BYTES: usize>(values: &[T], to_bytes: impl Fn(T) -> [u8; BYTES]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(values.len() * BYTES);
    values.iter().for_each(|&value| bytes.extend_from_slice(&to_bytes(value)));
    bytes
}

/// Undoes the filter in place. Whole elements only, so nothing is left over.
fn apply_filter(filter: Filter, stride: u64, bytes: &mut [u8]) {
    fn in_words<T: Copy>(
        bytes: &mut [u8],
        read: impl Fn([u8; 2]) -> T,
        write: impl Fn(T) -> [u8; 2],
        decode: impl Fn(&mut [[T; 4]]),
    ) {
        let (pairs, _) = bytes.as_chunks_mut::<8>();
        let word = |row: &[u8; 8], i: usize| read([row[2 * i], row[2 * i + 1]]);
        let mut rows: Vec<[T; 4]> = pairs.iter().map(|row| std::array::from_fn(|i| word(row, i))).collect();
        decode(&mut rows);
        for (row, decoded) in pairs.iter_mut().zip(rows) {
            for (pair, value) in row.as_chunks_mut::<2>().0.iter_mut().zip(decoded) {
                *pair = write(value);
            }
        }
    }
    match (filter, stride) {
        (Filter::None, _) => {}
        (Filter::Octahedral, 4) => {
            let mut rows: Vec<[i8; 4]> =
                bytes.as_chunks::<4>().0.iter().map(|row| row.map(|b| b as i8)).collect();
            meshopt::decode_filter_oct(&mut rows);
            let decoded = rows.iter().flatten().map(|&b| b as u8);
            bytes.iter_mut().zip(decoded).for_each(|(byte, value)| *byte = value);
        }
        (Filter::Octahedral, _) => {
            in_words(bytes, i16::from_ne_bytes, i16::to_ne_bytes, meshopt::decode_filter_oct);
        }
        (Filter::Quaternion, _) => {
            in_words(bytes, i16::from_ne_bytes, i16::to_ne_bytes, meshopt::decode_filter_quat);
        }
        (Filter::Color, 4) => meshopt::decode_filter_color(bytes.as_chunks_mut::<4>().0),
        (Filter::Color, _) => {
            in_words(bytes, u16::from_ne_bytes, u16::to_ne_bytes, meshopt::decode_filter_color);
        }
        (Filter::Exponential, _) => {
            let mut rows: Vec<[u32; 1]> =
                bytes.as_chunks::<4>().0.iter().map(|word| [u32::from_ne_bytes(*word)]).collect();
            meshopt::decode_filter_exp(&mut rows);
            for (word, row) in bytes.as_chunks_mut::<4>().0.iter_mut().zip(rows) {
                *word = row[0].to_ne_bytes();
            }
        }
    }
}

//! Lines of a text file, whatever ends them (LF, CR LF, CR, in one file too) and whatever they are written in: UTF-8,
//! Windows-1252 with Latin-1 in it, UTF-16 with a byte order mark. Reads piece by piece; keeps one line.

use std::borrow::Cow;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::{Files, name_of, open_regular, words};
use crate::import::error::ImportError;
use crate::import::limits;

/// Bytes that are read at a time.
const PIECE_BYTES: usize = 1 << 16;

/// A text file that is being read.
pub(super) struct Text {
    path: PathBuf,
    limit_bytes: u64,
    lines: Lines<BufReader<Source>>,
    /// The line, with those that a backslash joins to it.
    line: Vec<u8>,
    /// Lines so far.
    number: u64,
    /// Whether all of the file is UTF-8; not known before a line that is not ASCII.
    is_utf8: Option<bool>,
}

impl Text {
    /// Opens a file of at most `limit_bytes`.
    pub(super) fn open(path: &Path, limit_bytes: u64) -> Result<Text, ImportError> {
        let mut file = open_regular(path)?;
        let io = |source| ImportError::Io { path: path.to_owned(), source };
        let mut start = Vec::new();
        (&mut file).take(4).read_to_end(&mut start).and_then(|_| file.rewind()).map_err(io)?;
        let big_endian = match start[..] {
            [0xFF, 0xFE, 0, 0] | [0, 0, 0xFE, 0xFF] => {
                let message = format!("is UTF-32 text, expected {KNOWN}");
                return Err(ImportError::Syntax { file: name_of(path), message });
            }
            [0xFF, 0xFE, ..] => Some(false),
            [0xFE, 0xFF, ..] => Some(true),
            _ => None,
        };
        let hashed = Hashed { file, hasher: blake3::Hasher::new(), total: 0 };
        let source = match big_endian {
            Some(big_endian) => Source::Wide(Wide::new(hashed, big_endian)),
            None => Source::Bytes(hashed),
        };
        Ok(Text {
            path: path.to_owned(),
            limit_bytes,
            lines: Lines { reader: BufReader::with_capacity(PIECE_BYTES, source), after_cr: false },
            line: Vec::new(),
            number: 0,
            is_utf8: big_endian.map(|_| true),
        })
    }

    /// The next line without its end, and its number from 1. A byte order mark is dropped; a backslash at a line's end
    /// joins the next one.
    pub(super) fn next(&mut self, files: &Files) -> Result<Option<(u64, Cow<'_, str>)>, ImportError> {
        self.line.clear();
        let mut first = None;
        loop {
            let blank = self.lines.pass_blank().map_err(|error| self.error(error))?;
            self.number += blank;
            // An empty line ends what a backslash would join to it.
            if first.is_some() && blank > 0 {
                break;
            }
            if !self.lines.append(&mut self.line).map_err(|error| self.error(error))? {
                break;
            }
            let total = self.lines.reader.get_ref().hashed().total;
            if total > self.limit_bytes {
                files.limit(format!("bytes of {}", name_of(&self.path)), total, self.limit_bytes)?;
            }
            self.number += 1;
            let number = *first.get_or_insert(self.number);
            if self.line.len() as u64 > limits::LINE_BYTES {
                let what = format!("bytes of line {number} of {}", name_of(&self.path));
                files.limit(what, self.line.len() as u64, limits::LINE_BYTES)?;
            }
            if !self.is_continued()? {
                break;
            }
            *self.line.last_mut().expect("a backslash") = b' ';
        }
        let Some(number) = first else { return Ok(None) };
        if number == 1 {
            if self.line.starts_with(b"\xEF\xBB\xBF") {
                self.line.drain(..3);
            }
            if self.line.contains(&0) {
                let message = format!("line 1 holds a byte 0, expected {KNOWN}");
                return Err(ImportError::Syntax { file: name_of(&self.path), message });
            }
        }
        if self.is_utf8.is_none() && !self.line.is_ascii() {
            self.is_utf8 = Some(self.is_all_utf8()?);
        }
        let line = match self.is_utf8.unwrap_or(true) {
            true => words::decoded(&self.line),
            false => words::latin(&self.line).into(),
        };
        Ok(Some((number, line)))
    }

    /// Whether a backslash joins the next line. Behind a byte that is no ASCII, in a file that is no UTF-8, it is the
    /// second byte of a character: Shift JIS has such (of a table, of an ability).
    fn is_continued(&mut self) -> Result<bool, ImportError> {
        let is_character = match self.line.as_slice() {
            [.., before, b'\\'] => !before.is_ascii(),
            [b'\\'] => false,
            _ => return Ok(false),
        };
        if is_character && self.is_utf8.is_none() {
            self.is_utf8 = Some(self.is_all_utf8()?);
        }
        Ok(!is_character || self.is_utf8 == Some(true))
    }

    /// Digest and length, once all is read.
    pub(super) fn digest(&self) -> (blake3::Hash, u64) {
        let hashed = self.lines.reader.get_ref().hashed();
        (hashed.hasher.finalize(), hashed.total)
    }

    fn error(&self, source: io::Error) -> ImportError {
        match source.kind() {
            io::ErrorKind::InvalidData => {
                ImportError::Syntax { file: name_of(&self.path), message: source.to_string() }
            }
            _ => ImportError::Io { path: self.path.clone(), source },
        }
    }

    /// Whether all lines but comments are UTF-8. One that is not decides for all of them: a name has one reading in one
    /// file. Comments tell of the exporter's folders and people, and have no say.
    fn is_all_utf8(&mut self) -> Result<bool, ImportError> {
        let io = |source| ImportError::Io { path: self.path.clone(), source };
        let Source::Bytes(Hashed { file, .. }) = self.lines.reader.get_mut() else { return Ok(true) };
        let place = file.stream_position().map_err(io)?;
        file.rewind().map_err(io)?;
        let mut lines = Lines { reader: BufReader::with_capacity(PIECE_BYTES, &mut *file), after_cr: false };
        let (mut line, mut is_utf8) = (Vec::new(), true);
        while is_utf8 && lines.pass_blank().and_then(|_| lines.append(&mut line)).map_err(io)? {
            let is_comment = line.trim_ascii_start().starts_with(b"#");
            is_utf8 = is_comment || std::str::from_utf8(&line).is_ok();
            // What is too long is an error once it is read.
            if line.len() as u64 > limits::LINE_BYTES {
                break;
            }
            line.clear();
        }
        drop(lines);
        file.seek(SeekFrom::Start(place)).map_err(io)?;
        Ok(is_utf8)
    }
}

const KNOWN: &str = "text in UTF-8, in Latin-1, or in UTF-16 with a byte order mark";

/// Splits at LF, CR LF and CR. A run of CR before LF is one end, as conversions leave CR CR LF.
struct Lines<R> {
    reader: R,
    after_cr: bool,
}

impl<R: BufRead> Lines<R> {
    /// Passes over the rest of the end of the last line, and over empty lines that CR ends; how many those are.
    fn pass_blank(&mut self) -> io::Result<u64> {
        let mut blank = 0;
        while std::mem::take(&mut self.after_cr) {
            match self.reader.fill_buf()?.first() {
                Some(b'\r') => (self.after_cr, blank) = (true, blank + 1),
                Some(b'\n') => blank = 0,
                _ => break,
            }
            self.reader.consume(1);
        }
        Ok(blank)
    }

    /// Adds the next line to `line`, to one byte more than a line may have; whether there was one.
    fn append(&mut self, line: &mut Vec<u8>) -> io::Result<bool> {
        let mut is_there = false;
        loop {
            let piece = self.reader.fill_buf()?;
            if piece.is_empty() {
                return Ok(is_there);
            }
            is_there = true;
            let left = (limits::LINE_BYTES as usize + 1).saturating_sub(line.len());
            let end = memchr::memchr2(b'\n', b'\r', piece);
            let length = end.unwrap_or(piece.len());
            if length >= left {
                line.extend_from_slice(&piece[..left]);
                return Ok(true);
            }
            line.extend_from_slice(&piece[..length]);
            self.after_cr = end.is_some_and(|end| piece[end] == b'\r');
            self.reader.consume(length + usize::from(end.is_some()));
            if end.is_some() {
                return Ok(true);
            }
        }
    }
}

/// A file whose bytes are counted and go into a digest as they are read.
struct Hashed {
    file: File,
    hasher: blake3::Hasher,
    total: u64,
}

impl Read for Hashed {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let got = self.file.read(into)?;
        self.hasher.update(&into[..got]);
        self.total += got as u64;
        Ok(got)
    }
}

/// Where bytes of UTF-8 or Latin-1 come from.
enum Source {
    Bytes(Hashed),
    Wide(Wide),
}

impl Source {
    fn hashed(&self) -> &Hashed {
        match self {
            Source::Bytes(hashed) => hashed,
            Source::Wide(wide) => &wide.hashed,
        }
    }
}

impl Read for Source {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        match self {
            Source::Bytes(hashed) => hashed.read(into),
            Source::Wide(wide) => wide.read(into),
        }
    }
}

/// UTF-16 as UTF-8.
struct Wide {
    hashed: Hashed,
    big_endian: bool,
    /// Bytes that are no whole letter yet.
    raw: Vec<u8>,
    ready: Vec<u8>,
    given: usize,
}

impl Wide {
    fn new(hashed: Hashed, big_endian: bool) -> Wide {
        Wide { hashed, big_endian, raw: Vec::new(), ready: Vec::new(), given: 0 }
    }

    /// Makes the next piece ready; `false` at the end.
    fn next_piece(&mut self) -> io::Result<bool> {
        let mut piece = [0; 4096];
        let got = self.hashed.read(&mut piece)?;
        self.raw.extend_from_slice(&piece[..got]);
        let unit = |pair: &[u8; 2]| match self.big_endian {
            true => u16::from_be_bytes(*pair),
            false => u16::from_le_bytes(*pair),
        };
        let mut units: Vec<u16> = self.raw.as_chunks::<2>().0.iter().map(unit).collect();
        // The other half of the last letter may come with the next piece.
        units.pop_if(|last| got > 0 && (0xD800..0xDC00).contains(last));
        let text = String::from_utf16(&units);
        if text.is_err() || (got == 0 && self.raw.len() > 2 * units.len()) {
            let place =
                format!("up to byte {} it is not UTF-16, which its byte order mark says", self.hashed.total);
            return Err(io::Error::new(io::ErrorKind::InvalidData, place));
        }
        self.raw.drain(..2 * units.len());
        self.ready = text.unwrap_or_default().into_bytes();
        self.given = 0;
        Ok(got > 0)
    }
}

impl Read for Wide {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        while self.given == self.ready.len() {
            if !self.next_piece()? {
                return Ok(0);
            }
        }
        let count = into.len().min(self.ready.len() - self.given);
        into[..count].copy_from_slice(&self.ready[self.given..][..count]);
        self.given += count;
        Ok(count)
    }
}

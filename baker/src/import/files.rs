//! Reads the files that make up a mesh: bounded, recorded by digest, found under the names that
//! exporters write (percent-encoded, with backslashes, in another case, with a lost folder).

use std::fs::{self, File};
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use flb_format::meta::SourceFile;

use super::error::ImportError;
use super::limits;

/// The folder of a mesh, what was read from it so far and what is to be said about it.
pub struct Files {
    /// The mesh's file name, for messages.
    pub file: String,
    folder: PathBuf,
    /// Every file read, in order.
    pub sources: Vec<SourceFile>,
    warnings: Vec<String>,
    warnings_left_out: usize,
}

impl Files {
    /// Files beside `mesh_path`.
    pub fn beside(mesh_path: &Path) -> Files {
        Files {
            file: name_of(mesh_path),
            folder: mesh_path.parent().unwrap_or(Path::new("")).to_owned(),
            sources: Vec::new(),
            warnings: Vec::new(),
            warnings_left_out: 0,
        }
    }

    /// Keeps a sentence for the user, at most [`limits::WARNINGS`] and each once.
    pub fn warn(&mut self, sentence: String) {
        let sentence = format!("{}: {sentence}", self.file);
        if self.warnings.contains(&sentence) {
            return;
        }
        if self.warnings.len() < limits::WARNINGS {
            self.warnings.push(sentence);
        } else {
            self.warnings_left_out += 1;
        }
    }

    /// What was recorded: sources and warnings.
    pub fn into_records(mut self) -> (Vec<SourceFile>, Vec<String>) {
        if self.warnings_left_out > 0 {
            self.warnings.push(format!("{}: {} more warnings", self.file, self.warnings_left_out));
        }
        (self.sources, self.warnings)
    }

    /// Shorthand for [`ImportError::Malformed`] in the mesh file.
    pub fn malformed(
        &self,
        place: impl Into<String>,
        found: impl ToString,
        expected: impl Into<String>,
    ) -> ImportError {
        ImportError::Malformed {
            file: self.file.clone(),
            place: place.into(),
            found: found.to_string(),
            expected: expected.into(),
        }
    }

    /// An error if `found` is over `limit`.
    pub fn limit(&self, what: impl Into<String>, found: u64, limit: u64) -> Result<(), ImportError> {
        if found <= limit {
            return Ok(());
        }
        Err(ImportError::Limit { file: self.file.clone(), what: what.into(), found, limit })
    }

    /// Reads a whole file and records its digest.
    pub fn read(&mut self, path: &Path, limit_bytes: u64) -> Result<Vec<u8>, ImportError> {
        let bytes = read_bounded(path, limit_bytes)?;
        self.record(path, blake3::hash(&bytes));
        Ok(bytes)
    }

    /// Calls `each` with every line (number from 1, without line ending) and records the digest.
    /// A byte order mark is dropped; a backslash at a line's end joins the next one.
    pub fn read_lines(
        &mut self,
        path: &Path,
        limit_bytes: u64,
        each: &mut dyn FnMut(&mut Files, u64, &str) -> Result<(), ImportError>,
    ) -> Result<(), ImportError> {
        let io = |source| ImportError::Io { path: path.to_owned(), source };
        let mut reader = BufReader::with_capacity(1 << 16, open_regular(path)?);
        let mut hasher = blake3::Hasher::new();
        let mut line = Vec::new();
        let (mut number, mut total) = (0u64, 0u64);
        loop {
            line.clear();
            let first = number + 1;
            loop {
                // One byte more than allowed, so that a line that is too long is seen to be so.
                let left = limits::LINE_BYTES + 1 - line.len() as u64;
                let start = line.len();
                let got = (&mut reader).take(left).read_until(b'\n', &mut line).map_err(io)?;
                if got == 0 {
                    break;
                }
                number += 1;
                total += got as u64;
                hasher.update(&line[start..]);
                if total > limit_bytes {
                    self.limit(format!("bytes of {}", name_of(path)), total, limit_bytes)?;
                }
                if line.len() as u64 > limits::LINE_BYTES {
                    let what = format!("bytes of line {first} of {}", name_of(path));
                    self.limit(what, line.len() as u64, limits::LINE_BYTES)?;
                }
                while matches!(line.last(), Some(b'\n' | b'\r')) {
                    line.pop();
                }
                match line.last_mut() {
                    Some(last) if *last == b'\\' => *last = b' ',
                    _ => break,
                }
            }
            if number < first {
                break;
            }
            if first == 1 && line.starts_with(b"\xEF\xBB\xBF") {
                line.drain(..3);
            }
            each(self, first, &String::from_utf8_lossy(&line))?;
        }
        self.record(path, hasher.finalize());
        Ok(())
    }

    /// The file that `name`, as written in a mesh file, means; `Err` holds the first path tried.
    /// Tried in turn: the name itself, percent-decoded, with slashes for backslashes, each also in
    /// another case; then the last part of the name alone in the mesh's folder and in `textures`.
    pub fn find(&self, name: &str) -> Result<PathBuf, PathBuf> {
        let decoded = percent_encoding::percent_decode_str(name).decode_utf8_lossy().into_owned();
        let mut candidates = Vec::new();
        for spelling in [name.to_owned(), decoded] {
            for spelling in [spelling.clone(), spelling.replace('\\', "/")] {
                if !candidates.contains(&spelling) {
                    candidates.push(spelling);
                }
            }
        }
        let last = candidates.last().expect("at least the name itself").clone();
        if let Some(base) = last.rsplit('/').next().filter(|base| !base.is_empty() && *base != last) {
            for folder in ["", "textures/", "texture/", "maps/", "images/"] {
                candidates.push(format!("{folder}{base}"));
            }
        } else {
            for folder in ["textures/", "texture/", "maps/", "images/"] {
                candidates.push(format!("{folder}{last}"));
            }
        }
        let first = self.folder.join(&candidates[0]);
        candidates.iter().find_map(|candidate| find_any_case(&self.folder, candidate)).ok_or(first)
    }

    fn record(&mut self, path: &Path, digest: blake3::Hash) {
        let source = SourceFile { name: name_of(path), blake3: digest.to_hex().to_string() };
        if !self.sources.contains(&source) {
            self.sources.push(source);
        }
    }
}

/// The last part of a path, as text.
pub fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// Reads a whole regular file of at most `limit_bytes`.
fn read_bounded(path: &Path, limit_bytes: u64) -> Result<Vec<u8>, ImportError> {
    let io = |source| ImportError::Io { path: path.to_owned(), source };
    let file = open_regular(path)?;
    let mut bytes = Vec::new();
    file.take(limit_bytes + 1).read_to_end(&mut bytes).map_err(io)?;
    if bytes.len() as u64 > limit_bytes {
        return Err(ImportError::Limit {
            file: name_of(path),
            what: "bytes of the file".to_owned(),
            found: fs::metadata(path).map_or(bytes.len() as u64, |meta| meta.len().max(bytes.len() as u64)),
            limit: limit_bytes,
        });
    }
    Ok(bytes)
}

/// Reads a UTF-8 file of at most `limit_bytes`: its name for messages, and its text.
pub fn read_text(path: &Path, limit_bytes: u64) -> Result<(String, String), ImportError> {
    let file = name_of(path);
    match String::from_utf8(read_bounded(path, limit_bytes)?) {
        Ok(text) => Ok((file, text)),
        Err(error) => {
            let message = format!("byte {} is not UTF-8", error.utf8_error().valid_up_to());
            Err(ImportError::Syntax { file, message })
        }
    }
}

/// Opens a file, but no folder, pipe or device: those could block or never end.
fn open_regular(path: &Path) -> Result<File, ImportError> {
    let io = |source| ImportError::Io { path: path.to_owned(), source };
    if !fs::metadata(path).map_err(io)?.is_file() {
        return Err(io(io::Error::new(io::ErrorKind::InvalidInput, "it is not a regular file")));
    }
    File::open(path).map_err(io)
}

/// `name` below `folder`, each part matched exactly or else in any case (the first in byte order).
fn find_any_case(folder: &Path, name: &str) -> Option<PathBuf> {
    let exact = folder.join(name);
    if exact.is_file() {
        return Some(exact);
    }
    let mut path = if name.starts_with('/') { PathBuf::from("/") } else { folder.to_owned() };
    for part in name.split('/').filter(|part| !part.is_empty() && *part != ".") {
        let exact = path.join(part);
        if part == ".." || exact.exists() {
            path = exact;
            continue;
        }
        let place = if path.as_os_str().is_empty() { Path::new(".") } else { &path };
        let wanted = part.to_lowercase();
        let mut same: Vec<_> = fs::read_dir(place)
            .ok()?
            .filter_map(|entry| Some(entry.ok()?.file_name()))
            .filter(|entry| entry.to_string_lossy().to_lowercase() == wanted)
            .collect();
        same.sort();
        path = path.join(same.first()?);
    }
    path.is_file().then_some(path)
}

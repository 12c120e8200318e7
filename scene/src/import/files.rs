//! Reads the files that make up a mesh: bounded, recorded by digest, found under the names that
//! exporters write (percent-encoded, with backslashes, in another case or composition, with a lost folder). Keeps
//! account of the memory that all of it takes.

mod find;
mod lines;
pub(super) mod words;

use std::cell::Cell;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use flb_files::OpenError;
use flb_format::meta::SourceFile;

use self::find::Finder;
pub(super) use self::find::Found;
use self::lines::Text;
use super::error::{ImportError, quoted};
use super::limits;
use super::memory::{ask, reserve};

/// The folder of a mesh, what was read from it so far and what is to be said about it.
pub(crate) struct Files {
    /// The mesh's file name, for messages.
    pub file: String,
    finder: Finder,
    held_bytes: u64,
    /// What was last looked for, in the system.
    asked_mib: Cell<u64>,
    /// Every file read, in order.
    pub sources: Vec<SourceFile>,
    warnings: Vec<String>,
    warnings_left_out: usize,
    notes: Vec<String>,
}

/// What is known of the files of a mesh once it is read.
pub(crate) struct Records {
    /// Every file read, in order.
    pub sources: Vec<SourceFile>,
    /// Warnings of what was repaired or ignored.
    pub warnings: Vec<String>,
    /// Notes of what was made of the file as it asks.
    pub notes: Vec<String>,
}

impl Files {
    /// Files beside `mesh_path`.
    pub(crate) fn beside(mesh_path: &Path) -> Files {
        Files {
            file: name_of(mesh_path),
            finder: Finder::new(mesh_path.parent().unwrap_or(Path::new("")).to_owned()),
            held_bytes: 0,
            asked_mib: Cell::new(0),
            sources: Vec::new(),
            warnings: Vec::new(),
            warnings_left_out: 0,
            notes: Vec::new(),
        }
    }

    /// Keeps a sentence on what was made of the file as it asks, at most [`limits::WARNINGS`] and each once.
    pub(crate) fn note(&mut self, sentence: String) {
        let sentence = format!("{}: {sentence}", self.file);
        if self.notes.len() < limits::WARNINGS && !self.notes.contains(&sentence) {
            self.notes.push(sentence);
        }
    }

    /// Notes so far.
    pub(crate) fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Keeps a sentence for the user, at most [`limits::WARNINGS`] and each once.
    pub(crate) fn warn(&mut self, sentence: String) {
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

    /// What was recorded.
    pub(crate) fn into_records(mut self) -> Records {
        if self.warnings_left_out > 0 {
            self.warnings.push(format!("{}: {} more warnings", self.file, self.warnings_left_out));
        }
        Records { sources: self.sources, warnings: self.warnings, notes: self.notes }
    }

    /// Shorthand for [`ImportError::Malformed`] in the mesh file.
    pub(crate) fn malformed(
        &self,
        place: impl Into<String>,
        found: impl ToString,
        expected: impl Into<String>,
    ) -> ImportError {
        ImportError::Malformed {
            file: self.file.clone(),
            place: place.into(),
            found: quoted(&found.to_string()),
            expected: expected.into(),
        }
    }

    /// An error if `found` is over `limit`.
    pub(crate) fn limit(&self, what: impl Into<String>, found: u64, limit: u64) -> Result<(), ImportError> {
        if found <= limit {
            return Ok(());
        }
        Err(ImportError::Limit { file: self.file.clone(), what: what.into(), found, limit })
    }

    /// Takes memory into account that `what` needs until [`Files::release`]; an error if all together would be too
    /// much.
    pub(crate) fn hold(&mut self, what: &str, bytes: u64) -> Result<(), ImportError> {
        self.room_for(what, bytes)?;
        self.held_bytes += bytes;
        Ok(())
    }

    /// Gives memory back that [`Files::hold`] took.
    pub(crate) fn release(&mut self, bytes: u64) {
        self.held_bytes = self.held_bytes.checked_sub(bytes).expect("what is released was held");
    }

    /// An error if memory that `what` needs for a while would be too much beside what is held, or is not there.
    pub(crate) fn room_for(&self, what: &str, bytes: u64) -> Result<(), ImportError> {
        let total = self.held_bytes.saturating_add(bytes);
        if total > limits::MEMORY_BYTES {
            return self.limit(format!("bytes of memory, with {what}"), total, limits::MEMORY_BYTES);
        }
        // What grows by a few bytes at a time is looked for once for each MiB.
        match bytes >> 20 == self.asked_mib.replace(bytes >> 20) {
            true => Ok(()),
            false => ask(&self.file, what, bytes),
        }
    }

    /// Adds to a list, whose memory is held as it grows.
    pub(crate) fn push<T>(&mut self, what: &str, list: &mut Vec<T>, value: T) -> Result<(), ImportError> {
        if list.len() == list.capacity() {
            let more = list.capacity().max(1024);
            self.hold(what, more as u64 * size_of::<T>() as u64)?;
            reserve(&self.file, what, list, more)?;
        }
        list.push(value);
        Ok(())
    }

    /// A name that is kept; an error if it is too long.
    pub(crate) fn name(&self, place: impl Into<String>, name: &str) -> Result<String, ImportError> {
        self.limit(format!("{}: bytes of a name", place.into()), name.len() as u64, limits::NAME_BYTES)?;
        Ok(name.to_owned())
    }

    /// Reads a whole file and records its digest.
    pub(crate) fn read(&mut self, path: &Path, limit_bytes: u64) -> Result<Vec<u8>, ImportError> {
        let length = fs::metadata(path).map_or(0, |found| found.len());
        self.room_for(&format!("the file '{}'", name_of(path)), length.min(limit_bytes))?;
        let bytes = read_bounded(path, limit_bytes)?;
        self.record(path, blake3::hash(&bytes));
        Ok(bytes)
    }

    /// Calls `each` with every line (number from 1, without line ending, see [`Text`]) and records the digest. Gives
    /// the file's length.
    pub(crate) fn read_lines(
        &mut self,
        path: &Path,
        limit_bytes: u64,
        each: &mut dyn FnMut(&mut Files, u64, &str) -> Result<(), ImportError>,
    ) -> Result<u64, ImportError> {
        let mut text = Text::open(path, limit_bytes)?;
        while let Some((number, line)) = text.next(self)? {
            each(self, number, &line)?;
        }
        let (digest, length) = text.digest();
        self.record(path, digest);
        Ok(length)
    }

    /// What `name`, as `place` writes it, means in the folders, the mesh's own if there are none: see [`Finder::find`].
    pub(crate) fn find(&mut self, place: &str, name: &str, folders: &[&Path]) -> Result<Found, ImportError> {
        let folders = if folders.is_empty() { &[Path::new("")] } else { folders };
        self.finder.find(&self.file, place, name, folders)
    }

    /// The folder of a file that was found, from the mesh's folder.
    pub(crate) fn folder_of(&self, found: &Path) -> PathBuf {
        self.finder.folder_of(found)
    }

    fn record(&mut self, path: &Path, digest: blake3::Hash) {
        let source = SourceFile { name: name_of(path), blake3: digest.to_hex().to_string() };
        if !self.sources.contains(&source) {
            self.sources.push(source);
        }
    }
}

/// The last part of a path, as text.
pub(super) fn name_of(path: &Path) -> String {
    words::of_system(path.file_name().unwrap_or(path.as_os_str())).into_owned()
}

/// Reads a whole regular file of at most `limit_bytes`.
fn read_bounded(path: &Path, limit_bytes: u64) -> Result<Vec<u8>, ImportError> {
    let io = |source| ImportError::Io { path: path.to_owned(), source };
    let file = open_regular(path)?;
    let length = file.metadata().map_err(io)?.len();
    let check = |found: u64| match found <= limit_bytes {
        true => Ok(()),
        false => {
            let (file, what) = (name_of(path), "bytes of the file".to_owned());
            Err(ImportError::Limit { file, what, found, limit: limit_bytes })
        }
    };
    check(length)?;
    let mut bytes = Vec::new();
    reserve(&name_of(path), "the file", &mut bytes, length as usize)?;
    // A file that grows while it is read is longer than it said.
    file.take(limit_bytes + 1).read_to_end(&mut bytes).map_err(io)?;
    check(bytes.len() as u64)?;
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

/// A file of up to `limit_bytes`: its name and content.
pub fn read_bytes(path: &Path, limit_bytes: u64) -> Result<(String, Vec<u8>), ImportError> {
    Ok((name_of(path), read_bounded(path, limit_bytes)?))
}

/// Opens a file, but no folder, pipe or device: those could block or never end.
pub(super) fn open_regular(path: &Path) -> Result<File, ImportError> {
    let opened = flb_files::open_regular(path).map(|(file, _)| file);
    opened.map_err(|error| {
        let source = match error {
            OpenError::Io { source, .. } => source,
            OpenError::NotAFile { .. } => io::Error::new(io::ErrorKind::InvalidInput, NOT_A_FILE),
        };
        ImportError::Io { path: path.to_owned(), source }
    })
}

const NOT_A_FILE: &str = "it is not a regular file";

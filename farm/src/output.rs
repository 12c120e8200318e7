//! The folder of what is built: a file, a record, pictures and a log for each species, one file of all, an index and a
//! page.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use flb_files::{Existing, FileError, check_output, open_own, publish_own};

use crate::manifest::Manifest;
use crate::record::Record;

/// Folders in the output.
const FOLDERS: [&str; 4] = ["species", "records", "pictures", "logs"];

/// Name of a file that is never left behind.
const PROBE: &str = ".flb-probe";

/// Folder of what is built.
#[derive(Debug, Clone)]
pub struct Output {
    folder: PathBuf,
}

impl Output {
    /// Finds the folder of a manifest.
    pub fn of(manifest: &Manifest) -> Output {
        Output { folder: manifest.output.clone() }
    }

    /// Returns the folder itself.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Finds out whether the folders could be made and written to. Nothing is made.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn check(&self) -> Result<(), FileError> {
        let is_there = |path: &&Path| path.symlink_metadata().is_ok();
        let there = self.folder.ancestors().find(is_there).unwrap_or(Path::new(""));
        check_output(&there.join(PROBE), &[], Existing::Replace)
    }

    /// Makes the folders, and finds out whether each can be written to.
    ///
    /// # Errors
    /// [`FileError::Write`].
    pub fn prepare(&self) -> Result<(), FileError> {
        for folder in FOLDERS {
            let path = self.folder.join(folder);
            let refuse = |source| FileError::Write { path: path.clone(), source };
            fs::create_dir_all(&path).map_err(refuse)?;
            check_output(&path.join(PROBE), &[], Existing::Replace)?;
        }
        Ok(())
    }

    /// File of a species.
    pub fn species(&self, name: &str) -> PathBuf {
        self.folder.join("species").join(format!("{name}.flb"))
    }

    /// Pictures of a species.
    pub fn picture(&self, name: &str) -> PathBuf {
        self.folder.join("pictures").join(format!("{name}.png"))
    }

    /// Log of the bake of a species.
    pub fn log(&self, name: &str) -> PathBuf {
        self.folder.join("logs").join(format!("{name}.log"))
    }

    /// Record of a species.
    pub fn record_file(&self, name: &str) -> PathBuf {
        self.folder.join("records").join(format!("{name}.json"))
    }

    /// One file of all species.
    pub fn library(&self) -> PathBuf {
        self.folder.join("library.flb")
    }

    /// Index, as JSON.
    pub fn index(&self) -> PathBuf {
        self.folder.join("index.json")
    }

    /// Page for people.
    pub fn page(&self) -> PathBuf {
        self.folder.join("index.html")
    }

    /// The record of a species that was built.
    pub fn record(&self, name: &str) -> Option<Record> {
        let bytes = read(&self.record_file(name))?;
        serde_json::from_slice(&bytes).ok()
    }

    /// Names of species that have a file here.
    pub fn built(&self) -> Vec<String> {
        let Ok(entries) = fs::read_dir(self.folder.join("species")) else { return Vec::new() };
        let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
        let mut names: Vec<String> =
            names.filter_map(|name| name.strip_suffix(".flb").map(str::to_owned)).collect();
        names.sort();
        names
    }
}

/// The bytes of a file that a build wrote; `None` where there is none.
pub(crate) fn read(path: &Path) -> Option<Vec<u8>> {
    let (mut file, _) = open_own(path).ok()?;
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).ok()?;
    Some(bytes)
}

/// Writes a file, unless it has these bytes.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    if read(path).is_some_and(|found| found == bytes) {
        return Ok(());
    }
    publish_own(path, |file| file.write_all(bytes))
}

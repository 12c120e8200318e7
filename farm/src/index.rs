//! The index of a library, for programs.

use std::collections::BTreeMap;
use std::path::Path;

use flb_format::Source;
use flb_runtime::RuntimeError;
use flb_runtime::source::FileSource;
use serde::{Deserialize, Serialize};

use crate::FarmError;
use crate::manifest::Manifest;
use crate::outcome::Built;
use crate::output::{self, Output};
use crate::record::Facts;

/// Version of the index.
const SCHEMA: u32 = 1;
/// Bytes of an index: about those of 200,000 species.
const MAX_BYTES: u64 = 256 << 20;

/// Index of what is built.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Index {
    /// 1.
    pub schema: u32,
    /// Program that built it.
    pub tool: String,
    /// File of all species, if one is written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub library: Option<LibraryFile>,
    /// Species by name.
    pub species: BTreeMap<String, IndexEntry>,
}

/// File of all species.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LibraryFile {
    /// Path below the index.
    pub file: String,
    /// Size in bytes.
    pub bytes: u64,
    /// Digest, 64 hexadecimal digits.
    pub blake3: String,
    /// Digest of the names and digests of what it is made of.
    pub made_of: String,
}

/// A species in the index.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct IndexEntry {
    /// Path of its file below the index.
    pub file: String,
    /// Path of its pictures, if its light has colours.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub picture: Option<String>,
    /// Name of the species that it is a variant of.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub variant_of: Option<String>,
    /// Facts of its record.
    #[serde(flatten)]
    pub facts: Facts,
    /// Sentences on what goes over its budget.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub over_budget: Vec<String>,
}

impl Index {
    /// The index of what is there: of the species of a build as they are now, and of others of the manifest as they
    /// were built last.
    pub fn of(manifest: &Manifest, output: &Output, built: &[Built]) -> Index {
        let now: BTreeMap<&str, &Built> = built.iter().map(|one| (one.name.as_str(), one)).collect();
        let entry = |entry: &crate::manifest::Entry| {
            let record = match now.get(entry.name.as_str()) {
                Some(built) => built.record.clone()?,
                None => output.record(&entry.name).filter(|_| output.species(&entry.name).is_file())?,
            };
            let picture = output.picture(&entry.name).is_file();
            let one = IndexEntry {
                file: format!("species/{}.flb", entry.name),
                picture: picture.then(|| format!("pictures/{}.png", entry.name)),
                variant_of: entry.variant_of.clone(),
                over_budget: record.facts.over(&entry.budget),
                facts: record.facts,
            };
            Some((entry.name.clone(), one))
        };
        let species = manifest.species.iter().filter_map(entry).collect();
        let tool = concat!("flb ", env!("CARGO_PKG_VERSION")).to_owned();
        Index { schema: SCHEMA, tool, library: None, species }
    }

    /// The index that is there.
    pub fn read(output: &Output) -> Option<Index> {
        let index: Index = serde_json::from_slice(&output::read(&output.index())?).ok()?;
        (index.schema == SCHEMA).then_some(index)
    }

    /// Reads an index that a build wrote.
    ///
    /// # Errors
    /// A file that cannot be read; [`FarmError::Library`] for one that is no index.
    pub fn open(file: &Path) -> Result<Index, FarmError> {
        let path = file.to_owned();
        let refused = |found: String| FarmError::Library {
            file: path.clone(),
            found,
            expected: "an index that `flb library build` wrote".to_owned(),
        };
        let source = FileSource::open(file)?;
        let failed = |source| RuntimeError::Io { path: path.clone(), action: "read", source };
        let length = source.len_bytes().map_err(failed)?;
        if length > MAX_BYTES {
            return Err(refused(format!("{length} bytes, more than {MAX_BYTES}")));
        }
        let mut bytes = vec![0; length as usize];
        source.read_exact_at(0, &mut bytes).map_err(failed)?;
        let index: Index = serde_json::from_slice(&bytes).map_err(|error| refused(error.to_string()))?;
        match index.schema == SCHEMA {
            true => Ok(index),
            false => Err(refused(format!("schema {} instead of {SCHEMA}", index.schema))),
        }
    }

    pub(crate) fn made_of(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        for (name, entry) in &self.species {
            hasher.update(name.as_bytes()).update(b"\0").update(entry.facts.blake3.as_bytes());
        }
        hasher.finalize().to_hex().to_string()
    }
}

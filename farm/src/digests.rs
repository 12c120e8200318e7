//! Digests of files, kept by size and time, so that a file that did not change is not read again.

use std::collections::{BTreeMap, HashMap};
use std::fs::{self, File, Metadata};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use flb_files::{open_own, open_regular};
use flb_scene::ImportError;
use flb_scene::import::named_files;
use serde::{Deserialize, Serialize};

use crate::cache::Cache;

/// Name in the cache.
pub(crate) const NAME: &str = "digests.json";
/// A file that was written so short a time before it is looked at may be written again in the same tick of its clock.
const TICK: Duration = Duration::from_secs(2);
const BUFFER_BYTES: usize = 1 << 18;

/// Whether what is kept is believed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Trust {
    /// A file of the same size and time has the same bytes.
    #[default]
    SizeAndTime,
    /// Every file is read.
    Nothing,
}

/// What is known of a file of this size and time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Known {
    bytes: u64,
    modified_ns: u64,
    inode: u64,
    blake3: String,
    /// Files that it names, if it is a mesh.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    named: Option<Vec<PathBuf>>,
}

/// Digests of the files of a job.
pub struct Digests {
    trust: Trust,
    kept: HashMap<PathBuf, Known>,
    found: Mutex<BTreeMap<PathBuf, Known>>,
}

/// Bytes of a file, and the files that it names.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// 64 hexadecimal digits.
    pub blake3: String,
    /// Files that a mesh names and that are there.
    pub named: Vec<PathBuf>,
}

impl Digests {
    /// Reads the digests that a cache keeps.
    pub fn open(cache: &Cache, trust: Trust) -> Digests {
        let kept = match trust {
            Trust::SizeAndTime => cache.read(NAME).and_then(|bytes| serde_json::from_slice(&bytes).ok()),
            Trust::Nothing => None,
        };
        Digests { trust, kept: kept.unwrap_or_default(), found: Mutex::default() }
    }

    /// Keeps what was found, in place of what was kept.
    pub fn keep(&self, cache: &Cache) {
        let found = self.found.lock().expect("no holder panics");
        let mut all: BTreeMap<&PathBuf, &Known> = self.kept.iter().collect();
        all.extend(found.iter());
        let is_changed = found.iter().any(|(path, known)| self.kept.get(path) != Some(known));
        if is_changed && let Ok(bytes) = serde_json::to_vec(&all) {
            cache.write(NAME, &bytes);
        }
    }

    /// The digest of a file.
    ///
    /// # Errors
    /// [`ImportError::Io`].
    pub fn of_file(&self, path: &Path) -> Result<String, ImportError> {
        Ok(self.find(path, false, digest)?.blake3)
    }

    /// The digest of a mesh, and the files that it names.
    ///
    /// # Errors
    /// [`ImportError::Io`].
    pub fn of_mesh(&self, path: &Path) -> Result<Found, ImportError> {
        self.find(path, true, digest)
    }

    /// Whether a file that a build wrote still has these bytes, as far as that is believed. It is no input, which no
    /// build could write again.
    pub fn is(&self, path: &Path, blake3: &str) -> bool {
        let own = |path: &Path| {
            let (file, _) = open_own(path).map_err(io::Error::other)?;
            read_digest(file)
        };
        path.is_file() && self.find(path, false, own).is_ok_and(|found| found.blake3 == blake3)
    }

    /// `digest` reads a file that is not known.
    fn find(
        &self,
        path: &Path,
        is_mesh: bool,
        digest: impl Fn(&Path) -> io::Result<String>,
    ) -> Result<Found, ImportError> {
        let io = |source: io::Error| ImportError::Io { path: path.to_owned(), source };
        let metadata = fs::metadata(path).map_err(io)?;
        let stamp = Stamp::of(&metadata);
        let known = || {
            let found = self.found.lock().expect("no holder panics").get(path).cloned();
            let known = found.or_else(|| self.kept.get(path).cloned())?;
            let is_enough = stamp.is_of(&known) && (known.named.is_some() || !is_mesh);
            is_enough.then_some(known)
        };
        let known = match known() {
            Some(known) => known,
            None => {
                let blake3 = digest(path).map_err(io)?;
                let named = is_mesh.then(|| named_files(path));
                let Stamp { bytes, modified_ns, inode, .. } = stamp;
                Known { bytes, modified_ns, inode, blake3, named }
            }
        };
        let found = Found { blake3: known.blake3.clone(), named: known.named.clone().unwrap_or_default() };
        if stamp.is_old && self.trust == Trust::SizeAndTime {
            self.found.lock().expect("no holder panics").insert(path.to_owned(), known);
        }
        Ok(found)
    }
}

/// Size, time and place of a file.
struct Stamp {
    bytes: u64,
    modified_ns: u64,
    inode: u64,
    /// Whether it was written a while ago.
    is_old: bool,
}

impl Stamp {
    fn of(metadata: &Metadata) -> Stamp {
        let modified = metadata.modified().ok();
        let since = modified.and_then(|time| time.duration_since(UNIX_EPOCH).ok());
        let age = modified.and_then(|time| SystemTime::now().duration_since(time).ok());
        #[cfg(unix)]
        let inode = std::os::unix::fs::MetadataExt::ino(metadata);
        #[cfg(not(unix))]
        let inode = 0;
        Stamp {
            bytes: metadata.len(),
            modified_ns: since.map_or(0, |since| since.as_nanos() as u64),
            inode,
            // A time that is to come, or none, tells nothing.
            is_old: since.is_some() && age.is_some_and(|age| age >= TICK),
        }
    }

    fn is_of(&self, known: &Known) -> bool {
        self.is_old
            && (self.bytes, self.modified_ns, self.inode) == (known.bytes, known.modified_ns, known.inode)
    }
}

fn digest(path: &Path) -> io::Result<String> {
    let (file, _) = open_regular(path).map_err(io::Error::other)?;
    read_digest(file)
}

fn read_digest(mut file: File) -> io::Result<String> {
    let mut hasher = blake3::Hasher::new();
    let mut buffer = vec![0; BUFFER_BYTES];
    loop {
        match file.read(&mut buffer)? {
            0 => return Ok(hasher.finalize().to_hex().to_string()),
            count => _ = hasher.update(&buffer[..count]),
        }
    }
}

//! From the name of a file as a mesh file writes it to the file that it means, inside the mesh's folder alone.

use std::collections::HashMap;
use std::ffi::OsString;
use std::fs;
use std::path::{Component, Path, PathBuf};

use flb_format::text::url::shown_reference;

use crate::import::error::ImportError;
use crate::import::limits;

/// What a name leads to.
pub enum Found {
    /// A file, or a pipe, socket or device, which reading refuses.
    File(PathBuf),
    /// Nothing; the first path tried, of a URL no more than its host.
    Missing(PathBuf),
}

/// Looks for files in one folder and the folders below it.
pub struct Finder {
    folder: PathBuf,
    /// Names in the folders that were searched for another case, so that each is listed once.
    listings: HashMap<PathBuf, Vec<OsString>>,
    lookups: u64,
}

impl Finder {
    /// For names that start in `folder`.
    pub fn new(folder: PathBuf) -> Finder {
        Finder { folder, listings: HashMap::new(), lookups: 0 }
    }

    /// What `name` means, which `place` of `file` mentions. Tried in turn: the name itself, percent-decoded, with
    /// slashes for backslashes, each also in another case; then the last part of the name alone in the mesh's folder
    /// and in `textures` and the like.
    ///
    /// # Errors
    /// [`ImportError::Limit`]; [`ImportError::OutsideFolder`] where the only file of that name lies outside, for a
    /// mesh from a stranger must not make us read whatever it names.
    pub fn find(&mut self, file: &str, place: &str, name: &str) -> Result<Found, ImportError> {
        let limit = |what: String, found, limit| match found <= limit {
            true => Ok(()),
            false => Err(ImportError::Limit { file: file.to_owned(), what, found, limit }),
        };
        limit(format!("{place}: bytes of a file's name"), name.len() as u64, limits::URI_BYTES)?;
        self.lookups += 1;
        limit("files that are named".to_owned(), self.lookups, limits::FILES)?;
        let candidates = candidates(name);
        let mut outside = None;
        for candidate in &candidates {
            match self.inside(candidate) {
                Ok(relative) => {
                    if let Some(path) = self.look_up(&relative) {
                        return Ok(Found::File(path));
                    }
                }
                Err(path) => outside = outside.or(Some(path).filter(|path| path.exists())),
            }
        }
        match outside {
            Some(leads_to) => {
                let (file, place, uri) =
                    (file.to_owned(), place.to_owned(), shown_reference(name).into_owned());
                let leads_to = shown_reference(&leads_to.to_string_lossy()).into_owned().into();
                Err(ImportError::OutsideFolder { file, place, uri, leads_to })
            }
            None => Ok(Found::Missing(self.folder.join(&*shown_reference(&candidates[0])))),
        }
    }

    /// The name as a way from the folder down; where it leads out of it, `Err` with the place.
    fn inside(&self, name: &str) -> Result<PathBuf, PathBuf> {
        let here = Path::new(".");
        let folder = if self.folder.as_os_str().is_empty() { here } else { &self.folder };
        // It fails only where the current folder is gone; then nothing relative is found either.
        let folder = normal(&std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned()));
        let path = normal(&folder.join(name));
        path.strip_prefix(&folder).map(Path::to_owned).map_err(|_| path.clone())
    }

    /// `relative` in the folder, each part matched exactly or else in any case (the first in byte order).
    fn look_up(&mut self, relative: &Path) -> Option<PathBuf> {
        let exact = self.folder.join(relative);
        if is_no_folder(&exact) {
            return Some(exact);
        }
        let mut path = self.folder.clone();
        for part in relative.iter() {
            let exact = path.join(part);
            if exact.exists() {
                path = exact;
                continue;
            }
            let wanted = part.to_string_lossy().to_lowercase();
            let name =
                self.names_in(&path).iter().find(|n| n.to_string_lossy().to_lowercase() == wanted)?.clone();
            path.push(name);
        }
        is_no_folder(&path).then_some(path)
    }

    /// Names in a folder in byte order, none if it cannot be listed.
    fn names_in(&mut self, folder: &Path) -> &[OsString] {
        self.listings.entry(folder.to_owned()).or_insert_with(|| {
            let place = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
            let mut names = flb_files::names_in(place, limits::FOLDER_ENTRIES).unwrap_or_default();
            names.sort();
            names
        })
    }
}

/// Whether something is there that is not a folder.
fn is_no_folder(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|found| !found.is_dir())
}

/// Spellings of a name, the most literal first.
fn candidates(name: &str) -> Vec<String> {
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
    candidates
}

/// A path without `.` and `..`, by its spelling alone: links are not followed.
fn normal(path: &Path) -> PathBuf {
    let mut normal = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => drop(normal.pop()),
            part => normal.push(part),
        }
    }
    normal
}

//! From the name of a file as a mesh file writes it to the file that it means, inside the mesh's folder alone.

use std::collections::HashMap;
use std::ffi::{OsStr, OsString};
use std::fs;
use std::path::{Component, Path, PathBuf};

use flb_format::text::url::shown_reference;

use super::words;
use crate::import::error::ImportError;
use crate::import::limits;

/// What a name leads to.
pub(crate) enum Found {
    /// A file, or a pipe, socket or device, which reading refuses.
    File(PathBuf),
    /// Nothing; the first path tried, of a URL no more than its host.
    Missing(PathBuf),
}

/// Looks for files in one folder and the folders below it.
pub(super) struct Finder {
    folder: PathBuf,
    /// Names in the folders that were searched for another spelling, so that each is listed once.
    listings: HashMap<PathBuf, Listing>,
    lookups: u64,
}

/// Names in a folder in byte order, by what they have in common with other spellings.
#[derive(Default)]
struct Listing {
    composed: HashMap<String, Vec<OsString>>,
    caseless: HashMap<String, Vec<OsString>>,
}

impl Finder {
    /// For names that start in `folder`.
    pub(super) fn new(folder: PathBuf) -> Finder {
        Finder { folder, listings: HashMap::new(), lookups: 0 }
    }

    /// The folder of a file that was found, from the finder's.
    pub(super) fn folder_of(&self, found: &Path) -> PathBuf {
        let folder = found.parent().and_then(|folder| folder.strip_prefix(&self.folder).ok());
        folder.unwrap_or(Path::new("")).to_owned()
    }

    /// What `name` means, which `place` of `file` mentions. Tried in turn: the name itself, percent-decoded, with
    /// slashes for backslashes, as UTF-8 if it was read as Latin-1; then the last part of the name alone and in
    /// `textures` and the like. Each in every folder of `folders` (from the finder's own), and there each part as it is
    /// written, then in another composition (NFC), then in another case.
    ///
    /// # Errors
    /// [`ImportError::Limit`]; [`ImportError::OutsideFolder`] where the only file of that name lies outside, for a
    /// mesh from a stranger must not make us read whatever it names.
    pub(super) fn find(
        &mut self,
        file: &str,
        place: &str,
        name: &str,
        folders: &[&Path],
    ) -> Result<Found, ImportError> {
        let limit = |what: String, found, limit| match found <= limit {
            true => Ok(()),
            false => Err(ImportError::Limit { file: file.to_owned(), what, found, limit }),
        };
        limit(format!("{place}: bytes of a file's name"), name.len() as u64, limits::URI_BYTES)?;
        self.lookups += 1;
        limit("files that are named".to_owned(), self.lookups, limits::FILES)?;
        let candidates = candidates(name);
        let mut outside = None;
        for (candidate, folder) in
            candidates.iter().flat_map(|candidate| folders.iter().map(move |folder| (candidate, folder)))
        {
            match self.inside(folder, candidate) {
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

    /// The name in a folder as a way from the finder's folder down; where it leads out of it, `Err` with the place.
    fn inside(&self, below: &Path, name: &str) -> Result<PathBuf, PathBuf> {
        let here = Path::new(".");
        let folder = if self.folder.as_os_str().is_empty() { here } else { &self.folder };
        // It fails only where the current folder is gone; then nothing relative is found either.
        let folder = normal(&std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned()));
        let path = normal(&folder.join(below).join(name));
        path.strip_prefix(&folder).map(Path::to_owned).map_err(|_| path.clone())
    }

    /// `relative` in the folder.
    fn look_up(&mut self, relative: &Path) -> Option<PathBuf> {
        let exact = self.folder.join(relative);
        if is_no_folder(&exact) {
            return Some(exact);
        }
        let parts: Vec<&OsStr> = relative.iter().collect();
        self.descend(self.folder.clone(), &parts)
    }

    /// The first file on the way down, by the spellings of each part.
    fn descend(&mut self, path: PathBuf, parts: &[&OsStr]) -> Option<PathBuf> {
        let Some((part, rest)) = parts.split_first() else {
            return is_no_folder(&path).then_some(path);
        };
        self.spellings(&path, part).into_iter().find_map(|name| self.descend(path.join(name), rest))
    }

    /// Names in a folder that may be meant: as it is written, then composed alike, then alike without case, each in
    /// byte order.
    fn spellings(&mut self, folder: &Path, name: &OsStr) -> Vec<OsString> {
        let mut found: Vec<OsString> =
            folder.join(name).exists().then(|| name.to_owned()).into_iter().collect();
        let listing = self.listings.entry(folder.to_owned()).or_insert_with(|| Listing::of(folder));
        let name = words::of_system(name);
        let composed = listing.composed.get(&*words::composed(&name));
        let caseless = listing.caseless.get(&words::caseless(&name));
        for other in composed.into_iter().chain(caseless).flatten() {
            if !found.contains(other) {
                found.push(other.clone());
            }
        }
        found
    }
}

impl Listing {
    /// Of a folder; empty if it cannot be listed.
    fn of(folder: &Path) -> Listing {
        let place = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let mut names = flb_files::names_in(place, limits::FOLDER_ENTRIES).unwrap_or_default();
        names.sort();
        let mut listing = Listing::default();
        for name in names {
            let text = words::of_system(&name);
            listing.composed.entry(words::composed(&text).into_owned()).or_default().push(name.clone());
            listing.caseless.entry(words::caseless(&text)).or_default().push(name);
        }
        listing
    }
}

/// Whether something is there that is not a folder.
fn is_no_folder(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|found| !found.is_dir())
}

/// Spellings of a name, the most literal first.
fn candidates(name: &str) -> Vec<String> {
    let bytes: Vec<u8> = percent_encoding::percent_decode_str(name).collect();
    let decoded = words::decoded(&bytes).into_owned();
    let mut candidates = Vec::new();
    for spelling in [Some(name.to_owned()), Some(decoded), words::reread(name)].into_iter().flatten() {
        for spelling in [spelling.clone(), spelling.replace('\\', "/")] {
            if !candidates.contains(&spelling) {
                candidates.push(spelling);
            }
        }
    }
    let literal = candidates.clone();
    for folder in ["", "textures/", "texture/", "maps/", "images/"] {
        for name in &literal {
            let base = name.rsplit('/').next().filter(|base| !base.is_empty()).unwrap_or(name);
            let candidate = format!("{folder}{base}");
            if !candidates.contains(&candidate) {
                candidates.push(candidate);
            }
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

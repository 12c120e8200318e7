//! One of the two: the folder of a build, or a file of one or more species.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use flb_format::Source;
use flb_runtime::source::FileSource;
use flb_runtime::{Library, RuntimeError};

use crate::FarmError;
use crate::index::{Index, IndexEntry};

/// Name of the index in a folder.
const INDEX: &str = "index.json";
/// Bytes that are read at once for a digest.
const CHUNK_BYTES: usize = 1 << 20;

/// Species of one of the two, by name.
pub(super) struct Side {
    pub path: PathBuf,
    pub species: BTreeMap<String, Place>,
    /// The file of all, where it is one.
    library: Option<Library>,
}

/// Where a species is.
#[derive(Debug, Clone)]
pub(super) enum Place {
    /// A file of its own in a folder, with its digest and its pictures.
    File { file: PathBuf, blake3: String, picture: Option<PathBuf> },
    /// A place in the file of all.
    Within(usize),
}

impl Side {
    /// Opens a folder that a build wrote, or a `.flb` file.
    pub(super) fn open(path: &Path) -> Result<Side, FarmError> {
        if !path.is_dir() {
            let library = Library::open(path)?;
            let names = library.container().species().iter().map(|one| one.meta.name.clone());
            let species = names.enumerate().map(|(at, name)| (name, Place::Within(at))).collect();
            return Ok(Side { path: path.to_owned(), species, library: Some(library) });
        }
        let file = path.join(INDEX);
        if !file.exists() {
            return Err(FarmError::Library {
                file: path.to_owned(),
                found: format!("a folder without {INDEX}"),
                expected: "one that `flb library build` wrote, or a .flb file".to_owned(),
            });
        }
        let index = Index::open(&file)?;
        let place = |(name, entry): (String, IndexEntry)| {
            let below = |inner: &str| below(path, inner).ok_or_else(|| outside(&file, inner));
            let picture = entry.picture.as_deref().map(below).transpose()?;
            let place = Place::File { file: below(&entry.file)?, blake3: entry.facts.blake3, picture };
            Ok((name, place))
        };
        let species = index.species.into_iter().map(place).collect::<Result<_, FarmError>>()?;
        Ok(Side { path: path.to_owned(), species, library: None })
    }

    /// The library that a species is in, and its place there.
    pub(super) fn species<'s>(&'s self, name: &str) -> Result<(Opened<'s>, usize), FarmError> {
        match (&self.species[name], &self.library) {
            (Place::Within(at), Some(library)) => Ok((Opened::Shared(library), *at)),
            (Place::Within(_), None) => unreachable!("a place in a file is of a side that is one"),
            (Place::File { file, .. }, _) => {
                let library = Library::open(file)?;
                let at = library.find_species(name).ok_or_else(|| {
                    let species = library.container().species();
                    let found: Vec<String> =
                        species.iter().take(5).map(|one| format!("{:?}", one.meta.name)).collect();
                    FarmError::Library {
                        file: file.clone(),
                        found: format!("{} species: {}", species.len(), found.join(", ")),
                        expected: format!("the species {name:?}, as {INDEX} says"),
                    }
                })?;
                Ok((Opened::Own(Box::new(library)), at))
            }
        }
    }

    /// Checks that the file of a species has the bytes that the index tells of.
    pub(super) fn check(&self, name: &str) -> Result<(), FarmError> {
        let Place::File { file, blake3, .. } = &self.species[name] else { return Ok(()) };
        let found = file_digest(file)?;
        match found == *blake3 {
            true => Ok(()),
            false => Err(FarmError::Library {
                file: file.clone(),
                found: format!("bytes of the digest {found}"),
                expected: format!("{blake3}, as {INDEX} says: the file changed since it was built"),
            }),
        }
    }
}

impl Place {
    /// Whether two are files of one digest.
    pub(super) fn is_same(&self, other: &Place) -> bool {
        match (self, other) {
            (Place::File { blake3: one, .. }, Place::File { blake3: other, .. }) => one == other,
            _ => false,
        }
    }

    pub(super) fn picture(&self) -> Option<&Path> {
        match self {
            Place::File { picture, .. } => picture.as_deref(),
            Place::Within(_) => None,
        }
    }
}

/// An open library: that of a side, or one of a species alone.
pub(super) enum Opened<'s> {
    Shared(&'s Library),
    Own(Box<Library>),
}

impl std::ops::Deref for Opened<'_> {
    type Target = Library;

    fn deref(&self) -> &Library {
        match self {
            Opened::Shared(library) => library,
            Opened::Own(library) => library,
        }
    }
}

/// A path below a folder, unless it leads out of it.
fn below(folder: &Path, inner: &str) -> Option<PathBuf> {
    let stays = Path::new(inner).components().all(|part| matches!(part, Component::Normal(_)));
    (stays && !inner.is_empty()).then(|| folder.join(inner))
}

fn outside(file: &Path, inner: &str) -> FarmError {
    FarmError::Library {
        file: file.to_owned(),
        found: format!("the path {inner:?}"),
        expected: "one that stays below the folder".to_owned(),
    }
}

fn file_digest(file: &Path) -> Result<String, FarmError> {
    let failed = |source| RuntimeError::Io { path: file.to_owned(), action: "read", source };
    let source = FileSource::open(file)?;
    let length = source.len_bytes().map_err(failed)?;
    let (mut hasher, mut bytes) = (blake3::Hasher::new(), vec![0; CHUNK_BYTES]);
    let mut offset = 0;
    while offset < length {
        let part = (length - offset).min(CHUNK_BYTES as u64);
        let part_bytes = &mut bytes[..part as usize];
        source.read_exact_at(offset, part_bytes).map_err(failed)?;
        hasher.update(part_bytes);
        offset += part;
    }
    Ok(hasher.finalize().to_hex().to_string())
}

/// Digest of all that a file has of a species: metadata and pages, wherever in the file they are.
pub(super) fn content_digest(library: &Library, species: usize) -> Result<[u8; 32], FarmError> {
    let (container, source) = (library.container(), library.source());
    let refused = |error| RuntimeError::Format { path: library.path().to_owned(), source: Box::new(error) };
    let mut hasher = blake3::Hasher::new();
    for (at, section) in container.sections().iter().enumerate() {
        if section.key.species as usize != species {
            continue;
        }
        let head = [section.key.kind, section.key.item, section.codec, section.threshold.to_bits()];
        let head = [&head[..], &[section.lattice, section.bands, section.page_count]].concat();
        head.iter().for_each(|number| _ = hasher.update(&number.to_le_bytes()));
        for page in 0..container.pages(at).len() {
            let bytes = container.read_stored(source, at, page as u32).map_err(refused)?;
            hasher.update(&(bytes.len() as u64).to_le_bytes()).update(&bytes);
        }
    }
    Ok(*hasher.finalize().as_bytes())
}

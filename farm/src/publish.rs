//! Writes what all species of a library have together: one file, the index, the page.

use flb_files::publish_own;
use flb_packer::{Copier, EncodedSpecies, write_library_to};
use flb_runtime::Library;

use crate::FarmError;
use crate::index::{Index, LibraryFile};
use crate::manifest::Manifest;
use crate::outcome::{Built, Outcome};
use crate::output::{self, Output};
use crate::page;

/// Writes the file of all species, index and page, as far as they change; returns the bytes of the first, if it is
/// there. While a species is missing, the file of all stays as it was.
pub(crate) fn write_all(
    manifest: &Manifest,
    output: &Output,
    mut index: Index,
    old: Option<Index>,
    built: &[Built],
) -> Result<Option<u64>, FarmError> {
    let is_whole = index.species.len() == manifest.species.len();
    let kept = old.as_ref().and_then(|old| old.library.clone());
    index.library = match (manifest.merge, is_whole) {
        (false, _) => None,
        (true, false) => kept,
        (true, true) => Some(merge(output, &index, kept)?),
    };
    let mut text = serde_json::to_vec_pretty(&index).expect("numbers, names and lists are JSON");
    text.push(b'\n');
    let failed = built.iter().any(|one| matches!(one.outcome, Outcome::Failed(_)));
    // The page tells what changed with the last build that changed anything.
    if old.as_ref() != Some(&index) || failed || !output.page().is_file() {
        let page = page::html(manifest, &index, old.as_ref(), built);
        output::write(&output.page(), page.as_bytes())?;
    }
    output::write(&output.index(), &text)?;
    Ok(index.library.map(|library| library.bytes))
}

/// The file of all species, unless it is there.
fn merge(output: &Output, index: &Index, kept: Option<LibraryFile>) -> Result<LibraryFile, FarmError> {
    let made_of = index.made_of();
    let path = output.library();
    if let Some(kept) = kept.filter(|kept| kept.made_of == made_of)
        && output::read(&path).is_some_and(|bytes| blake3::hash(&bytes).to_hex().as_str() == kept.blake3)
    {
        return Ok(kept);
    }
    let mut coded: Vec<EncodedSpecies> = Vec::with_capacity(index.species.len());
    for entry in index.species.values() {
        let library = Library::open(output.folder().join(&entry.file))?;
        let mut copier = Copier::new(library.container(), library.source());
        coded.push(copier.species(0)?);
    }
    let mut bytes = Vec::new();
    let all: Vec<&EncodedSpecies> = coded.iter().collect();
    write_library_to(&mut bytes, &all)?;
    publish_own(&path, |file| file.write_all(&bytes))?;
    let blake3 = blake3::hash(&bytes).to_hex().to_string();
    Ok(LibraryFile { file: "library.flb".to_owned(), bytes: bytes.len() as u64, blake3, made_of })
}

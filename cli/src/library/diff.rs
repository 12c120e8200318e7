//! `flb library diff`: by how much the light of two libraries differs, and a verdict.

use std::path::{Path, PathBuf};

use flb_farm::compare::{CompareObserver, Comparison, FILES, SpeciesComparison, State, compare, files};
use flb_format::container::Species;
use flb_runtime::Library;

use crate::args::LibraryDiffArgs;
use crate::exit::{Failure, USAGE, VERDICT};
use crate::folder;
use crate::inputs::check_local;
use crate::memory::{check_bytes, sampler_bytes};
use crate::print::{self, line, say};

/// Folders of a build, which are no place for a report on it.
const BUILT: [&str; 5] = ["", "species", "records", "pictures", "logs"];
/// Arrays of the medium and the extinction, and what is made of them to march through, bytes a site.
const MEDIUM_BYTES: u64 = 48;

/// Checks, compares, publishes the folder, prints; exits 1 where a species fails.
pub(super) fn run(args: &LibraryDiffArgs) -> Result<u8, Failure> {
    for input in [&args.old, &args.new] {
        check_local(input)?;
    }
    if let Some(folder) = &args.out {
        check_folder(folder, args)?;
    }
    let found = compare(&args.old, &args.new, args.fail_above, &Shown(args))?;
    if let Some(folder) = &args.out {
        let files = files(&found);
        let named: Vec<_> = files.iter().map(|(name, bytes)| (name.as_str(), bytes.clone())).collect();
        folder::publish_all(folder, &named, args.existing)?;
        say!("{}: {} files; open index.html", folder.display(), named.len());
    }
    match args.json {
        true => print::json(&found)?,
        false => print::out(&text(&found))?,
    }
    Ok(if found.passes { 0 } else { VERDICT })
}

/// Refuses, before any work, a folder that is an input or cannot be written to.
fn check_folder(folder: &Path, args: &LibraryDiffArgs) -> Result<(), Failure> {
    for input in [&args.old, &args.new] {
        if input.is_dir() && BUILT.iter().any(|inner| is_same(&input.join(inner), folder)) {
            let message = format!("is of {}, which is compared: name another folder", input.display());
            return Err(Failure::new(USAGE, message).at(folder));
        }
    }
    folder::check_folder(folder, &FILES, &[&args.old, &args.new], args.existing)
}

/// Whether two names lead to one folder.
fn is_same(one: &Path, other: &Path) -> bool {
    let real = |path: &Path| -> Option<PathBuf> { path.canonicalize().ok() };
    real(one).is_some_and(|one| real(other) == Some(one))
}

/// Says what has been compared, and keeps to the memory.
struct Shown<'a>(&'a LibraryDiffArgs);

impl CompareObserver for Shown<'_> {
    fn compared(&self, species: &SpeciesComparison, done: usize, total: usize) {
        if print::is_terminal() {
            say!("[{done}/{total}] {}", species.name);
        }
    }

    fn admit(&self, light: &[(&Library, &Species)]) -> Result<(), String> {
        let bytes = |species: &Species| {
            sampler_bytes(species).saturating_add(MEDIUM_BYTES * species.meta.grid.sites() as u64)
        };
        // One is sampled after the other.
        light.iter().try_for_each(|(library, species)| {
            let what = format!("{}: species {:?}", library.path().display(), species.meta.name);
            check_bytes(&what, bytes(species), &self.0.memory).map_err(|failure| failure.message)
        })
    }
}

/// The summary, then a line for each species that is not as it was.
fn text(found: &Comparison) -> String {
    let mut text = line!("{} -> {}: {}", found.old, found.new, found.summary());
    for one in found.species.iter().filter(|one| one.state != State::Unchanged) {
        let verdict = if one.failure.is_some() { "FAILED: " } else { "" };
        text += &line!("{}: {verdict}{}", one.name, one.told());
    }
    text
}

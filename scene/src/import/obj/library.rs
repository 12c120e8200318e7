//! The materials of all MTL files of an OBJ, and what a name in the OBJ means among them.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use flb_format::text::url::{is_meant, shown_reference};

use super::mtl::{self, Mtl};
use crate::import::error::ImportError;
use crate::import::files::{Files, Found, words};
use crate::import::limits;

/// The materials of all MTL files, each file read once.
#[derive(Default)]
pub(super) struct Library {
    materials: Vec<Mtl>,
    read: Vec<Read>,
    bytes: u64,
    /// By name as written; of several materials of one name the last one holds, as if it had overwritten the others.
    exact: HashMap<String, usize>,
    /// Names of several materials that differ.
    ambiguous: HashSet<String>,
    /// By [`common`] name, and by that without case.
    alike: [HashMap<String, usize>; 2],
}

/// Words of a file's name among several on a line.
const MAX_WORDS: usize = 6;

/// An MTL file.
struct Read {
    path: PathBuf,
    /// From the mesh's folder.
    folder: PathBuf,
    /// Number of its first material.
    first: usize,
}

impl Library {
    /// Reads the files that `lines` of `mtllib` name.
    pub(super) fn read(files: &mut Files, lines: &[String]) -> Result<Library, ImportError> {
        let mut library = Library::default();
        for names in lines {
            library.read_line(files, names)?;
        }
        for (index, mtl) in library.materials.iter().enumerate() {
            let before = library.exact.insert(mtl.name.clone(), index);
            if before.is_some_and(|before| library.materials[before] != *mtl) {
                library.ambiguous.insert(mtl.name.clone());
            }
            let common = common(&mtl.name);
            library.alike[1].insert(words::caseless(&common), index);
            library.alike[0].insert(common, index);
        }
        Ok(library)
    }

    /// The material that an OBJ calls `name`, and where its textures are looked for: as it is written in both files,
    /// else as the same letters in another spelling, else in another case, with a warning.
    pub(super) fn find(&self, files: &mut Files, name: &str) -> Option<(&Mtl, [&Path; 2])> {
        let common = common(name);
        let alike = || self.alike[0].get(&common);
        let index = match self.exact.get(name).or_else(alike) {
            Some(&index) => index,
            None => {
                let &index = self.alike[1].get(&words::caseless(&common))?;
                files.warn(format!(
                    "the material '{name}' is '{}' in the MTL file",
                    self.materials[index].name
                ));
                index
            }
        };
        if self.ambiguous.contains(&self.materials[index].name) {
            files.warn(format!(
                "the material '{name}' is there several times, and differs; the last one is taken"
            ));
        }
        let of = self.read.partition_point(|read| read.first <= index) - 1;
        Some((&self.materials[index], [&self.read[of].folder, Path::new("")]))
    }

    /// `mtllib` may name one file with spaces in its name, or several files.
    fn read_line(&mut self, files: &mut Files, names: &str) -> Result<(), ImportError> {
        let names = names.trim_matches('"');
        if let Found::File(path) = self.look_for(files, names)? {
            return self.read_file(files, path);
        }
        // A URL with a blank in it is one name: its pieces would not look like one.
        let is_one = is_meant(names);
        let words: Vec<&str> =
            names.split(|c: char| c.is_whitespace() && !is_one).filter(|name| !name.is_empty()).collect();
        let mut at = 0;
        while at < words.len() {
            let (name, path) = (
                shown_reference(words[at]),
                match self.look_for(files, words[at].trim_matches('"'))? {
                    Found::File(path) => {
                        self.read_file(files, path)?;
                        at += 1;
                        continue;
                    }
                    Found::Missing(path) => path,
                },
            );
            // One of several files may have blanks in its name, too.
            if let Some((path, next)) = self.look_for_words(files, &words, at)? {
                self.read_file(files, path)?;
                at = next;
                continue;
            }
            let path = path.display();
            files.warn(format!("the material file '{name}' is not there ({path}); going on without"));
            at += 1;
        }
        Ok(())
    }

    /// The file whose name is the words from one on, and the number of the word behind them.
    fn look_for_words(
        &self,
        files: &mut Files,
        words: &[&str],
        from: usize,
    ) -> Result<Option<(PathBuf, usize)>, ImportError> {
        for to in from + 2..=words.len().min(from + MAX_WORDS) {
            if let Found::File(path) = self.look_for(files, words[from..to].join(" ").trim_matches('"'))? {
                return Ok(Some((path, to)));
            }
        }
        Ok(None)
    }

    /// Beside the OBJ, then beside the MTL file before.
    fn look_for(&self, files: &mut Files, name: &str) -> Result<Found, ImportError> {
        let before = self.read.last().map_or(Path::new(""), |read| &read.folder);
        files.find("mtllib", name, &[Path::new(""), before])
    }

    fn read_file(&mut self, files: &mut Files, path: PathBuf) -> Result<(), ImportError> {
        if !self.read.iter().any(|read| read.path == path) {
            let first = self.materials.len();
            self.bytes += mtl::read(files, &path, limits::MTL_BYTES - self.bytes, &mut self.materials)?;
            files.limit("material files", self.read.len() as u64 + 1, limits::LIBRARIES)?;
            self.read.push(Read { folder: files.folder_of(&path), path, first });
        }
        Ok(())
    }
}

/// What one name has in common in two files: its letters, composed, whatever each file was read as.
fn common(name: &str) -> String {
    words::composed(&words::reread(name).unwrap_or_else(|| name.to_owned())).into_owned()
}

//! Which mesh of a glTF is meant: a word that is its name, or its number where names do not tell meshes apart.

use std::collections::HashMap;

use gltf::json::Root;

use crate::import::error::{ImportError, quoted};
use crate::import::files::Files;

/// The word for the whole default scene as one plant, instances included.
pub const WHOLE: &str = "*";

/// Meshes that a message lists.
const LISTED: usize = 20;

/// The words for all meshes of a file.
pub(super) struct Words<'a> {
    root: &'a Root,
    /// How many meshes have a name.
    counts: HashMap<&'a str, usize>,
}

impl<'a> Words<'a> {
    /// Of a file's meshes.
    pub(super) fn of(root: &'a Root) -> Words<'a> {
        let mut counts = HashMap::new();
        root.meshes
            .iter()
            .flat_map(|mesh| &mesh.name)
            .for_each(|name| *counts.entry(name.as_str()).or_insert(0) += 1);
        Words { root, counts }
    }

    /// The name of mesh `index`, if that name is no other's and cannot be mistaken for another word.
    pub(super) fn name(&self, index: usize) -> Option<&'a str> {
        let name = self.root.meshes.get(index)?.name.as_deref()?;
        let is_word = !name.is_empty() && name != WHOLE && !name.starts_with('#');
        (is_word && self.counts[name] == 1).then_some(name)
    }

    /// Whether a mesh has this name.
    pub(super) fn is_name(&self, name: &str) -> bool {
        self.counts.contains_key(name)
    }

    /// The word that means mesh `index`.
    pub(super) fn word(&self, index: usize) -> String {
        self.name(index).map_or_else(|| format!("#{index}"), str::to_owned)
    }

    /// The mesh that `word` means.
    pub(super) fn find(&self, files: &Files, word: &str) -> Result<usize, ImportError> {
        let meshes = &self.root.meshes;
        let found = match word.strip_prefix('#').map(str::parse::<usize>) {
            Some(Ok(index)) if index < meshes.len() => return Ok(index),
            Some(_) => format!("no mesh has this number, of 0 to {}", meshes.len().saturating_sub(1)),
            None => {
                let mut named =
                    (0..meshes.len()).filter(|&index| meshes[index].name.as_deref() == Some(word));
                match (named.next(), named.count()) {
                    (Some(index), 0) => return Ok(index),
                    (Some(_), more) => format!("{} meshes have this name", more + 1),
                    (None, _) => "no mesh has this name".to_owned(),
                }
            }
        };
        let (file, word, meshes) = (files.file.clone(), quoted(word), self.listed());
        Err(ImportError::UnknownMesh { file, word, found, meshes })
    }

    /// The words for a message; a number has its name behind it.
    pub(super) fn listed(&self) -> String {
        let count = self.root.meshes.len();
        let described = |index: usize| match (self.name(index), &self.root.meshes[index].name) {
            (None, Some(name)) => format!("#{index} ('{}')", quoted(name)),
            _ => format!("'{}'", quoted(&self.word(index))),
        };
        let mut words: Vec<String> = (0..count.min(LISTED)).map(described).collect();
        match count {
            0 => words.push("none".to_owned()),
            _ if count > LISTED => words.push(format!("and {} more", count - LISTED)),
            _ => {}
        }
        words.join(", ")
    }
}

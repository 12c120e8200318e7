//! Documents and the code that cites them: what a comment or a page points at is there, and pages stay as short as they
//! promise. Commands and flags of `flb` are held in `cli/src/reference.rs`, Rust by doctests of this crate.

mod citations;
mod commands;
mod links;
mod planted;
mod shown;
mod text;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The checks, which hold what they look for.
const CHECKS: &str = "tests/tests/it/documents/";

/// A text file of the repository.
pub(crate) struct File {
    /// From the root, with `/`.
    pub(crate) path: String,
    pub(crate) text: String,
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Every file of ours whose name ends in one of these, and the paths of all others.
pub(crate) fn files(endings: &[&str]) -> (Vec<File>, BTreeSet<String>) {
    fn walk(folder: &Path, from_root: &str, paths: &mut BTreeSet<String>) {
        for entry in std::fs::read_dir(folder).expect("the checkout can be listed") {
            let entry = entry.expect("an entry");
            let name = entry.file_name().into_string().expect("names are text");
            let path = format!("{from_root}{name}");
            if !entry.file_type().expect("a type").is_dir() {
                paths.insert(path);
            } else if !name.starts_with('.')
                && !["target", "out", "corpus", "artifacts", "shared"].contains(&name.as_str())
            {
                walk(&entry.path(), &format!("{path}/"), paths);
            }
        }
    }
    let mut paths = BTreeSet::new();
    walk(&root(), "", &mut paths);
    let is_ours =
        |path: &&String| endings.iter().any(|ending| path.ends_with(ending)) && !path.starts_with(CHECKS);
    let read = |path: &String| File {
        path: path.clone(),
        text: std::fs::read_to_string(root().join(path)).expect("ours is text"),
    };
    let found = paths.iter().filter(is_ours).map(read).collect();
    (found, paths)
}

fn documents() -> (Vec<File>, BTreeSet<String>) {
    files(&[".md"])
}

fn sources() -> (Vec<File>, BTreeSet<String>) {
    files(&[".rs", ".wgsl", ".py", ".toml"])
}

fn nothing(found: Vec<String>) {
    assert!(found.is_empty(), "\n{}", found.join("\n"));
}

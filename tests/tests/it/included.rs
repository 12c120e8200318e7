//! No file is a part of two crates: `#[path]` leads to files of the same crate, and what tests of several crates share
//! is in `flb-testkit`. Such a file would be compiled twice, with other names around it.

use std::path::Path;

use crate::documents::{File, files};

/// `a/../b` without dots; `None` where it leaves the repository.
fn normal(path: &Path) -> Option<String> {
    let mut parts: Vec<String> = Vec::new();
    for part in path.iter().map(|part| part.to_string_lossy()) {
        match &*part {
            "." => {}
            ".." => drop(parts.pop()?),
            part => parts.push(part.to_owned()),
        }
    }
    Some(parts.join("/"))
}

/// Every `#[path]` that leaves the crate, which is the first folder of a file's path.
fn leaving(file: &File) -> Vec<String> {
    let named =
        file.text.lines().filter_map(|line| line.trim().strip_prefix("#[path = \"")?.split('"').next());
    let package = file.path.split('/').next().unwrap_or_default();
    let folder = Path::new(&file.path).parent().unwrap_or(Path::new(""));
    let leaves = |named: &&str| {
        !normal(&folder.join(named)).is_some_and(|path| path.starts_with(&format!("{package}/")))
    };
    named.filter(leaves).map(|named| format!("{} includes {named} of another crate", file.path)).collect()
}

#[test]
fn no_file_is_a_part_of_two_crates() {
    let (sources, _) = files(&[".rs"]);
    assert!(sources.len() > 400, "{} sources", sources.len());
    assert_eq!(sources.iter().flat_map(leaving).collect::<Vec<_>>(), Vec::<String>::new());
}

#[test]
fn a_planted_file_of_another_crate_is_found() {
    let file = File {
        path: "cli/tests/it/main.rs".to_owned(),
        text: "#[path = \"../own.rs\"]\nmod own;\n    #[path = \"../../../view/src/x.rs\"]\n#[path = \"../../../../x.rs\"]\n"
            .to_owned(),
    };
    assert_eq!(
        leaving(&file),
        [
            "cli/tests/it/main.rs includes ../../../view/src/x.rs of another crate",
            "cli/tests/it/main.rs includes ../../../../x.rs of another crate"
        ]
    );
}

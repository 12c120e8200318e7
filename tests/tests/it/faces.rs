//! A library's root shows what its user meets first: a dozen names or so, and an example that runs. The rest lies in
//! modules.

use std::path::Path;

use crate::comments::rooms;
use crate::imports::paths;

/// Bound of the names at a root, modules not counted.
const MAX_NAMES: usize = 14;

/// Libraries whose documentation begins with an example that runs: those that a program begins from.
const WITH_EXAMPLE: [&str; 6] = ["format-spec", "packer", "render", "runtime-loader", "scene", "stage"];

/// Items that a root declares itself.
const ITEMS: [&str; 7] = ["fn ", "struct ", "enum ", "trait ", "type ", "const ", "static "];

/// Names that a root gives out or declares. A glob is one, `*`, which no bound can hold.
fn names(root: &str) -> Vec<String> {
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    let mut found = Vec::new();
    for (at, _) in root.match_indices("\npub ") {
        let item = &root[at + "\npub ".len()..];
        if let Some(tree) = item.strip_prefix("use ") {
            let tree = tree.split(';').next().unwrap_or_default();
            let last = |path: &String| path.rsplit("::").next().unwrap_or_default().to_owned();
            found.extend(paths(tree).iter().map(last));
        } else if let Some(declared) = ITEMS.iter().find_map(|kind| item.strip_prefix(kind)) {
            found.push(declared.split(|c| !is_name(c)).next().unwrap_or_default().to_owned());
        }
    }
    found
}

/// Whether the first example in a root's documentation is compiled and run.
fn begins_with_an_example(root: &str) -> bool {
    let fences = root.lines().filter_map(|line| line.strip_prefix("//! ```"));
    fences.step_by(2).find(|language| *language != "text") == Some("")
}

/// What a root shows too much of, or lacks; one sentence each.
fn breaches(folder: &str, root: &str) -> Vec<String> {
    let (names, mut found) = (names(root), Vec::new());
    if names.len() > MAX_NAMES || names.iter().any(|name| name == "*") {
        let list = names.join(", ");
        found.push(format!(
            "{folder}: {} names at the root, expected at most {MAX_NAMES}: {list}",
            names.len()
        ));
    }
    if WITH_EXAMPLE.contains(&folder) && !begins_with_an_example(root) {
        found.push(format!("{folder}: the first example does not run"));
    }
    found
}

#[test]
fn a_root_shows_a_dozen_names_and_an_example_that_runs() {
    let root = |folder: &str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(folder).join("src/lib.rs");
        std::fs::read_to_string(path).ok()
    };
    let rooms = rooms(include_str!("../../../ARCHITECTURE.md"));
    let roots: Vec<_> = rooms.into_iter().filter_map(|folder| Some((folder, root(folder)?))).collect();
    assert!(roots.len() >= 15, "{} libraries", roots.len());
    assert!(names(&root("format-spec").expect("a library")).contains(&"Container".to_owned()));
    let found: Vec<String> = roots.iter().flat_map(|(folder, root)| breaches(folder, root)).collect();
    assert!(found.is_empty(), "\n{}", found.join("\n"));
}

#[test]
fn planted_names_and_an_example_that_does_not_run_are_found() {
    let few = "//! ```text\n//! a -> b\n//! ```\n//! ```\n//! a();\n//! ```\n\npub mod a;\nmod b;\n\n\
               pub use b::{\n    B,\n    c::{D, E as F},\n};\npub(crate) use b::G;\npub fn h() {}\n";
    assert_eq!(names(few), ["B", "D", "E", "h"]);
    assert_eq!(breaches("scene", few), Vec::<String>::new());
    let many: String = (0..15).map(|number| format!("\npub const N{number}: u8 = 0;")).collect();
    let found = breaches("scene", &format!("//! ```no_run\n//! a();\n//! ```\n{many}"));
    assert!(found[0].starts_with("scene: 15 names at the root, expected at most 14: N0, N1"), "{found:?}");
    assert_eq!(found[1..], ["scene: the first example does not run"]);
    assert_eq!(breaches("gpu", "\npub use a::*;").len(), 1);
}

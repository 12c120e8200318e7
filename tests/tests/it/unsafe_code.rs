//! Only three files may hold unsafe code: read from the sources themselves, so that no attribute can be forgotten.

use std::fs;
use std::path::{Path, PathBuf};

/// The files, and the crate root that lets each: a mapping, a look at stdout before the standard library starts, and
/// names that a web page calls.
const ALLOWED: [(&str, &str); 3] = [
    ("examples/browser/src/lib.rs", "examples/browser/src/lib.rs"),
    ("runtime-loader/src/source/mapped.rs", "runtime-loader/src/lib.rs"),
    ("cli/src/startup.rs", "cli/src/main.rs"),
];

/// Every Rust file of the repository, by its path from the root.
pub(crate) fn sources() -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut found = Vec::new();
    let mut folders = vec![PathBuf::new()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(root.join(&folder)).expect("a folder of the repository") {
            let entry = entry.expect("an entry");
            let name = entry.file_name().to_string_lossy().into_owned();
            let path = folder.join(&name);
            if entry.file_type().expect("its type").is_dir() {
                if !name.starts_with('.') && name != "target" {
                    folders.push(path);
                }
            } else if name.ends_with(".rs") {
                let text = fs::read_to_string(root.join(&path)).expect("Rust is UTF-8");
                found.push((path.to_string_lossy().replace('\\', "/"), text));
            }
        }
    }
    found.sort();
    found
}

/// Every breach of the rule, one sentence each.
fn breaches(sources: &[(String, String)]) -> Vec<String> {
    let mut found = Vec::new();
    for (path, text) in sources {
        let is_root = path.ends_with("/src/lib.rs") || path.ends_with("/src/main.rs");
        let is_allowing = ALLOWED.iter().any(|(_, root)| path == root);
        let attribute = if is_allowing { "#![deny(unsafe_code" } else { "#![forbid(unsafe_code" };
        if is_root && !text.lines().any(|line| line.starts_with(attribute)) {
            found.push(format!("{path} lacks {attribute})]"));
        }
        // Names of the lint aside, the word is code: strings and comments do not need it.
        let code = text.lines().map(|line| line.split("//").next().unwrap_or_default());
        let unsafe_line = code.map(|line| line.replace("unsafe_code", "")).position(|line| {
            line.split(|c: char| !c.is_alphanumeric() && c != '_').any(|word| word == concat!("un", "safe"))
        });
        let allows = text.contains(concat!("allow(", "unsafe_code"));
        let is_allowed = ALLOWED.iter().any(|(file, _)| path == file);
        if !is_allowed && (unsafe_line.is_some() || allows) {
            found.push(format!("{path} leaves safe Rust, line {}", unsafe_line.map_or(0, |line| line + 1)));
        }
    }
    found
}

#[test]
fn unsafe_code_is_in_three_files() {
    let sources = sources();
    let roots =
        sources.iter().filter(|(path, _)| path.ends_with("/src/lib.rs") || path.ends_with("/src/main.rs"));
    assert!(roots.count() >= 9, "the crates of the workspace");
    for (file, _) in ALLOWED {
        let holds =
            |text: &str| text.contains(concat!("un", "safe {")) || text.contains(concat!("un", "safe("));
        assert!(sources.iter().any(|(path, text)| path == file && holds(text)), "{file}");
    }
    assert_eq!(breaches(&sources), Vec::<String>::new());
}

#[test]
fn planted_unsafe_code_is_found() {
    let planted = [
        ("a/src/lib.rs".to_owned(), "//! No attribute.\n".to_owned()),
        ("b/src/lib.rs".to_owned(), "#![deny(unsafe_code)]\n".to_owned()),
        ("c/src/x.rs".to_owned(), concat!("fn f() {\n    un", "safe { g() }\n}\n").to_owned()),
        ("d/tests/x.rs".to_owned(), concat!("#![allow(", "unsafe_code)]\n").to_owned()),
        ("e/src/x.rs".to_owned(), concat!("// nothing un", "safe here\n").to_owned()),
    ];
    assert_eq!(
        breaches(&planted),
        [
            "a/src/lib.rs lacks #![forbid(unsafe_code)]",
            "b/src/lib.rs lacks #![forbid(unsafe_code)]",
            "c/src/x.rs leaves safe Rust, line 2",
            "d/tests/x.rs leaves safe Rust, line 0",
        ]
    );
}

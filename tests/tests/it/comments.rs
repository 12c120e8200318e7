//! A comment of a public item stands alone: documentation shows an item without those beside it, so the comment does
//! not begin with a word that refers to one.

use std::path::Path;

/// First words of a comment that refer to something before it.
const REFERENCES: &str = "Another, As, How it, How many there, It, Its, Of, Such, That, The other, The same, Their, \
    Them, These, They, This, Those, What, Where it, Whether it, Whether they, Which, Who, Whose";

/// Flags of the command: their comments are its help, which says what a user does.
const HELP: [&str; 2] = ["cli/src/args", "cli/src/args.rs"];

/// Folders of what ships: the drawing of rooms, and the fixtures beside it.
pub(crate) fn rooms(architecture: &str) -> Vec<&str> {
    let floors = architecture.lines().filter(|line| line.starts_with("floor "));
    let folders = floors.flat_map(|line| line.split_whitespace().skip(2)).chain(["fixtures"]);
    folders.collect()
}

/// Comments before an item of a source by the line that each begins in: its first line, and whether the item is
/// public. Variants of a public enum and items of a public trait are. Sources are formatted, so a block ends at the
/// indentation that it begins at.
fn comments(text: &str) -> Vec<(usize, &str, bool)> {
    let indentation = |line: &str| line.len() - line.trim_start().len();
    let mut found = Vec::new();
    // Indentation of the public enum or trait around the line.
    let mut around = None;
    let mut lines = (1..).zip(text.lines()).peekable();
    while let Some((number, line)) = lines.next() {
        let code = line.trim_start();
        if let Some(first) = code.strip_prefix("///") {
            let is_next = |line: &str| line.trim_start().starts_with("//");
            while lines.next_if(|(_, line)| is_next(line)).is_some() {}
            // Attributes, each to its last line.
            while let Some((_, line)) = lines.next_if(|(_, line)| line.trim_start().starts_with("#[")) {
                let end = indentation(line);
                if !line.trim_end().ends_with(']') {
                    while lines.next_if(|(_, line)| indentation(line) > end).is_some() {}
                    lines.next();
                }
            }
            let is_public = lines.peek().is_some_and(|(_, item)| item.trim_start().starts_with("pub "));
            found.push((number, first.trim(), is_public || around.is_some()));
        } else if ["pub enum ", "pub trait "].iter().any(|start| code.starts_with(start))
            && code.ends_with('{')
        {
            around = Some(indentation(line));
        } else if code == "}" && around == Some(indentation(line)) {
            around = None;
        }
    }
    found
}

/// Comments of public items that begin with a reference, one sentence each.
fn dangling(path: &str, text: &str) -> Vec<String> {
    let begins_with = |comment: &str, words: &str| {
        comment
            .strip_prefix(words)
            .is_some_and(|rest| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '\''))
    };
    let public = comments(text).into_iter().filter(|(.., is_public)| *is_public);
    let refers = |comment: &str| REFERENCES.split(", ").find(|words| begins_with(comment, words));
    let told = |(number, words)| {
        format!("{path}:{number}: begins with \"{words}\", expected what the item is or does")
    };
    public.filter_map(|(number, comment, _)| Some((number, refers(comment)?))).map(told).collect()
}

/// Every source of a folder but its tests and the help, by its path from the root.
fn sources(folder: &str) -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let (mut found, mut folders) = (Vec::new(), vec![format!("{folder}/src")]);
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(root.join(&folder)).expect("a folder of the repository") {
            let entry = entry.expect("an entry");
            let name = entry.file_name().into_string().expect("names are text");
            let path = format!("{folder}/{name}");
            if ["tests", "tests.rs"].contains(&name.as_str()) || HELP.contains(&path.as_str()) {
                continue;
            }
            if entry.file_type().expect("its type").is_dir() {
                folders.push(path);
            } else if name.ends_with(".rs") {
                found.push((path, std::fs::read_to_string(entry.path()).expect("Rust is UTF-8")));
            }
        }
    }
    found.sort();
    found
}

#[test]
fn comments_of_public_items_stand_alone() {
    let rooms = rooms(include_str!("../../../ARCHITECTURE.md"));
    assert!(rooms.contains(&"format-spec") && rooms.contains(&"fixtures"), "{rooms:?}");
    let sources: Vec<_> = rooms.into_iter().flat_map(sources).collect();
    let public: usize = sources
        .iter()
        .map(|(_, text)| comments(text).iter().filter(|(.., is_public)| *is_public).count())
        .sum();
    assert!(public > 3000, "read {public} comments in {} files", sources.len());
    let found: Vec<String> = sources.iter().flat_map(|(path, text)| dangling(path, text)).collect();
    assert!(found.is_empty(), "{} comments:\n{}", found.len(), found.join("\n"));
}

#[test]
fn planted_references_are_found_on_public_items_alone() {
    let text = "\
/// Of a private one.
struct A {
    /// What it holds.
    pub b: u8,
    /// Its name.
    c: String,
}

/// The same, of another.
///
/// It goes on.
#[derive(
    Debug,
)]
#[must_use]
pub enum D {
    /// As [`A`].
    E {
        /// Whether it is so.
        f: bool,
    },
    /// Itself, asymmetric, officially.
    G,
}

/// This within the crate.
pub(crate) fn h() {}
";
    let found: Vec<String> = dangling("a.rs", text);
    let lines: Vec<&str> =
        found.iter().map(|told| &told[..told.find(", expected").expect("it says what")]).collect();
    assert_eq!(
        lines,
        [
            "a.rs:3: begins with \"What\"",
            "a.rs:9: begins with \"The same\"",
            "a.rs:17: begins with \"As\"",
            "a.rs:19: begins with \"Whether it\"",
        ]
    );
    assert_eq!(comments(text).len(), 8);
}

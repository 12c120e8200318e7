//! Documents and comments are spelt in one way: the list, and what is left out, stand in typos.toml. Constants that
//! bound something are called so in one way.

use std::collections::BTreeMap;
use std::path::Path;

/// What typos.toml says.
struct Rules {
    /// A wrong word, small letters, to the right one.
    words: BTreeMap<String, String>,
    /// Paths from the root, folders with `/` at their end, and `*` before an ending.
    excluded: Vec<String>,
}

fn root() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn rules() -> Rules {
    let text = std::fs::read_to_string(root().join("typos.toml")).expect("it is in the root");
    let table: toml::Table = text.parse().expect("it is TOML");
    let words = table["type"]["markdown"]["extend-words"].as_table().expect("a table");
    let words =
        words.iter().map(|(wrong, right)| (wrong.clone(), right.as_str().expect("a word").to_owned()));
    let excluded = table["files"]["extend-exclude"].as_array().expect("a list").iter();
    Rules {
        words: words.filter(|(wrong, right)| wrong != right).collect(),
        excluded: excluded.map(|path| path.as_str().expect("a path").to_owned()).collect(),
    }
}

impl Rules {
    fn excludes(&self, path: &str) -> bool {
        self.excluded.iter().any(|rule| match (rule.strip_prefix('*'), rule.ends_with('/')) {
            (Some(ending), _) => path.ends_with(ending),
            (None, true) => path.starts_with(rule.as_str()),
            (None, false) => path == rule,
        })
    }

    /// Wrong words of a file, one sentence each.
    fn wrong(&self, path: &str, text: &str) -> Vec<String> {
        let mut found = Vec::new();
        for (number, line) in prose(path, text) {
            // What is joined by one of these is a name of code or a path, not a word.
            let tokens = line.split(|c: char| !c.is_alphanumeric() && !"_:./".contains(c));
            let tokens = tokens.map(|token| token.trim_matches([':', '.', '/', '_']));
            for token in tokens.filter(|token| token.chars().all(char::is_alphabetic)) {
                let is_name = token.chars().skip(1).any(char::is_uppercase);
                if let Some(right) = self.words.get(&token.to_lowercase()).filter(|_| !is_name) {
                    found.push(format!("{path}, line {number}: {token}, expected {right}"));
                }
            }
        }
        found
    }
}

/// Constants of a source whose names bound something in other words than MAX and MIN.
fn other_bounds(path: &str, text: &str) -> Vec<String> {
    let name = |line: &str| {
        let line = line.trim_start();
        let seen = ["pub ", "pub(crate) ", "pub(super) "].iter().find_map(|seen| line.strip_prefix(seen));
        let rest = seen.unwrap_or(line).strip_prefix("const ")?;
        Some(rest.split(':').next()?.to_owned())
    };
    let is_other = |name: &String| {
        ["MOST", "LEAST", "FEWEST"].iter().any(|word| name == word || name.starts_with(&format!("{word}_")))
            || name.ends_with("_LIMIT")
    };
    let told = |(number, name)| format!("{path}, line {number}: {name}, expected MAX_ or MIN_");
    let names = (1..).zip(text.lines()).filter_map(|(number, line)| Some((number, name(line)?)));
    names.filter(|(_, name): &(u32, String)| is_other(name)).map(told).collect()
}

#[test]
fn bounds_are_called_max_and_min() {
    let text = [
        "const MAX_A: u32 = 1;",
        "pub const MOST_B: u32 = 2;",
        "    const C_LIMIT: u32 = 3;",
        "const LEAST: u8 = 4;",
    ];
    let text = text.join("\n");
    let planted = other_bounds("a.rs", &text);
    assert_eq!(planted.len(), 3, "{planted:?}");
    let files = files();
    let sources = files.iter().filter(|(path, _)| path.ends_with(".rs") || path.ends_with(".wgsl"));
    let found: Vec<String> = sources.flat_map(|(path, text)| other_bounds(path, text)).collect();
    assert!(found.is_empty(), "\n{}", found.join("\n"));
}

/// Lines of a document outside of blocks, or comments of a source, by their numbers; code between back quotes is left
/// out.
fn prose(path: &str, text: &str) -> Vec<(usize, String)> {
    let is_document = path.ends_with(".md");
    let mut inside = false;
    let mut found = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let is_fence = line.trim_start().trim_start_matches(['/', '!', ' ']).starts_with("```");
        inside ^= is_fence;
        let mark = if path.ends_with(".rs") || path.ends_with(".wgsl") { "//" } else { "#" };
        let words = if is_document { Some(line) } else { line.split_once(mark).map(|(_, words)| words) };
        if let Some(words) = words.filter(|_| !inside && !is_fence) {
            let words = words.split('`').step_by(2).collect::<Vec<_>>().join(" ` ");
            let words = words.split(' ').filter(|word| !word.contains("://"));
            found.push((number, words.collect::<Vec<_>>().join(" ")));
        }
    }
    found
}

/// Documents and sources of ours: paths from the root, and texts.
fn files() -> Vec<(String, String)> {
    fn walk(folder: &Path, from_root: &str, found: &mut Vec<(String, String)>) {
        for entry in std::fs::read_dir(folder).expect("the checkout can be listed") {
            let entry = entry.expect("an entry");
            let name = entry.file_name().into_string().expect("names are text");
            let path = format!("{from_root}{name}");
            if entry.file_type().expect("a type").is_dir() {
                if !name.starts_with('.') && !["target", "out", "shared"].contains(&name.as_str()) {
                    walk(&entry.path(), &format!("{path}/"), found);
                }
            } else if [".md", ".rs", ".wgsl", ".py", ".toml"].iter().any(|ending| name.ends_with(ending)) {
                found.push((path, std::fs::read_to_string(entry.path()).expect("ours is text")));
            }
        }
    }
    let mut found = Vec::new();
    walk(&root(), "", &mut found);
    found
}

#[test]
fn documents_and_comments_are_spelt_in_one_way() {
    let (rules, files) = (rules(), files());
    assert!(files.len() > 400 && rules.words.len() > 50, "{} files", files.len());
    let read = files.iter().filter(|(path, _)| !rules.excludes(path));
    let found: Vec<String> = read.flat_map(|(path, text)| rules.wrong(path, text)).collect();
    assert!(found.is_empty(), "{} words (typos.toml):\n{}", found.len(), found.join("\n"));
}

#[test]
fn what_is_left_out_of_spelling_is_there() {
    let files = files();
    for rule in rules().excluded.iter().filter(|rule| !rule.starts_with('*')) {
        let is_there = root().join(rule).exists() || files.iter().any(|(path, _)| path.starts_with(rule));
        assert!(is_there, "typos.toml leaves out {rule}, which is not there");
    }
}

#[test]
fn planted_spellings_are_found_in_prose_and_not_in_code() {
    let rules = rules();
    let document = "The Color of `color` in\n```rust\nlet color = 1;\n```\n(gray), wgpu::Color, a.color, background_color\n";
    assert_eq!(
        rules.wrong("README.md", document),
        ["README.md, line 1: Color, expected colour", "README.md, line 5: gray, expected grey"]
    );
    // No comment of this file.
    let mark = "/".repeat(2);
    let source = format!(
        "let color = 1; {mark} a color. See https:{mark}example.org/color\n{mark}/ Two meters of `meters`\nfn center() {{}}\n"
    );
    assert_eq!(
        rules.wrong("a.rs", &source),
        ["a.rs, line 1: color, expected colour", "a.rs, line 2: meters, expected metres"]
    );
    assert!(rules.excludes("fuzz/README.md") && rules.excludes("a/b.snap") && !rules.excludes("README.md"));
}

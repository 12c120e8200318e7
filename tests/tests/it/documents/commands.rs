//! Sources that documents name, and the benches, examples and tests that they tell to run.

use std::collections::{BTreeMap, BTreeSet};

use super::citations::has_end;
use super::text::code;
use super::{File, documents, files, nothing, sources};

/// `a/{b,c}.rs` -> `a/b.rs`, `a/c.rs`.
fn expanded(piece: &str) -> Vec<String> {
    let Some((before, rest)) = piece.split_once('{') else { return vec![piece.to_owned()] };
    let Some((choices, after)) = rest.split_once('}') else { return vec![piece.to_owned()] };
    choices.split(',').map(|choice| format!("{before}{choice}{after}")).collect()
}

/// Source files that a document names and that are not there.
pub(super) fn missing_sources(file: &File, paths: &BTreeSet<String>) -> Vec<String> {
    let is_path = |name: &str| {
        name.chars().all(|sign| sign.is_ascii_alphanumeric() || "._-/".contains(sign))
            && [".rs", ".wgsl", ".py"].iter().any(|ending| name.ends_with(ending))
    };
    let named = code(&file.text).into_iter().flat_map(|piece| expanded(&piece)).filter(|name| is_path(name));
    let missing = named.filter(|name| !has_end(paths, name));
    let folders = code(&file.text).into_iter().filter(|name| {
        let is_ours = name.ends_with('/')
            && name.chars().all(|sign| sign.is_ascii_alphanumeric() || "_-/".contains(sign));
        is_ours && name.matches('/').count() > 1 && !name.starts_with('/') && !name.contains("TARGET")
    });
    let missing_folders = folders.filter(|name| !paths.iter().any(|path| path.contains(name.as_str())));
    missing.chain(missing_folders).map(|name| format!("{}: no {name}", file.path)).collect()
}

/// Benches, examples and tests that a document tells to run and that are not there; `sources` holds where names of
/// tests are.
pub(super) fn missing_targets(
    file: &File,
    packages: &BTreeMap<String, String>,
    paths: &BTreeSet<String>,
    sources: &[File],
) -> Vec<String> {
    let mut found = Vec::new();
    // An empty word after each that ends a piece of code.
    let words: Vec<&str> = file
        .text
        .split_whitespace()
        .flat_map(|word| {
            let bare = word.trim_matches(['`', '(', ')', ',', ';', '.', ':']);
            let ends = word.trim_end_matches(['(', ')', ',', ';', '.', ':']).ends_with('`');
            std::iter::once(bare).chain(ends.then_some(""))
        })
        .collect();
    for place in (0..words.len()).filter(|place| words[*place] == "cargo") {
        let line: Vec<&str> =
            words[place + 1..].iter().take(20).take_while(|word| **word != "cargo").copied().collect();
        let value =
            |flag: &str| line.iter().position(|word| *word == flag).and_then(|at| line.get(at + 1)).copied();
        let Some(package) = value("-p") else { continue };
        let Some(folder) = packages.get(package) else {
            found.push(format!("{}: no package {package}", file.path));
            continue;
        };
        for (flag, kind) in [("--bench", "benches"), ("--test", "tests"), ("--example", "examples")] {
            let Some(name) = value(flag) else { continue };
            let is_there = |end: &str| paths.contains(&format!("{folder}/{kind}/{name}{end}"));
            if !is_there(".rs") && !is_there("/main.rs") {
                found.push(format!("{}: {package} has no {flag} {name}", file.path));
            }
        }
        found.extend(
            missing_modules(&line, folder, paths, sources)
                .into_iter()
                .map(|what| format!("{}: {package} has no {what}", file.path)),
        );
        // `cargo test -p PACKAGE [--lib] NAME`: a part of the names of tests.
        let after = line.iter().skip_while(|word| **word != "-p").skip(2).find(|word| **word != "--lib");
        let is_name = |word: &str| {
            word.contains('_') && word.chars().all(|sign| sign.is_ascii_lowercase() || sign == '_')
        };
        if let (Some(&"test"), Some(name)) = (line.first(), after.filter(|word| is_name(word))) {
            let has = |source: &&File| {
                source.path.starts_with(&format!("{folder}/")) && source.text.contains(*name)
            };
            if !sources.iter().any(|source| has(&source)) {
                found.push(format!("{}: {package} has no test {name}", file.path));
            }
        }
    }
    found
}

/// Of `--test it [--] MODULE[::NAME]...`: modules that are no file of `tests/it/`, and names that are not in it. What
/// follows the first one may be prose, unless it has a `::`.
fn missing_modules(line: &[&str], folder: &str, paths: &BTreeSet<String>, sources: &[File]) -> Vec<String> {
    let Some(at) = line.windows(2).position(|pair| pair == ["--test", "it"]) else { return Vec::new() };
    let is_name = |word: &str| {
        !word.is_empty() && word.chars().all(|sign| sign.is_ascii_lowercase() || "_:".contains(sign))
    };
    let named = line[at + 2..].iter().filter(|word| !["--", "\\"].contains(*word));
    let named = named.take_while(|word| is_name(word)).enumerate();
    let filters = named.filter(|(number, word)| *number == 0 || word.contains("::"));
    let mut found = Vec::new();
    for (_, filter) in filters {
        let (module, name) = filter.split_once("::").unwrap_or((filter, ""));
        let (file, below) =
            (format!("{folder}/tests/it/{module}.rs"), format!("{folder}/tests/it/{module}/"));
        let has_name = |source: &&File| {
            (source.path == file || source.path.starts_with(&below)) && source.text.contains(name)
        };
        if !paths.contains(&file) {
            found.push(format!("module {module} of --test it"));
        } else if !sources.iter().any(|source| has_name(&source)) {
            found.push(format!("test {filter}"));
        }
    }
    found
}

/// Package names to their folders.
pub(super) fn packages() -> BTreeMap<String, String> {
    let (manifests, _) = files(&["Cargo.toml"]);
    let mut found = BTreeMap::new();
    for file in manifests {
        let name = file.text.lines().find_map(|line| line.strip_prefix("name = "));
        if let (Some(name), Some((folder, _))) = (name, file.path.rsplit_once('/')) {
            found.insert(name.trim_matches('"').to_owned(), folder.to_owned());
        }
    }
    found
}

#[test]
fn every_source_and_command_that_a_document_names_is_there() {
    let (documents, paths) = documents();
    let packages = packages();
    nothing(documents.iter().flat_map(|file| missing_sources(file, &paths)).collect());
    let (sources, _) = sources();
    nothing(documents.iter().flat_map(|file| missing_targets(file, &packages, &paths, &sources)).collect());
}

//! What comments cite: documents, their sections, and works of others.

use std::collections::BTreeSet;

use super::text::{comments, prose};
use super::{File, nothing, root, sources};

/// Sections of the lighting model that comments cite.
const LIGHTING_MODEL: &str = "docs/lighting-model.md";

/// Whether a path ends in these parts.
pub(super) fn has_end(paths: &BTreeSet<String>, end: &str) -> bool {
    let is_it = |path: &String| {
        path.strip_suffix(end).is_some_and(|before| before.is_empty() || before.ends_with('/'))
    };
    paths.iter().any(is_it)
}

/// Words of a text that name a file with this ending, punctuation taken away.
fn names<'a>(text: &'a str, ending: &'a str) -> impl Iterator<Item = &'a str> {
    let is_part = |sign: char| sign.is_ascii_alphanumeric() || "._-/".contains(sign);
    text.split(move |sign: char| !is_part(sign))
        .map(|word| word.trim_end_matches(['.', '/']).trim_start_matches("../"))
        .filter(move |word| word.ends_with(ending) && word.len() > ending.len())
}

/// Documents that a source cites and that are not there.
pub(super) fn missing_documents(file: &File, paths: &BTreeSet<String>) -> Vec<String> {
    let cited = |name: &str| name.trim_start_matches(['/', '.']).to_owned();
    let lines = file.text.lines().filter(|line| line.contains(".md"));
    lines
        .flat_map(|line| names(line, ".md").map(cited).collect::<Vec<_>>())
        .filter(|name| !has_end(paths, name))
        .map(|name| format!("{} cites {name}, which is not in the repository", file.path))
        .collect()
}

/// The numbers of a citation's tail: ` 3`, ` 3.1`, `s 3 to 5 and 9`, `s 2, 3.1`.
fn numbers(tail: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut words = tail.trim_start_matches('s').split(' ').filter(|word| !word.is_empty());
    for word in &mut words {
        let number = word.trim_end_matches([',', ';', ':', ')', '.', '`']);
        let is_number = !number.is_empty() && number.chars().all(|sign| sign.is_ascii_digit() || sign == '.');
        match (is_number, number) {
            (true, _) => found.push(number.to_owned()),
            (false, "to" | "and") if !found.is_empty() => {}
            _ => break,
        }
        // A sentence goes on with another number only after these.
        if is_number && word.ends_with([';', ')', '.', ':']) {
            break;
        }
    }
    found
}

/// Sections of a document that a comment cites as `name, section N`.
fn sections(comment: &str, name: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut rest = comment;
    while let Some((_, after)) = rest.split_once(name) {
        let tail = after.trim_start_matches(['\'', 's', '`', ',', ' ']);
        if let Some(tail) = tail.strip_prefix("ection") {
            found.extend(numbers(tail));
        }
        rest = after;
    }
    found
}

/// The numbers of a document's headings.
fn headings(text: &str) -> BTreeSet<String> {
    let number = |line: &str| {
        let words = line.trim_start_matches('#').trim();
        words.split(' ').next().unwrap_or_default().trim_end_matches('.').to_owned()
    };
    prose(text).filter(|line| line.starts_with('#')).map(number).collect()
}

pub(super) fn missing_sections(file: &File, name: &str, known: &BTreeSet<String>) -> Vec<String> {
    let cited = comments(&file.text).into_iter().flat_map(|comment| sections(&comment, name));
    let missing = cited.filter(|section| !known.contains(section));
    missing.map(|section| format!("{} cites {name}, section {section}", file.path)).collect()
}

/// `Name 1965`, `Name (1965)`, `Name, 1965`, `Name and Other (1965)`, `Name et al., 1965`: the name before the year.
fn works(comment: &str) -> Vec<(String, String)> {
    let words: Vec<&str> = comment.split_whitespace().collect();
    let mut found = Vec::new();
    for (place, word) in words.iter().enumerate().skip(1) {
        let year = word.trim_matches(|sign: char| "(),.;:".contains(sign));
        let is_year = year.len() == 4 && (1800..2027).contains(&year.parse().unwrap_or(0));
        let before = words[place - 1];
        let ends = before.ends_with(['.', ':', ';']) && !before.ends_with("al.,") && !before.ends_with("al.");
        let name = words[..place]
            .iter()
            .rev()
            .find(|word| !["others", "and", "al.,", "al.", "et"].contains(*word))
            .map(|word| word.trim_matches(|sign: char| !sign.is_alphabetic()))
            .map(|name| name.strip_suffix("'s").unwrap_or(name))
            .unwrap_or_default();
        let is_name = name.len() > 2
            && name.starts_with(char::is_uppercase)
            && name.chars().skip(1).all(char::is_lowercase);
        if is_year && is_name && !ends && !MONTHS_AND_SUCH.contains(&name) {
            found.push((name.to_owned(), year.to_owned()));
        }
    }
    found
}

/// Words with a capital that stand before a year and are no author.
const MONTHS_AND_SUCH: [&str; 2] = ["Nov", "October"];

pub(super) fn unknown_works(file: &File, bibliography: &str) -> Vec<String> {
    let plain = |text: &str| text.replace('á', "a").replace('é', "e").replace('ö', "o");
    let entries: Vec<String> = bibliography.split("\n- ").map(plain).collect();
    let cited = comments(&file.text).into_iter().flat_map(|comment| works(&comment));
    let unknown = cited.filter(|(name, year)| {
        !entries.iter().any(|entry| entry.contains(&plain(name)) && entry.contains(year))
    });
    unknown.map(|(name, year)| format!("{} cites {name} {year}", file.path)).collect()
}

#[test]
fn every_document_that_a_comment_cites_is_in_the_repository() {
    let (sources, paths) = sources();
    assert!(sources.len() > 400, "{} sources", sources.len());
    nothing(sources.iter().flat_map(|file| missing_documents(file, &paths)).collect());
}

#[test]
fn every_section_that_a_comment_cites_is_there() {
    let (sources, _) = sources();
    let read = |path: &str| std::fs::read_to_string(root().join(path)).expect("the document is there");
    let model = headings(&read(LIGHTING_MODEL));
    let spec = headings(&read("format-spec/SPEC.md"));
    assert!((1..=10).all(|number| model.contains(&number.to_string())), "{model:?}");
    let cited: usize =
        sources.iter().flat_map(|f| comments(&f.text)).map(|c| sections(&c, "lighting model").len()).sum();
    assert!(cited > 20, "only {cited} citations were found");
    let names = [("lighting model", &model), ("lighting-model.md", &model), ("SPEC.md", &spec)];
    let missing =
        names.map(|(name, known)| sources.iter().flat_map(move |file| missing_sections(file, name, known)));
    nothing(missing.into_iter().flatten().collect());
}

#[test]
fn every_work_that_a_comment_cites_is_in_the_bibliography() {
    let (sources, _) = sources();
    let path = root().join("docs/book/src/bibliography.md");
    let bibliography = std::fs::read_to_string(path).expect("the book has one");
    let cited: usize = sources.iter().flat_map(|f| comments(&f.text)).map(|c| works(&c).len()).sum();
    assert!(cited > 30, "only {cited} works were found");
    nothing(sources.iter().flat_map(|file| unknown_works(file, &bibliography)).collect());
}

//! Text of documents and comments: prose, comments, code, and how long and how worded they may be.

use super::{File, documents, nothing, sources};

/// Most lines of the README: two screens.
const README_LINES: usize = 120;

/// Most bytes of the architecture: a map, no lab notebook.
const ARCHITECTURE_BYTES: usize = 10_240;

/// Most columns of a line of a document; of tables and lines of a URL alone there is no such limit.
const COLUMNS: usize = 120;

/// Documents that code writes, or that a release pins: their lines may be longer.
const WIDE: [&str; 3] = ["docs/extremes.md", "docs/book/src/command-line.md", "format-spec/SPEC.md"];

/// Words of private history, which mean nothing to a reader of the repository.
const PRIVATE: [&str; 5] = ["house plan", "its issue", "the issue's", "of the issue:", "the plan had"];

/// Words that personify, or hide who does what.
const AVOIDED: [&str; 6] = ["nobody", "somebody", "whoever", "hangs on", "hang on ", "is handed"];

/// The comments of a source, each block of lines as one line; also what follows code on a line.
pub(super) fn comments(text: &str) -> Vec<String> {
    let mut found = vec![String::new()];
    for line in text.lines() {
        let line = line.trim();
        let comment = ["//!", "///", "//", "#"].iter().find_map(|mark| line.strip_prefix(mark));
        match comment {
            Some(words) => {
                let last = found.last_mut().expect("never empty");
                last.push_str(words.trim());
                last.push(' ');
            }
            None => {
                found.push(line.split_once(" // ").map_or(String::new(), |(_, words)| words.to_owned()));
                found.push(String::new());
            }
        }
    }
    found.retain(|one| !one.is_empty());
    found
}

/// A document's lines outside of blocks of code.
pub(super) fn prose(text: &str) -> impl Iterator<Item = &str> {
    let mut inside = false;
    text.lines().filter(move |line| {
        let is_fence = line.trim_start().starts_with("```");
        inside ^= is_fence;
        !inside && !is_fence
    })
}

/// Pieces of text between back quotes, outside of blocks.
pub(super) fn code(text: &str) -> Vec<String> {
    let lines: Vec<&str> = prose(text).collect();
    lines.join(" ").split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

/// Blocks of a document in this language.
pub(super) fn blocks(text: &str, language: &str) -> Vec<String> {
    let (mut found, mut open) = (Vec::new(), None::<String>);
    for line in text.lines() {
        match &mut open {
            Some(_) if line == "```" => found.extend(open.take()),
            Some(block) => *block += &format!("{line}\n"),
            None if line == format!("```{language}") => open = Some(String::new()),
            None => {}
        }
    }
    found
}

/// Lines of a document that are too long.
pub(super) fn wide_lines(file: &File) -> Vec<String> {
    let may_be = |line: &str| line.starts_with('|') || (line.contains("://") && !line.trim().contains(' '));
    let numbered = file.text.lines().enumerate();
    let wide = numbered.filter(|(_, line)| line.chars().count() > COLUMNS && !may_be(line));
    wide.map(|(number, line)| format!("{}, line {}: {} columns", file.path, number + 1, line.chars().count()))
        .collect()
}

#[test]
fn no_comment_or_document_tells_of_private_history() {
    let (mut all, _) = sources();
    all.extend(documents().0);
    let found = all.iter().flat_map(|file| {
        let text = file.text.split_whitespace().collect::<Vec<_>>().join(" ").to_lowercase();
        let told: Vec<String> = PRIVATE
            .iter()
            .filter(|words| text.contains(*words))
            .map(|words| format!("{}: {words}", file.path))
            .collect();
        told
    });
    nothing(found.collect());
}

#[test]
fn documents_are_as_short_and_as_narrow_as_they_promise() {
    let (documents, _) = documents();
    let text =
        |path: &str| &documents.iter().find(|file| file.path == path).expect("the document is there").text;
    let lines = text("README.md").lines().count();
    assert!(lines <= README_LINES, "README.md has {lines} lines, {README_LINES} at most");
    let bytes = text("ARCHITECTURE.md").len();
    assert!(bytes <= ARCHITECTURE_BYTES, "ARCHITECTURE.md has {bytes} bytes, {ARCHITECTURE_BYTES} at most");
    nothing(
        documents.iter().filter(|file| !WIDE.contains(&file.path.as_str())).flat_map(wide_lines).collect(),
    );
}

/// Lines of comments that are too long: of a source, and of what follows code on its line.
pub(super) fn wide_comments(file: &File) -> Vec<String> {
    let mark = if [".rs", ".wgsl"].iter().any(|end| file.path.ends_with(end)) { "//" } else { "#" };
    // Two slashes in a text are no comment: those of a URL, above all.
    let is_comment = |line: &str| {
        let before = line.split_once(mark).map(|(before, _)| before);
        before
            .is_some_and(|before| before.trim().is_empty() || before.ends_with(' ') && !before.contains('"'))
    };
    let numbered = file.text.lines().enumerate();
    let wide = numbered.filter(|(_, line)| {
        line.chars().count() > COLUMNS
            && is_comment(line)
            && !line.split(' ').any(|word| word.len() > COLUMNS / 2)
    });
    wide.map(|(number, line)| format!("{}, line {}: {} columns", file.path, number + 1, line.chars().count()))
        .collect()
}

#[test]
fn comments_are_as_narrow_as_documents() {
    nothing(sources().0.iter().flat_map(wide_comments).collect());
}

/// Words that hide who does what, in the comments of a source.
pub(super) fn avoided_in_comments(file: &File) -> Vec<String> {
    let comments = comments(&file.text).into_iter().map(|comment| comment.to_lowercase());
    let found = comments.flat_map(|comment| {
        AVOIDED
            .iter()
            .filter(move |word| comment.contains(*word))
            .map(|word| format!("{}: {word:?}", file.path))
    });
    found.collect()
}

#[test]
fn comments_say_who_does_what() {
    nothing(sources().0.iter().flat_map(avoided_in_comments).collect());
}

#[test]
fn documents_say_who_does_what() {
    let (documents, _) = documents();
    let ours = documents.iter().filter(|file| !WIDE.contains(&file.path.as_str()));
    let found = ours.flat_map(|file| {
        let text = file.text.split_whitespace().collect::<Vec<_>>().join(" ").to_lowercase();
        AVOIDED
            .iter()
            .filter(|word| text.contains(*word))
            .map(|word| format!("{}: {word:?}", file.path))
            .collect::<Vec<_>>()
    });
    nothing(found.collect());
}

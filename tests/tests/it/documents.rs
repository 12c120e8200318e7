//! Documents and the code that cites them: what a comment or a page points at is there, and pages stay as short as they
//! promise. Commands and flags of `flb` are held in `cli/src/reference.rs`, Rust by doctests of this crate.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Most lines of the README: two screens.
const README_LINES: usize = 120;

/// Most bytes of the architecture: a map, no lab notebook.
const ARCHITECTURE_BYTES: usize = 10_240;

/// Most columns of a line of a document; of tables and lines of a URL alone there is no such limit.
const COLUMNS: usize = 120;

/// Documents that code writes, or that a release pins: their lines may be longer.
const WIDE: [&str; 3] = ["docs/extremes.md", "docs/book/src/command-line.md", "format-spec/SPEC.md"];

/// Sections of the lighting model that comments cite.
const LIGHTING_MODEL: &str = "docs/lighting-model.md";

/// Words of private history, which mean nothing to a reader of the repository.
const PRIVATE: [&str; 5] = ["house plan", "its issue", "the issue's", "of the issue:", "the plan had"];

/// Words that personify, or hide who does what.
const AVOIDED: [&str; 6] = ["nobody", "somebody", "whoever", "hangs on", "hang on ", "is handed"];

/// A text file of the repository.
struct File {
    /// From the root, with `/`.
    path: String,
    text: String,
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Every file of ours whose name ends in one of these, and the paths of all others.
fn files(endings: &[&str]) -> (Vec<File>, BTreeSet<String>) {
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
    let is_ours = |path: &&String| {
        endings.iter().any(|ending| path.ends_with(ending)) && *path != "tests/tests/it/documents.rs"
    };
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

/// The comments of a source, each block of lines as one line; also what follows code on a line.
fn comments(text: &str) -> Vec<String> {
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
fn prose(text: &str) -> impl Iterator<Item = &str> {
    let mut inside = false;
    text.lines().filter(move |line| {
        let is_fence = line.trim_start().starts_with("```");
        inside ^= is_fence;
        !inside && !is_fence
    })
}

/// What a forge makes of a heading for links.
fn anchor(heading: &str) -> String {
    let kept = heading.to_lowercase().replace(' ', "-");
    kept.chars().filter(|sign| sign.is_alphanumeric() || "-_".contains(*sign)).collect()
}

fn anchors(text: &str) -> BTreeSet<String> {
    prose(text)
        .filter(|line| line.starts_with('#'))
        .map(|line| anchor(line.trim_start_matches('#').trim()))
        .collect()
}

/// The targets of links and pictures.
fn links(text: &str) -> Vec<String> {
    let joined: Vec<&str> = prose(text).collect();
    let joined = joined.join(" ");
    let of_link = |piece: &str| piece.split_once(')').map(|(target, _)| target.to_owned());
    joined.split("](").skip(1).filter_map(of_link).collect()
}

/// `a/../b/./c` without dots.
fn normal(path: &str) -> String {
    let mut parts: Vec<&str> = Vec::new();
    for part in path.split('/') {
        match part {
            "." | "" => {}
            ".." if parts.pop().is_some() => {}
            part => parts.push(part),
        }
    }
    parts.join("/")
}

/// Links of a document to what is not there.
fn broken_links(file: &File, paths: &BTreeSet<String>, all: &BTreeMap<&str, &str>) -> Vec<String> {
    let folder = file.path.rsplit_once('/').map_or("", |(folder, _)| folder);
    let mut found = Vec::new();
    for link in links(&file.text).iter().filter(|link| !link.contains("://")) {
        let (target, part) = link.split_once('#').unwrap_or((link, ""));
        let is_here = target.is_empty();
        let target = if is_here { file.path.clone() } else { normal(&format!("{folder}/{target}")) };
        let is_folder = || paths.iter().any(|path| path.starts_with(&format!("{target}/")));
        if !is_here && !paths.contains(&target) && !is_folder() {
            found.push(format!("{}: no file {link}", file.path));
        } else if !part.is_empty()
            && !all.get(target.as_str()).is_some_and(|text| anchors(text).contains(part))
        {
            found.push(format!("{}: no heading {link}", file.path));
        }
    }
    found
}

/// Whether a path ends in these parts.
fn has_end(paths: &BTreeSet<String>, end: &str) -> bool {
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
fn missing_documents(file: &File, paths: &BTreeSet<String>) -> Vec<String> {
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

fn missing_sections(file: &File, name: &str, known: &BTreeSet<String>) -> Vec<String> {
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

fn unknown_works(file: &File, bibliography: &str) -> Vec<String> {
    let plain = |text: &str| text.replace('á', "a").replace('é', "e").replace('ö', "o");
    let entries: Vec<String> = bibliography.split("\n- ").map(plain).collect();
    let cited = comments(&file.text).into_iter().flat_map(|comment| works(&comment));
    let unknown = cited.filter(|(name, year)| {
        !entries.iter().any(|entry| entry.contains(&plain(name)) && entry.contains(year))
    });
    unknown.map(|(name, year)| format!("{} cites {name} {year}", file.path)).collect()
}

/// Lines of a document that are too long.
fn wide_lines(file: &File) -> Vec<String> {
    let may_be = |line: &str| line.starts_with('|') || (line.contains("://") && !line.trim().contains(' '));
    let numbered = file.text.lines().enumerate();
    let wide = numbered.filter(|(_, line)| line.chars().count() > COLUMNS && !may_be(line));
    wide.map(|(number, line)| format!("{}, line {}: {} columns", file.path, number + 1, line.chars().count()))
        .collect()
}

/// Pieces of text between back quotes, outside of blocks.
fn code(text: &str) -> Vec<String> {
    let lines: Vec<&str> = prose(text).collect();
    lines.join(" ").split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

/// `a/{b,c}.rs` -> `a/b.rs`, `a/c.rs`.
fn expanded(piece: &str) -> Vec<String> {
    let Some((before, rest)) = piece.split_once('{') else { return vec![piece.to_owned()] };
    let Some((choices, after)) = rest.split_once('}') else { return vec![piece.to_owned()] };
    choices.split(',').map(|choice| format!("{before}{choice}{after}")).collect()
}

/// Source files that a document names and that are not there.
fn missing_sources(file: &File, paths: &BTreeSet<String>) -> Vec<String> {
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

/// Benches, examples and tests that a document tells to run and that are not there; `sources` holds where names of tests are.
fn missing_targets(
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

/// Of `--test it [--] MODULE[::NAME]...`: modules that are no file of `tests/it/`, and names that are not in it. What follows the first
/// one may be prose, unless it has a `::`.
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

/// Blocks of a document in this language.
fn blocks(text: &str, language: &str) -> Vec<String> {
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

/// Package names to their folders.
fn packages() -> BTreeMap<String, String> {
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

fn nothing(found: Vec<String>) {
    assert!(found.is_empty(), "\n{}", found.join("\n"));
}

#[test]
fn every_link_of_a_document_leads_to_something() {
    let (documents, paths) = documents();
    let all = documents.iter().map(|file| (file.path.as_str(), file.text.as_str())).collect();
    assert!(documents.len() > 40, "{} documents", documents.len());
    nothing(documents.iter().flat_map(|file| broken_links(file, &paths, &all)).collect());
}

#[test]
fn every_page_of_the_book_is_in_its_summary() {
    let (documents, _) = documents();
    let summary =
        documents.iter().find(|file| file.path == "docs/book/src/SUMMARY.md").expect("the book has one");
    let listed = links(&summary.text);
    let pages = documents.iter().filter_map(|file| file.path.strip_prefix("docs/book/src/"));
    let left_out = pages.filter(|page| *page != "SUMMARY.md" && !listed.iter().any(|link| link == page));
    nothing(left_out.map(|page| format!("{page} is not in SUMMARY.md")).collect());
    let decisions =
        documents.iter().find(|file| file.path == "docs/decisions/README.md").expect("there is a list");
    let listed = links(&decisions.text);
    let pages = documents.iter().filter_map(|file| file.path.strip_prefix("docs/decisions/"));
    let left_out = pages.filter(|page| *page != "README.md" && !listed.iter().any(|link| link == page));
    nothing(left_out.map(|page| format!("{page} is not in docs/decisions/README.md")).collect());
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

#[test]
fn every_document_with_rust_is_compiled() {
    let compiled = std::fs::read_to_string(root().join("tests/src/lib.rs")).expect("the crate has it");
    let (documents, _) = documents();
    let with_rust: Vec<&File> =
        documents.iter().filter(|file| file.text.lines().any(|l| l == "```rust")).collect();
    assert!(with_rust.len() > 1, "README and the book show Rust");
    let left_out =
        with_rust.iter().filter(|f| !compiled.contains(&format!("include_str!(\"../../{}\")", f.path)));
    nothing(left_out.map(|file| format!("tests/src/lib.rs does not compile {}", file.path)).collect());
    // Any other mark of Rust would be left out of sight: no_run, ignore, ...
    let marked =
        documents.iter().filter(|file| file.text.lines().any(|l| l.starts_with("```rust") && l != "```rust"));
    nothing(
        marked.map(|file| format!("{}: a block of Rust that is not compiled as it is", file.path)).collect(),
    );
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

#[test]
fn every_source_and_command_that_a_document_names_is_there() {
    let (documents, paths) = documents();
    let packages = packages();
    nothing(documents.iter().flat_map(|file| missing_sources(file, &paths)).collect());
    let (sources, _) = sources();
    nothing(documents.iter().flat_map(|file| missing_targets(file, &packages, &paths, &sources)).collect());
}

#[test]
fn every_scene_and_species_file_that_a_document_shows_is_read() {
    let (documents, _) = documents();
    let (mut scenes, mut species) = (0, 0);
    for file in &documents {
        for block in blocks(&file.text, "toml") {
            let read = if block.contains("[[instance]]") {
                scenes += 1;
                flb_scene::scene::Scene::parse(&file.path, Path::new("."), &block).map(drop)
            } else {
                species += 1;
                flb_scene::SpeciesFile::parse(&file.path, &block).map(drop)
            };
            assert!(read.is_ok(), "{}: {}\n{block}", file.path, read.expect_err("just seen"));
        }
    }
    assert!(scenes > 1 && species > 2, "{scenes} scenes, {species} species files");
}

#[test]
fn the_table_of_surfaces_is_what_a_bake_takes() {
    use flb_scene::leaf::{Bands, LeafModel, knapp_carter};
    let page = std::fs::read_to_string(root().join("docs/book/src/bake.md")).expect("the page is there");
    let of_model = LeafModel::default().surfaces(&Bands::Rgb);
    for (begins, surfaces) in
        [("| leaf, without either", &knapp_carter()), ("| leaf, `[leaf_model]`", &of_model)]
    {
        let row = page.lines().find(|line| line.starts_with(begins)).expect(begins);
        let stated: Vec<f64> = row
            .split('|')
            .skip(2)
            .flat_map(|cell| cell.split('/'))
            .filter_map(|number| number.trim().parse().ok())
            .collect();
        let found: Vec<f64> =
            surfaces.bands.iter().flat_map(|band| [band.leaf.reflectance, band.leaf.transmittance]).collect();
        assert_eq!(stated.len(), 6, "{row}");
        assert!(
            stated.iter().zip(&found).all(|(stated, found)| (stated - found).abs() <= 5e-4),
            "{row}: {found:?}"
        );
        let row = page.lines().find(|line| line.starts_with("| wood, unless given")).expect("a row of wood");
        let stated = row.split('|').skip(2).filter_map(|number| number.trim().parse::<f64>().ok());
        let wood: Vec<f64> = surfaces.bands.iter().map(|band| band.wood.reflectance).collect();
        assert!(
            stated.zip(&wood).filter(|(stated, found)| (stated - *found).abs() <= 5e-4).count() == 3,
            "{wood:?}"
        );
    }
}

/// A source or a document, made up.
fn planted(text: &str) -> File {
    File { path: "docs/planted.md".to_owned(), text: text.to_owned() }
}

#[test]
fn planted_links_and_citations_are_found() {
    let (_, paths) = documents();
    let page = planted(
        "[a](../README.md), [b](none.md)\n# Two words\n[c](#two-words) [d](#three) ![e](../docs)\n```\n[f](x.md)\n```\n",
    );
    let all = BTreeMap::from([("docs/planted.md", page.text.as_str())]);
    let found = broken_links(&page, &paths, &all);
    assert_eq!(found, ["docs/planted.md: no file none.md", "docs/planted.md: no heading #three"]);

    let source = planted(
        "/// See docs/none.md and SPEC.md.\nlet a = include_str!(\"../../README.md\"); // ../NONE.md\n",
    );
    let found = missing_documents(&source, &paths);
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(found[0].contains("docs/none.md") && found[1].contains("NONE.md"), "{found:?}");

    let known = BTreeSet::from(["1", "2", "3", "3.1", "9"].map(str::to_owned));
    let source = planted(
        "//! As the project's lighting\n//! model, section 7, says; lighting model's, section 3. 12 bases\n\
        fn f() {} // lighting model, sections 2, 3.1 and 8)\n/// (lighting model,\n/// section 9)\n",
    );
    let found = missing_sections(&source, "lighting model", &known);
    let cites = |section: &str| format!("docs/planted.md cites lighting model, section {section}");
    assert_eq!(found, [cites("7"), cites("8")]);
}

#[test]
fn planted_works_widths_and_commands_are_found() {
    let bibliography = "# B\n- Ross, J. 1981. *X.*\n- Akenine-Möller, T. 2001. *Y.*";
    let source = planted(
        "// (Ross, 1981; Nobel and others 1999), after Akenine-Moller (2001); on 3 October 2005 it was 1981.\n",
    );
    assert_eq!(unknown_works(&source, bibliography), ["docs/planted.md cites Nobel 1999"]);

    let long = "word ".repeat(30);
    let page = planted(&format!("{long}\n| {long} |\nhttps://example.org/{}\n", "a".repeat(120)));
    assert_eq!(wide_lines(&page), ["docs/planted.md, line 1: 150 columns"]);

    let (_, paths) = documents();
    let page = planted("`cli/src/main.rs`, `{main,none}.rs`, `baker/src/none/`, `cli/src/`, `a * b.rs`");
    assert_eq!(
        missing_sources(&page, &paths),
        ["docs/planted.md: no none.rs", "docs/planted.md: no baker/src/none/"]
    );
    let page = planted(
        "`cargo bench -p flb-tests --bench stand` and `cargo bench -p flb-tests --bench none`, `cargo test -p flb-none`,
        `cargo test -p flb-scene surfaces_in_rgb`, `cargo test -p flb-scene --lib surfaces_in_xyz`.",
    );
    let found = missing_targets(&page, &packages(), &paths, &sources().0);
    let expected = [
        "docs/planted.md: flb-tests has no --bench none",
        "docs/planted.md: no package flb-none",
        "docs/planted.md: flb-scene has no test surfaces_in_xyz",
    ];
    assert_eq!(found, expected);

    let page = planted(
        "`cargo test -p flb-tests --test it` and `--test it scene_light` bound it. `cargo test -p flb --test it none` or
        `cargo test -p flb --test it -- faults::` `cargo test -p flb-format --test it forged::a_base_that forged::a_none
        none::a` `cargo test -p flb --test none`.",
    );
    let found = missing_targets(&page, &packages(), &paths, &sources().0);
    let expected = [
        "docs/planted.md: flb has no module none of --test it",
        "docs/planted.md: flb-format has no test forged::a_none",
        "docs/planted.md: flb-format has no module none of --test it",
        "docs/planted.md: flb has no --test none",
    ];
    assert_eq!(found, expected);
}

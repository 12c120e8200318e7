//! Links between documents, and the lists of pages.

use std::collections::{BTreeMap, BTreeSet};

use super::text::prose;
use super::{File, documents, nothing};

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
pub(super) fn broken_links(file: &File, paths: &BTreeSet<String>, all: &BTreeMap<&str, &str>) -> Vec<String> {
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

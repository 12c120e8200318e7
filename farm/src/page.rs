//! The page of a library, for people: no scripts, no network.

use std::fmt::Write;

use flb_scene::extents::number;

use crate::index::{Index, IndexEntry};
use crate::manifest::Manifest;
use crate::outcome::{Built, Outcome};

pub(crate) const STYLE: &str = "\
body { font: 15px/1.4 system-ui, sans-serif; margin: 2rem; color: #222; }\n\
table { border-collapse: collapse; }\n\
th, td { padding: .35rem .8rem; text-align: right; vertical-align: top; border-bottom: 1px solid #ddd; }\n\
th:first-child, td:first-child, td.text { text-align: left; }\n\
td.text { max-width: 28rem; }\n\
img { display: block; background: #eee; }\n\
.bad { color: #a00; }\n";

/// Pixels of the pictures of a species.
const PICTURE_PX: [u32; 2] = [384, 128];

/// The page, with what changed since the index of before and what failed in a build.
pub(crate) fn html(manifest: &Manifest, index: &Index, old: Option<&Index>, built: &[Built]) -> String {
    let mut page = String::new();
    let name = manifest.path.file_name().unwrap_or_default().to_string_lossy();
    let title = escaped(&name);
    let _ = write!(
        page,
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>{title}</title>\n<style>\n{STYLE}</style>\n<h1>{title}</h1>\n"
    );
    let bytes: u64 = index.species.values().map(|entry| entry.facts.bytes).sum();
    let _ = writeln!(page, "<p>{} species, {} MB.", index.species.len(), megabytes(bytes));
    if let Some(library) = &index.library {
        let file = &library.file;
        let _ = writeln!(
            page,
            "All in one file: <a href=\"{file}\">{file}</a>, {} MB.",
            megabytes(library.bytes)
        );
    }
    page.push_str("</p>\n");
    failures(&mut page, built);
    changes(&mut page, index, old);
    page.push_str(
        "<table>\n<tr><th>species<th>morning, noon, evening<th>triangles<th>metres<th>lattice<th>MB<th>error over suns<th>coding<th>bake<th>warnings\n",
    );
    index.species.iter().for_each(|(name, entry)| row(&mut page, name, entry));
    page.push_str("</table>\n");
    page
}

fn row(page: &mut String, name: &str, entry: &IndexEntry) {
    let facts = &entry.facts;
    let (label, file) = (escaped(name), link(&entry.file));
    let picture = entry.picture.as_ref().map_or_else(String::new, |picture| {
        let [width, height] = PICTURE_PX;
        format!("<img src=\"{}\" width=\"{width}\" height=\"{height}\" alt=\"{label}\">", link(picture))
    });
    let size = facts.size_m.map(number).join(" x ");
    let error = facts.suns_error.map_or_else(|| "-".to_owned(), |error| format!("{:.2} %", 100.0 * error));
    let dark =
        facts.dark_error.map(|error| format!(", in the dark {:.0} %", 100.0 * error)).unwrap_or_default();
    let coding = facts.psnr_db.map_or_else(|| "-".to_owned(), |db| format!("{db:.1} dB{dark}"));
    let warnings = facts.warnings.iter().map(|warning| escaped(warning));
    let over = entry.over_budget.iter().map(|over| format!("<span class=\"bad\">{}</span>", escaped(over)));
    let told: Vec<String> = over.chain(warnings).collect();
    let _ = writeln!(
        page,
        "<tr><td><a href=\"{file}\">{label}</a><td>{picture}<td>{}<td>{size}<td>{}<td>{}<td>{error}<td>{coding}<td>{:.1} s<td class=\"text\">{}",
        facts.triangles[0],
        facts.lattice,
        megabytes(facts.bytes),
        facts.seconds,
        told.join("<br>")
    );
}

fn failures(page: &mut String, built: &[Built]) {
    let failed = built.iter().filter_map(|one| match &one.outcome {
        Outcome::Failed(error) => Some((&one.name, error.to_string())),
        _ => None,
    });
    let rows: Vec<String> =
        failed.map(|(name, error)| format!("<li>{}: {}\n", escaped(name), escaped(&error))).collect();
    if !rows.is_empty() {
        let _ = write!(page, "<h2 class=\"bad\">Failed</h2>\n<ul>\n{}</ul>\n", rows.concat());
    }
}

/// Species that are new, changed or gone since the index of before.
fn changes(page: &mut String, index: &Index, old: Option<&Index>) {
    let Some(old) = old else { return };
    let mut rows = Vec::new();
    for (name, entry) in &index.species {
        match old.species.get(name) {
            None => rows.push(format!("<li>{} is new\n", escaped(name))),
            Some(was) if was.facts.blake3 != entry.facts.blake3 => rows.push(format!(
                "<li>{}: {} MB, before {} MB\n",
                escaped(name),
                megabytes(entry.facts.bytes),
                megabytes(was.facts.bytes)
            )),
            Some(_) => {}
        }
    }
    let gone = old.species.keys().filter(|name| !index.species.contains_key(*name));
    rows.extend(gone.map(|name| format!("<li>{} is gone\n", escaped(name))));
    if !rows.is_empty() {
        let _ = write!(page, "<h2>Changed with the last build</h2>\n<ul>\n{}</ul>\n", rows.concat());
    }
}

fn megabytes(bytes: u64) -> String {
    format!("{:.2}", bytes as f64 / 1e6)
}

/// Text that HTML shows as it is.
pub(crate) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '&' => out.push_str("&amp;"),
            '"' => out.push_str("&quot;"),
            c => out.push(c),
        }
    }
    out
}

/// A path as a link has it.
pub(crate) fn link(path: &str) -> String {
    let mut out = String::with_capacity(path.len());
    for byte in path.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'/' | b'.' | b'-' | b'_' => out.push(byte.into()),
            byte => _ = write!(out, "%{byte:02X}"),
        }
    }
    out
}

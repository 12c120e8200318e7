//! Files of a comparison: a page, JSON, JUnit XML and pictures.

use super::junit;
use super::page::{Shown, html};
use super::pictures::pictures;
use super::report::{Comparison, State};

/// Names of the files that are always written.
pub const FILES: [&str; 3] = ["index.html", "diff.json", "junit.xml"];
/// Species at most that are shown by pictures, the worst of those that changed.
const MAX_SHOWN: usize = 100;

/// Names and bytes of all files of a folder; those of [`FILES`] come last.
pub fn files(found: &Comparison) -> Vec<(String, Vec<u8>)> {
    let (mut files, mut shown) = (Vec::new(), Vec::new());
    for (at, one) in found.species.iter().enumerate() {
        let paths = one.pictures.as_ref().filter(|_| one.state == State::Changed && at < MAX_SHOWN);
        let pictures = paths.and_then(|paths| pictures(paths.each_ref().map(|path| path.as_path())));
        shown.push(pictures.map(|pictures| {
            // Names of species may be anything.
            let names = ["before", "after", "difference"].map(|what| format!("{}-{what}.png", at + 1));
            files.extend(names.iter().cloned().zip(pictures.files));
            Shown { names, size: pictures.size }
        }));
    }
    let mut json = serde_json::to_vec_pretty(found).expect("numbers, names and lists are JSON");
    json.push(b'\n');
    let contents = [html(found, &shown).into_bytes(), json, junit::xml(found).into_bytes()];
    files.extend(FILES.map(str::to_owned).into_iter().zip(contents));
    files
}

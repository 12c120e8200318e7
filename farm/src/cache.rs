//! Care of a store's folder: what it holds, whether it is sound, and what of it may go.
//!
//! Nothing else in the folder is looked at: a file is an entry by its name alone, which ends in a digest.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use flb_baker::artefact;
use flb_files::FileError;
use flb_scene::ImportError;

use crate::plan::sound_record;
use crate::store::read_whole;

/// Digits of a digest at the end of the name of an entry.
const DIGITS: usize = 64;
/// Endings of the files of an entry.
const ENDINGS: [&str; 5] = ["artefact", "flb", "json", "log", "png"];
/// Kind of what a killed writer left.
const LEFT: &str = "left";
/// Time for which a file that is being written stays.
const WRITING: Duration = Duration::from_hours(24);

/// An entry: what a stage made, or a species with its record, log and pictures.
#[derive(Debug, Clone, PartialEq)]
pub struct Kept {
    /// Stage and digest, or "species" and key.
    pub name: String,
    /// Stage, "species", "parts" for the parts of a key, "left" for what a killed writer left.
    pub kind: String,
    /// Files of it.
    pub files: Vec<PathBuf>,
    /// Bytes of the files.
    pub bytes: u64,
    /// Time of the last use, to the day.
    pub used: SystemTime,
}

/// Limits of a store; `None`: none.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Limits {
    /// Bytes that stay at most: what was used last stays.
    pub max_bytes: Option<u64>,
    /// Time since the last use from which on an entry goes.
    pub older_than: Option<Duration>,
}

/// The entries of a folder, by name.
///
/// # Errors
/// [`ImportError::Io`] for a folder that cannot be listed.
pub fn list(folder: &Path) -> Result<Vec<Kept>, ImportError> {
    let refuse = |source| ImportError::Io { path: folder.to_owned(), source };
    let mut kept: BTreeMap<String, Kept> = BTreeMap::new();
    for entry in fs::read_dir(folder).map_err(refuse)? {
        let entry = entry.map_err(refuse)?;
        let file_name = entry.file_name();
        let Some((name, kind)) = file_name.to_str().and_then(split) else { continue };
        // Another command may have removed it, or put a link in its place.
        let Some(metadata) = entry.metadata().ok().filter(fs::Metadata::is_file) else { continue };
        let one = kept.entry(name.to_owned()).or_insert_with(|| Kept {
            name: name.to_owned(),
            kind: kind.to_owned(),
            files: Vec::new(),
            bytes: 0,
            used: UNIX_EPOCH,
        });
        one.files.push(entry.path());
        one.bytes += metadata.len();
        one.used = one.used.max(metadata.modified().unwrap_or(UNIX_EPOCH));
    }
    let mut kept: Vec<Kept> = kept.into_values().collect();
    kept.iter_mut().for_each(|one| one.files.sort());
    Ok(kept)
}

/// Name and kind of an entry, from the name of a file.
fn split(file: &str) -> Option<(&str, &str)> {
    if let Some(of) = file.strip_prefix('.') {
        let (of, random) = of.strip_suffix(".tmp")?.rsplit_once(".flb-")?;
        let is_ours = split(of).is_some() || of == crate::digests::NAME;
        return (is_ours && random.bytes().all(|byte| byte.is_ascii_alphanumeric())).then_some((file, LEFT));
    }
    let (name, ending) = file.rsplit_once('.')?;
    let (kind, digest) = name.rsplit_once('-')?;
    let is_digest = digest.len() == DIGITS
        && digest.bytes().all(|byte| byte.is_ascii_digit() || (b'a'..=b'f').contains(&byte));
    let is_kind = !kind.is_empty() && kind.bytes().all(|byte| byte.is_ascii_lowercase() || byte == b'-');
    if !(is_digest && is_kind && ENDINGS.contains(&ending)) {
        return None;
    }
    Some((name, if kind.starts_with("parts") { "parts" } else { kind }))
}

fn file_of<'k>(kept: &'k Kept, ending: &str) -> Result<&'k Path, String> {
    let is_it = |file: &&PathBuf| file.extension().is_some_and(|found| found == ending);
    let found = kept.files.iter().find(is_it).ok_or_else(|| format!("has no .{ending}"))?;
    Ok(found)
}

fn record_of(kept: &Kept) -> Result<crate::record::Record, String> {
    let digest = kept.name.strip_prefix("species-").ok_or("is no species")?;
    sound_record(&read_whole(file_of(kept, "json")?)?, digest)
}

/// Name of the species that an entry is, if it is one.
pub fn species_of(kept: &Kept) -> Option<String> {
    record_of(kept).ok().map(|record| record.name)
}

/// Whether an entry is what was kept.
///
/// # Errors
/// A sentence without a subject: "has other bytes than were kept".
pub fn verify(kept: &Kept) -> Result<(), String> {
    match kept.kind.as_str() {
        LEFT => Err("was left by a writer that was killed".to_owned()),
        "species" => {
            let record = record_of(kept)?;
            let found = blake3::hash(&read_whole(file_of(kept, "flb")?)?).to_hex();
            match found.as_str() == record.facts.blake3 {
                true => Ok(()),
                false => Err("has other bytes than were kept".to_owned()),
            }
        }
        "parts" => {
            let bytes = read_whole(file_of(kept, "artefact")?)?;
            let parts: Result<Vec<(String, serde_json::Value)>, _> = serde_json::from_slice(&bytes);
            parts.map(drop).map_err(|error| error.to_string())
        }
        _ => {
            let bytes = read_whole(file_of(kept, "artefact")?)?;
            let digest = &kept.name[kept.name.len() - DIGITS..];
            artefact::check(&bytes, digest).map_err(|error| error.to_string())
        }
    }
}

/// Entries that go by limits, at a time: those that were not used for so long, then those that were used longest ago.
/// What a killed writer left goes after a day. Returns what goes and what stays, each by name.
pub fn beyond(kept: Vec<Kept>, limits: &Limits, now: SystemTime) -> [Vec<Kept>; 2] {
    let age = |one: &Kept| now.duration_since(one.used).unwrap_or_default();
    let is_old = |one: &Kept| match one.kind == LEFT {
        true => age(one) >= WRITING,
        false => limits.older_than.is_some_and(|most| age(one) >= most),
    };
    let (mut gone, rest): (Vec<Kept>, Vec<Kept>) = kept.into_iter().partition(is_old);
    // What may be in the making is none of an entry's bytes, and stays.
    let (being_made, mut rest): (Vec<Kept>, Vec<Kept>) = rest.into_iter().partition(|one| one.kind == LEFT);
    let mut bytes: u64 = rest.iter().map(|one| one.bytes).sum();
    rest.sort_by(|a, b| b.used.cmp(&a.used).then_with(|| b.name.cmp(&a.name)));
    while let Some(one) = rest.pop_if(|_| limits.max_bytes.is_some_and(|most| bytes > most)) {
        bytes -= one.bytes;
        gone.push(one);
    }
    rest.extend(being_made);
    for list in [&mut gone, &mut rest] {
        list.sort_by(|a, b| a.name.cmp(&b.name));
    }
    [gone, rest]
}

/// Removes an entry. A command that uses it meanwhile makes it again.
///
/// # Errors
/// [`FileError::Write`].
pub fn remove(kept: &Kept) -> Result<(), FileError> {
    // The record first: without it a species is not there.
    let mut files = kept.files.clone();
    files.sort_by_key(|file| file.extension().is_none_or(|ending| ending != "json"));
    for path in files {
        match fs::remove_file(&path) {
            Err(source) if source.kind() != std::io::ErrorKind::NotFound => {
                return Err(FileError::Write { path, source });
            }
            _ => {}
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kept(name: &str, bytes: u64, days: u64) -> Kept {
        let used = UNIX_EPOCH + Duration::from_hours(24 * (100 - days));
        let kind = name.split('-').next().unwrap_or_default().to_owned();
        Kept { name: name.to_owned(), kind, files: Vec::new(), bytes, used }
    }

    #[test]
    fn the_oldest_go_first_and_what_is_being_written_stays() {
        let all = || {
            vec![kept("solve-1", 10, 3), kept("solve-2", 10, 1), kept("solve-3", 10, 2), kept("left", 5, 0)]
        };
        let now = UNIX_EPOCH + Duration::from_hours(24 * 100);
        let names = |limits: Limits| {
            beyond(all(), &limits, now)[0].clone().into_iter().map(|one| one.name).collect::<Vec<_>>()
        };
        assert_eq!(names(Limits::default()), [""; 0]);
        let days = |days: u64| Some(Duration::from_hours(24 * days));
        assert_eq!(names(Limits { older_than: days(2), ..Limits::default() }), ["solve-1", "solve-3"]);
        assert_eq!(names(Limits { max_bytes: Some(25), ..Limits::default() }), ["solve-1"]);
        let both = Limits { max_bytes: Some(10), older_than: days(3) };
        assert_eq!(names(both), ["solve-1", "solve-3"]);
        assert_eq!(names(Limits { max_bytes: Some(15), ..Limits::default() }), ["solve-1", "solve-3"]);
    }

    #[test]
    fn names_of_others_are_no_entries() {
        let digest = "0123456789abcdef".repeat(4);
        for (file, expected) in [
            (format!("solve-{digest}.artefact"), Some("solve")),
            (format!("parts-{digest}.artefact"), Some("parts")),
            (format!("species-{digest}.flb"), Some("species")),
            (format!(".species-{digest}.flb.flb-a1B2c3D4.tmp"), Some(LEFT)),
            (format!(".notes-{digest}.flb-a1B2c3D4.tmp"), None),
            (".digests.json.flb-a1B2c3D4.tmp".to_owned(), Some(LEFT)),
            (".notes.txt.flb-a1B2c3D4.tmp".to_owned(), None),
            ("digests.json".to_owned(), None),
            (format!("{digest}.flb"), None),
            (format!("oak-{}.flb", digest.to_uppercase()), None),
            ("oak.flb".to_owned(), None),
        ] {
            assert_eq!(split(&file).map(|(_, kind)| kind), expected, "{file}");
        }
    }
}

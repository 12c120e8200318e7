//! Care of a cache: what it holds, whether it is sound, and what of it may go.
//!
//! Nothing else in its place is looked at: a file is an entry by its name alone, which ends in a digest.

use std::collections::BTreeMap;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use flb_baker::artefact;

use super::{Cache, packed};
use crate::FarmError;
use crate::plan::sound_record;

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
    /// Names of its files.
    pub files: Vec<String>,
    /// Bytes of the files.
    pub bytes: u64,
    /// Time of the last use, to the day; in a bucket that of the last write.
    pub used: SystemTime,
}

/// Limits of a cache; `None`: none.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Limits {
    /// Bytes that stay at most: what was used last stays.
    pub max_bytes: Option<u64>,
    /// Time since the last use from which on an entry goes.
    pub older_than: Option<Duration>,
}

/// The entries of a cache, by name.
///
/// # Errors
/// A folder or a bucket that cannot be listed.
pub fn list(cache: &Cache) -> Result<Vec<Kept>, FarmError> {
    let mut kept: BTreeMap<String, Kept> = BTreeMap::new();
    for listed in cache.list()? {
        let Some((name, kind)) = split(&listed.name) else { continue };
        let one = kept.entry(name.to_owned()).or_insert_with(|| Kept {
            name: name.to_owned(),
            kind: kind.to_owned(),
            files: Vec::new(),
            bytes: 0,
            used: UNIX_EPOCH,
        });
        one.bytes += listed.bytes;
        one.used = one.used.max(listed.used);
        one.files.push(listed.name);
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

fn bytes_of(cache: &Cache, kept: &Kept, ending: &str) -> Result<Vec<u8>, String> {
    let is_it = |file: &&String| file.rsplit_once('.').is_some_and(|(_, found)| found == ending);
    let file = kept.files.iter().find(is_it).ok_or_else(|| format!("has no .{ending}"))?;
    cache.read_listed(file)
}

/// What a stage made.
fn artefact_of(cache: &Cache, kept: &Kept) -> Result<Vec<u8>, String> {
    packed::unpack(bytes_of(cache, kept, "artefact")?)
}

fn record_of(cache: &Cache, kept: &Kept) -> Result<crate::record::Record, String> {
    let digest = kept.name.strip_prefix("species-").ok_or("is no species")?;
    sound_record(&bytes_of(cache, kept, "json")?, digest)
}

/// Name of the species that an entry is, if it is one.
pub fn species_of(cache: &Cache, kept: &Kept) -> Option<String> {
    record_of(cache, kept).ok().map(|record| record.name)
}

/// Whether an entry is what was kept.
///
/// # Errors
/// A sentence without a subject: "has other bytes than were kept".
pub fn verify(cache: &Cache, kept: &Kept) -> Result<(), String> {
    match kept.kind.as_str() {
        LEFT => Err("was left by a writer that was killed".to_owned()),
        "species" => {
            let record = record_of(cache, kept)?;
            let found = blake3::hash(&bytes_of(cache, kept, "flb")?).to_hex();
            match found.as_str() == record.facts.blake3 {
                true => Ok(()),
                false => Err("has other bytes than were kept".to_owned()),
            }
        }
        "parts" => {
            let bytes = artefact_of(cache, kept)?;
            let parts: Result<Vec<(String, serde_json::Value)>, _> = serde_json::from_slice(&bytes);
            parts.map(drop).map_err(|error| error.to_string())
        }
        _ => {
            let bytes = artefact_of(cache, kept)?;
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
/// A file that cannot be removed.
pub fn remove(cache: &Cache, kept: &Kept) -> Result<(), FarmError> {
    // The record first: without it a species is not there.
    let mut files: Vec<&String> = kept.files.iter().collect();
    files.sort_by_key(|file| !file.ends_with(".json"));
    files.into_iter().try_for_each(|file| cache.remove(file))
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

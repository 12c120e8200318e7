//! `flb cache`: what a cache holds, whether it is sound, and what of it may go.

use std::collections::BTreeMap;
use std::time::SystemTime;

use flb_farm::cache::Cache;
use flb_farm::cache::care::{Kept, Limits, beyond, list, remove, species_of, verify};
use serde::Serialize;

use crate::args::{CacheArgs, CacheCommand, CacheFolder, GcArgs, VerifyArgs};
use crate::exit::{Failure, USAGE, VERDICT};
use crate::library::say_told;
use crate::print::{self, line, say};

/// Seconds of a day.
const DAY_S: u64 = 86_400;

/// What `--json` prints (cli/schema/cache.json).
#[derive(Serialize, Default)]
struct Report {
    folder: String,
    /// Entries and bytes by kind, of those that stay.
    kinds: BTreeMap<String, Total>,
    entries: usize,
    bytes: u64,
    list: Option<Vec<Entry>>,
    damaged: Option<Vec<Damaged>>,
    removed: Option<Vec<Entry>>,
}

#[derive(Serialize, Default)]
struct Total {
    entries: usize,
    bytes: u64,
}

#[derive(Serialize)]
struct Entry {
    name: String,
    kind: String,
    species: Option<String>,
    bytes: u64,
    days_unused: u64,
}

#[derive(Serialize)]
struct Damaged {
    name: String,
    fault: String,
    removed: bool,
}

pub(crate) fn run(args: &CacheArgs) -> Result<u8, Failure> {
    match &args.command {
        CacheCommand::List(args) => show(args, true),
        CacheCommand::Stats(args) => show(args, false),
        CacheCommand::Verify(args) => check(args),
        CacheCommand::Gc(args) => collect(args),
    }
}

/// A cache that is there, and its entries.
fn entries(args: &CacheFolder) -> Result<(Cache<'static>, Vec<Kept>), Failure> {
    let cache = Cache::existing(&args.folder, &say_told)?;
    let kept = list(&cache)?;
    Ok((cache, kept))
}

impl Report {
    fn of(args: &CacheFolder, kept: &[Kept]) -> Report {
        let mut report = Report { folder: args.folder.to_string(), ..Report::default() };
        for one in kept {
            let kind = report.kinds.entry(one.kind.clone()).or_default();
            kind.entries += 1;
            kind.bytes += one.bytes;
            report.entries += 1;
            report.bytes += one.bytes;
        }
        report
    }

    fn line(&self) -> String {
        line!("{}: {} entries, {}", self.folder, self.entries, print::bytes(self.bytes))
    }
}

impl Entry {
    fn of(cache: &Cache, kept: &Kept, now: SystemTime) -> Entry {
        let unused = now.duration_since(kept.used).unwrap_or_default();
        Entry {
            name: kept.name.clone(),
            kind: kept.kind.clone(),
            species: species_of(cache, kept),
            bytes: kept.bytes,
            days_unused: unused.as_secs() / DAY_S,
        }
    }

    fn cells(&self) -> Vec<String> {
        let species = self.species.clone().unwrap_or_default();
        vec![self.name.clone(), print::bytes(self.bytes), format!("{} d", self.days_unused), species]
    }
}

fn show(args: &CacheFolder, is_list: bool) -> Result<u8, Failure> {
    let (cache, kept) = entries(args)?;
    let now = SystemTime::now();
    let mut report = Report::of(args, &kept);
    if args.json {
        report.list = is_list.then(|| kept.iter().map(|one| Entry::of(&cache, one, now)).collect());
        print::json(&report)?;
        return Ok(0);
    }
    let mut rows: Vec<Vec<String>> = Vec::new();
    match is_list {
        true => {
            rows.push(["entry", "bytes", "unused", "species"].map(str::to_owned).to_vec());
            rows.extend(kept.iter().map(|one| Entry::of(&cache, one, now).cells()));
        }
        false => {
            rows.push(["kind", "entries", "bytes"].map(str::to_owned).to_vec());
            let row = |(kind, total): (&String, &Total)| {
                vec![kind.clone(), total.entries.to_string(), print::bytes(total.bytes)]
            };
            rows.extend(report.kinds.iter().map(row));
        }
    }
    print::out(&(print::table(&rows) + &report.line()))?;
    Ok(0)
}

/// Reads every entry, and says which are not what was kept.
fn check(args: &VerifyArgs) -> Result<u8, Failure> {
    let (cache, kept) = entries(&args.folder)?;
    let mut report = Report::of(&args.folder, &kept);
    let mut damaged = Vec::new();
    for one in &kept {
        let Err(fault) = verify(&cache, one) else { continue };
        let end = if args.remove { "; removed" } else { "" };
        if args.remove {
            remove(&cache, one)?;
        }
        say!("{}: {fault}{end}", cache.name(&one.name));
        damaged.push(Damaged { name: one.name.clone(), fault, removed: args.remove });
    }
    let count = damaged.len();
    report.damaged = Some(damaged);
    match args.folder.json {
        true => print::json(&report)?,
        false => print::out(&line!("{}, {count} damaged", report.line().trim_end()))?,
    }
    Ok(if count > 0 && !args.remove { VERDICT } else { 0 })
}

/// Removes what goes beyond the limits.
fn collect(args: &GcArgs) -> Result<u8, Failure> {
    let limits = Limits { max_bytes: args.max_size, older_than: args.older_than };
    if limits == Limits::default() {
        return Err(Failure::new(USAGE, "expected --max-size, --older-than or both"));
    }
    let now = SystemTime::now();
    let (cache, kept) = entries(&args.folder)?;
    let [gone, left] = beyond(kept, &limits, now);
    let bytes: u64 = gone.iter().map(|one| one.bytes).sum();
    let mut report = Report::of(&args.folder, &left);
    // Names of species are in what goes.
    report.removed = Some(gone.iter().map(|one| Entry::of(&cache, one, now)).collect());
    if !args.dry_run {
        gone.iter().try_for_each(|one| remove(&cache, one))?;
    }
    if args.folder.json {
        print::json(&report)?;
        return Ok(0);
    }
    let would = if args.dry_run { "would remove" } else { "removed" };
    let (count, entries, [bytes, stay]) =
        (gone.len(), report.entries, [bytes, report.bytes].map(print::bytes));
    print::out(&line!("{}: {would} {count} entries, {bytes}; {entries} stay, {stay}", report.folder))?;
    Ok(0)
}

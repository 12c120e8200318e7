//! `flb diff`: two files, what differs, and a verdict.

use flb_format::container::Species;
use flb_inspector::diff::{Diff, Settings, SpeciesDiff, diff};

use crate::args::DiffArgs;
use crate::exit::{Failure, USAGE, VERDICT};
use crate::inputs::open;
use crate::memory::{check, read_bytes};
use crate::print::{self, line};

/// Compares, prints, exits 0 where the files are equal and 1 where they differ.
pub(crate) fn run(args: &DiffArgs) -> Result<u8, Failure> {
    if args.tolerance.is_some_and(|t| !(t.is_finite() && t >= 0.0)) {
        let found = args.tolerance.expect("was just looked at");
        return Err(Failure::new(USAGE, format!("--tolerance is {found}, expected a number from 0 up")));
    }
    let a = open(&args.a)?;
    let b = open(&args.b)?;
    for species in a.container().species() {
        let other = b.find_species(&species.meta.name).map(|index| &b.container().species()[index]);
        let Some(other) = other else { continue };
        let largest = |s: &Species| s.bases.iter().map(|base| read_bytes(s, base)).max().unwrap_or(0);
        let needed = largest(species).saturating_add(largest(other));
        check(&a, &format!("a base of species {:?} of both files", species.meta.name), needed, &args.memory)?;
    }
    let settings = Settings { tolerance: args.tolerance };
    let either = format!("{} or {}", a.path().display(), b.path().display());
    let found = diff((a.container(), a.source()), (b.container(), b.source()), &settings)
        .map_err(|error| Failure::from(error).at(either.as_ref()))?;
    match args.json {
        true => print::json(&found)?,
        false => print::out(&text(&found))?,
    }
    Ok(if found.equal { 0 } else { VERDICT })
}

fn text(found: &Diff) -> String {
    let mut text = String::new();
    for name in &found.species_only_in_a {
        text += &line!("species {name}: only in A");
    }
    for name in &found.species_only_in_b {
        text += &line!("species {name}: only in B");
    }
    if let Some(version) = &found.format_version {
        text += &line!("format version: {} in A, {} in B", version.a, version.b);
    }
    found.species.iter().for_each(|species| text += &species_text(species));
    found.notes.iter().for_each(|note| text += &line!("note: {note}"));
    text + if found.equal { "equal\n" } else { "different\n" }
}

fn species_text(species: &SpeciesDiff) -> String {
    let mut text = line!("species {}: {}", species.name, verdict(species.equal));
    for change in &species.metadata {
        let side =
            |value: &Option<serde_json::Value>| value.as_ref().map_or("absent".into(), |v| v.to_string());
        let mark = if change.decides { "" } else { " (history, does not decide)" };
        text += &line!("  {}: {} in A, {} in B{mark}", change.path, side(&change.a), side(&change.b));
    }
    for (list, side) in [(&species.bases_only_in_a, "A"), (&species.bases_only_in_b, "B")] {
        list.iter().for_each(|base| text += &line!("  base {base}: only in {side}"));
    }
    let mut rows =
        vec![["", "verdict", "max abs", "rms", "relative rms", "psnr dB"].map(str::to_owned).to_vec()];
    let numbers = |name: String, equal: bool, v: &flb_inspector::diff::values::ValueDiff| {
        let psnr = v.psnr_db.map_or("-".to_owned(), |db| format!("{db:.2}"));
        let number = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.3e}"));
        let [max, rms, relative] = [v.max_abs, v.rms, v.relative_rms].map(number);
        vec![name, verdict(equal).to_owned(), max, rms, relative, psnr]
    };
    rows.extend(
        species.medium.iter().map(|array| numbers(array.name.to_owned(), array.equal, &array.values)),
    );
    rows.extend(
        species.bases.iter().map(|base| numbers(format!("base {}", base.base), base.equal, &base.values)),
    );
    if rows.len() > 1 {
        text += &print::table(&rows).lines().map(|line| format!("  {line}\n")).collect::<String>();
    }
    species.notes.iter().for_each(|note| text += &line!("  note: {note}"));
    text
}

fn verdict(equal: bool) -> &'static str {
    if equal { "equal" } else { "different" }
}

//! `flb torture`: corruptions of a good file, written down, and whether `validate` gives each its code.

use std::fs;
use std::io::{self, Read};
use std::path::Path;

use flb_files::{Existing, names_in, open_regular, publish};
use flb_format::testing::torture::{CONDITIONS, Case, KINDS, Subject};
use flb_inspector::{Level, Report};
use flb_runtime::Location;
use serde::Serialize;

use crate::args::TortureArgs;
use crate::exit::{Failure, INPUT_OUTPUT, INTERNAL, LIMIT, UNSUPPORTED, USAGE, VERDICT};
use crate::inputs::check_no_dash;
use crate::memory::room_for;
use crate::print::{self, line};
use crate::validate::{demand, exit_code, look};

/// Largest file that is corrupted; each corruption is another file of its size.
const MAX_FILE_BYTES: u64 = 16 << 20;

#[derive(Serialize)]
struct Manifest {
    /// Whether `validate` gave every file its code and exit code.
    agrees: bool,
    /// The good file.
    file: String,
    /// The folder of the bad ones.
    output: String,
    seed: u64,
    /// How many files disagree.
    wrong: usize,
    /// What each kind is, 1 first.
    kinds: &'static [&'static str],
    cases: Vec<Verdict>,
    /// Kinds that are conditions of a server, a disk or a process, with the tests that carry them.
    conditions: Vec<Carried>,
}

#[derive(Serialize)]
struct Carried {
    kind: u8,
    carried_by: &'static str,
}

#[derive(Serialize)]
struct Verdict {
    kind: u8,
    label: String,
    /// What was done.
    done: String,
    /// Its name in the folder.
    file: String,
    expected: Outcome,
    found: Outcome,
    ok: bool,
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
struct Outcome {
    /// "FLB-1003", or null for a file that passes.
    code: Option<String>,
    exit: u8,
}

/// Corrupts, validates, writes the manifest. Exits 1 where a verdict is not the expected one.
pub(crate) fn run(args: &TortureArgs) -> Result<u8, Failure> {
    let subject = subject(args)?;
    check_no_dash(&args.output)?;
    make_folder(&args.output)?;
    let mut verdicts = Vec::new();
    let mut failed = None;
    subject.corrupt(&mut |case| {
        if failed.is_none() {
            match tried(&args.output, case) {
                Ok(verdict) => verdicts.push(verdict),
                Err(failure) => failed = Some(failure),
            }
        }
    });
    if let Some(failure) = failed {
        return Err(failure);
    }
    verdicts.extend(no_files(&args.output)?);
    verdicts.sort_by_key(|verdict| verdict.kind);
    let wrong = verdicts.iter().filter(|verdict| !verdict.ok).count();
    let manifest = Manifest {
        agrees: wrong == 0,
        file: args.file.display().to_string(),
        output: args.output.display().to_string(),
        seed: args.seed,
        wrong,
        kinds: &KINDS,
        cases: verdicts,
        conditions: CONDITIONS.map(|c| Carried { kind: c.kind, carried_by: c.carried_by }).into(),
    };
    let json = serde_json::to_vec_pretty(&manifest).map_err(|error| Failure::new(INTERNAL, error))?;
    publish(&args.output.join("manifest.json"), Existing::Keep, |out| out.write_all(&json))?;
    match args.json {
        true => print::json(&manifest)?,
        false => print::out(&text(&manifest))?,
    }
    Ok(if manifest.agrees { 0 } else { VERDICT })
}

/// The good file, checked.
fn subject(args: &TortureArgs) -> Result<Subject, Failure> {
    let location = Location::parse(&args.file)?;
    let Some(path) = location.file() else {
        return Err(Failure::new(USAGE, "a file on this machine is needed, not a URL").at(&args.file));
    };
    // Looked at before it is read: pipes and devices do not end.
    demand(&location, &look(&location, Level::Header)?)?;
    let reading = |error: io::Error| Failure::new(INPUT_OUTPUT, error).at(path);
    let (mut from, found) = open_regular(path).map_err(|error| Failure::new(INPUT_OUTPUT, error).at(path))?;
    let length = found.len();
    if length > MAX_FILE_BYTES {
        let message =
            format!("it has {length} bytes, over the limit of {MAX_FILE_BYTES}: choose a smaller file");
        return Err(Failure::new(LIMIT, message).at(path));
    }
    let mut file = room_for(length as usize).map_err(|failure| failure.at(path))?;
    from.by_ref().take(MAX_FILE_BYTES).read_to_end(&mut file).map_err(reading)?;
    Subject::new(file, args.seed).map_err(|error| Failure::from(error).at(path))
}

/// A folder that is new, or was empty.
fn make_folder(folder: &Path) -> Result<(), Failure> {
    let failed = |error: io::Error| Failure::new(INPUT_OUTPUT, error).at(folder);
    fs::create_dir_all(folder).map_err(failed)?;
    if !names_in(folder, 1).map_err(failed)?.is_empty() {
        return Err(Failure::new(INPUT_OUTPUT, "the folder is not empty").at(folder));
    }
    Ok(())
}

/// Writes a bad file, and validates it.
fn tried(folder: &Path, case: Case) -> Result<Verdict, Failure> {
    let name = format!("{:02}-{}.flb", case.kind, case.label);
    let path = folder.join(&name);
    publish(&path, Existing::Keep, |out| out.write_all(&case.bytes))?;
    let expected = Outcome::of(case.expected);
    Ok(verdict(case.kind, case.label, case.done, name, expected, &path))
}

fn verdict(kind: u8, label: String, done: String, file: String, expected: Outcome, path: &Path) -> Verdict {
    let found = found(path);
    Verdict { ok: found == expected, kind, label, done, file, expected, found }
}

/// What `flb validate` says of a path. A panic is a finding, too.
fn found(path: &Path) -> Outcome {
    let location = Location::File(path.to_owned());
    let report = match std::panic::catch_unwind(|| look(&location, Level::Decode)) {
        Ok(Ok(report)) => report,
        // As `flb validate` reports it.
        Ok(Err(_)) => return Outcome { code: Some("FLB-1000".to_owned()), exit: INPUT_OUTPUT },
        Err(_) => return Outcome { code: Some("panic".to_owned()), exit: INTERNAL },
    };
    Outcome { code: code(&report), exit: exit_code(&report) }
}

fn code(report: &Report) -> Option<String> {
    report.issues.first().map(|issue| issue.code.clone())
}

impl Outcome {
    /// By the list of SPEC.md section 12, and not by what the reader makes of a code.
    fn of(code: Option<u32>) -> Outcome {
        let exit = match code {
            None => 0,
            Some(1000) => INPUT_OUTPUT,
            Some(1003 | 1004 | 2005 | 2006 | 3007) => UNSUPPORTED,
            Some(1009) => LIMIT,
            Some(_) => VERDICT,
        };
        Outcome { code: code.map(|code| format!("FLB-{code}")), exit }
    }
}

/// Kind 56: what is no regular file.
fn no_files(folder: &Path) -> Result<Vec<Verdict>, Failure> {
    let made = |name: &str, label: &str, done: &str, outcome: io::Result<()>| {
        let path = folder.join(name);
        outcome.map_err(|error| Failure::new(INPUT_OUTPUT, error).at(&path))?;
        let expected = Outcome::of(Some(1000));
        let verdict = verdict(56, label.to_owned(), done.to_owned(), name.to_owned(), expected, &path);
        Ok::<_, Failure>(verdict)
    };
    let is_folder = fs::create_dir(folder.join("56-folder.flb"));
    #[cfg_attr(not(unix), allow(unused_mut))]
    let mut verdicts = vec![made("56-folder.flb", "folder", "a folder", is_folder)?];
    #[cfg(unix)]
    {
        use rustix::fs::{CWD, Mode, mkfifoat};
        let pipe = mkfifoat(CWD, folder.join("56-pipe.flb"), Mode::RUSR | Mode::WUSR);
        verdicts.push(made(
            "56-pipe.flb",
            "pipe",
            "a named pipe without a writer",
            pipe.map_err(Into::into),
        )?);
        let device = std::os::unix::fs::symlink("/dev/zero", folder.join("56-device.flb"));
        verdicts.push(made("56-device.flb", "device", "a link to /dev/zero", device)?);
    }
    Ok(verdicts)
}

fn text(manifest: &Manifest) -> String {
    let mut rows = vec![["kind", "file", "expected", "found", ""].map(str::to_owned).to_vec()];
    let said =
        |outcome: &Outcome| format!("{} ({})", outcome.code.as_deref().unwrap_or("passes"), outcome.exit);
    rows.extend(manifest.cases.iter().map(|case| {
        let kind = format!("{:>2} {}", case.kind, manifest.kinds[usize::from(case.kind) - 1]);
        let mark = if case.ok { "" } else { "WRONG" };
        vec![kind, case.file.clone(), said(&case.expected), said(&case.found), mark.to_owned()]
    }));
    let mut text = print::table(&rows);
    for condition in &manifest.conditions {
        let kind = manifest.kinds[usize::from(condition.kind) - 1];
        text += &line!("{:>2} {kind}: {}", condition.kind, condition.carried_by);
    }
    let (cases, wrong, output) = (manifest.cases.len(), manifest.wrong, &manifest.output);
    text + &line!("{output}: {cases} files, {wrong} with another verdict than expected")
}

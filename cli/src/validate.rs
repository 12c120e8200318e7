//! `flb validate`: does a file keep every promise of SPEC.md?

use flb_format::Source;
use flb_format::error::ErrorClass;
use flb_inspector::validate::{Issue, Level, Report, validate};
use flb_runtime::source::{FileSource, retry_replaced};
use flb_runtime::{Location, RuntimeError};
use serde::Serialize;

use crate::args::ValidateArgs;
use crate::exit::{Failure, INPUT_OUTPUT, LIMIT, UNSUPPORTED, USAGE, VERDICT};
use crate::print::{self, line, say};

#[derive(Serialize)]
struct Verdicts {
    /// Whether every file is valid; none where none is invalid, and one could not be read.
    valid: Option<bool>,
    /// Those of all files, in order.
    issues: Vec<FileIssue>,
    files: Vec<FileVerdict>,
}

#[derive(Serialize)]
struct FileVerdict {
    file: String,
    /// None where it could not be read: what was not seen is neither valid nor invalid.
    valid: Option<bool>,
    issues: Vec<Issue>,
    /// Why it could not be read.
    error: Option<String>,
}

#[derive(Serialize)]
struct FileIssue {
    file: String,
    #[serde(flatten)]
    issue: Issue,
}

/// Checks every file, prints every verdict. Exits with the gravest: an environment that says nothing usable of s3, then
/// unreadable, then invalid, then unsupported or over a limit.
pub(crate) fn run(args: &ValidateArgs) -> Result<u8, Failure> {
    let level = args.level;
    let mut code = 0;
    let mut verdicts = Verdicts { valid: Some(true), issues: Vec::new(), files: Vec::new() };
    let locations = args.files.iter().map(Location::parse).collect::<Result<Vec<_>, _>>()?;
    for location in &locations {
        let file = location.to_string();
        let told = |failure: &Failure| say!("{}; reading it again", failure.message);
        let report = retry_replaced(|| look(location, level), |failure| failure.replaced, told);
        let verdict = match report {
            Ok(report) if exit_code(&report) != INPUT_OUTPUT => {
                code = graver(code, exit_code(&report));
                FileVerdict { file, valid: Some(report.valid), issues: report.issues, error: None }
            }
            Ok(report) => {
                let message = report.issues.first().map_or("", |issue| &issue.message);
                code = graver(code, INPUT_OUTPUT);
                unread(file, Failure::new(INPUT_OUTPUT, message))
            }
            Err(failure) => {
                code = graver(code, failure.code);
                unread(file, failure)
            }
        };
        verdicts.valid = both(verdicts.valid, verdict.valid);
        let name = |issue: &Issue| FileIssue { file: verdict.file.clone(), issue: issue.clone() };
        verdicts.issues.extend(verdict.issues.iter().map(name));
        verdicts.files.push(verdict);
    }
    match args.json {
        true => print::json(&verdicts)?,
        false => print::out(&text(&verdicts))?,
    }
    Ok(code)
}

/// A file that could not be read has no verdict, but a reason.
fn unread(file: String, failure: Failure) -> FileVerdict {
    let message = failure.message.strip_prefix(&format!("{file}: ")).unwrap_or(&failure.message);
    say!("{file}: {message}");
    FileVerdict { valid: None, issues: Vec::new(), error: Some(message.to_owned()), file }
}

/// Whether two are valid: an invalid one decides, an unknown one leaves it open.
fn both(a: Option<bool>, b: Option<bool>) -> Option<bool> {
    match (a, b) {
        (Some(false), _) | (_, Some(false)) => Some(false),
        (Some(true), Some(true)) => Some(true),
        _ => None,
    }
}

/// The verdict on one file, or why it could not be read.
pub(crate) fn look(location: &Location, level: Level) -> Result<Report, Failure> {
    let opened: Result<Box<dyn Source>, RuntimeError> = match location {
        Location::File(path) => FileSource::open(path).map(|source| Box::new(source) as _),
        #[cfg(feature = "remote")]
        Location::Remote(url) => {
            flb_runtime::source::RemoteSource::open(url, &crate::inputs::remote_settings())
                .map(|source| Box::new(source) as _)
        }
    };
    match opened {
        Ok(source) => look_at(location, source.as_ref(), level),
        // A file of no bytes is the shortest truncation: a verdict, not an accident.
        Err(RuntimeError::Empty { .. }) => Ok(validate(&Vec::<u8>::new(), level)),
        Err(error) => Err(Failure::from(error).at(&location.name())),
    }
}

/// The verdict on a file that is open.
pub(crate) fn look_at(location: &Location, source: &dyn Source, level: Level) -> Result<Report, Failure> {
    match location {
        Location::File(_) => Ok(validate(source, level)),
        #[cfg(feature = "remote")]
        Location::Remote(_) => remote::look(source, level).map_err(|failure| failure.at(&location.name())),
    }
}

/// A file whose verdict is not good is a failure.
pub(crate) fn demand(location: &Location, report: &Report) -> Result<(), Failure> {
    match (exit_code(report), report.issues.first()) {
        (code @ 1.., Some(issue)) => Err(Failure::new(code, &issue.message).at(&location.name())),
        _ => Ok(()),
    }
}

/// The exit code of a verdict.
pub(crate) fn exit_code(report: &Report) -> u8 {
    match report.class {
        None => 0,
        Some(ErrorClass::Unsupported) => UNSUPPORTED,
        Some(ErrorClass::Limit) => LIMIT,
        Some(ErrorClass::Io) => INPUT_OUTPUT,
        Some(ErrorClass::Invalid | ErrorClass::Request) => VERDICT,
    }
}

/// The one of two exit codes that a caller must hear of first.
fn graver(a: u8, b: u8) -> u8 {
    let order = [0, LIMIT, UNSUPPORTED, VERDICT, INPUT_OUTPUT, USAGE];
    let rank = |code: u8| order.iter().position(|&c| c == code).unwrap_or(order.len());
    if rank(b) > rank(a) { b } else { a }
}

fn text(verdicts: &Verdicts) -> String {
    let line = |file: &FileVerdict| match (&file.error, file.issues.first()) {
        (Some(error), _) => line!("{}: not read: {error}", file.file),
        (None, Some(issue)) => line!("{}: INVALID: {}", file.file, issue.message),
        (None, None) => line!("{}: valid", file.file),
    };
    verdicts.files.iter().map(line).collect()
}

#[cfg(feature = "remote")]
mod remote;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_invalid_file_decides_and_an_unread_one_leaves_it_open() {
        let states = [Some(true), None, Some(false)];
        for (i, a) in states.into_iter().enumerate() {
            for (j, b) in states.into_iter().enumerate() {
                assert_eq!(both(a, b), states[i.max(j)]);
            }
        }
    }

    #[test]
    fn the_gravest_code_wins_in_any_order() {
        assert_eq!(graver(VERDICT, UNSUPPORTED), VERDICT);
        assert_eq!(graver(UNSUPPORTED, VERDICT), VERDICT);
        assert_eq!(graver(0, LIMIT), LIMIT);
        assert_eq!(graver(INPUT_OUTPUT, 0), INPUT_OUTPUT);
        assert_eq!(graver(USAGE, VERDICT), USAGE);
    }
}

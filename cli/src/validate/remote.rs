//! The verdict on a file behind a URL. The deeper levels read every byte several times, so they fetch it once, into a
//! temporary file.

use std::fs::File;
use std::io::Write;

use flb_format::error::Place;
use flb_format::{FormatError, Source};
use flb_inspector::validate::{Level, Report, check};
use flb_runtime::source::{FileSource, is_replaced};

use crate::exit::{Failure, INPUT_OUTPUT};

/// Bytes copied at a time.
const STEP_BYTES: u64 = 1 << 20;

/// As `flb_inspector::validate::validate`; a file that was replaced meanwhile has no verdict.
pub(super) fn look(source: &dyn Source, level: Level) -> Result<Report, Failure> {
    // What is no container is found out before it is fetched as a whole.
    let verdict = match check(source, level.min(Level::Tables)) {
        Ok(()) if level > Level::Tables => fetch(source)?.and_then(|copy| check(&copy, level)),
        verdict => verdict,
    };
    match verdict {
        Err(error) if is_replaced(&error) => Err(error.into()),
        verdict => Ok(Report::of(verdict)),
    }
}

/// All bytes of a file, in a temporary one that no name leads to. The inner error is the source's, the outer one the
/// disk's.
fn fetch(source: &dyn Source) -> Result<Result<FileSource, FormatError>, Failure> {
    let disk = |error| Failure::new(INPUT_OUTPUT, format!("temporary file for the whole of it: {error}"));
    let mut copy: File = tempfile::tempfile().map_err(disk)?;
    let read =
        |at: u64, bytes: u64| move |source| FormatError::Read { place: Place::file(at), bytes, source };
    let length = match source.len_bytes() {
        Ok(length) => length,
        Err(error) => return Ok(Err(read(0, 0)(error))),
    };
    let mut buffer = vec![0; STEP_BYTES.min(length) as usize];
    for at in (0..length).step_by(STEP_BYTES as usize) {
        let step = &mut buffer[..STEP_BYTES.min(length - at) as usize];
        if let Err(error) = source.read_exact_at(at, step) {
            return Ok(Err(read(at, step.len() as u64)(error)));
        }
        copy.write_all(step).map_err(disk)?;
    }
    Ok(Ok(FileSource::from(copy)))
}

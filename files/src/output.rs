//! Checks of outputs before the work that makes them.

use std::ffi::OsString;
use std::fs;
use std::io;
use std::path::Path;

use crate::guard::{Id, check_unread, guard_input, id, two_outputs};
use crate::publish::{folder_of, probe};
use crate::{Existing, FileError};

/// Refuses, before any long work, an output that cannot be published later: one that exists ([`Existing::Keep`]), that
/// is no regular file, read-only, an input that is named here or was read before, or whose folder is missing or takes
/// no new file.
///
/// # Errors
/// What [`publish`](crate::publish) would say.
pub fn check_output(output: &Path, inputs: &[&Path], existing: Existing) -> Result<(), FileError> {
    inputs.iter().for_each(|input| guard_input(input));
    check_unread(output)?;
    if let Ok(metadata) = fs::metadata(output) {
        for input in inputs {
            let same = fs::metadata(input).is_ok_and(|found| id(input, &found) == id(output, &metadata));
            if same {
                let (output, input) = (output.to_owned(), input.to_path_buf());
                return Err(FileError::OutputIsInput { output, input });
            }
        }
    }
    probe(output, existing)
}

/// Refuses two outputs that are one file, by way of links or not.
///
/// # Errors
/// [`FileError::TwoOutputs`].
pub fn check_distinct(first: &Path, second: &Path) -> Result<(), FileError> {
    match place(first).is_ok_and(|first| place(second).is_ok_and(|second| first == second)) {
        true => Err(two_outputs(first, second)),
        false => Ok(()),
    }
}

/// Where an output will lie, links resolved as far as there is something: which folder, and the name in it.
fn place(path: &Path) -> io::Result<(Id, OsString)> {
    let end = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let name = end.file_name().ok_or(io::ErrorKind::InvalidInput)?.to_owned();
    let folder = folder_of(&end);
    let id = id(&folder, &fs::metadata(&folder)?).ok_or(io::ErrorKind::NotFound)?;
    Ok((id, name))
}

#[cfg(test)]
mod tests;

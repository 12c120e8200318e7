//! A file appears under its name whole or not at all: a temporary file in the same folder is filled,
//! flushed to the disk, renamed, and the folder flushed. One that a killed writer of the same output left is removed first.

mod left_behind;

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use tempfile::NamedTempFile;

use crate::PackError;

/// Bytes gathered before they go to the system.
const BUFFER_BYTES: usize = 1 << 20;

/// Lets `write` fill a new file at `path`. An existing file is replaced only with `force`; where
/// anything fails, it is left as it was.
///
/// # Errors
/// [`PackError::Exists`], [`PackError::NotAFile`] for a folder, pipe or device, and write errors.
pub fn publish(
    path: &Path,
    force: bool,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), PackError> {
    let failed = |source| PackError::Write { path: path.to_owned(), source };
    let target = check_target(path, force)?;
    let folder = folder_of(&target);
    let name = target.file_name().expect("check_target refuses paths without a name").to_string_lossy();
    left_behind::remove(&folder, &name);
    let mut temporary = new_temporary(&folder, &name).map_err(failed)?;
    let _unfinished = Unfinished::note(temporary.path());

    let mut out = BufWriter::with_capacity(BUFFER_BYTES, temporary.as_file_mut());
    write(&mut out).and_then(|()| out.flush()).map_err(failed)?;
    drop(out);
    temporary.as_file().sync_all().map_err(failed)?;
    let renamed = if force { temporary.persist(&target) } else { temporary.persist_noclobber(&target) };
    renamed.map_err(|error| match error.error.kind() {
        io::ErrorKind::AlreadyExists => PackError::Exists { path: path.to_owned() },
        _ => failed(error.error),
    })?;
    // Without this the rename itself may be lost with the power.
    if cfg!(unix) {
        File::open(&folder).and_then(|folder| folder.sync_all()).map_err(failed)?;
    }
    Ok(())
}

/// A temporary file that other runs see is in use.
fn new_temporary(folder: &Path, name: &str) -> io::Result<NamedTempFile> {
    let prefix = left_behind::prefix(name);
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(left_behind::SUFFIX).rand_bytes(left_behind::RANDOM_LENGTH);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666)); // less the umask
    // Each round lost is one that another run won, which goes on.
    loop {
        let temporary = builder.tempfile_in(folder)?;
        if left_behind::claim(temporary.as_file())? {
            return Ok(temporary);
        }
    }
}

/// Temporary files that are being filled.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Removes the temporary files of every [`publish`] that is under way; for a signal handler's thread, right
/// before it ends the process. (A killed process leaves them behind, hidden, beside the output; the next [`publish`] there removes them.)
pub fn remove_unfinished() {
    let mut unfinished = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
    for path in unfinished.drain(..) {
        // It may be gone already: renamed, or removed with its folder.
        let _ = fs::remove_file(path);
    }
}

/// A path in [`UNFINISHED`] for as long as it lives.
struct Unfinished(PathBuf);

impl Unfinished {
    fn note(path: &Path) -> Unfinished {
        UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner).push(path.to_owned());
        Unfinished(path.to_owned())
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner).retain(|path| *path != self.0);
    }
}

/// Refuses an output that is one of the inputs, under any name.
///
/// # Errors
/// [`PackError::OutputIsInput`].
pub fn refuse_inputs(output: &Path, inputs: &[&Path]) -> Result<(), PackError> {
    for input in inputs {
        if same_file(output, input) {
            let (output, input) = (output.to_owned(), input.to_path_buf());
            return Err(PackError::OutputIsInput { output, input });
        }
    }
    Ok(())
}

/// The path to write to, links resolved.
fn check_target(path: &Path, force: bool) -> Result<PathBuf, PackError> {
    let not_a_file = |found| Err(PackError::NotAFile { path: path.to_owned(), found });
    if path.file_name().is_none() {
        return not_a_file("no file name");
    }
    let Ok(link) = fs::symlink_metadata(path) else {
        return Ok(path.to_owned()); // new, or its folder is missing, which the temporary file reports
    };
    let Ok(target) = fs::metadata(path) else {
        return not_a_file("a link that leads nowhere");
    };
    if target.is_dir() {
        return not_a_file("a folder");
    }
    if !target.is_file() {
        return not_a_file("a pipe, socket or device");
    }
    if !force {
        return Err(PackError::Exists { path: path.to_owned() });
    }
    if link.is_symlink() {
        return fs::canonicalize(path).map_err(|source| PackError::Write { path: path.to_owned(), source });
    }
    Ok(path.to_owned())
}

fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
        _ => PathBuf::from("."),
    }
}

#[cfg(unix)]
fn same_file(a: &Path, b: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let key = |path: &Path| fs::metadata(path).map(|m| (m.dev(), m.ino())).ok();
    key(a).is_some_and(|a| key(b) == Some(a))
}

#[cfg(not(unix))]
fn same_file(a: &Path, b: &Path) -> bool {
    fs::canonicalize(a).is_ok_and(|a| fs::canonicalize(b).is_ok_and(|b| a == b))
}

#[cfg(test)]
mod tests;

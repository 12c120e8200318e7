//! A folder of files that a command writes: checked before the work, written whole or not at all.

use std::fs;
use std::path::{Path, PathBuf};

use flb_files::{Existing, check_distinct, publish};

use crate::exit::{Failure, INPUT_OUTPUT};
use crate::inputs::{check_local, check_no_dash, check_output_of};

/// Refuses, before any work, a folder that files of these names cannot be written to.
pub(crate) fn check_folder(
    folder: &Path,
    names: &[&str],
    inputs: &[&Path],
    existing: Existing,
) -> Result<(), Failure> {
    check_local(folder)?;
    check_no_dash(folder)?;
    if !folder.exists() {
        // Its own parent must be there, and be a folder. A slash at the end names a folder, which this will be.
        return check_output_of(&folder.components().collect::<PathBuf>(), &[], existing);
    }
    if !folder.is_dir() {
        return Err(
            Failure::new(INPUT_OUTPUT, "exists and is not a folder, expected a folder or nothing").at(folder)
        );
    }
    let outputs: Vec<PathBuf> = names.iter().map(|name| folder.join(name)).collect();
    for (index, output) in outputs.iter().enumerate() {
        check_output_of(output, inputs, existing)?;
        outputs[..index].iter().try_for_each(|other| check_distinct(other, output))?;
    }
    Ok(())
}

/// Writes every file whole; where one fails, those that were new go again, and a new folder with them.
pub(crate) fn publish_all(
    folder: &Path,
    files: &[(&str, Vec<u8>)],
    existing: Existing,
) -> Result<(), Failure> {
    let is_new = !folder.exists();
    if is_new {
        fs::create_dir(folder).map_err(|error| Failure::new(INPUT_OUTPUT, error).at(folder))?;
    }
    let mut written: Vec<PathBuf> = Vec::new();
    for (name, content) in files {
        let path = folder.join(name);
        let is_new_file = !path.exists();
        if let Err(error) = publish(&path, existing, |file| file.write_all(content)) {
            for path in written {
                // What cannot be removed stays whole.
                let _ = fs::remove_file(path);
            }
            if is_new {
                let _ = fs::remove_dir(folder);
            }
            return Err(error.into());
        }
        if is_new_file {
            written.push(path);
        }
    }
    Ok(())
}

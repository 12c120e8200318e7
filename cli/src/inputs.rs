//! Files to read, and checks on paths before any long work starts.

use std::fs;
use std::path::{Path, PathBuf};
#[cfg(feature = "remote")]
use std::sync::atomic::{AtomicBool, Ordering};

use flb_packer::publish::refuse_inputs;
#[cfg(feature = "remote")]
use flb_runtime::RemoteSettings;
use flb_runtime::{Library, Location};

use crate::exit::{Failure, INPUT_OUTPUT, USAGE};

/// Whether redirects may lead to private addresses, as the command line says for all URLs at once.
#[cfg(feature = "remote")]
static ALLOW_PRIVATE_REDIRECTS: AtomicBool = AtomicBool::new(false);

/// Opens a file as a command's word names it: a path or a URL.
pub fn open(word: &Path) -> Result<Library, Failure> {
    open_location(&Location::parse(word)?)
}

/// Opens a path or a URL.
pub fn open_location(location: &Location) -> Result<Library, Failure> {
    Ok(match location {
        #[cfg(feature = "remote")]
        Location::Remote(url) => Library::open_remote(url, &remote_settings())?,
        Location::File(_) => Library::open_location(location)?,
    })
}

/// Called once, before any URL is read.
#[cfg(feature = "remote")]
pub fn allow_private_redirects(allow: bool) {
    ALLOW_PRIVATE_REDIRECTS.store(allow, Ordering::Relaxed);
}

/// How URLs are read.
#[cfg(feature = "remote")]
pub fn remote_settings() -> RemoteSettings {
    let allow_private_redirects = ALLOW_PRIVATE_REDIRECTS.load(Ordering::Relaxed);
    RemoteSettings { allow_private_redirects, ..RemoteSettings::default() }
}

/// As [`check_output`], for inputs of which some may be URLs.
pub fn check_output_of(output: &Path, inputs: &[&Path], force: bool) -> Result<(), Failure> {
    let inputs = inputs.iter().map(Location::parse).collect::<Result<Vec<_>, _>>()?;
    check_output(output, &inputs.iter().filter_map(Location::file).collect::<Vec<_>>(), force)
}

/// Refuses an output that is there already (without `force`), that is an input too, or whose folder is
/// missing, so that nobody waits for a bake that cannot be written.
pub fn check_output(output: &Path, inputs: &[&Path], force: bool) -> Result<(), Failure> {
    let folder = match output.parent() {
        Some(folder) if folder.as_os_str().is_empty() => Path::new("."),
        Some(folder) => folder,
        None => return Err(Failure::new(USAGE, "the output is a folder, expected a file").at(output)),
    };
    if !folder.is_dir() {
        return Err(
            Failure::new(INPUT_OUTPUT, format!("the folder {} does not exist", folder.display())).at(output)
        );
    }
    let found = match fs::metadata(output) {
        Ok(found) => found,
        Err(_) => return Ok(()),
    };
    refuse_inputs(output, inputs)?;
    if !found.is_file() {
        return Err(Failure::new(INPUT_OUTPUT, "exists and is not a regular file").at(output));
    }
    if !force {
        return Err(Failure::new(INPUT_OUTPUT, "exists already; use --force to overwrite it").at(output));
    }
    Ok(())
}

/// Refuses two outputs that are one file.
pub fn check_distinct(a: &Path, b: &Path) -> Result<(), Failure> {
    let place = |path: &Path| -> Option<(PathBuf, _)> {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        Some((fs::canonicalize(folder).ok()?, path.file_name()?.to_owned()))
    };
    match place(a).is_some() && place(a) == place(b) {
        true => Err(Failure::new(USAGE, format!("{}: named as two outputs at once", a.display()))),
        false => Ok(()),
    }
}

/// The index of the species to use: the named one; else the only one; else the one that `hint` names.
pub fn choose_species(library: &Library, name: Option<&str>, hint: Option<&str>) -> Result<usize, Failure> {
    let species = library.container().species();
    let find = |wanted: &str| species.iter().position(|s| s.meta.name == wanted);
    let names: Vec<&str> = species.iter().map(|s| s.meta.name.as_str()).collect();
    let listed = names.join(", ");
    match (name, species.len()) {
        (Some(name), _) => find(name).ok_or_else(|| {
            Failure::new(USAGE, format!("no species is named {name:?}; there are: {listed}"))
                .at(library.path())
        }),
        (None, 1) => Ok(0),
        (None, count) => hint.and_then(find).ok_or_else(|| {
            let message = format!("holds {count} species; choose one with --species: {listed}");
            Failure::new(USAGE, message).at(library.path())
        }),
    }
}

//! Files to read, and checks on paths before any long work starts.

use std::path::Path;
#[cfg(feature = "remote")]
use std::sync::atomic::{AtomicBool, Ordering};

use flb_files::{Existing, check_unread, guard_input};
use flb_format::text::url;
#[cfg(feature = "remote")]
use flb_runtime::source::RemoteSettings;
use flb_runtime::{Library, Location};
use flb_scene::import::named_files;
use flb_scene::scene::Scene;
use flb_stage::open::find_species;

use crate::exit::{Failure, USAGE};

/// Whether redirects may lead to private addresses, as the command line says for all URLs at once.
#[cfg(feature = "remote")]
static ALLOW_PRIVATE_REDIRECTS: AtomicBool = AtomicBool::new(false);

/// Opens a file as a command's word names it: a path or a URL.
pub(crate) fn open(word: &Path) -> Result<Library, Failure> {
    open_location(&Location::parse(word)?)
}

/// Opens a path or a URL.
pub(crate) fn open_location(location: &Location) -> Result<Library, Failure> {
    Ok(match location {
        #[cfg(feature = "remote")]
        Location::Remote(url) => Library::open_remote(url, &remote_settings())?,
        Location::File(_) => Library::open_location(location)?,
    })
}

/// Called once, before any URL is read.
#[cfg(feature = "remote")]
pub(crate) fn allow_private_redirects(allow: bool) {
    ALLOW_PRIVATE_REDIRECTS.store(allow, Ordering::Relaxed);
}

/// How URLs are read.
#[cfg(feature = "remote")]
pub(crate) fn remote_settings() -> RemoteSettings {
    let allow_private_redirects = ALLOW_PRIVATE_REDIRECTS.load(Ordering::Relaxed);
    RemoteSettings { allow_private_redirects, ..RemoteSettings::default() }
}

/// As [`check_output`], for inputs of which some may be URLs.
pub(crate) fn check_output_of(output: &Path, inputs: &[&Path], existing: Existing) -> Result<(), Failure> {
    let inputs = inputs.iter().map(Location::parse).collect::<Result<Vec<_>, _>>()?;
    check_output(output, &inputs.iter().filter_map(Location::file).collect::<Vec<_>>(), existing)
}

/// Refuses an output that cannot be written later, so that no long work is lost: see [`flb_files::check_output`].
pub(crate) fn check_output(output: &Path, inputs: &[&Path], existing: Existing) -> Result<(), Failure> {
    check_local(output)?;
    check_no_dash(output)?;
    flb_files::check_output(output, inputs, existing)?;
    guard_named(inputs.iter().copied(), &[output]);
    Ok(check_unread(output)?)
}

/// Refuses `-`, which elsewhere means stdout.
pub(crate) fn check_no_dash(output: &Path) -> Result<(), Failure> {
    match output.as_os_str() == "-" {
        true => {
            let message =
                "found -, expected a name: nothing but text is written to stdout; ./- is a file of that name";
            Err(Failure::new(USAGE, message))
        }
        false => Ok(()),
    }
}

/// Counts what these files name, if they are meshes, as inputs, too: textures and buffers, whether the command reads
/// them or not. Meshes are looked at only where an output is there already, which could be one of those.
fn guard_named<'f>(files: impl Iterator<Item = &'f Path>, outputs: &[&Path]) {
    if outputs.iter().any(|output| output.exists()) {
        files.flat_map(named_files).for_each(|named| guard_input(&named));
    }
}

/// Refuses a URL where only files of this machine will do: meshes, which name other files; what a scene names; outputs.
pub(crate) fn check_local(word: &Path) -> Result<(), Failure> {
    let location = Location::parse(word)?;
    match location.file() {
        Some(_) => Ok(()),
        None => {
            let message = "found a URL, expected a file of this machine: the .flb files that a command line names, \
                           and --cache, may be URLs";
            Err(Failure::new(USAGE, message).at(&location.name()))
        }
    }
}

/// Refuses a URL that a scene names, whose folder stands before it.
fn check_named(file: &Path) -> Result<(), Failure> {
    let name = file.to_string_lossy();
    match url::is_meant(&name) {
        true => {
            let failure = Failure::new(USAGE, "found a URL, expected a file of this machine");
            Err(failure.at(Path::new(&*url::shown_reference(&name))))
        }
        false => Ok(()),
    }
}

/// Reads a scene. Every file that it names counts as an input from now on, whether the command reads it or not, and
/// none of the outputs may be one.
pub(crate) fn read_scene(path: &Path, outputs: &[&Path]) -> Result<Scene, Failure> {
    let scene = read_scene_to_light(path, &[])?; // its outputs are looked at below, when the light is known too
    scene.light.iter().for_each(|light| guard_input(light));
    guard_named(scene.files(), outputs);
    outputs.iter().try_for_each(|output| check_unread(output))?;
    Ok(scene)
}

/// The same for what makes the light of the scene, which may replace the one that the scene names.
pub(crate) fn read_scene_to_light(path: &Path, outputs: &[&Path]) -> Result<Scene, Failure> {
    let scene = Scene::read(path)?;
    for file in scene.files().chain(scene.light.as_deref()) {
        check_named(file).map_err(|failure| failure.at(path))?;
    }
    scene.files().for_each(guard_input);
    guard_named(scene.files(), outputs);
    outputs.iter().try_for_each(|output| check_unread(output))?;
    Ok(scene)
}

/// The index of the species to use: the named one; else the only one; else the one that `hint` names.
pub(crate) fn choose_species(
    library: &Library,
    name: Option<&str>,
    hint: Option<&str>,
) -> Result<usize, Failure> {
    find_species(library, name, hint).map_err(|error| Failure::from(error).at(library.path()))
}

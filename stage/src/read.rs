//! Mesh files, read for people: what import and classes have to say goes to an observer.

use std::path::Path;

use flb_scene::import::import;
use flb_scene::{ClassedMesh, ImportError, ImportSettings, Mesh, Observer, PlantReader};

use crate::StageError;

/// The mesh of a file; the observer hears what import repaired or ignored.
///
/// # Errors
/// [`ImportError`].
pub fn read_mesh(
    path: &Path,
    settings: &ImportSettings,
    observer: &dyn Observer,
) -> Result<Mesh, ImportError> {
    let mesh = import(path, settings)?;
    // A warning names its file, which may be a texture; the folder is what it lacks.
    let told = mesh.warnings.iter().map(|warning| format!("warning: {warning}"));
    for note in told.chain(mesh.notes.iter().cloned()) {
        observer.note(&format!("{note} (reading {})", path.display()));
    }
    Ok(mesh)
}

/// A mesh with its classes. The observer hears what import repaired or ignored, the class of each material and why, and
/// what of the mesh is there twice and counts once.
///
/// # Errors
/// [`StageError::At`] the file: [`StageError::Import`].
pub fn read_classed(
    file: &Path,
    reader: &PlantReader,
    observer: &dyn Observer,
) -> Result<ClassedMesh, StageError> {
    let at_file = |error: ImportError| StageError::from(error).at(file);
    let mesh = read_mesh(file, &reader.settings, observer).map_err(at_file)?;
    let (classed, decisions) = reader.class(mesh).map_err(at_file)?;
    for (material, decision) in classed.mesh.materials.iter().zip(&decisions) {
        let (name, class) = (&material.name, decision.class.name());
        observer.note(&format!("{}: material {name:?} is {class}: {}", file.display(), decision.rule));
    }
    tell_sheets(file, &classed, observer);
    Ok(classed)
}

/// Tells what of a mesh is there twice and counts once.
pub fn tell_sheets(file: &Path, classed: &ClassedMesh, observer: &dyn Observer) {
    let notes = classed.mesh.sheets.notes();
    notes.iter().for_each(|note| observer.note(&format!("{}: {note}", file.display())));
}

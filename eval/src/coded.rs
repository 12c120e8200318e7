//! The light of a coded species on its mesh, before it is written.

use flb_format::MeshError;
use flb_format::provenance::IGNORE_ALPHA;
use flb_packer::{EncodeSettings, EncodedSpecies, write_library_to};
use flb_runtime::{Library, SpeciesLight};
use flb_scene::{ClassedMesh, Observer};

use crate::EvalError;
use crate::mesh::{JudgeSettings, MeshJudge, judged_points, judged_surfaces, mesh_error};

/// Judges a species as it will be read, writes the figures into its metadata, and returns them.
///
/// # Errors
/// [`EvalError`], as [`judged_surfaces`], [`judged_points`] and [`MeshJudge`].
pub fn judge_coded(
    species: &mut EncodedSpecies,
    mesh: &ClassedMesh,
    coding: &EncodeSettings,
    settings: JudgeSettings,
    observer: &dyn Observer,
) -> Result<MeshError, EvalError> {
    let name = species.meta.name.clone();
    let mut bytes = Vec::new();
    write_library_to(&mut bytes, &[species])?;
    let library = Library::from_source(&name, Box::new(bytes))?.with_picture_bands(0, &[])?;
    let surfaces = judged_surfaces(&library.container().species()[0].meta)?;
    let light = SpeciesLight::load(&library, 0)?;
    let ignore_alpha = species.meta.recorded(&IGNORE_ALPHA) == Some(true);
    let points = judged_points(mesh, settings.points, ignore_alpha)?;
    let found = JudgeSettings { points: points.len() as u32, ..settings };
    let judge = MeshJudge::new(&light, surfaces, points, settings.suns as usize, observer)?;
    let error = mesh_error(&judge.judge(mesh, settings.samples, &name, observer)?, found);
    species.set_mesh_error(&error, coding)?;
    Ok(error)
}

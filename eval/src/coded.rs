//! The light of a coded species on its mesh, before it is written.

use flb_format::mesh::MeshError;
use flb_format::provenance::IGNORE_ALPHA;
use flb_packer::{EncodeSettings, EncodedSpecies, write_library_to};
use flb_runtime::{Library, SpeciesLight};
use flb_scene::{ClassedMesh, Observer};
use flb_transport::monte_carlo::judge::suns;

use crate::EvalError;
use crate::mesh::{JudgeSettings, MeshJudge, judged_points, judged_surfaces, mesh_error};

/// Judges a species as it will be read, on the mesh that it was baked from, writes the figures into its metadata, and
/// returns them. The surfaces of materials are those that the species states.
///
/// # Errors
/// As [`judged_surfaces`], [`judged_points`] and [`MeshJudge`]; [`EvalError::Bands`] for a species without R, G and B;
/// [`EvalError::Pack`] for metadata that no file can hold.
///
/// # Panics
/// If more suns are asked for than [`MAX_SUNS`](flb_transport::monte_carlo::judge::MAX_SUNS).
pub fn judge_coded(
    species: &mut EncodedSpecies,
    mut mesh: ClassedMesh,
    coding: &EncodeSettings,
    settings: JudgeSettings,
    observer: &dyn Observer,
) -> Result<MeshError, EvalError> {
    let name = species.meta.name.clone();
    let mut bytes = Vec::new();
    write_library_to(&mut bytes, &[species])?;
    let library = Library::from_source(&name, Box::new(bytes))?.with_picture_bands(0, &[])?;
    let meta = &library.container().species()[0].meta;
    let surfaces = judged_surfaces(meta)?;
    // The bands were chosen above, which looks at the same surfaces.
    if let Ok(Some(of_materials)) = meta.material_surfaces() {
        mesh.mesh.set_surfaces(of_materials);
    }
    let light = SpeciesLight::load(&library, 0)?;
    let ignore_alpha = species.meta.recorded(&IGNORE_ALPHA) == Some(true);
    let points = judged_points(&mesh, settings.points, ignore_alpha)?;
    let found = JudgeSettings { points: points.len() as u32, ..settings };
    let judge = MeshJudge::new(&light, surfaces, points, suns(settings.suns as usize), observer)?;
    let error = mesh_error(&judge.judge(&mesh, settings.samples, &name, observer)?, found);
    species.set_mesh_error(&error, coding)?;
    Ok(error)
}

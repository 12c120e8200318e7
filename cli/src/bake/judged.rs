//! `--judge`: how far the coded light is off on the mesh, for the file.

use flb_format::provenance::IGNORE_ALPHA;
use flb_packer::{EncodeSettings, EncodedSpecies, write_library_to};
use flb_runtime::{Library, SpeciesLight};
use flb_scene::ClassedMesh;

use crate::args::{BandArgs, JUDGED};
use crate::exit::Failure;
use crate::judge::judging::{self, Judging};
use crate::judge::surfaces;
use crate::picture::shown;
use crate::print::{self, say};
use crate::stages::Stages;

/// Judges a species as it will be read, writes the figures into its metadata, and says them.
pub(super) fn judge(
    species: &mut EncodedSpecies,
    mesh: &ClassedMesh,
    coding: &EncodeSettings,
    stages: &Stages,
) -> Result<(), Failure> {
    let [suns, points, samples] = JUDGED;
    let name = species.meta.name.clone();
    let mut bytes = Vec::new();
    write_library_to(&mut bytes, &[species])?;
    let library = Library::from_source(&name, Box::new(bytes))?;
    let library = shown(library, 0, &BandArgs::default())?;
    let surfaces = surfaces(&library.container().species()[0].meta)?;
    let light = SpeciesLight::load(&library, 0)?;
    let ignore_alpha = species.meta.recorded(&IGNORE_ALPHA) == Some(true);
    let points = judging::points(mesh, points, ignore_alpha)?;
    let counts = [suns, points.len() as u32, samples];
    let judging = Judging::new(&light, surfaces, points, suns, stages)?;
    let error = judging::kept(&judging.judge(mesh, samples, (&name, stages))?, counts);
    say!("{name}: on the mesh: {}", print::mesh_error(&error));
    species.set_mesh_error(&error, coding)?;
    Ok(())
}

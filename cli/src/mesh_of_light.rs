//! The mesh that is shown with the light of a file; what is odd about it goes to stderr.

use std::path::Path;

use flb_format::SpeciesMeta;
use flb_format::mesh::MeshMatch;
use flb_scene::{ClassedMesh, Observer};
pub(crate) use flb_stage::MeshOfLight;

use crate::exit::Failure;
use crate::inputs::check_local;
use crate::print::say;

/// Says what it hears on stderr.
pub(crate) struct Said;

impl Observer for Said {
    fn note(&self, text: &str) {
        say!("{text}");
    }
}

/// [`MeshOfLight::read`] of a file of this machine.
pub(crate) fn mesh_of_species(
    path: &Path,
    meta: &SpeciesMeta,
    gltf_mesh: Option<&str>,
    may_differ: bool,
) -> Result<MeshOfLight, Failure> {
    check_local(path)?;
    Ok(MeshOfLight::read(path, meta, gltf_mesh, may_differ, &Said)?)
}

/// [`MeshOfLight::check`] of a mesh that was read.
pub(crate) fn check_fit(
    path: &Path,
    meta: &SpeciesMeta,
    mesh: &ClassedMesh,
    may_differ: bool,
) -> Result<MeshMatch, Failure> {
    Ok(MeshOfLight::check(path, meta, mesh, may_differ, &Said)?)
}

//! The mesh that is shown with the light of a file: read as it was baked, and held against what the file remembers of
//! it. Light of another mesh looks like light.

use std::path::Path;

use flb_format::SpeciesMeta;
use flb_format::colors::COLORS;
use flb_format::mesh::FIT_SHARE;
use flb_format::mesh::MeshMatch;
use flb_scene::classify::classify;
use flb_scene::extents::{Extents, number};
use flb_scene::plant::{recorded_classes, recorded_settings};
use flb_scene::{ClassRules, ClassedMesh, ImportSettings, Mesh, Observer};

use crate::StageError;
use crate::read::read_mesh;

/// The digits of a digest that a message shows.
pub(crate) fn short(digest: &str) -> &str {
    digest.get(..12).unwrap_or(digest)
}

/// A mesh, and how it and the light belong together.
pub struct MeshOfLight {
    /// Mesh with its classes, surfaces and colours as baked.
    pub mesh: ClassedMesh,
    /// Units, axes and parts that it was read by.
    pub read_as: ImportSettings,
    /// Relation of the mesh to the light.
    pub matched: MeshMatch,
}

impl MeshOfLight {
    /// The mesh that a species was baked from, read with the settings that its file records, or another mesh of a glTF.
    /// Tells the observer if it is another mesh.
    ///
    /// # Errors
    /// [`StageError::Metadata`]; [`StageError::At`] the mesh: [`StageError::Import`], and unless `may_differ`
    /// [`StageError::MaterialCount`], [`StageError::OtherMesh`] for a mesh that does not fit the light.
    pub fn read(
        path: &Path,
        meta: &SpeciesMeta,
        gltf_mesh: Option<&str>,
        may_differ: bool,
        observer: &dyn Observer,
    ) -> Result<MeshOfLight, StageError> {
        let at_mesh = |error: StageError| error.at(path);
        let (mesh, read_as) = read_as_baked(path, meta, gltf_mesh, observer).map_err(at_mesh)?;
        let mut mesh = class_as_baked(meta, mesh, may_differ).map_err(at_mesh)?;
        color_as_baked(path, meta, &mut mesh.mesh, observer)?;
        texels_of_bands(&mut mesh.mesh, meta);
        let matched = MeshOfLight::check(path, meta, &mesh, may_differ, observer)?;
        Ok(MeshOfLight { mesh, read_as, matched })
    }

    /// Compares a mesh with the light of a species. A mesh that does not fit is refused, unless `may_differ`; then, and
    /// of another one that fits, the observer hears of it.
    ///
    /// # Errors
    /// [`StageError::At`] the mesh: [`StageError::NoTriangles`], [`StageError::OtherMesh`].
    pub fn check(
        path: &Path,
        meta: &SpeciesMeta,
        mesh: &ClassedMesh,
        may_differ: bool,
        observer: &dyn Observer,
    ) -> Result<MeshMatch, StageError> {
        let at_mesh = |error: StageError| error.at(path);
        let name = &meta.name;
        let mark = mesh.mark().ok_or(StageError::NoTriangles).map_err(at_mesh)?;
        let matched = MeshMatch::of(meta, &mark);
        let shown = path.display();
        match matched {
            MeshMatch::Differs(fit) | MeshMatch::Unknown(fit) if !fit.is_good() => {
                let size = |bounds_m| Extents { bounds_m }.to_string();
                let message = format!(
                    "does not fit the light of species {name:?}: it is {}, the light is of {}; a side is {} m off, expected \
                     at most {} m",
                    size(mark.bounds_m),
                    size(meta.bounds_m),
                    number(fit.off_m),
                    number(FIT_SHARE * fit.longest_m)
                );
                if !may_differ {
                    return Err(at_mesh(StageError::OtherMesh(message)));
                }
                observer.note(&format!("warning: {shown}: {message}"));
            }
            MeshMatch::Differs(_) => {
                observer.note(&format!(
                    "warning: {shown}: not the mesh that species {name:?} was baked from: its digest is {}..., the file says \
                     {}...; its size fits, as that of another level of detail does",
                    short(&mark.blake3),
                    short(meta.mesh_blake3.as_deref().unwrap_or_default())
                ));
            }
            MeshMatch::Unknown(_) if !is_baked_from(meta, &mesh.mesh) => {
                observer.note(&format!(
                    "warning: {shown}: not the file that species {name:?} was baked from, or changed since"
                ));
            }
            MeshMatch::Same if !is_baked_from(meta, &mesh.mesh) => {
                observer.note(&format!(
                    "{shown}: another file than species {name:?} was baked from: its triangles are the same, its textures \
                     need not be"
                ));
            }
            MeshMatch::Same | MeshMatch::Unknown(_) => {}
        }
        Ok(matched)
    }
}

fn read_as_baked(
    path: &Path,
    meta: &SpeciesMeta,
    gltf_mesh: Option<&str>,
    observer: &dyn Observer,
) -> Result<(Mesh, ImportSettings), StageError> {
    let mut settings = recorded_settings(meta);
    if let Some(asked) = gltf_mesh {
        let baked = settings.gltf_mesh.replace(asked.to_owned());
        if let Some(baked) = baked.filter(|baked| baked != asked) {
            observer.note(&format!(
                "warning: {}: species {:?} was baked from mesh {baked:?}, shown is {asked:?}",
                path.display(),
                meta.name
            ));
        }
    }
    Ok((read_mesh(path, &settings, observer)?, settings))
}

/// With the classes that the file records; those of another mesh, which has other materials, are found anew.
fn class_as_baked(meta: &SpeciesMeta, mesh: Mesh, may_differ: bool) -> Result<ClassedMesh, StageError> {
    let classes = recorded_classes(meta);
    let found = classes.as_ref().map_or(0, Vec::len);
    let expected = mesh.materials.len();
    match classes.filter(|_| found == expected) {
        Some(classes) => Ok(ClassedMesh::of(mesh, classes)),
        None if may_differ => {
            let decisions = classify(&mesh, &ClassRules::default())?;
            Ok(ClassedMesh::of(mesh, decisions.iter().map(|decision| decision.class).collect()))
        }
        None => {
            Err(StageError::MaterialCount { species: meta.name.clone(), found: expected, expected: found })
        }
    }
}

/// With what the file says of its materials' surfaces; another mesh, which has other materials, has the species' own.
fn color_as_baked(
    path: &Path,
    meta: &SpeciesMeta,
    mesh: &mut Mesh,
    observer: &dyn Observer,
) -> Result<(), StageError> {
    let refuse = |message| StageError::Metadata { species: meta.name.clone(), message };
    let Some(surfaces) = meta.material_surfaces().map_err(refuse)? else { return Ok(()) };
    let stated = surfaces.len();
    if !mesh.set_surfaces(surfaces) {
        observer.note(&format!(
            "warning: {}: the mesh has {} materials, the file of its light tells the surfaces of {}: drawn as tints of \
             the species' mean leaf and wood",
            path.display(),
            mesh.materials.len(),
            stated
        ));
    }
    Ok(())
}

/// Textures and colours of a mesh whose light is shown in other bands than R, G and B in this order: a band that is a
/// colour has that of the texels, whatever it is shown as; another one takes no colour (SPEC.md, section 9.3).
fn texels_of_bands(mesh: &mut Mesh, meta: &SpeciesMeta) {
    let names: Vec<&str> = meta.bands().collect();
    if names.len() != COLORS.len() || names == COLORS {
        return;
    }
    let places: Vec<Option<usize>> =
        names.iter().map(|name| COLORS.iter().position(|color| color == name)).collect();
    take_places(mesh, &places);
}

/// Colours of textures, vertices and materials with the values of these places; white where there is none.
fn take_places(mesh: &mut Mesh, places: &[Option<usize>]) {
    for image in &mut mesh.images {
        image.rgba.as_chunks_mut::<4>().0.iter_mut().for_each(|texel| taken(texel, places, u8::MAX));
    }
    mesh.colors.iter_mut().for_each(|color| taken(color, places, 1.0));
    mesh.materials.iter_mut().for_each(|material| taken(&mut material.base_color, places, 1.0));
}

/// What lies beyond the places, as alpha does, stays.
fn taken<const N: usize, T: Copy>(values: &mut [T; N], places: &[Option<usize>], white: T) {
    let old = *values;
    places.iter().zip(values).for_each(|(place, new)| *new = place.map_or(white, |place| old[place]));
}

/// Whether the file of the mesh is among those that the species was made from.
fn is_baked_from(meta: &SpeciesMeta, mesh: &Mesh) -> bool {
    let baked_from = |digest: &str| meta.sources.iter().any(|source| source.blake3 == digest);
    mesh.sources.first().is_some_and(|source| baked_from(&source.blake3))
}

#[cfg(test)]
mod tests {
    use flb_scene::mesh::{Image, Material};

    use super::*;

    #[test]
    fn colours_of_texels_vertices_and_materials_go_with_their_bands() {
        let mut material = Material::opaque("leaf");
        material.base_color = [0.1, 0.2, 0.3, 0.4];
        let rgba = vec![1, 2, 3, 4];
        let image = Image { name: "leaf".to_owned(), width: 1, height: 1, rgba, has_cut: true };
        let colors = vec![[0.5, 0.6, 0.7]];
        let mut mesh = Mesh { materials: vec![material], images: vec![image], colors, ..Mesh::default() };
        take_places(&mut mesh, &[None, Some(1), Some(0)]);
        assert_eq!(mesh.materials[0].base_color, [1.0, 0.2, 0.1, 0.4]);
        assert_eq!(mesh.images[0].rgba, [255, 2, 1, 4]);
        assert_eq!(mesh.colors, [[1.0, 0.6, 0.5]]);
    }
}

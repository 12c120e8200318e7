//! What the bakes of both models share: metadata, and the voxels of a plant.

use flb_format::container::metadata;
use flb_format::error::Place;
use flb_format::meta::Bounds;
use flb_format::model::Model;
use flb_format::{Grid, Medium, SpeciesMeta, provenance};
use flb_scene::plant::Record;
use flb_scene::{ClassedMesh, Plant, Step};
use serde_json::json;

use super::key::{Key, of_voxels};
use super::observer::Event;
use super::store::{self, Store};
use super::{BakeError, BakeSettings, Work};
use crate::{VoxelSettings, downsample, voxelise};

/// Smallest and largest plants, metres along the longest axis.
const EXTENT_M: [f64; 2] = [1e-5, 1e5];

/// A plant, and how it is cut into voxels.
pub(super) struct Start {
    pub plant: Plant,
    pub voxels: VoxelSettings,
    /// Key of all that the voxels depend on, besides the settings of the voxeliser.
    pub shape: Key,
}

impl Start {
    pub(super) fn new(plant: Plant, settings: &BakeSettings, store: &dyn Store) -> Start {
        let voxels = VoxelSettings {
            voxels: settings.voxels,
            lattice: settings.lattice,
            ignore_alpha: settings.ignore_alpha || plant.ignore_alpha,
        };
        let shape = shape(&plant, store);
        Start { plant, voxels, shape }
    }
}

/// The files of a plant, and how they were read. A mesh that was made in memory has no files: there the triangles
/// count, where a store keeps anything.
fn shape(plant: &Plant, store: &dyn Store) -> Key {
    // Names do not count, nor what a species file says of colours: seasons of a plant share its voxels.
    let digests: Vec<&str> = plant.classed.mesh.sources.iter().map(|source| source.blake3.as_str()).collect();
    let in_memory = (digests.is_empty() && store.keeps()).then(|| mesh_digest(&plant.classed));
    // Colours of vertices do not count either; their alpha does, which changes materials.
    let Record { up, unit_m, gltf_mesh, nodes, split, ignore_vertex_colors, offset_m, classes } =
        &plant.record;
    let classes: Vec<&str> = classes.iter().map(|class| class.name()).collect();
    Key::new("shape")
        .with("files", json!(digests))
        .with_all(in_memory.map(|digest| ("mesh", json!(digest))))
        .with("classes", json!(classes))
        .with_all(gltf_mesh.as_ref().map(|mesh| ("gltf_mesh", json!(mesh))))
        .with_all((!nodes.is_empty()).then(|| ("nodes", json!(nodes))))
        .with_all((!split.is_empty()).then(|| ("split", json!(split))))
        .with_all(ignore_vertex_colors.then(|| ("ignore_vertex_colors", json!(true))))
        .with_all((*offset_m != [0.0; 3]).then(|| ("offset_m", json!(offset_m))))
        .with("up", json!(up.name()))
        .with("unit_m", json!(unit_m))
}

/// Of everything that voxels and crown depend on.
fn mesh_digest(classed: &ClassedMesh) -> String {
    let mut hasher = blake3::Hasher::new();
    let mesh = &classed.mesh;
    for part in [mesh.positions.as_flattened(), mesh.uvs.as_flattened()] {
        hasher.update(&(part.len() as u64).to_le_bytes());
        part.iter().for_each(|value| _ = hasher.update(&value.to_le_bytes()));
    }
    for part in [mesh.triangles.as_flattened(), &mesh.triangle_material] {
        hasher.update(&(part.len() as u64).to_le_bytes());
        part.iter().for_each(|value| _ = hasher.update(&value.to_le_bytes()));
    }
    // As the readers of files find them in the mesh itself; a mesh in memory may say what it likes.
    mesh.sheets.sides.iter().for_each(|&side| _ = hasher.update(&[side as u8]));
    let images = mesh.images.iter().map(|image| (image.width, image.height, blake3::hash(&image.rgba)));
    hasher.update(format!("{:?} {:?}", mesh.materials, images.collect::<Vec<_>>()).as_bytes());
    hasher.finalize().to_hex().to_string()
}

/// Voxelise and downsample, or what an earlier bake kept of them.
pub(super) fn hold_medium(
    work: &Work,
    classed: &ClassedMesh,
    settings: &VoxelSettings,
    shape: &Key,
) -> Result<Medium, BakeError> {
    let voxels = Key::new("occupancy").with_all(shape.parts().iter().cloned()).with_all(of_voxels(settings));
    let occupancy = work.run(Step::Voxelise, |progress| {
        let make = || Ok(voxelise(&classed.mesh, &classed.classes, settings, progress)?);
        store::reuse_or_make(work, Step::Voxelise, &voxels, |_| Ok(()), make)
    })?;
    let key = Key::new("medium").with("occupancy", voxels.digest().into());
    let medium: Medium = work.run(Step::Downsample, |_| {
        let make = || Ok(downsample(&occupancy)?);
        store::reuse_or_make(work, Step::Downsample, &key, |_| Ok(()), make)
    })?;
    drop(occupancy);
    work.hear(Event::Matter { species: work.species.to_owned(), sites: medium.nonempty_sites() as u64 });
    Ok(medium)
}

/// What the file says about the species; the grid is the downsampled medium's, set later.
pub(super) fn describe(plant: &Plant, voxels: &VoxelSettings, model: Model) -> SpeciesMeta {
    let mut meta = SpeciesMeta {
        name: plant.name.clone(),
        model,
        grid: Grid { lattice: voxels.lattice, origin_m: [0.0; 3], spacing_m: 1.0 },
        bounds_m: plant.classed.bounds().unwrap_or(Bounds { min: [0.0; 3], max: [0.0; 3] }),
        triangles: plant.classed.triangle_counts(),
        mesh_blake3: plant.classed.mesh.digest(),
        mean_light: None,
        sky_averages: None,
        sources: plant.sources.clone(),
        settings: Default::default(),
        tool: concat!("flb ", env!("CARGO_PKG_VERSION")).to_owned(),
        left_out: None,
        extra: Default::default(),
    };
    plant.record.write(&mut meta);
    meta.record(&provenance::VOXELS, voxels.voxels);
    meta.record(&provenance::IGNORE_ALPHA, voxels.ignore_alpha);
    meta
}

/// Refuses, before the long work, metadata that no file can hold: a name, a digest, a size.
pub(super) fn check_storable(meta: &SpeciesMeta) -> Result<(), BakeError> {
    let Bounds { min, max } = meta.bounds_m;
    let found_m = (0..3).map(|axis| max[axis] - min[axis]).fold(0.0, f64::max);
    let [low_m, high_m] = EXTENT_M;
    if !(low_m..=high_m).contains(&found_m) {
        return Err(BakeError::Extent { found_m, low_m, high_m });
    }
    metadata::to_bytes(meta, Place::file(0)).map(drop).map_err(BakeError::Metadata)
}

//! How a species was made, as its metadata record it ([`SpeciesMeta::settings`]): keys with the kind of their values.
//! What readers check has readers of its own: [`crate::mesh`], [`crate::material_surface`],
//! [`crate::scene_light`].
//!
//! Readers of light need none of it. A renderer reads the mesh as it was read; who bakes again compares.

use std::marker::PhantomData;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::SpeciesMeta;

/// The name of a setting whose values are of one type.
pub struct Key<T> {
    name: &'static str,
    value: PhantomData<fn() -> T>,
}

impl<T> Key<T> {
    const fn new(name: &'static str) -> Key<T> {
        Key { name, value: PhantomData }
    }

    /// Name of the setting in the metadata.
    pub const fn name(&self) -> &'static str {
        self.name
    }
}

/// Axis that points up in the mesh file: "y" or "z".
pub const UP: Key<String> = Key::new("import.up");
/// Metres per unit of the mesh file.
pub const UNIT_M: Key<f64> = Key::new("import.unit_m");
/// The one mesh of a glTF that was read.
pub const GLTF_MESH: Key<String> = Key::new("import.gltf_mesh");
/// Patterns of the nodes that were read.
pub const NODES: Key<Vec<String>> = Key::new("import.nodes");
/// Patterns by which materials were split.
pub const SPLIT: Key<Vec<String>> = Key::new("import.split");
/// Whether all vertices were taken for white.
pub const IGNORE_VERTEX_COLORS: Key<bool> = Key::new("import.ignore_vertex_colors");
/// Offset subtracted from the coordinates, metres.
pub const OFFSET_M: Key<[f64; 3]> = Key::new("import.offset_m");
/// Class of every material.
pub const CLASSES: Key<Vec<String>> = Key::new("classify.materials");
/// Voxels along an edge.
pub const VOXELS: Key<u32> = Key::new("voxelise.voxels");
/// Whether every texel of a leaf card was taken for present.
pub const IGNORE_ALPHA: Key<bool> = Key::new("voxelise.ignore_alpha");
/// Name of the solver, of the model `paper`; of `physical` where a GPU solved.
pub const SOLVER: Key<String> = Key::new("solve.solver");
/// Change of a field at which a solve ends.
pub const TOLERANCE: Key<f64> = Key::new("solve.tolerance");
/// Iterations of a solve that did a fixed number of them, of the model `paper`.
pub const STEPS: Key<u32> = Key::new("solve.steps");
/// Largest number of sweeps or passes of a solve.
pub const MAX_SWEEPS: Key<u32> = Key::new("solve.max_sweeps");
/// Parts that a site is cut into along an edge, of the model `physical`.
pub const PARTS: Key<u32> = Key::new("solve.parts");
/// Whether all solves came to an end.
pub const CONVERGED: Key<bool> = Key::new("solve.converged");
/// The factor of all extinctions, of the model `physical`.
pub const CROWN_FACTOR: Key<f64> = Key::new("crown.factor");
/// Gap fraction of the medium, of the model `physical`.
pub const CROWN_GAP: Key<f64> = Key::new("crown.gap");
/// Prefix of the names of all keys of a coding.
pub const CODING: &str = "encode.";
/// Name of the codec.
pub const CODEC: Key<String> = Key::new("encode.codec");
/// Whether pages are compressed.
pub const COMPRESS: Key<bool> = Key::new("encode.compress");
/// Size of a page before compression.
pub const PAGE_BYTES: Key<u32> = Key::new("encode.page_bytes");
/// Threshold of the codec `haar-paper`.
pub const THRESHOLD: Key<f64> = Key::new("encode.threshold");
/// PSNR that was asked for, dB.
pub const TARGET_PSNR_DB: Key<f64> = Key::new("encode.target_psnr_db");
/// Relative error that was asked for.
pub const TARGET_ERROR: Key<f64> = Key::new("encode.target_error");
/// Whether blocks without matter are coded, too.
pub const ALL_BLOCKS: Key<bool> = Key::new("encode.all_blocks");
/// PSNR at sites of surfaces, dB; null: no sample has an error.
pub const SURFACE_PSNR_DB: Key<Option<f64>> = Key::new("encode.surface_psnr_db");

impl SpeciesMeta {
    /// Whether its light was made as the papers say: of whole leaf cards, in twice as many steps as the lattice has
    /// sites along an edge.
    pub fn is_as_papers_say(&self) -> bool {
        // Steps are of the papers' model alone.
        self.recorded(&STEPS) == Some(2 * self.grid.lattice) && self.recorded(&IGNORE_ALPHA) == Some(true)
    }

    /// Records how the species was made.
    ///
    /// # Panics
    /// Never for the types of the keys above: each has a form in JSON.
    pub fn record<T: Serialize>(&mut self, key: &Key<T>, value: T) {
        let value = serde_json::to_value(value).expect("numbers, words and lists of them make JSON");
        self.settings.insert(key.name.to_owned(), value);
    }

    /// Returns the recorded value; `None` where nothing was recorded, or a value of another kind.
    pub fn recorded<T: DeserializeOwned>(&self, key: &Key<T>) -> Option<T> {
        serde_json::from_value(self.settings.get(key.name)?.clone()).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_recorded_is_read_and_what_is_of_another_kind_is_not() {
        let bytes =
            std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/golden/mesh.flb")).expect("it is committed");
        let mut meta = crate::Container::open(&bytes).expect("it opens").species()[0].meta.clone();
        meta.settings.clear();
        assert_eq!(meta.recorded(&VOXELS), None);
        meta.record(&VOXELS, 1024);
        meta.record(&NODES, vec!["oak*".to_owned()]);
        meta.record(&SURFACE_PSNR_DB, None);
        assert_eq!(meta.recorded(&VOXELS), Some(1024));
        assert_eq!(meta.recorded(&NODES), Some(vec!["oak*".to_owned()]));
        assert_eq!((meta.recorded(&SURFACE_PSNR_DB), meta.recorded(&CONVERGED)), (Some(None), None));
        meta.settings.insert(VOXELS.name().to_owned(), "many".into());
        assert_eq!(meta.recorded(&VOXELS), None);
    }
}

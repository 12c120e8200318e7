//! What a baked file says of how its mesh was read ([`flb_format::provenance`]).

use flb_format::SpeciesMeta;
use flb_format::provenance::{CLASSES, GLTF_MESH, IGNORE_VERTEX_COLORS, NODES, OFFSET_M, SPLIT, UNIT_M, UP};

use crate::import::Up;
use crate::{ImportSettings, MaterialClass, Mesh};

/// Record of how a mesh was read.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// Axis that points up in the mesh file.
    pub up: Up,
    /// Metres per unit of the mesh file.
    pub unit_m: f64,
    /// The one mesh of a glTF that was read.
    pub gltf_mesh: Option<String>,
    /// Patterns of the nodes that were read.
    pub nodes: Vec<String>,
    /// Patterns by which materials were split.
    pub split: Vec<String>,
    /// Whether all vertices were taken for white.
    pub ignore_vertex_colors: bool,
    /// Offset subtracted from the coordinates, metres.
    pub offset_m: [f64; 3],
    /// Class of every material.
    pub classes: Vec<MaterialClass>,
}

impl Record {
    /// Makes the record of a mesh read with `settings`.
    pub fn of(settings: &ImportSettings, mesh: &Mesh, classes: &[MaterialClass]) -> Record {
        Record {
            up: settings.up.unwrap_or(Up::Y),
            unit_m: settings.unit_m.unwrap_or(1.0),
            gltf_mesh: settings.gltf_mesh.clone(),
            nodes: settings.nodes.clone(),
            split: settings.split.clone(),
            ignore_vertex_colors: settings.ignore_vertex_colors,
            offset_m: mesh.offset_m,
            classes: classes.to_vec(),
        }
    }

    /// Into the metadata of a species.
    pub fn write(&self, meta: &mut SpeciesMeta) {
        meta.record(&UP, self.up.name().to_owned());
        meta.record(&UNIT_M, self.unit_m);
        meta.record(&CLASSES, self.classes.iter().map(|class| class.name().to_owned()).collect());
        for (key, patterns) in [(&NODES, &self.nodes), (&SPLIT, &self.split)] {
            if !patterns.is_empty() {
                meta.record(key, patterns.clone());
            }
        }
        if self.ignore_vertex_colors {
            meta.record(&IGNORE_VERTEX_COLORS, true);
        }
        if self.offset_m != [0.0; 3] {
            meta.record(&OFFSET_M, self.offset_m);
        }
        if let Some(mesh) = &self.gltf_mesh {
            meta.record(&GLTF_MESH, mesh.clone());
        }
    }
}

/// Returns the settings by which the mesh was read that a species was baked from.
pub fn recorded_settings(meta: &SpeciesMeta) -> ImportSettings {
    let up = match meta.recorded(&UP).as_deref() {
        Some("z") => Up::Z,
        _ => Up::Y,
    };
    let (gltf_mesh, unit_m) = (meta.recorded(&GLTF_MESH), meta.recorded(&UNIT_M));
    let [nodes, split] = [&NODES, &SPLIT].map(|key| meta.recorded(key).unwrap_or_default());
    // A file that says none was baked from coordinates as they are.
    let offset_m = Some(recorded_offset_m(meta));
    let ignore_vertex_colors = meta.recorded(&IGNORE_VERTEX_COLORS) == Some(true);
    ImportSettings { up: Some(up), unit_m, gltf_mesh, nodes, split, ignore_vertex_colors, offset_m }
}

/// Returns the offset subtracted from the coordinates of the mesh that a species was baked from, metres; zeros for
/// nothing.
pub fn recorded_offset_m(meta: &SpeciesMeta) -> [f64; 3] {
    meta.recorded(&OFFSET_M).filter(is_finite).unwrap_or_default()
}

fn is_finite(offset: &[f64; 3]) -> bool {
    offset.iter().all(|x| x.is_finite())
}

/// Classes of the materials of the mesh that a species was baked from; `None` where its file says none, or a word that
/// is none.
pub fn recorded_classes(meta: &SpeciesMeta) -> Option<Vec<MaterialClass>> {
    meta.recorded(&CLASSES)?.iter().map(|name| MaterialClass::of_name(name)).collect()
}

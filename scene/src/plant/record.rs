//! What a baked file says of how its mesh was read: keys of [`SpeciesMeta::settings`].

use std::collections::BTreeMap;

use flb_format::SpeciesMeta;
use serde_json::{Value, json};

use crate::{ImportSettings, MaterialClass, Mesh, Up};

const UP: &str = "import.up";
const UNIT: &str = "import.unit_m";
const GLTF_MESH: &str = "import.gltf_mesh";
const NODES: &str = "import.nodes";
const SPLIT: &str = "import.split";
const OFFSET: &str = "import.offset_m";
const CLASSES: &str = "classify.materials";

/// How a mesh was read.
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
    /// What was taken off the coordinates, metres.
    pub offset_m: [f64; 3],
    /// Class of every material.
    pub classes: Vec<MaterialClass>,
}

impl Record {
    /// Of a mesh read with `settings`.
    pub fn of(settings: &ImportSettings, mesh: &Mesh, classes: &[MaterialClass]) -> Record {
        Record {
            up: settings.up.unwrap_or(Up::Y),
            unit_m: settings.unit_m.unwrap_or(1.0),
            gltf_mesh: settings.gltf_mesh.clone(),
            nodes: settings.nodes.clone(),
            split: settings.split.clone(),
            offset_m: mesh.offset_m,
            classes: classes.to_vec(),
        }
    }

    /// As the settings of a file.
    pub fn settings(&self) -> BTreeMap<String, Value> {
        let names: Vec<&str> = self.classes.iter().map(|class| class.name()).collect();
        let mut settings = BTreeMap::from([
            (UP.to_owned(), json!(self.up.name())),
            (UNIT.to_owned(), json!(self.unit_m)),
            (CLASSES.to_owned(), json!(names)),
        ]);
        for (key, patterns) in [(NODES, &self.nodes), (SPLIT, &self.split)] {
            if !patterns.is_empty() {
                settings.insert(key.to_owned(), json!(patterns));
            }
        }
        if self.offset_m != [0.0; 3] {
            settings.insert(OFFSET.to_owned(), json!(self.offset_m));
        }
        settings.extend(self.gltf_mesh.iter().map(|mesh| (GLTF_MESH.to_owned(), json!(mesh))));
        settings
    }
}

/// How the mesh was read that a species was baked from.
pub fn recorded_settings(meta: &SpeciesMeta) -> ImportSettings {
    let up = match meta.settings.get(UP).and_then(Value::as_str) {
        Some("z") => Up::Z,
        _ => Up::Y,
    };
    let gltf_mesh = meta.settings.get(GLTF_MESH).and_then(Value::as_str).map(str::to_owned);
    let unit_m = meta.settings.get(UNIT).and_then(Value::as_f64);
    let list = |key: &str| {
        let patterns = meta.settings.get(key).and_then(Value::as_array).into_iter().flatten();
        patterns.filter_map(|pattern| pattern.as_str().map(str::to_owned)).collect()
    };
    let (nodes, split) = (list(NODES), list(SPLIT));
    // A file that says none was baked from coordinates as they are.
    let offset_m = Some(recorded_offset_m(meta));
    ImportSettings { up: Some(up), unit_m, gltf_mesh, nodes, split, offset_m }
}

/// What was taken off the coordinates of the mesh that a species was baked from, metres; zeros for nothing.
pub fn recorded_offset_m(meta: &SpeciesMeta) -> [f64; 3] {
    let offset = meta.settings.get(OFFSET).and_then(Value::as_array);
    let offset: Option<Vec<f64>> = offset.and_then(|list| list.iter().map(Value::as_f64).collect());
    offset.and_then(|offset| offset.try_into().ok()).filter(is_finite).unwrap_or_default()
}

fn is_finite(offset: &[f64; 3]) -> bool {
    offset.iter().all(|x| x.is_finite())
}

/// Classes of the materials of the mesh that a species was baked from; `None` where its file says none, or a word that
/// is none.
pub fn recorded_classes(meta: &SpeciesMeta) -> Option<Vec<MaterialClass>> {
    let names = meta.settings.get(CLASSES).and_then(Value::as_array)?;
    names.iter().map(|name| MaterialClass::of_name(name.as_str()?)).collect()
}

//! What a baked file says of how its mesh was read: keys of [`SpeciesMeta::settings`].

use std::collections::BTreeMap;

use flb_format::SpeciesMeta;
use serde_json::{Value, json};

use crate::{ImportSettings, MaterialClass, Up};

const UP: &str = "import.up";
const UNIT: &str = "import.unit_m";
const GLTF_MESH: &str = "import.gltf_mesh";
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
    /// Class of every material.
    pub classes: Vec<MaterialClass>,
}

impl Record {
    /// Of a mesh read with `settings`.
    pub fn of(settings: &ImportSettings, classes: &[MaterialClass]) -> Record {
        Record {
            up: settings.up.unwrap_or(Up::Y),
            unit_m: settings.unit_m.unwrap_or(1.0),
            gltf_mesh: settings.gltf_mesh.clone(),
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
    ImportSettings { up: Some(up), unit_m: meta.settings.get(UNIT).and_then(Value::as_f64), gltf_mesh }
}

/// Classes of the materials of the mesh that a species was baked from; `None` where its file says none, or a word that
/// is none.
pub fn recorded_classes(meta: &SpeciesMeta) -> Option<Vec<MaterialClass>> {
    let names = meta.settings.get(CLASSES).and_then(Value::as_array)?;
    names.iter().map(|name| MaterialClass::of_name(name.as_str()?)).collect()
}

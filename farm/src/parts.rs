//! What a species is made of: every input and setting that its file depends on, by name. From two such lists follows
//! what has changed, and which stages have to work again.

use std::collections::BTreeMap;

use flb_baker::artefact;
use flb_scene::Step;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Longest value that a message shows, in characters.
const MAX_SHOWN: usize = 60;

/// Inputs and settings of a species, each under its name.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Parts(BTreeMap<String, Value>);

/// A part that is another one than before.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// Name of the part.
    pub part: String,
    /// Value before; `None` where there was none.
    pub was: Option<Value>,
    /// Value now; `None` where there is none any more.
    pub is: Option<Value>,
}

impl Parts {
    /// Adds a part.
    pub fn add(&mut self, name: impl Into<String>, value: impl Into<Value>) {
        self.0.insert(name.into(), value.into());
    }

    /// Adds a table, a part for each of its leaves: "plant.leaf_model.water_cm". Tables of a list go by their names:
    /// "plant.surfaces.G.leaf.reflectance".
    pub fn add_table(&mut self, name: &str, value: &Value) {
        match value {
            Value::Object(table) => {
                table.iter().for_each(|(key, value)| self.add_table(&format!("{name}.{key}"), value));
            }
            Value::Array(list) if !list.is_empty() && list.iter().all(Value::is_object) => {
                for (at, value) in list.iter().enumerate() {
                    let words = ["material", "name"].map(|key| value.get(key).and_then(Value::as_str));
                    let words: Vec<&str> = words.into_iter().flatten().collect();
                    let own = match words.is_empty() {
                        true => at.to_string(),
                        false => words.join("."),
                    };
                    self.add_table(&format!("{name}.{own}"), value);
                }
            }
            leaf => self.add(name, leaf.clone()),
        }
    }

    /// Whether a file of this digest is among them.
    pub fn has_digest(&self, blake3: &str) -> bool {
        self.0.values().any(|value| value.as_str() == Some(blake3))
    }

    /// 64 hexadecimal digits, of all parts and of the version of the stages.
    pub fn key(&self) -> String {
        artefact::key("species", &[], &serde_json::json!(self.0).to_string())
    }

    /// Parts that differ from those of before, by name.
    pub fn changes(&self, before: &Parts) -> Vec<Change> {
        let names: std::collections::BTreeSet<&String> = self.0.keys().chain(before.0.keys()).collect();
        let change = |name: &String| {
            let (was, is) = (before.0.get(name).cloned(), self.0.get(name).cloned());
            (was != is).then(|| Change { part: name.clone(), was, is })
        };
        names.into_iter().filter_map(change).collect()
    }
}

impl Change {
    /// First stage that works again for it; those before it find what they made.
    pub fn first_step(&self) -> Step {
        first_step(&self.part)
    }
}

/// "plant.leaf_model.water_cm 0.01 -> 0.02". Digests are not shown.
impl std::fmt::Display for Change {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let is_digest = |value: &Value| {
            value.as_str().is_some_and(|text| text.len() == 64 && text.bytes().all(|b| b.is_ascii_hexdigit()))
        };
        let shown = |value: &Option<Value>| match value {
            None => "nothing".to_owned(),
            Some(Value::String(text)) => shortened(text),
            Some(value) => shortened(&value.to_string()),
        };
        let Change { part, was, is } = self;
        match (was, is) {
            (Some(was), Some(is)) if is_digest(was) && is_digest(is) => write!(f, "{part} has other bytes"),
            (None, Some(is)) if is_digest(is) => write!(f, "{part} is new"),
            (Some(was), None) if is_digest(was) => write!(f, "{part} is not used any more"),
            _ => write!(f, "{part} {} -> {}", shown(was), shown(is)),
        }
    }
}

fn shortened(text: &str) -> String {
    match text.char_indices().nth(MAX_SHOWN) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

/// Stages of a species, in the order in which they work.
pub const STEPS: [Step; 6] =
    [Step::Import, Step::Voxelise, Step::Crown, Step::Solve, Step::Encode, Step::Write];

/// First stage that a part changes the result of.
fn first_step(part: &str) -> Step {
    let (group, key) = part.split_once(['.', ' ']).unwrap_or((part, ""));
    let key = key.split('.').next().unwrap_or_default();
    match (group, key) {
        ("bake", "lattice" | "voxels" | "ignore_alpha") => Step::Voxelise,
        ("bake", "leaf_angles") => Step::Crown,
        ("bake", _) => Step::Solve,
        ("coding" | "name" | "species_file", _) | ("plant", "name") => Step::Encode,
        ("plant", "leaf" | "wood" | "ignore" | "ignore_alpha") => Step::Voxelise,
        ("plant", "surfaces" | "optics" | "leaf_model" | "leaf_colour" | "wood_colour") => Step::Solve,
        // Files, the way in which they are read, and the program.
        _ => Step::Import,
    }
}

/// Stages that work again for some changes, and those that find what they made.
pub fn redone(changes: &[Change]) -> (&'static [Step], &'static [Step]) {
    let place = |step: Step| STEPS.iter().position(|other| *other == step).unwrap_or(0);
    let first = changes.iter().map(|change| place(change.first_step())).min().unwrap_or(STEPS.len());
    let (reused, redone) = STEPS.split_at(first);
    (redone, reused)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn parts(of: &[(&str, Value)]) -> Parts {
        let mut parts = Parts::default();
        of.iter().for_each(|(name, value)| parts.add(*name, value.clone()));
        parts
    }

    #[test]
    fn a_table_is_a_part_for_each_of_its_leaves() {
        let mut parts = Parts::default();
        let surfaces = json!([
            { "name": "G", "leaf": { "reflectance": 0.125 } },
            { "name": "G", "material": "petal", "leaf": { "reflectance": 0.5 } },
        ]);
        parts.add_table("plant", &json!({ "surfaces": surfaces, "leaf": ["a", "b"], "nodes": [] }));
        let names: Vec<&String> = parts.0.keys().collect();
        let expected = [
            "plant.leaf",
            "plant.nodes",
            "plant.surfaces.G.leaf.reflectance",
            "plant.surfaces.G.name",
            "plant.surfaces.petal.G.leaf.reflectance",
            "plant.surfaces.petal.G.material",
            "plant.surfaces.petal.G.name",
        ];
        assert_eq!(names, expected);
    }

    #[test]
    fn a_change_tells_both_values_and_what_works_again() {
        let before =
            parts(&[("plant.surfaces.G.leaf.reflectance", json!(0.125)), ("bake.lattice", json!(64))]);
        let now = parts(&[("plant.surfaces.G.leaf.reflectance", json!(0.14)), ("bake.lattice", json!(64))]);
        let changes = now.changes(&before);
        let [change] = &changes[..] else { panic!("one change, not {changes:?}") };
        assert_eq!(change.to_string(), "plant.surfaces.G.leaf.reflectance 0.125 -> 0.14");
        let (again, reused) = redone(&changes);
        assert_eq!((again, reused.len()), (&[Step::Solve, Step::Encode, Step::Write][..], 3));
        assert_ne!(now.key(), before.key());
        assert_eq!(now.changes(&now), []);
    }

    #[test]
    fn a_file_changes_all_and_shows_no_digest() {
        let digest = |byte: char| json!(byte.to_string().repeat(64));
        let (before, now) = (
            parts(&[("mesh oak.glb", digest('a'))]),
            parts(&[("mesh oak.glb", digest('b')), ("file x", digest('c'))]),
        );
        let changes = now.changes(&before);
        let told: Vec<String> = changes.iter().map(Change::to_string).collect();
        assert_eq!(told, ["file x is new", "mesh oak.glb has other bytes"]);
        assert_eq!(redone(&changes).0, STEPS);
        assert_eq!(redone(&[]), (&[][..], &STEPS[..]));
    }
}

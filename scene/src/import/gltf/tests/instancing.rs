//! Instances of EXT_mesh_gpu_instancing: read as the nodes that they stand for, refused by node and attribute.

use super::*;
use crate::import::{Stand, WHOLE, read_stand};

/// An attribute: its name, components, and the accessor's componentType, type and normalisation.
pub(super) type Attribute<'a> = (&'a str, Vec<u8>, Value);

pub(super) fn floats(name: &'static str, kind: &str, values: &[f32]) -> Attribute<'static> {
    let lanes = if kind == "VEC4" { 4 } else { 3 };
    let json = json!({"componentType": 5126, "count": values.len() / lanes, "type": kind});
    (name, bytes_of(values), json)
}

/// The triangle with these attributes of instances at node 0.
pub(super) fn instanced(attributes: Vec<Attribute>) -> Value {
    let mut json = one_triangle();
    let mut bytes = bytes_of(TRIANGLE.as_flattened());
    let mut named = serde_json::Map::new();
    for (name, values, mut accessor) in attributes {
        let (view, index) =
            (json["bufferViews"].as_array().unwrap().len(), json["accessors"].as_array().unwrap().len());
        accessor["bufferView"] = json!(view);
        let lies = json!({"buffer": 0, "byteOffset": bytes.len(), "byteLength": values.len()});
        json["bufferViews"].as_array_mut().unwrap().push(lies);
        json["accessors"].as_array_mut().unwrap().push(accessor);
        named.insert(name.to_owned(), json!(index));
        bytes.extend(values);
        bytes.resize(bytes.len().next_multiple_of(4), 0);
    }
    json["buffers"][0] = json!({"byteLength": bytes.len(), "uri": data_uri(&bytes)});
    json["nodes"][0]["name"] = json!("grove");
    json["nodes"][0]["extensions"] = json!({"EXT_mesh_gpu_instancing": {"attributes": named}});
    json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    json
}

pub(super) fn stand_of(json: &Value) -> Result<Stand, ImportError> {
    stand_without(json, &[])
}

pub(super) fn stand_without(json: &Value, leave_out: &[&str]) -> Result<Stand, ImportError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("forest.gltf");
    fs::write(&path, json.to_string()).unwrap();
    read_stand(&path, &leave_out.iter().map(|&word| word.to_owned()).collect::<Vec<_>>(), &[])
}

fn whole(json: &Value) -> Result<Mesh, ImportError> {
    let settings = ImportSettings { gltf_mesh: Some(WHOLE.to_owned()), ..ImportSettings::default() };
    read_with("forest.gltf", json.to_string().as_bytes(), &[], &settings)
}

const TRANSLATIONS: [f32; 6] = [0.0, 0.0, 0.0, 0.0, 0.0, 7.0];

#[test]
fn instances_are_the_nodes_that_they_stand_for() {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let (turns, scales) = ([0.0, half, 0.0, half, 0.0, 0.0, 0.0, 1.0], [2.0, 2.0, 2.0, 0.5, 0.5, 0.5]);
    let mut by_extension = instanced(vec![
        floats("TRANSLATION", "VEC3", &TRANSLATIONS),
        floats("ROTATION", "VEC4", &turns),
        floats("SCALE", "VEC3", &scales),
        ("_ID", vec![1, 0, 2, 0], json!({"componentType": 5123, "count": 2, "type": "SCALAR"})),
    ]);
    by_extension["nodes"][0]["translation"] = json!([1.0, 0.0, 0.0]);
    let mut by_nodes = one_triangle();
    by_nodes["nodes"] = json!([
        {"children": [1, 2], "translation": [1.0, 0.0, 0.0]},
        {"mesh": 0, "rotation": turns[..4], "scale": [2.0, 2.0, 2.0]},
        {"mesh": 0, "translation": [0.0, 0.0, 7.0], "scale": [0.5, 0.5, 0.5]},
    ]);
    let (a, b) = (stand_of(&by_extension).unwrap(), stand_of(&by_nodes).unwrap());
    assert_eq!((&a.species, &a.plants), (&b.species, &b.plants));
    assert_eq!((a.plants[0].position_m, a.plants[1].position_m), ([1.0, 0.0, 0.0], [1.0, 0.0, 7.0]));
    let (a, b) = (whole(&by_extension).unwrap(), whole(&by_nodes).unwrap());
    assert_eq!((a.positions, a.triangles), (b.positions, b.triangles));
}

#[test]
fn a_file_of_instances_is_one_plant_only_if_that_is_said() {
    let json = instanced(vec![floats("TRANSLATION", "VEC3", &TRANSLATIONS)]);
    let error = read(&json).unwrap_err();
    assert!(error.to_string().contains("holds 2 instances (EXT_mesh_gpu_instancing)"), "{error}");
    assert!(error.to_string().ends_with("the meshes are: 'leaf'"), "{error}");
    assert_eq!(error.fault(), Fault::Usage);
    assert_eq!(whole(&json).unwrap().bounds().unwrap().max[2], 7.0);
    // A single one multiplies nothing.
    let single = instanced(vec![floats("TRANSLATION", "VEC3", &TRANSLATIONS[3..])]);
    assert_eq!(read(&single).unwrap().bounds().unwrap().max[2], 7.0);
}

#[test]
fn rotations_may_be_normalised_integers() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let of_i16: Vec<u8> = [0, 23170i16, 0, 23170].iter().flat_map(|x| x.to_le_bytes()).collect();
    for (bytes, component) in [(of_i16, 5122), (vec![0, 90, 0, 90], 5120)] {
        let json = json!({"componentType": component, "count": 1, "type": "VEC4", "normalized": true});
        let plant = stand_of(&instanced(vec![("ROTATION", bytes, json)])).unwrap().plants[0];
        let off = plant.rotation.iter().zip([0.0, half, 0.0, half]).map(|(a, b)| (a - b).abs());
        assert!(off.fold(0.0, f64::max) < 1e-12, "{plant:?}");
    }
}

#[test]
fn what_is_wrong_with_instances_is_named_by_node_and_attribute() {
    let some = || floats("TRANSLATION", "VEC3", &TRANSLATIONS);
    let with = |attribute: Attribute<'static>| instanced(vec![some(), attribute]);
    let edited = |pointer: &str, value: Value| {
        let mut json = instanced(vec![some()]);
        *json.pointer_mut(pointer).unwrap() = value;
        json
    };
    let attributes = "/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes";
    let at = "nodes[0] 'grove', EXT_mesh_gpu_instancing";
    let integers = |kind: &str, component: u32, normalized: bool| {
        let lanes = if kind == "VEC4" { 4 } else { 3 };
        let json = json!({"componentType": component, "count": 2, "type": kind, "normalized": normalized});
        (vec![0; lanes * 2 * if component == 5120 { 1 } else { 2 }], json)
    };
    let (bytes, shorts) = (integers("VEC4", 5120, false), integers("VEC3", 5122, true));
    let nan = f32::NAN;
    let table: Vec<(Value, String)> = vec![
        (
            with(floats("SCALE", "VEC3", &[1.0; 9])),
            format!("{at}: found 3 of SCALE and 2 of TRANSLATION, expected as many of each attribute"),
        ),
        (
            with(("_ID", vec![0; 8], json!({"componentType": 5125, "count": 1, "type": "SCALAR"}))),
            format!("{at}: found 2 of TRANSLATION and 1 of _ID"),
        ),
        (
            with(floats("ROTATION", "VEC3", &[0.0; 6])),
            format!("({at}, ROTATION): found type Vec3, expected [Vec4]"),
        ),
        (
            with(("ROTATION", bytes.0, bytes.1)),
            format!(
                "{at}, ROTATION: found components of I8, expected F32 or normalised I8 or normalised I16"
            ),
        ),
        (
            with(("SCALE", shorts.0, shorts.1)),
            format!("{at}, SCALE: found components of normalised I16, expected F32"),
        ),
        (
            with(floats("ROTATION", "VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0])),
            format!(
                "{at}, ROTATION of instance 1: found [0.0, 0.0, 0.0, 0.0], expected a quaternion of length 1"
            ),
        ),
        (
            with(floats("SCALE", "VEC3", &[1.0, 1.0, 1.0, 1.0, nan, 1.0])),
            format!("{at}, SCALE of instance 1: found [1.0, NaN, 1.0], expected finite numbers"),
        ),
        (
            instanced(vec![floats("TRANSLATION", "VEC3", &[f32::INFINITY, 0.0, 0.0])]),
            format!("{at}, TRANSLATION of instance 0: found [inf, 0.0, 0.0]"),
        ),
        (
            edited(attributes, json!({"SCALE": 9})),
            format!("{at}, SCALE: found accessor 9, expected one of 2"),
        ),
        (edited(attributes, json!({"_ID": 9})), format!("{at}, _ID: found accessor 9, expected one of 2")),
        (edited(attributes, json!({"SCALE": "1"})), "expected attributes that name accessors".to_owned()),
        (
            edited("/accessors/1/count", json!(1u64 << 32)),
            "count: 4294967296 is over the limit of 1048576".to_owned(),
        ),
        (
            edited("/accessors/1", json!({"componentType": 5126, "count": 1u64 << 32, "type": "VEC3"})),
            "count: 4294967296 is over the limit of 1048576".to_owned(),
        ),
        (edited("/nodes/0/mesh", Value::Null), format!("{at}: found a node without a mesh")),
    ];
    for (json, words) in table {
        for error in [whole(&json).unwrap_err(), stand_of(&json).unwrap_err()] {
            let text = error.to_string();
            assert!(text.starts_with("forest.gltf: ") && text.contains(&words), "{words}: {text}");
        }
    }
}

#[test]
fn a_count_that_a_file_merely_claims_costs_nothing() {
    // Attributes that are not read and accessors without bytes state counts for nothing.
    let claims = json!({"componentType": 5126, "count": 1 << 20, "type": "VEC3"});
    let mut json = instanced(vec![floats("TRANSLATION", "VEC3", &TRANSLATIONS)]);
    json["accessors"][1] = claims;
    json["nodes"] = (0..64).map(|_| json["nodes"][0].clone()).collect();
    json["scenes"][0]["nodes"] = (0..64).collect();
    let error = stand_of(&json).unwrap_err();
    assert!(error.to_string().contains("nodes and instances visited"), "{error}");
    assert_eq!(error.fault(), Fault::Limit);
}

#[test]
fn a_rotation_of_zeros_is_taken_as_none_with_a_warning() {
    let mesh = read(&changed(&[("/nodes/0/rotation", json!([0.0, 0.0, 0.0, 0.0]))])).unwrap();
    assert_eq!(mesh.positions, TRIANGLE);
    assert!(
        mesh.warnings[0].contains("nodes[0] has a rotation of zeros; taken as none"),
        "{:?}",
        mesh.warnings
    );
}

#[test]
fn colours_of_instances_are_warned_of_by_name() {
    let with = |name: &'static str| {
        whole(&instanced(vec![
            floats("TRANSLATION", "VEC3", &TRANSLATIONS),
            floats(name, "VEC3", &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0]),
        ]))
        .unwrap()
        .warnings
        .join("\n")
    };
    let told = with("_COLOR_0");
    assert!(told.contains("_COLOR_0 (nodes[0]) is not read: all instances have the colours"), "{told}");
    assert_eq!(with("_ID"), "");
}

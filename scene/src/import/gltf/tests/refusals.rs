//! What is refused, and in which words.

use super::*;

#[test]
fn required_extensions_are_refused_by_name() {
    for name in ["KHR_draco_mesh_compression", "KHR_texture_basisu", "ACME_secret"] {
        let error = read(&changed(&[("/extensionsRequired", json!([name]))])).unwrap_err();
        assert!(error.to_string().contains(name), "{error}");
        assert_eq!(error.fault(), Fault::Unsupported);
    }
    read(&changed(&[("/extensionsUsed", json!(["ACME_secret"]))])).unwrap();
}

#[test]
fn extras_may_be_of_any_kind() {
    for extras in [json!("text"), json!(3), json!(null), json!([1, 2]), json!({"a": {"b": 1}})] {
        read(&changed(&[("/nodes/0/extras", extras.clone()), ("/asset/extras", extras)])).unwrap();
    }
}

#[test]
fn other_versions_are_refused() {
    let error = read(&changed(&[("/asset/version", json!("1.0"))])).unwrap_err();
    assert_eq!(error.to_string(), "plant.gltf: glTF version 1.0, expected 2.x");
}

#[test]
fn hostile_files_end_in_an_error_that_names_the_place() {
    let huge = 4_000_000_000u64;
    let table: Vec<(Vec<(&str, Value)>, &str)> = vec![
        (vec![("/nodes/0/children", json!([0]))], "a node below itself"),
        (vec![("/nodes/0/children", json!([7]))], "node 7"),
        (vec![("/scenes/0/nodes/0", json!(7))], "node 7"),
        (vec![("/scene", json!(3))], "scene: found 3"),
        (vec![("/nodes/0/mesh", json!(9))], "mesh 9"),
        (vec![("/nodes/0/scale", json!([1e39, 1.0, 1.0]))], "number out of range"),
        (vec![("/meshes/0/primitives/0/material", json!(4))], "material 4"),
        (vec![("/meshes/0/primitives/0/attributes/POSITION", json!(8))], "accessor 8"),
        (vec![("/meshes/0/primitives/0/mode", json!(77))], "unknown mode"),
        (vec![("/accessors/0/count", json!(4))], "to end within the view's 36 bytes"),
        (vec![("/accessors/0/count", json!(u64::MAX))], "over the limit"),
        (vec![("/accessors/0/count", json!(huge))], "to end within"),
        (
            vec![("/accessors/0", json!({"componentType": 5126, "count": huge, "type": "VEC3"}))],
            "an accessor without bufferView",
        ),
        (vec![("/accessors/0/count", json!(0))], "no triangle is left"),
        (vec![("/accessors/0/componentType", json!(1))], "unknown componentType"),
        (vec![("/accessors/0/type", json!("VEC9"))], "unknown type"),
        (vec![("/accessors/0/type", json!("VEC2"))], "type Vec2"),
        (vec![("/accessors/0/bufferView", json!(5))], "bufferView 5"),
        (vec![("/accessors/0/byteOffset", json!(u64::MAX))], "to end within"),
        (vec![("/bufferViews/0/byteStride", json!(4))], "byteStride 4"),
        (vec![("/bufferViews/0/byteLength", json!(37))], "to end within the 36"),
        (vec![("/bufferViews/0/byteOffset", json!(u64::MAX))], "to end within the 36"),
        (vec![("/bufferViews/0/buffer", json!(2))], "buffer 2"),
        (vec![("/buffers/0/byteLength", json!(37))], "byteLength 37"),
        (vec![("/buffers/0", json!({"byteLength": 36}))], "which has no data"),
        (vec![("/buffers/0/uri", json!("data:nothing"))], "a data URI"),
        (vec![("/buffers/0/uri", json!("data:;base64,!!!!"))], "does not decode"),
        (vec![("/nodes/0/extensions", json!({"EXT_mesh_gpu_instancing": 3}))], "EXT_mesh_gpu_instancing"),
        (vec![("/nodes/0/skin", json!(3))], "no error"),
    ];
    for (changes, words) in table {
        match read(&changed(&changes)) {
            Ok(_) if words == "no error" => {}
            Ok(_) => panic!("{changes:?} was taken"),
            Err(error) => assert!(error.to_string().contains(words), "{changes:?}: {error}"),
        }
    }
}

#[test]
fn an_index_out_of_range_is_named() {
    let mut bytes = bytes_of(TRIANGLE.as_flattened());
    bytes.extend([0, 1, 3]);
    let json = changed(&[
        ("/buffers/0", json!({"byteLength": 39, "uri": data_uri(&bytes)})),
        ("/bufferViews/1", json!({"buffer": 0, "byteOffset": 36, "byteLength": 3})),
        ("/accessors/1", json!({"bufferView": 1, "componentType": 5121, "count": 3, "type": "SCALAR"})),
        ("/meshes/0/primitives/0/indices", json!(1)),
    ]);
    let error = read(&json).unwrap_err().to_string();
    assert_eq!(error, "plant.gltf: meshes[0].primitives[0], index 2: found vertex 3, expected one of 3");
}

#[test]
fn a_vertex_that_is_not_a_number_is_named() {
    let mut corners = TRIANGLE;
    corners[1][2] = f32::NAN;
    let json = changed(&[("/buffers/0/uri", json!(data_uri(&bytes_of(corners.as_flattened()))))]);
    let error = read(&json).unwrap_err();
    assert!(error.to_string().contains("meshes[0].primitives[0], vertex 1"), "{error}");
    assert_eq!(error.fault(), Fault::Input);
}

#[test]
fn a_deep_chain_of_nodes_needs_no_deep_stack() {
    let depth = 100_000;
    let mut nodes: Vec<Value> = (0..depth).map(|i| json!({"children": [i + 1]})).collect();
    nodes.push(json!({"mesh": 0}));
    let mesh = read(&changed(&[("/nodes", json!(nodes))])).unwrap();
    assert_eq!(mesh.triangles.len(), 1);
}

#[test]
fn a_tree_that_doubles_at_every_node_is_over_the_limit() {
    let mut nodes: Vec<Value> = (0..60).map(|i| json!({"children": [i + 1, i + 1]})).collect();
    nodes.push(json!({"mesh": 0}));
    let error = read(&changed(&[("/nodes", json!(nodes))])).unwrap_err();
    assert_eq!(error.fault(), Fault::Limit, "{error}");
}

#[test]
fn json_that_nests_or_multiplies_without_end_is_refused() {
    let (open, close) = ("[".repeat(5000), "]".repeat(5000));
    let deep = format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"nodes\":[{{\"extensions\":{{\"x\":{open}{close}}}}}]}}"
    );
    let error = read_with("a.gltf", deep.as_bytes(), &[], &ImportSettings::default()).unwrap_err();
    assert!(matches!(error, ImportError::Syntax { .. }), "{error}");
    let wide = format!("{{\"asset\":{{\"version\":\"2.0\"}},\"nodes\":[{}{{}}]}}", "{},".repeat(1_100_000));
    let error = read_with("a.gltf", wide.as_bytes(), &[], &ImportSettings::default()).unwrap_err();
    assert_eq!(error.fault(), Fault::Limit, "{error}");
    let error = read_with("a.gltf", b"{\"asset\": 3}", &[], &ImportSettings::default()).unwrap_err();
    assert!(error.to_string().contains("line 1 column"), "{error}");
}

#[test]
fn what_is_no_mesh_is_refused_by_kind() {
    let error = read_with("plant.fbx", b"Kaydara", &[], &ImportSettings::default()).unwrap_err();
    assert!(error.to_string().contains("extension 'fbx'"), "{error}");
    let folder = tempfile::tempdir().unwrap();
    let error = import(folder.path(), &ImportSettings::default()).unwrap_err();
    assert!(error.to_string().contains("not a regular file"), "{error}");
    let error = import(&folder.path().join("none.glb"), &ImportSettings::default()).unwrap_err();
    assert_eq!(error.fault(), Fault::Io);
}

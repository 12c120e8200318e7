//! One mesh of a file of several.

use super::*;

/// Meshes `Oak`, one without a name, and two of the name `Fir`, each a triangle of its own height and moved by its
/// node.
pub(super) fn four_meshes() -> Value {
    let mut json = one_triangle();
    let heights = [1.0f32, 2.0, 3.0, 4.0];
    let bytes: Vec<u8> =
        heights.iter().flat_map(|y| bytes_of(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, *y, 0.0])).collect();
    json["buffers"][0] = json!({"byteLength": bytes.len(), "uri": data_uri(&bytes)});
    let mesh = |index: usize, name: &str| {
        let mut mesh = json!({"primitives": [{"attributes": {"POSITION": index}}]});
        if !name.is_empty() {
            mesh["name"] = json!(name);
        }
        mesh
    };
    json["meshes"] = ["Oak", "", "Fir", "Fir"].iter().enumerate().map(|(i, name)| mesh(i, name)).collect();
    json["bufferViews"] =
        (0..4).map(|i| json!({"buffer": 0, "byteOffset": 36 * i, "byteLength": 36})).collect();
    json["accessors"] =
        (0..4).map(|i| json!({"bufferView": i, "componentType": 5126, "count": 3, "type": "VEC3"})).collect();
    json["nodes"] =
        (0..4).map(|i| json!({"mesh": i, "translation": [10.0 * f64::from(i), 0.0, 5.0]})).collect();
    json["scenes"][0]["nodes"] = json!([0, 1, 2, 3]);
    json
}

fn read_mesh(json: &Value, word: &str) -> Result<Mesh, ImportError> {
    let settings = ImportSettings { gltf_mesh: Some(word.to_owned()), ..ImportSettings::default() };
    read_with("forest.gltf", json.to_string().as_bytes(), &[], &settings)
}

#[test]
fn a_mesh_by_itself_has_the_shape_that_its_nodes_agree_on() {
    let mut json = four_meshes();
    json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": 3}]);
    json["meshes"][0]["weights"] = json!([0.0]);
    json["nodes"][1]["mesh"] = json!(0);
    let top = |json: &Value| read_mesh(json, "Oak").unwrap().bounds().unwrap().max[1];
    assert_eq!(top(&json), 1.0);
    for node in [0, 1] {
        json["nodes"][node]["weights"] = json!([0.5]);
    }
    assert_eq!(top(&json), 3.0);
    assert!(read_mesh(&json, "Oak").unwrap().warnings.is_empty());
    json["nodes"][1]["weights"] = json!([1.0]);
    assert_eq!(top(&json), 1.0);
    let words = "mesh 'Oak' has other weights of its morph targets at nodes[1] than at nodes[0]";
    for warnings in
        [read_mesh(&json, "Oak").unwrap().warnings, super::instancing::stand_of(&json).unwrap().warnings]
    {
        assert!(warnings.iter().any(|warning| warning.contains(words)), "{warnings:?}");
    }
}

#[test]
fn a_mesh_is_read_in_its_own_space_by_name_or_number() {
    let json = four_meshes();
    for (word, height) in [("Oak", 1.0), ("#0", 1.0), ("#1", 2.0), ("#2", 3.0), ("#3", 4.0)] {
        let mesh = read_mesh(&json, word).unwrap();
        assert_eq!(mesh.positions, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, height, 0.0]], "{word}");
        assert_eq!(mesh.materials.len(), 1, "{word}");
    }
    assert_eq!(read_mesh(&json, "*").unwrap().positions, read(&json).unwrap().positions);
    assert_eq!(read(&json).unwrap().triangles.len(), 4);
}

#[test]
fn a_mesh_may_be_read_though_nothing_shows_it_and_the_node_tree_is_no_tree() {
    let mut json = four_meshes();
    json["nodes"] = json!([{"children": [0], "mesh": 0}]);
    json["scenes"][0]["nodes"] = json!([0]);
    assert!(read(&json).unwrap_err().to_string().contains("a node below itself"));
    assert_eq!(read_mesh(&json, "#3").unwrap().positions[2][1], 4.0);
}

#[test]
fn a_skin_does_not_move_a_mesh_by_itself_and_axes_and_unit_do() {
    let mut json = four_meshes();
    json["nodes"][0]["skin"] = json!(7);
    let settings = ImportSettings {
        gltf_mesh: Some("Oak".to_owned()),
        up: Some(Up::Z),
        unit_m: Some(10.0),
        ..ImportSettings::default()
    };
    let mesh = read_with("forest.gltf", json.to_string().as_bytes(), &[], &settings).unwrap();
    assert_eq!(mesh.positions[2], [0.0, 0.0, -10.0]);
    assert!(mesh.warnings.is_empty(), "{:?}", mesh.warnings);
}

#[test]
fn a_word_that_means_no_mesh_or_several_is_refused_with_those_that_would_do() {
    let json = four_meshes();
    let all = "the meshes are: 'Oak', '#1', #2 ('Fir'), #3 ('Fir')";
    for (word, found) in [
        ("Elm", "gltf_mesh 'Elm': no mesh has this name; "),
        ("", "gltf_mesh '': no mesh has this name; "),
        ("Fir", "gltf_mesh 'Fir': 2 meshes have this name; "),
        ("#4", "gltf_mesh '#4': no mesh has this number, of 0 to 3; "),
        ("#-1", "gltf_mesh '#-1': no mesh has this number, of 0 to 3; "),
    ] {
        let error = read_mesh(&json, word).unwrap_err();
        assert_eq!(error.to_string(), format!("forest.gltf: --gltf-mesh or {found}{all}"));
        assert_eq!(error.fault(), Fault::Usage);
    }
    let mut many = json.clone();
    many["meshes"] = (0..100).map(|i| json!({"name": format!("m{i}"), "primitives": []})).collect();
    let error = read_mesh(&many, &"x".repeat(100_000)).unwrap_err().to_string();
    assert!(error.ends_with("'m19', and 80 more") && error.len() < 1000, "{error}");
    many["meshes"] = json!([]);
    assert!(read_mesh(&many, "Oak").unwrap_err().to_string().ends_with("the meshes are: none"));
}

#[test]
fn an_obj_has_no_such_meshes() {
    let settings = ImportSettings { gltf_mesh: Some("Oak".to_owned()), ..ImportSettings::default() };
    let error = read_with("a.obj", b"v 0 0 0\n", &[], &settings).unwrap_err();
    assert_eq!(error.to_string(), "gltf_mesh: found 'Oak' for a.obj, an OBJ, expected a glTF or GLB file");
}

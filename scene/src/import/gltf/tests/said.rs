//! What a glTF says beside its triangles: colours and morphs of vertices, what it hides, where it stands, which parts
//! one material serves, and how much of a surface is there.

use glam::DVec3;

use super::*;
use crate::alpha::Coverage;
use crate::classify::{ClassRules, classify};
use crate::{MaterialClass, PlantReader};

/// `json` with accessors added to its buffer, from index 1 on.
pub(super) fn with_accessors(mut json: Value, accessors: Vec<(Vec<u8>, Value)>) -> Value {
    let mut bytes = bytes_of(TRIANGLE.as_flattened());
    for (values, mut accessor) in accessors {
        let view = json["bufferViews"].as_array().unwrap().len();
        let lies = json!({"buffer": 0, "byteOffset": bytes.len(), "byteLength": values.len()});
        json["bufferViews"].as_array_mut().unwrap().push(lies);
        accessor["bufferView"] = json!(view);
        json["accessors"].as_array_mut().unwrap().push(accessor);
        bytes.extend(values);
        bytes.resize(bytes.len().next_multiple_of(4), 0);
    }
    json["buffers"][0] = json!({"byteLength": bytes.len(), "uri": data_uri(&bytes)});
    json
}

pub(super) fn float(count: usize, kind: &str) -> Value {
    json!({"componentType": 5126, "count": count, "type": kind})
}

#[test]
fn colours_of_vertices_multiply_those_of_the_material() {
    let of_bytes = [255u8, 0, 0, 255, 0, 255, 0, 255, 0, 0, 51, 255];
    let of_shorts: Vec<u8> =
        of_bytes.iter().flat_map(|&byte| (u16::from(byte) * 257).to_le_bytes()).collect();
    let of_floats = bytes_of(&of_bytes.map(|byte| f32::from(byte) / 255.0));
    let kinds = [
        (of_bytes.to_vec(), json!({"componentType": 5121, "normalized": true, "count": 3, "type": "VEC4"})),
        (of_bytes.to_vec(), json!({"componentType": 5121, "count": 3, "type": "VEC4"})),
        (of_shorts, json!({"componentType": 5123, "normalized": true, "count": 3, "type": "VEC4"})),
        (of_floats, float(3, "VEC4")),
    ];
    for (values, accessor) in kinds {
        let json = changed(&[
            ("/meshes/0/primitives/0/attributes/COLOR_0", json!(1)),
            ("/meshes/0/primitives/0/material", json!(0)),
            ("/materials", json!([{"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1.0]}}])),
        ]);
        let mesh = read(&with_accessors(json, vec![(values, accessor)])).unwrap();
        assert_eq!(mesh.colors, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.2]]);
        assert!((mesh.vertex_color(0, [0.25, 0.5]) - glam::Vec3::new(0.25, 0.25, 0.1)).length() < 1e-6);
        let mean = crate::color::mean_colors(&mesh, &[Coverage::Full])[0];
        assert!((mean - glam::Vec3::new(0.5, 0.5, 0.1) / 3.0).length() < 2e-3, "{mean}");
    }
    let wrong = changed(&[("/meshes/0/primitives/0/attributes/COLOR_0", json!(1))]);
    let large = with_accessors(wrong.clone(), vec![(bytes_of(&[200.0; 9]), float(3, "VEC3"))]);
    assert!(
        read(&large).unwrap().warnings[0].contains("a vertex has the colour 200 200 200, expected shares")
    );
    let three = with_accessors(wrong.clone(), vec![(bytes_of(&[0.5; 9]), float(3, "VEC3"))]);
    assert_eq!(read(&three).unwrap().colors, [[0.5; 3]; 3]);
    let signed = json!({"componentType": 5120, "count": 3, "type": "VEC3"});
    let error = read(&with_accessors(wrong, vec![(vec![1; 12], signed)])).unwrap_err().to_string();
    assert!(error.contains("COLOR_0: found components of I8, expected F32"), "{error}");
}

#[test]
fn a_red_tree_by_its_vertices_is_a_red_tree() {
    let red = |json: Value| {
        let mut mesh = read(&json).unwrap();
        mesh.materials[0].name = "leaves".to_owned();
        let (classed, _) = PlantReader::default().class(mesh).unwrap();
        PlantReader::default().plant("red".to_owned(), classed)
    };
    let by_factor = red(changed(&[
        ("/meshes/0/primitives/0/material", json!(0)),
        ("/materials", json!([{"pbrMetallicRoughness": {"baseColorFactor": [0.6, 0.05, 0.03, 1.0]}}])),
    ]));
    let attribute = changed(&[("/meshes/0/primitives/0/attributes/COLOR_0", json!(1))]);
    let by_vertex =
        red(with_accessors(attribute, vec![(bytes_of(&[[0.6, 0.05, 0.03]; 3].concat()), float(3, "VEC3"))]));
    let shown = |plant: &crate::Plant| plant.colors[0].as_ref().unwrap().shown.clone();
    for (a, b) in shown(&by_factor).iter().zip(shown(&by_vertex)) {
        assert!((a.reflectance - b.reflectance).abs() < 1e-6, "{a:?} {b:?}");
    }
    assert!(shown(&by_vertex)[0].reflectance > 10.0 * shown(&by_vertex)[1].reflectance);
}

#[test]
fn colours_of_vertices_are_left_out_where_that_is_asked_for() {
    let attribute = changed(&[("/meshes/0/primitives/0/attributes/COLOR_0", json!(1))]);
    let json =
        with_accessors(attribute, vec![(bytes_of(&[[0.6, 0.05, 0.0, 0.2]; 3].concat()), float(3, "VEC4"))]);
    let ignored = ImportSettings { ignore_vertex_colors: true, ..ImportSettings::default() };
    let mesh = read_with("plant.gltf", json.to_string().as_bytes(), &[], &ignored).unwrap();
    assert!(mesh.colors.is_empty() && read(&json).unwrap().colors.len() == 3);
    let white = read(&one_triangle()).unwrap();
    assert_eq!((&mesh.materials, mesh.digest()), (&white.materials, white.digest()));
}

#[test]
fn morph_weights_of_a_node_go_before_those_of_its_mesh() {
    let moved = bytes_of(&[0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 3.0, 0.0]);
    let morphed = |changes: &[(&str, Value)]| {
        let targets = [("/meshes/0/primitives/0/targets", json!([{"POSITION": 1}]))];
        read(&with_accessors(changed(&[&targets, changes].concat()), vec![(moved.clone(), float(3, "VEC3"))]))
            .unwrap()
    };
    let top = |mesh: &Mesh| mesh.bounds().unwrap().max[1];
    assert_eq!(top(&morphed(&[])), 2.0);
    assert_eq!(top(&morphed(&[("/meshes/0/weights", json!([1.0]))])), 5.0);
    assert_eq!(top(&morphed(&[("/nodes/0/weights", json!([0.5]))])), 3.5);
    let both = morphed(&[("/meshes/0/weights", json!([1.0])), ("/nodes/0/weights", json!([0.0]))]);
    assert_eq!(top(&both), 2.0);
    assert!(both.warnings.is_empty() && both.notes.is_empty(), "{:?}", both.warnings);
}

#[test]
fn joints_of_all_sets_move_a_vertex() {
    let json = changed(&[
        ("/nodes/0", json!({"mesh": 0, "skin": 0})),
        ("/nodes/1", json!({"translation": [8.0, 0.0, 0.0]})),
        ("/nodes/2", json!({"translation": [0.0, 8.0, 0.0]})),
        ("/scenes/0/nodes", json!([0, 1, 2])),
        ("/skins", json!([{"joints": [1, 2]}])),
        (
            "/meshes/0/primitives/0/attributes",
            json!({"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2, "JOINTS_1": 3, "WEIGHTS_1": 2}),
        ),
    ]);
    let bytes = json!({"componentType": 5121, "count": 3, "type": "VEC4"});
    let half = bytes_of(&[[0.5f32, 0.0, 0.0, 0.0]; 3].concat());
    let second = [[1u8, 0, 0, 0]; 3].concat();
    let accessors = vec![(vec![0; 12], bytes.clone()), (half, float(3, "VEC4")), (second, bytes)];
    let mesh = read(&with_accessors(json, accessors)).unwrap();
    assert_eq!(mesh.bounds().unwrap().min, [4.0, 4.0, 0.0]);
}

#[test]
fn what_a_file_hides_is_left_out_and_counted() {
    let hidden = json!({"KHR_node_visibility": {"visible": false}});
    let json = changed(&[
        ("/scenes/0/nodes", json!([0, 1, 3])),
        ("/nodes/1", json!({"children": [2], "extensions": hidden.clone()})),
        ("/nodes/2", json!({"mesh": 0, "name": "old crown", "translation": [0.0, 5.0, 0.0]})),
        (
            "/nodes/3",
            json!({"mesh": 0, "name": "shown", "translation": [0.0, 0.0, 1.0], "extensions": {"KHR_node_visibility": {"visible": true}}}),
        ),
        ("/extensionsRequired", json!(["KHR_node_visibility"])),
    ]);
    let mesh = read(&json).unwrap();
    assert_eq!((mesh.bounds().unwrap().max[1], mesh.parts.len()), (2.0, 2));
    assert!(
        mesh.notes[0].contains("1 node with a mesh is left out as hidden (KHR_node_visibility): 'old crown'")
    );
    let chosen = ImportSettings { nodes: vec!["Old*".to_owned()], ..ImportSettings::default() };
    let mesh = read_with("plant.gltf", json.to_string().as_bytes(), &[], &chosen).unwrap();
    assert_eq!(mesh.bounds().unwrap().min[1], 5.0, "a choice goes before what the file hides");
    let all = changed(&[("/nodes/0/extensions", hidden)]);
    let error = read(&all).unwrap_err().to_string();
    let expected = "no triangle is left (it shows none: 1 node with a mesh is left out as hidden";
    assert!(error.contains(expected), "{error}");
    let bad = changed(&[("/nodes/0/extensions", json!({"KHR_node_visibility": {"visible": "no"}}))]);
    assert!(read(&bad).unwrap_err().to_string().contains("KHR_node_visibility"));
}

#[test]
fn lower_levels_of_detail_are_left_out() {
    let json = changed(&[
        ("/scenes/0/nodes", json!([0, 1, 2])),
        ("/nodes/0/extensions", json!({"MSFT_lod": {"ids": [1, 2]}})),
        ("/nodes/1", json!({"mesh": 0, "name": "middle", "translation": [0.0, 7.0, 0.0]})),
        ("/nodes/2", json!({"children": [3]})),
        ("/nodes/3", json!({"mesh": 0, "translation": [0.0, 9.0, 0.0]})),
        ("/extensionsUsed", json!(["MSFT_lod"])),
    ]);
    let mesh = read(&json).unwrap();
    assert_eq!(mesh.triangles.len(), 1);
    assert!(
        mesh.notes.iter().any(|note| note.contains("lower levels of detail (MSFT_lod): 'middle'")),
        "{:?}",
        mesh.notes
    );
}

#[test]
fn what_is_in_another_scene_or_in_none_is_told() {
    let nodes = [
        ("/scenes", json!([{"nodes": [0]}, {"name": "winter", "nodes": [1]}])),
        ("/nodes/1", json!({"mesh": 0, "name": "bare"})),
        ("/nodes/2", json!({"children": [3, 4]})),
        ("/nodes/3", json!({"mesh": 0, "name": "spare", "translation": [0.0, 7.0, 0.0]})),
        ("/nodes/4", json!({"name": "without a mesh"})),
        ("/nodes/5", json!({"mesh": 0, "name": "far"})),
        ("/nodes/0/extensions", json!({"MSFT_lod": {"ids": [5]}})),
    ];
    let mut json = changed(&nodes);
    json.as_object_mut().unwrap().remove("scene");
    let mesh = read(&json).unwrap();
    assert_eq!(mesh.triangles.len(), 1);
    let said = |all: &[String], part: &str| assert!(all.iter().any(|one| one.contains(part)), "{all:?}");
    said(
        &mesh.warnings,
        "scene 0 of 2 is read, as the file names no default, not scene 1 'winter'; --node chooses nodes of any",
    );
    said(&mesh.notes, "1 node with a mesh is left out as parts of no scene: 'spare'; --node chooses nodes");
    said(&mesh.notes, "1 node with a mesh is left out as lower levels of detail (MSFT_lod): 'far'");
    said(&read(&changed(&nodes)).unwrap().warnings, "scene 0 of 2 is read, not scene 1 'winter'");
    // Who chooses knows.
    let chosen = ImportSettings { nodes: vec!["spare".to_owned()], ..ImportSettings::default() };
    let mesh = read_with("plant.gltf", changed(&nodes).to_string().as_bytes(), &[], &chosen).unwrap();
    assert_eq!((mesh.bounds().unwrap().min[1], mesh.notes.len()), (7.0, 0));
    assert!(mesh.warnings.is_empty(), "{:?}", mesh.warnings);
}

#[test]
fn nodes_are_chosen_with_all_below_them() {
    let json = changed(&[
        ("/scenes", json!([{"nodes": [0, 1]}, {"nodes": [3]}])),
        ("/nodes/0/name", json!("Oak_LOD0")),
        ("/nodes/1", json!({"name": "Oak_LOD1", "children": [2], "translation": [3.0, 0.0, 0.0]})),
        ("/nodes/2", json!({"mesh": 0})),
        ("/nodes/3", json!({"name": "Elsewhere", "mesh": 0, "translation": [0.0, 0.0, 9.0]})),
    ]);
    let chosen = |words: &[&str]| {
        let nodes = words.iter().map(|&word| word.to_owned()).collect();
        let settings = ImportSettings { nodes, ..ImportSettings::default() };
        read_with("plant.gltf", json.to_string().as_bytes(), &[], &settings)
    };
    let low = |mesh: Mesh| mesh.bounds().unwrap().min;
    assert_eq!(low(chosen(&["oak_lod0"]).unwrap()), [0.0; 3]);
    assert_eq!(low(chosen(&["*LOD1"]).unwrap()), [3.0, 0.0, 0.0]);
    assert_eq!(low(chosen(&["#2"]).unwrap()), [3.0, 0.0, 0.0]);
    assert_eq!(low(chosen(&["Elsewhere"]).unwrap()), [0.0, 0.0, 9.0], "another scene's node");
    assert_eq!(chosen(&["Oak*"]).unwrap().triangles.len(), 2);
    let error = chosen(&["Oak*", "pine"]).unwrap_err();
    assert_eq!(error.fault(), Fault::Usage);
    assert!(
        error.to_string().contains("--node 'pine' means no node or group; there are: 'Oak_LOD0'"),
        "{error}"
    );
}

#[test]
fn a_plant_far_from_the_origin_keeps_its_shape_and_tells_its_offset() {
    let near = read(&one_triangle()).unwrap();
    for offset in [[200.0, 0.0, 0.0], [448262.0, 318.0, -5411932.0], [0.0, 3.0e7, -16777216.0]] {
        let mesh = read(&changed(&[("/nodes/0/translation", json!(offset))])).unwrap();
        assert!((area_of(&mesh) - area_of(&near)).abs() < 1e-6, "{offset:?}: {}", area_of(&mesh));
        assert!(mesh.bounds().unwrap().max.iter().all(|x| x.abs() < 3.0));
        let at = |mesh: &Mesh, offset: [f64; 3]| {
            DVec3::from_array(mesh.positions[0].map(f64::from)) + DVec3::from_array(offset)
        };
        assert_eq!(at(&mesh, mesh.offset_m), at(&near, offset));
        assert!(mesh.notes[0].contains("m (x, y up, z), too far off"), "{:?}", mesh.notes);
    }
    let cancelled = changed(&[
        ("/scenes/0/nodes/0", json!(1)),
        ("/nodes/0/translation", json!([448262.25, 318.0, -5411932.125])),
        ("/nodes/1", json!({"children": [0], "translation": [-448262.0, -318.0, 5411932.0]})),
    ]);
    let mesh = read(&cancelled).unwrap();
    assert_eq!(mesh.offset_m, [0.0; 3]);
    assert_eq!(mesh.positions[0], [0.25, 0.0, -0.125]);
    let asked = ImportSettings { offset_m: Some([1.0, 2.0, 3.0]), ..ImportSettings::default() };
    let mesh = read_with("a.gltf", one_triangle().to_string().as_bytes(), &[], &asked).unwrap();
    assert_eq!(mesh.positions[0], [-1.0, -2.0, -3.0]);
}

#[test]
fn a_shape_that_f32_lost_is_refused_with_both_numbers() {
    let far = |add: f32| {
        let moved: Vec<f32> = TRIANGLE.iter().flat_map(|[x, y, z]| [x + add, *y, *z]).collect();
        read(&changed(&[("/buffers/0", json!({"byteLength": 36, "uri": data_uri(&bytes_of(&moved))}))]))
    };
    let mesh = far(1000.0).unwrap();
    assert_eq!(mesh.offset_m, [1001.0, 0.0, 0.0].map(|x: f64| if x > 0.0 { mesh.offset_m[0] } else { x }));
    let error = far(4.0e6).unwrap_err().to_string();
    assert!(error.contains("whose steps are 0.25 there, and edges of 1.83 in the mean"), "{error}");
    assert!(error.contains("export the plant near its origin"), "{error}");
}

#[test]
fn compressed_geometry_is_refused_by_name_although_not_required() {
    for extension in ["KHR_draco_mesh_compression", "ACME_mesh_zip"] {
        let json = changed(&[
            ("/meshes/0/primitives/0/extensions", json!({extension: {"bufferView": 0}})),
            ("/accessors/0", float(3, "VEC3")),
        ]);
        let error = read(&json).unwrap_err();
        assert_eq!(error.fault(), Fault::Unsupported);
        let error = error.to_string();
        assert!(error.contains(extension) && error.contains("gltf-transform copy"), "{error}");
        // Beside a fallback that is not compressed, it is not needed.
        let fallback =
            changed(&[("/meshes/0/primitives/0/extensions", json!({extension: {"bufferView": 0}}))]);
        assert_eq!(read(&fallback).unwrap().triangles.len(), 1);
    }
}

/// Two triangles of one material, in nodes of these names.
fn atlas(names: [&str; 2], material: Value) -> Value {
    changed(&[
        ("/scenes/0/nodes", json!([0, 1])),
        ("/meshes/0/name", json!("Mesh.001")),
        ("/meshes/0/primitives/0/material", json!(0)),
        ("/nodes/0/name", json!(names[0])),
        ("/nodes/1", json!({"mesh": 0, "name": names[1], "translation": [0.0, 0.0, 1.0]})),
        ("/materials", json!([material])),
    ])
}

#[test]
fn an_atlas_is_split_by_the_names_of_what_it_serves() {
    let image = data_uri(&png(8, 8, |x| if x < 4 { 0 } else { 255 }));
    let mut json = atlas(
        ["Trunk", "Leaves"],
        json!({"name": "Tree", "alphaMode": "MASK", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}),
    );
    json["images"] = json!([{"uri": image}]);
    json["textures"] = json!([{"source": 0}]);
    let mesh = read(&json).unwrap();
    assert_eq!(
        mesh.materials.iter().map(|material| material.name.as_str()).collect::<Vec<_>>(),
        ["Tree", "Tree"]
    );
    let decided = classify(&mesh, &ClassRules::default()).unwrap();
    let class_of = |label: &str| {
        let part = mesh.parts.iter().find(|part| part.label() == label).unwrap();
        decided[part.uses[0].material as usize].class
    };
    assert_eq!((class_of("Trunk"), class_of("Leaves")), (MaterialClass::Wood, MaterialClass::Leaf));
    assert!(decided.iter().any(|one| one.rule == "'trunk' in the name of its part 'Trunk'"), "{decided:?}");
    // Nor does the name of an atlas say what each part is.
    let shared = read(&atlas(["Trunk", "Leaves"], json!({"name": "leaf_atlas"}))).unwrap();
    let decided = classify(&shared, &ClassRules::default()).unwrap();
    let classes: Vec<MaterialClass> = decided.iter().map(|one| one.class).collect();
    assert_eq!(classes, [MaterialClass::Leaf, MaterialClass::Wood]);
    let alone = read(&atlas(["Trunk", "Cube"], json!({"name": "leaf_atlas"}))).unwrap();
    assert_eq!(alone.materials.len(), 1);
    // A material that says what it is by itself is not split.
    let leaves = read(&atlas(["Trunk", "Leaves"], json!({"name": "foliage"}))).unwrap();
    assert_eq!(leaves.materials.len(), 1);
    // Names that say nothing are told apart by a pattern.
    let split = vec!["Tree@Cube.1".to_owned()];
    let settings = ImportSettings { split, ..ImportSettings::default() };
    let silent = atlas(["Cube.1", "Cube.2"], json!({"name": "Tree"}));
    let mesh = read_with("a.gltf", silent.to_string().as_bytes(), &[], &settings).unwrap();
    assert_eq!((mesh.materials.len(), read(&silent).unwrap().materials.len()), (2, 1));
}

#[test]
fn a_texture_of_what_passes_tells_leaf_from_wood() {
    let image = data_uri(&png(8, 8, |x| if x < 4 { 0 } else { 255 }));
    let uvs = bytes_of(&[[0.7f32, 0.5], [0.9, 0.5], [0.8, 0.9], [0.1, 0.5], [0.3, 0.5], [0.2, 0.9]].concat());
    let transmission = json!({"KHR_materials_diffuse_transmission":
        {"diffuseTransmissionFactor": 0.4, "diffuseTransmissionTexture": {"index": 0}}});
    let mut json = changed(&[
        ("/meshes/0/primitives/0/material", json!(0)),
        ("/meshes/0/primitives/0/attributes/TEXCOORD_0", json!(1)),
        ("/meshes/0/primitives/1", json!({"attributes": {"POSITION": 3, "TEXCOORD_0": 2}, "material": 0})),
        ("/materials", json!([{"name": "Plant", "extensions": transmission}])),
        ("/images", json!([{"uri": image}])),
        ("/textures", json!([{"source": 0}])),
    ]);
    let raised = bytes_of(&TRIANGLE.map(|[x, y, z]| [x, y, z + 1.0]).concat());
    json["meshes"][0]["name"] = json!("Mesh");
    let accessors = vec![
        (uvs[..24].to_vec(), float(3, "VEC2")),
        (uvs[24..].to_vec(), float(3, "VEC2")),
        (raised, float(3, "VEC3")),
    ];
    let mesh = read(&with_accessors(json.clone(), accessors.clone())).unwrap();
    assert_eq!(mesh.materials.len(), 2);
    let mut passes: Vec<f32> =
        mesh.materials.iter().map(|material| material.diffuse_transmission.unwrap()).collect();
    passes.sort_by(f32::total_cmp);
    assert_eq!(passes, [0.0, 0.4]);
    let classes: Vec<_> =
        classify(&mesh, &ClassRules::default()).unwrap().into_iter().map(|one| one.class).collect();
    assert!(classes.contains(&MaterialClass::Leaf) && classes.contains(&MaterialClass::Wood), "{classes:?}");
    // Without the texture all of it lets through as much.
    let factor = json!({"diffuseTransmissionFactor": 0.4, "diffuseTransmissionColorFactor": [0.2, 0.9, 0.1]});
    json["materials"][0]["extensions"]["KHR_materials_diffuse_transmission"] = factor;
    let mesh = read(&with_accessors(json, accessors)).unwrap();
    assert_eq!(mesh.materials[0].diffuse_transmission, Some(0.4));
    assert_eq!(mesh.materials[0].transmission_color, Some([0.2, 0.9, 0.1]));
}

#[test]
fn the_colour_of_what_passes_is_that_of_the_texels_that_are_shown() {
    let image = |left: [u8; 4], right: [u8; 4]| {
        let image = image::RgbaImage::from_fn(8, 8, |x, _| image::Rgba(if x < 4 { left } else { right }));
        let mut bytes = std::io::Cursor::new(Vec::new());
        image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
        data_uri(&bytes.into_inner())
    };
    let uvs = bytes_of(&[0.7f32, 0.5, 0.9, 0.5, 0.8, 0.9]);
    let of = |passing: Value| {
        let json = changed(&[
            ("/meshes/0/primitives/0/material", json!(0)),
            ("/meshes/0/primitives/0/attributes/TEXCOORD_0", json!(1)),
            (
                "/materials",
                json!([{"name": "Plant", "extensions": {"KHR_materials_diffuse_transmission": passing}}]),
            ),
            ("/images", json!([{"uri": image([255, 0, 0, 255], [0, 255, 0, 255])}])),
            ("/textures", json!([{"source": 0}])),
        ]);
        read(&with_accessors(json, vec![(uvs.clone(), float(3, "VEC2"))])).unwrap()
    };
    let mesh = of(json!({"diffuseTransmissionFactor": 0.4, "diffuseTransmissionColorTexture": {"index": 0},
        "diffuseTransmissionColorFactor": [1.0, 0.5, 1.0]}));
    assert_eq!(mesh.materials[0].transmission_color, Some([0.0, 0.5, 0.0]));
    assert_eq!(mesh.materials[0].diffuse_transmission, Some(0.4));
    let mesh = of(json!({"diffuseTransmissionFactor": 0.4, "diffuseTransmissionColorTexture": {"index": 0},
        "diffuseTransmissionTexture": {"index": 0}}));
    assert_eq!(mesh.materials[0].transmission_color, Some([0.0, 1.0, 0.0]));
}

/// Share of a material's surface that is there.
fn share_there(mesh: &Mesh) -> f64 {
    let coverage: Vec<Coverage> =
        (0..mesh.materials.len()).map(|at| Coverage::of(mesh, at).unwrap()).collect();
    let mut sums = [0.0; 2];
    for (cover, sum) in [coverage, vec![Coverage::Full; mesh.materials.len()]].iter().zip(&mut sums) {
        crate::color::on_surface(mesh, cover, |_, _, share| *sum += share);
    }
    sums[0] / sums[1]
}

#[test]
fn a_blended_alpha_is_the_share_that_is_there() {
    let blend = |material: Value, image: Option<Vec<u8>>| {
        let mut json = changed(&[
            ("/meshes/0/primitives/0/material", json!(0)),
            ("/meshes/0/primitives/0/attributes/TEXCOORD_0", json!(1)),
            ("/materials", json!([material])),
            ("/textures", json!([{"source": 0}])),
        ]);
        json["images"] = json!(image.iter().map(|image| json!({"uri": data_uri(image)})).collect::<Vec<_>>());
        let uvs = bytes_of(&[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
        read(&with_accessors(json, vec![(uvs, float(3, "VEC2"))])).unwrap()
    };
    let textured = |factor: f64| {
        json!({"name": "leaf", "alphaMode": "BLEND", "pbrMetallicRoughness":
            {"baseColorFactor": [1.0, 1.0, 1.0, factor], "baseColorTexture": {"index": 0}}})
    };
    let plain = json!({"name": "leaf", "alphaMode": "BLEND", "pbrMetallicRoughness":
        {"baseColorFactor": [1.0, 1.0, 1.0, 0.4]}});
    let cases = [
        (textured(1.0), Some(png(64, 64, |_| 102)), 0.4),
        (textured(1.0), Some(png(1, 1, |_| 153)), 0.6),
        (textured(0.5), Some(png(64, 64, |_| 153)), 0.3),
        (textured(0.4), Some(png(16, 16, |_| 255)), 0.4),
        (textured(1.0), Some(png(64, 64, |x| (x * 4) as u8)), 0.33),
        (plain, None, 0.4),
    ];
    for (material, image, expected) in cases {
        let mesh = blend(material.clone(), image);
        assert!(
            (share_there(&mesh) - expected).abs() < 0.01,
            "{material}: {} of {expected}",
            share_there(&mesh)
        );
    }
    let whole = blend(textured(1.0), Some(png(4, 4, |_| 255)));
    assert_eq!(whole.materials[0].alpha_mode, AlphaMode::Opaque);
    let zeros = blend(textured(1.0), Some(png(4, 4, |_| 0)));
    assert_eq!(zeros.materials[0].alpha_mode, AlphaMode::Opaque);
    assert!(zeros.warnings[0].contains("is 0 everywhere; it is not used"), "{:?}", zeros.warnings);
}

#[test]
fn alpha_of_vertices_multiplies_that_of_the_material() {
    let blend = json!([{"name": "leaf", "alphaMode": "BLEND"}]);
    let colors = [1.0, 1.0, 1.0, 0.25].repeat(3);
    let with = |materials: Value| {
        let json = changed(&[
            ("/meshes/0/primitives/0/attributes/COLOR_0", json!(1)),
            ("/meshes/0/primitives/0/material", json!(0)),
            ("/materials", materials),
        ]);
        read(&with_accessors(json, vec![(bytes_of(&colors), float(3, "VEC4"))])).unwrap()
    };
    assert!((share_there(&with(blend)) - 0.25).abs() < 0.01);
    assert_eq!(share_there(&with(json!([{"name": "leaf", "alphaMode": "MASK"}]))), 0.0);
    assert_eq!(share_there(&with(json!([{"name": "leaf"}]))), 1.0, "opaque is opaque");
}

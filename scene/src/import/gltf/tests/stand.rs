//! Where the meshes of a glTF stand.

use std::f64::consts::FRAC_1_SQRT_2;

use glam::{DQuat, DVec3};

use super::chosen::four_meshes;
use super::instancing::{floats, instanced, stand_of, stand_without};
use super::*;
use crate::import::{Plant, read_stand};

fn message(json: &Value) -> String {
    stand_of(json).expect_err("it cannot stand").to_string()
}

#[test]
fn every_mesh_is_a_species_and_every_node_a_plant() {
    let stand = stand_of(&four_meshes()).unwrap();
    let species: Vec<[&str; 2]> =
        stand.species.iter().map(|species| [species.name.as_str(), species.gltf_mesh.as_str()]).collect();
    assert_eq!(species, [["Oak", "Oak"], ["mesh_1", "#1"], ["Fir_2", "#2"], ["Fir_3", "#3"]]);
    let plant = |species: usize| Plant {
        species,
        position_m: [10.0 * species as f64, 0.0, 5.0],
        rotation: [0.0, 0.0, 0.0, 1.0],
        scale: 1.0,
    };
    assert_eq!(stand.plants, (0..4).map(plant).collect::<Vec<_>>());
    assert_eq!((stand.camera, stand.sun, stand.warnings.len()), (None, None, 0));
    for (word, index) in [("Oak", 0), ("#0", 0), ("mesh_1", 1), ("#3", 3), ("Fir_3", 3)] {
        assert_eq!(stand.find(word), Some(index), "{word}");
    }
    assert_eq!(stand.find("Fir"), None);
}

#[test]
fn names_of_species_are_their_own_and_printable() {
    let mut json = four_meshes();
    for (mesh, name) in ["Fir", "a\nb/c", "Fir", "Fir_0"].into_iter().enumerate() {
        json["meshes"][mesh]["name"] = json!(name);
    }
    let stand = stand_of(&json).unwrap();
    let names =
        |what: fn(&crate::import::StandSpecies) -> &str| stand.species.iter().map(what).collect::<Vec<_>>();
    assert_eq!(names(|species| &species.name), ["Fir_0_", "a_b_c", "Fir_2", "Fir_0"]);
    assert_eq!(names(|species| &species.gltf_mesh), ["#0", "a\nb/c", "#2", "Fir_0"]);
    json["meshes"][0]["name"] = json!("x".repeat(2000));
    assert!(message(&json).contains("meshes[0]: bytes of a name: 2000 is over the limit of 1024"));
}

#[test]
fn only_the_default_scene_stands_and_what_is_left_out_does_not() {
    let mut json = four_meshes();
    json["scenes"] = json!([{"nodes": [0]}, {"nodes": [1, 2, 3]}]);
    json["scene"] = json!(1);
    // A ground may be of any shape.
    json["nodes"][1]["scale"] = json!([50.0, 1.0, 50.0]);
    let stand = stand_without(&json, &["#1"]).unwrap();
    assert_eq!(stand.species.iter().map(|species| species.mesh).collect::<Vec<_>>(), [2, 3]);
    assert!(stand.warnings[0].contains("scene 1 of 2 is read"), "{:?}", stand.warnings);
    let error = stand_without(&json, &["Ground"]).unwrap_err().to_string();
    assert!(error.contains("gltf_mesh 'Ground': no mesh has this name"), "{error}");
    let error = stand_without(&json, &["#1", "#2", "#3"]).unwrap_err().to_string();
    assert!(error.contains("the default scene: found none of the meshes 'Oak', '#1'"), "{error}");
}

#[test]
fn a_chain_of_nodes_makes_one_rotation_and_one_scale() {
    let mut json = one_triangle();
    let half = FRAC_1_SQRT_2;
    json["nodes"] = json!([
        {"children": [1], "scale": [100.0, 100.0, 100.0], "rotation": [-half, 0.0, 0.0, half]},
        {"children": [2], "translation": [0.01, 0.0, 0.02]},
        {"mesh": 0, "scale": [0.02, 0.02, 0.02]},
    ]);
    let plant = stand_of(&json).unwrap().plants[0];
    let near = |found: &[f64], expected: &[f64]| {
        let off = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-6, "{found:?}, expected {expected:?}");
    };
    near(&plant.position_m, &[1.0, 2.0, 0.0]);
    near(&plant.rotation, &[-half, 0.0, 0.0, half]);
    near(&[plant.scale], &[2.0]);
    // Read with +Z up and in centimetres the model stands upright, and no triangle has moved.
    let model = plant.of_model(Up::Z, 0.01, [0.0; 3]);
    near(&model.rotation, &[0.0, 0.0, 0.0, 1.0]);
    near(&[model.scale / 100.0], &[2.0]);
    assert_eq!(model.position_m, plant.position_m);
    assert_eq!(plant.of_model(Up::Y, 1.0, [0.0; 3]), plant);
    // A point of the mesh 7 m up its z axis, of which 5 were taken off.
    let moved = plant.of_model(Up::Y, 1.0, [0.0, 0.0, 5.0]);
    let at = |plant: &Plant, z: f64| {
        let turned = DQuat::from_array(plant.rotation) * (DVec3::new(0.0, 0.0, z) * plant.scale);
        DVec3::from_array(plant.position_m) + turned
    };
    assert!((at(&moved, 2.0) - at(&plant, 7.0)).length() < 1e-9, "{moved:?}");
}

#[test]
fn a_transform_that_no_bake_serves_is_refused_by_node_and_numbers() {
    let scaled = |scale: [f32; 3]| instanced(vec![floats("SCALE", "VEC3", &[[1.0; 3], scale].concat())]);
    assert!(message(&scaled([1.0, 1.2, 1.0])).contains(
        "nodes[0] 'grove', instance 1: found scales [1.0, 1.2000000476837158, 1.0] along x, y and z, expected a rotation"
    ));
    assert!(message(&scaled([-1.0, 1.0, 1.0])).contains("instance 1: found a mirror"));
    assert!(
        message(&scaled([0.0; 3])).contains("instance 1: found scale 0, expected a scale of 1e-6 to 1e6")
    );
    assert!(message(&scaled([2e6; 3])).contains("found scale 2000000"));
    assert!(stand_of(&scaled([1.00005, 1.0, 1.0])).is_ok());
    let mut sheared = four_meshes();
    sheared["nodes"][2] = json!({"mesh": 2, "name": "bent", "matrix":
        [1, 0, 0, 0, 0.6, 0.8, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]});
    assert!(message(&sheared).contains("nodes[2] 'bent': found axes with a cosine of 0.600000"));
    let far = instanced(vec![floats("TRANSLATION", "VEC3", &[2e9, 0.0, 0.0])]);
    assert!(message(&far).contains("instance 0: found position [2000000000.0, 0.0, 0.0]"));
    let huge: Vec<Value> = (0..20)
        .map(|i| json!({"children": [i + 1], "scale": [1e38, 1e38, 1e38]}))
        .chain([json!({"mesh": 0})])
        .collect();
    assert!(
        message(&changed(&[("/nodes", json!(huge))]))
            .contains("nodes[20]: found a transform that is not finite")
    );
    assert!(message(&changed(&[("/nodes/0/skin", json!(0))])).contains("nodes[0]: found a skin"));
    assert!(
        message(&changed(&[("/nodes/0/mesh", json!(3))]))
            .contains("nodes[0]: found mesh 3, expected one of 1")
    );
    assert!(message(&changed(&[("/nodes/0/children", json!([0]))])).contains("a node below itself"));
}

#[test]
fn what_is_no_forest_is_refused() {
    assert!(message(&changed(&[("/scenes/0/nodes", json!([]))])).contains("the default scene: found none"));
    let lines = changed(&[("/meshes/0/primitives/0/mode", json!(1))]);
    assert!(message(&lines).contains("the default scene: found none of the meshes 'leaf'"));
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.obj"), "v 0 0 0\n").unwrap();
    let error = read_stand(&folder.path().join("a.obj"), &[], &[]).unwrap_err().to_string();
    assert_eq!(
        error,
        "scene: found a.obj, an OBJ, expected a glTF or GLB file, which says where plants stand"
    );
}

#[test]
fn meshes_in_the_very_same_places_are_said_to_be_parts_of_one_plant() {
    let mut json = four_meshes();
    json["nodes"][3]["translation"] = json["nodes"][0]["translation"].clone();
    let warnings = stand_of(&json).unwrap().warnings;
    assert!(warnings[0].contains("meshes 'Oak' and '#3' stand in the same 1 places"), "{warnings:?}");
    assert_eq!(warnings.len(), 1);
}

/// A camera and a light for the triangle, with the members of their node.
fn seen(node: Value, camera: Value, light: Value) -> Value {
    let mut node = node;
    node["camera"] = json!(0);
    node["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
    changed(&[
        ("/nodes/1", node),
        ("/scenes/0/nodes/1", json!(1)),
        ("/cameras", json!([camera])),
        ("/extensions", json!({"KHR_lights_punctual": {"lights": [light]}})),
        ("/extensionsRequired", json!(["KHR_lights_punctual"])),
    ])
}

#[test]
fn the_first_camera_and_the_first_sun_are_the_scene_s() {
    let lens =
        json!({"type": "perspective", "perspective": {"yfov": std::f64::consts::FRAC_PI_2, "znear": 0.1}});
    let sun = json!({"type": "directional"});
    // About Y by 90 degrees: -Z, where it looks, becomes -X; the light comes from +X, the east.
    let node = json!({"translation": [1.0, 2.0, 3.0], "rotation": [0.0, FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2]});
    let stand = stand_of(&seen(node.clone(), lens.clone(), sun.clone())).unwrap();
    let camera = stand.camera.unwrap();
    assert_eq!(camera.position_m, [1.0, 2.0, 3.0]);
    assert!((camera.fov_deg - 90.0).abs() < 1e-5, "{camera:?}");
    let off = camera.look_at_m.iter().zip([-9.0, 2.0, 3.0]).map(|(a, b)| (a - b).abs());
    assert!(off.fold(0.0, f64::max) < 1e-5, "{camera:?}");
    let [azimuth, elevation] = stand.sun.unwrap();
    assert!((azimuth - 90.0).abs() < 1e-5 && elevation.abs() < 1e-5, "{azimuth} {elevation}");
    // From above: about X by -90 degrees, +Z becomes +Y.
    let above = json!({"rotation": [-FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2]});
    assert_eq!(stand_of(&seen(above, lens.clone(), sun.clone())).unwrap().sun, Some([0.0, 90.0]));
    // Others are told, and no error.
    let flat = json!({"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "zfar": 1, "znear": 0}});
    let stand = stand_of(&seen(node.clone(), flat, json!({"type": "point"}))).unwrap();
    assert_eq!((stand.camera, stand.sun), (None, None));
    for words in ["the camera of nodes[1] has no perspective", "the light of nodes[1] is not directional"] {
        assert!(stand.warnings.iter().any(|warning| warning.contains(words)), "{:?}", stand.warnings);
    }
    let mut twice = seen(node, lens, sun);
    twice["nodes"][0]["camera"] = json!(0);
    twice["nodes"][0]["extensions"] = twice["nodes"][1]["extensions"].clone();
    twice["nodes"][0]["rotation"] = json!([0.0, 0.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2]);
    let warnings = stand_of(&twice).unwrap().warnings;
    for words in [
        "the camera of nodes[0] leans to its side",
        "the camera of nodes[1] is not the first",
        "the sun of nodes[1] is not the first",
    ] {
        assert!(warnings.iter().any(|warning| warning.contains(words)), "{words}: {warnings:?}");
    }
}

#[test]
fn suns_that_a_scene_cannot_have_are_told() {
    let lens = json!({"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}});
    let below = json!({"rotation": [0.25881904510252074, 0.0, 0.0, 0.9659258262890683]});
    let red = json!({"type": "directional", "color": [1, 0.25, 0]});
    let stand = stand_of(&seen(below.clone(), lens.clone(), red)).unwrap();
    assert!((stand.sun.unwrap()[1] + 30.0).abs() < 1e-3, "{:?}", stand.sun);
    for words in [
        "the sun of nodes[1] stands 30.0 degrees below the horizon",
        "the sun of nodes[1] has the colour 1 0.25 0; a scene's is white",
    ] {
        assert!(stand.warnings.iter().any(|warning| warning.contains(words)), "{:?}", stand.warnings);
    }
    let mut hidden = seen(below, lens, json!({"type": "directional"}));
    hidden["nodes"][1]["extensions"]["KHR_node_visibility"] = json!({"visible": false});
    let stand = stand_of(&hidden).unwrap();
    assert_eq!(stand.sun, None);
    let words = "the light of nodes[1] is hidden; ignored";
    assert!(stand.warnings.iter().any(|warning| warning.contains(words)), "{:?}", stand.warnings);
}

#[test]
fn cameras_and_lights_that_are_not_there_are_named() {
    let good = || {
        let lens = json!({"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}});
        seen(json!({"name": "eye"}), lens, json!({"type": "directional"}))
    };
    for (pointer, value, words) in [
        ("/nodes/1/camera", json!(4), "nodes[1] 'eye': found camera 4, expected one of 1"),
        (
            "/nodes/1/extensions/KHR_lights_punctual/light",
            json!(4),
            "nodes[1] 'eye': found light 4, expected one of 1",
        ),
        ("/nodes/1/extensions/KHR_lights_punctual", json!(4), "nodes[1] 'eye', KHR_lights_punctual"),
        ("/extensions/KHR_lights_punctual", json!({"lights": 3}), "KHR_lights_punctual: found invalid type"),
    ] {
        let mut json = good();
        *json.pointer_mut(pointer).unwrap() = value;
        assert!(message(&json).contains(words), "{words}: {}", message(&json));
    }
    let mut json = good();
    json["cameras"][0]["perspective"]["yfov"] = json!(0.0);
    assert_eq!(stand_of(&json).unwrap().camera, None);
}

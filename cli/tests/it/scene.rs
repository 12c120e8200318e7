//! `flb scene`: forests in one glTF, baked mesh by mesh and drawn as scenes.

use serde_json::{Value, json};

use crate::flb::{Folder, PAPER};
use crate::picture::pixels;
use crate::schema::{misfits, schema};

/// The JSON and the binary chunk of a GLB.
pub(crate) fn taken_apart(glb: &[u8]) -> (Value, Vec<u8>) {
    let word = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().expect("four bytes")) as usize;
    let end = 20 + word(12);
    (serde_json::from_slice(&glb[20..end]).expect("JSON"), glb[end + 8..].to_vec())
}

fn put_together(json: &Value, binary: &[u8]) -> Vec<u8> {
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut binary = binary.to_vec();
    binary.resize(binary.len().next_multiple_of(4), 0);
    let words = [0x4654_6C67, 2, 28 + text.len() + binary.len(), text.len(), 0x4E4F_534A];
    let mut glb: Vec<u8> = words.iter().flat_map(|word| (*word as u32).to_le_bytes()).collect();
    glb.extend(text);
    glb.extend((binary.len() as u32).to_le_bytes());
    glb.extend(0x004E_4942u32.to_le_bytes());
    glb.extend(binary);
    glb
}

/// The list of that key, made where it is missing.
fn list<'a>(json: &'a mut Value, key: &str) -> &'a mut Vec<Value> {
    let object = json.as_object_mut().expect("an object");
    object.entry(key).or_insert_with(|| json!([])).as_array_mut().expect("a list")
}

/// Two plants in one file, `Oak` and `Shrub`, as an exporter would join them.
fn joined(folder: &Folder) -> (Value, Vec<u8>) {
    let (mut json, mut binary) = taken_apart(&folder.read("oak.glb"));
    let (mut other, others) = taken_apart(&folder.read("shrub.glb"));
    binary.resize(binary.len().next_multiple_of(4), 0);
    let offset = binary.len();
    binary.extend(others);
    let keys = ["bufferViews", "accessors", "images", "samplers", "textures", "materials", "meshes"];
    let base: std::collections::HashMap<&str, u64> =
        keys.into_iter().map(|key| (key, list(&mut json, key).len() as u64)).collect();
    let shift = |value: Option<&mut Value>, key: &str| {
        if let Some(value) = value {
            *value = json!(value.as_u64().expect("an index") + base[key]);
        }
    };
    for view in list(&mut other, "bufferViews") {
        view["byteOffset"] = json!(view["byteOffset"].as_u64().unwrap_or(0) + offset as u64);
    }
    list(&mut other, "accessors").iter_mut().for_each(|a| shift(a.get_mut("bufferView"), "bufferViews"));
    list(&mut other, "images").iter_mut().for_each(|i| shift(i.get_mut("bufferView"), "bufferViews"));
    for texture in list(&mut other, "textures") {
        shift(texture.get_mut("source"), "images");
        shift(texture.get_mut("sampler"), "samplers");
    }
    for material in list(&mut other, "materials") {
        shift(material.pointer_mut("/pbrMetallicRoughness/baseColorTexture/index"), "textures");
    }
    for primitive in list(&mut other, "meshes").iter_mut().flat_map(|mesh| list(mesh, "primitives")) {
        shift(primitive.get_mut("indices"), "accessors");
        shift(primitive.get_mut("material"), "materials");
        let attributes = primitive["attributes"].as_object_mut().expect("attributes");
        attributes.values_mut().for_each(|accessor| shift(Some(accessor), "accessors"));
    }
    for key in keys {
        let more = std::mem::take(list(&mut other, key));
        list(&mut json, key).extend(more);
    }
    json["meshes"][0]["name"] = json!("Oak");
    json["meshes"][1]["name"] = json!("Shrub");
    (json, binary)
}

/// Adds floats as an accessor; its index.
fn add_floats(json: &mut Value, binary: &mut Vec<u8>, kind: &str, values: &[f32]) -> usize {
    binary.resize(binary.len().next_multiple_of(4), 0);
    let offset = binary.len();
    binary.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    let view = json!({"buffer": 0, "byteOffset": offset, "byteLength": 4 * values.len()});
    list(json, "bufferViews").push(view);
    let view = list(json, "bufferViews").len() - 1;
    let count = values.len() / if kind == "VEC4" { 4 } else { 3 };
    let accessor = json!({"bufferView": view, "componentType": 5126, "count": count, "type": kind});
    list(json, "accessors").push(accessor);
    list(json, "accessors").len() - 1
}

const OAKS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [6.5, 0.25, -4.0], [-7.0, 0.0, -2.5]];
const SHRUBS: [[f32; 3]; 2] = [[2.5, 0.0, 3.0], [-3.0, 0.0, 2.0]];
/// Of the oaks, and of the shrubs in a node of its own turn and scale.
const SCALES: [f32; 3] = [0.5, 0.75, 1.0];

/// Writes `forest.glb`, whose trees stand by extension or by a node each.
fn write_forest(folder: &Folder, by_extension: bool) {
    let (mut json, mut binary) = joined(folder);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let quarter = [0.0, half, 0.0, half];
    let sun =
        json!({"rotation": [-half, 0.0, 0.0, half], "extensions": {"KHR_lights_punctual": {"light": 0}}});
    let eye = json!({"camera": 0, "translation": [0.0, 4.0, 22.0]});
    let mut nodes = vec![sun, eye];
    if by_extension {
        let scales = SCALES.map(|scale| [scale; 3]).concat();
        let (oaks, shrubs) = (OAKS.concat(), SHRUBS.concat());
        let oaks = add_floats(&mut json, &mut binary, "VEC3", &oaks);
        let scales = add_floats(&mut json, &mut binary, "VEC3", &scales);
        let turns =
            add_floats(&mut json, &mut binary, "VEC4", &[quarter, [0.0, 0.0, 0.0, 1.0], quarter].concat());
        let shrubs = add_floats(&mut json, &mut binary, "VEC3", &shrubs);
        let of = |attributes: Value| json!({"EXT_mesh_gpu_instancing": {"attributes": attributes}});
        let all = json!({"TRANSLATION": oaks, "SCALE": scales, "ROTATION": turns});
        nodes.push(json!({"name": "oaks", "mesh": 0, "extensions": of(all)}));
        nodes.push(json!({"mesh": 1, "extensions": of(json!({"TRANSLATION": shrubs}))}));
        json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    } else {
        for (i, (position, scale)) in OAKS.iter().zip(SCALES).enumerate() {
            let scales = [scale; 3];
            let rotation = if i == 1 { [0.0, 0.0, 0.0, 1.0] } else { quarter };
            nodes.push(json!({"mesh": 0, "translation": position, "scale": scales, "rotation": rotation}));
        }
        nodes.extend(SHRUBS.iter().map(|position| json!({"mesh": 1, "translation": position})));
    }
    json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}]);
    json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "directional"}]}});
    json["scenes"] = json!([{"nodes": (0..nodes.len()).collect::<Vec<_>>()}]);
    json["nodes"] = json!(nodes);
    json["buffers"][0]["byteLength"] = json!(binary.len());
    folder.write("forest.glb", put_together(&json, &binary));
}

fn bake(folder: &Folder, words: &[&str]) {
    let small = ["--lattice", "16", "--voxels", "128"];
    let run = folder.flb(&[&["bake"], words, &small, &PAPER].concat());
    assert!(run.code == 0 || run.code == 3, "{}", run.stderr);
}

#[test]
fn a_forest_is_baked_mesh_by_mesh_and_drawn_as_if_every_mesh_had_its_file() {
    let folder = Folder::with_plants(&["oak", "shrub"]);
    write_forest(&folder, true);
    bake(&folder, &["forest.glb", "--gltf-mesh", "Oak", "-o", "Oak.flb"]);
    bake(&folder, &["forest.glb", "--gltf-mesh", "#1", "--name", "Shrub", "-o", "Shrub.flb"]);
    let lights = ["--light", "Oak=Oak.flb", "--light", "#1=Shrub.flb", "--ground", "-0.5"];
    let scene = ["scene", "forest.glb", "-o", "forest.toml", "--json"];
    let run = folder.flb_with(&scene, &lights).expect_code(0);
    assert_eq!(misfits(&schema("scene"), &run.json()), [""; 0], "{}", run.json());
    assert_eq!((run.json()["instances"].clone(), run.json()["has_sun"].clone()), (json!(5), json!(true)));
    let kinds = run.json()["species"].clone();
    assert_eq!((&kinds[0]["name"], &kinds[0]["instances"]), (&json!("Oak"), &json!(3)));
    assert_eq!((&kinds[1]["gltf_mesh"], &kinds[1]["light"]), (&json!("Shrub"), &json!("Shrub.flb")));
    let by_extension = String::from_utf8(folder.read("forest.toml")).expect("TOML is text");
    for line in [
        "fixed = [[0.0, 90.0]]",
        "position_m = [0.0, 4.0, 22.0]\nlook_at_m = [0.0, 4.0, 12.0]\nfov_deg = 45.836624",
        "height_m = -0.5",
        "file = \"forest.glb\"\ngltf_mesh = \"Oak\"\nlight = \"Oak.flb\"",
        "species = \"Oak\"\nposition_m = [6.5, 0.25, -4.0]\nyaw_deg = 0.0\nscale = 0.75\n",
        "species = \"Oak\"\nposition_m = [-7.0, 0.0, -2.5]\nyaw_deg = 270.0\nscale = 1.0\n",
        "species = \"Shrub\"\nposition_m = [-3.0, 0.0, 2.0]\nyaw_deg = 0.0\nscale = 1.0\n",
    ] {
        assert!(by_extension.contains(line), "{line}\nis not in\n{by_extension}");
    }
    let render = ["--size", "64x36", "--samples", "2", "--sun", "135,35"];
    let seen = folder.flb_with(&["render", "forest.toml", "-o", "forest.png"], &render).expect_code(0);
    assert!(!seen.stderr.contains("not the file"), "{}", seen.stderr);
    folder.flb(&["plan", "forest.toml", "-o", "plan.toml"]).expect_code(0);

    // The same by nodes is the same scene; the digest of the file that was baked is another.
    write_forest(&folder, false);
    folder.flb_with(&["scene", "forest.glb", "-o", "nodes.toml"], &lights).expect_code(0);
    assert_eq!(String::from_utf8(folder.read("nodes.toml")).expect("TOML is text"), by_extension);

    // Written by hand, with each mesh in a file of its own, baked from there.
    bake(&folder, &["oak.glb", "-o", "oak.flb"]);
    bake(&folder, &["shrub.glb", "-o", "shrub.flb"]);
    let mut by_hand = by_extension.clone();
    for (mesh, plant) in [("Oak", "oak"), ("Shrub", "shrub")] {
        let files = |file: &str, light: &str| format!("file = \"{file}\"\nlight = \"{light}.flb\"");
        let lines = format!("file = \"forest.glb\"\ngltf_mesh = \"{mesh}\"\nlight = \"{mesh}.flb\"");
        by_hand = by_hand.replace(&lines, &files(&format!("{plant}.glb"), plant));
    }
    assert!(!by_hand.contains("gltf_mesh"), "{by_hand}");
    folder.write("hand.toml", by_hand);
    folder.flb_with(&["render", "hand.toml", "-o", "hand.png"], &render).expect_code(0);
    assert!(folder.read("forest.png") == folder.read("hand.png"));
    // A planted difference is seen.
    folder.write("moved.toml", by_extension.replace("[6.5, 0.25, -4.0]", "[6.0, 0.25, -4.0]"));
    folder.flb_with(&["render", "moved.toml", "-o", "moved.png"], &render).expect_code(0);
    assert!(folder.read("forest.png") != folder.read("moved.png"));

    // A plant of the forest by itself: its file knows the mesh.
    let alone = ["--sun", "135,35", "--size", "32x32", "--samples", "1"];
    let render =
        |words: &[&str], code: i32| folder.flb_with(&[&["render"], words].concat(), &alone).expect_code(code);
    render(&["Oak.flb", "--mesh", "forest.glb", "-o", "a.png"], 0);
    render(&["oak.flb", "--mesh", "oak.glb", "-o", "b.png"], 0);
    render(&["oak.flb", "--mesh", "forest.glb", "--gltf-mesh", "Oak", "-o", "c.png"], 0);
    assert!(folder.read("a.png") == folder.read("b.png") && folder.read("a.png") == folder.read("c.png"));
    render(&["Oak.flb", "--mesh", "forest.glb", "--gltf-mesh", "#0", "-o", "d.png"], 0)
        .says(&["species \"Oak\" was baked from mesh \"Oak\", shown is \"#0\""]);
}

#[test]
fn axes_and_unit_of_a_species_file_move_no_plant() {
    let folder = Folder::with_plants(&["oak", "shrub"]);
    write_forest(&folder, true);
    folder.write("flat.toml", "up = \"z\"\nunit_m = 0.5\n").write("plain.toml", "");
    let picture = |species_file: &str| {
        let toml = format!("{species_file}-scene.toml");
        let word = format!("Oak={species_file}");
        folder.flb(&["scene", "forest.glb", "--species-file", &word, "-o", &toml]).expect_code(0);
        let drawn = format!("{species_file}.png");
        let render = ["render", &toml, "--size", "48x27", "--samples", "1", "--sun", "135,35", "-o", &drawn];
        folder.flb(&render).expect_code(0);
        let text = String::from_utf8(folder.read(&toml)).expect("TOML is text");
        (text, pixels(&folder.read(&drawn)))
    };
    let ((flat_text, flat), (plain_text, plain)) = (picture("flat.toml"), picture("plain.toml"));
    assert!(flat_text.contains("rotation = [0.5, 0.5, -0.5, 0.5]\nscale = 1.0\n"), "{flat_text}");
    assert!(plain_text.contains("yaw_deg = 270.0\nscale = 0.5\n"), "{plain_text}");
    // Rays that graze an edge may fall to either side of it.
    let apart = flat.iter().zip(&plain).filter(|(a, b)| a.abs_diff(**b) > 5).count();
    assert!(apart * 50 < plain.len(), "{apart} of {}", plain.len());
    assert!(plain.iter().any(|value| *value > 30), "the plants are in the picture");
}

#[test]
fn a_forest_of_100_000_plants_is_a_scene_of_as_many() {
    const COUNT: usize = 100_000;
    let folder = Folder::with_plants(&["oak", "shrub"]);
    let (mut json, mut binary) = joined(&folder);
    let places: Vec<f32> =
        (0..COUNT).flat_map(|i| [(i % 400) as f32 * 3.25, 0.5, (i / 400) as f32 * -2.75]).collect();
    let accessor = add_floats(&mut json, &mut binary, "VEC3", &places);
    let extension = json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": accessor}}});
    json["nodes"] = json!([{"mesh": 1, "extensions": extension}]);
    json["scenes"] = json!([{"nodes": [0]}]);
    json["buffers"][0]["byteLength"] = json!(binary.len());
    folder.write("forest.glb", put_together(&json, &binary));
    let run = folder.flb(&["scene", "forest.glb", "-o", "forest.toml"]).expect_code(0);
    assert!(
        run.stdout.contains("forest.toml: 100000 plants; camera: made up, sun: made up"),
        "{}",
        run.stdout
    );
    let text = String::from_utf8(folder.read("forest.toml")).expect("TOML is text");
    assert_eq!(text.matches("[[instance]]").count(), COUNT);
    assert!(text.contains("position_m = [1296.75, 0.5, -684.75]"));
    folder.flb(&["plan", "forest.toml", "-o", "plan.toml"]).expect_code(0);
}

#[test]
fn what_no_scene_can_be_made_of_is_refused_and_nothing_is_written() {
    let folder = Folder::with_plants(&["oak", "shrub"]);
    write_forest(&folder, true);
    folder.write("oak.flb", "").write("a.obj", "v 0 0 0\n");
    for (words, code, expected) in [
        (
            &["forest.glb", "--light", "Elm=oak.flb"][..],
            2,
            "forest.glb: --light \"Elm\": no such mesh stands there; there are: Oak, Shrub",
        ),
        (&["forest.glb", "--light", "Oak=none.flb"], 4, "none.flb: --light \"Oak\": there is no such file"),
        (&["forest.glb", "--light", "Oak"], 2, "expected MESH=FILE"),
        (
            &["forest.glb", "--species-file", "Oak=a.obj", "--species-file", "#0=a.obj"],
            2,
            "mesh \"#0\" has a file already",
        ),
        (
            &["forest.glb", "--leave-out", "Ground"],
            2,
            "gltf_mesh 'Ground': no mesh has this name; the meshes are: 'Oak', 'Shrub'",
        ),
        (
            &["forest.glb", "--leave-out", "Oak", "--leave-out", "Shrub"],
            1,
            "the default scene: found none of the meshes",
        ),
        (&["forest.glb", "--height-map", "a.png"], 2, "--height"),
        (
            &["forest.glb", "--height-map", "a.png", "--height", "0..1", "--area", "0,1"],
            2,
            "--area is [0.0, 1.0]",
        ),
        (&["forest.glb", "--height-map", "none.png", "--height", "0..1", "--area", "9,9"], 4, "none.png"),
        (&["forest.glb", "--ground", "nan"], 2, "--ground is NaN"),
        (&["a.obj"], 2, "scene: found a.obj, an OBJ"),
        (&["none.glb"], 4, "none.glb"),
    ] {
        let run = folder.flb_with(&["scene", "-o", "s.toml"], words);
        assert_eq!(run.code, code, "{words:?}: {}", run.stderr);
        run.says(&[expected]);
    }
    assert!(!folder.path("s.toml").exists());
    folder.write("s.toml", "mine");
    let scene = ["scene", "forest.glb", "-o", "s.toml"];
    folder.flb(&scene).expect_code(4).says(&["s.toml", "use --force"]);
    assert_eq!(folder.read("s.toml"), b"mine");
    folder.flb_with(&scene, &["--force"]).expect_code(0);
    folder.flb(&["scene", "forest.glb", "-o", "forest.glb", "--force"]).expect_code(2);
    folder.write("tiny.toml", "unit_m = 1e-9\n");
    let words = ["scene", "forest.glb", "--species-file", "Oak=tiny.toml", "-o", "t.toml"];
    folder.flb(&words).expect_code(2).says(&["species \"Oak\": at 0.000000001 m per unit a plant has scale"]);
    // Neither is the forest a plant.
    for command in ["bake", "materials"] {
        let words = if command == "bake" { &["-o", "x.flb"][..] } else { &[] };
        let says =
            "holds 5 instances (EXT_mesh_gpu_instancing), a forest or the parts of one plant: name the mesh";
        folder.flb_with(&[command, "forest.glb"], words).expect_code(2).says(&[says, "'Oak', 'Shrub'"]);
        let words = [words, &["--gltf-mesh", "Elm"]].concat();
        folder.flb_with(&[command, "forest.glb"], &words).expect_code(2).says(&["no mesh has this name"]);
    }
    folder.flb(&["materials", "forest.glb", "--gltf-mesh", "*"]).expect_code(0);
    folder.write("shrub.toml", "gltf_mesh = \"Shrub\"\n");
    folder.flb(&["materials", "forest.glb", "--species", "shrub.toml"]).expect_code(0);
    // In a scene file a mesh needs a file that holds it.
    folder.write("bad.toml", "[[species]]\nname = \"a\"\ngltf_mesh = \"Oak\"\nupright = true\n");
    let run = folder.flb(&["plan", "bad.toml", "-o", "p.toml"]).expect_code(1);
    run.says(&["line 3, species: found gltf_mesh without file, expected file, which holds the mesh"]);
}

use std::fs;

use serde_json::{Value, json};

use super::gltf::{Place, ROWS, Row, find};
use super::obj::{MTL, OBJ};
use super::*;
use crate::import::{ImportError, ImportSettings, import};
use crate::mesh::Mesh;

/// A triangle with something of every kind.
fn document() -> Value {
    let bytes = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0, 0.0].map(f32::to_le_bytes).concat();
    let png = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg==";
    use base64::Engine;
    let uri = format!("data:;base64,{}", base64::engine::general_purpose::STANDARD.encode(bytes));
    json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "leaf"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "materials": [{"name": "leaf", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{}],
        "images": [{"uri": png}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": uri}],
        "skins": [{"joints": [0]}],
    })
}

fn read(json: &Value) -> Result<Mesh, ImportError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gltf");
    fs::write(&path, json.to_string()).unwrap();
    import(&path, &ImportSettings::default())
}

/// The object of a kind in `json`, made where it is not there.
fn object(json: &mut Value, place: Place) -> &mut Value {
    let material = |name: &str| format!("/materials/0/extensions/{name}");
    let pointer = match place {
        Place::File => String::new(),
        Place::Asset => "/asset".to_owned(),
        Place::Scene => "/scenes/0".to_owned(),
        Place::Node => "/nodes/0".to_owned(),
        Place::Mesh => "/meshes/0".to_owned(),
        Place::Primitive => "/meshes/0/primitives/0".to_owned(),
        Place::Attributes => "/meshes/0/primitives/0/attributes".to_owned(),
        Place::Target => "/meshes/0/primitives/0/targets/0".to_owned(),
        Place::Accessor => "/accessors/0".to_owned(),
        Place::Sparse => "/accessors/0/sparse".to_owned(),
        Place::BufferView => "/bufferViews/0".to_owned(),
        Place::Buffer => "/buffers/0".to_owned(),
        Place::Image => "/images/0".to_owned(),
        Place::Texture => "/textures/0".to_owned(),
        Place::Sampler => "/samplers/0".to_owned(),
        Place::Material => "/materials/0".to_owned(),
        Place::Pbr => "/materials/0/pbrMetallicRoughness".to_owned(),
        Place::TextureInfo => "/materials/0/pbrMetallicRoughness/baseColorTexture".to_owned(),
        Place::Skin => "/skins/0".to_owned(),
        Place::Extensions => "/materials/0/extensions".to_owned(),
        Place::DiffuseTransmission => material("KHR_materials_diffuse_transmission"),
        Place::SpecularGlossiness => material("KHR_materials_pbrSpecularGlossiness"),
        Place::Transmission => material("KHR_materials_transmission"),
        Place::Volume => material("KHR_materials_volume"),
        Place::Instances => "/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes".to_owned(),
    };
    let mut at = json;
    for key in pointer.split('/').skip(1) {
        at = match (key.parse::<usize>(), at) {
            (Ok(index), list) => {
                if list.is_null() {
                    *list = json!([]);
                }
                let list = list.as_array_mut().unwrap();
                if list.len() <= index {
                    list.push(json!({}));
                }
                &mut list[index]
            }
            (Err(_), object) => {
                if object.is_null() {
                    *object = json!({});
                }
                object.as_object_mut().unwrap().entry(key).or_insert(Value::Null)
            }
        };
    }
    if at.is_null() {
        *at = json!({});
    }
    at
}

/// A name that a row means.
fn name_of(row: &Row) -> String {
    row.name.replace('*', "7")
}

fn with(row: &Row, value: Value) -> Value {
    let mut json = document();
    object(&mut json, row.place)[name_of(row)] = value;
    json
}

/// What a mesh is, without the digests of its file.
fn shape(mesh: Mesh) -> Mesh {
    Mesh { sources: Vec::new(), ..mesh }
}

#[test]
fn every_row_of_gltf_is_read_warned_of_or_without_meaning() {
    let plain = shape(read(&document()).unwrap());
    assert!(plain.warnings.is_empty(), "{:?}", plain.warnings);
    for row in ROWS {
        let example: Value = serde_json::from_str(row.example).unwrap();
        let said =
            |json: &Value| read(json).map(|mesh| mesh.warnings.join("\n")).unwrap_or_else(|e| e.to_string());
        let is_told =
            |text: &str| text.contains(&format!("{} (", name_of(row))) && text.contains("is not read");
        match row.rule {
            // One of instances has its own test in `gltf/tests/instancing.rs`.
            Rule::Warned(_) if row.place == Place::Instances => {}
            Rule::Warned(why) => {
                let text = said(&with(row, example));
                assert!(is_told(&text) && text.contains(why), "{row:?}: {text}");
            }
            Rule::WarnedUnless(why, nothing) => {
                let text = said(&with(row, example));
                assert!(is_told(&text) && text.contains(why), "{row:?}: {text}");
                let text = said(&with(row, serde_json::from_str(nothing).unwrap()));
                assert!(!text.contains(&name_of(row)), "{row:?}: {text}");
            }
            Rule::NoMeaning(_) => match read(&with(row, example)) {
                Ok(mesh) => assert_eq!(shape(mesh), plain, "{row:?}"),
                // An attribute of instances is one of instances, of which the user has to say what they are.
                Err(ImportError::Instanced { .. }) if row.place == Place::Instances => {}
                Err(error) => panic!("{row:?}: {error}"),
            },
            // What is read is looked at: nonsense in its place is an error, or makes another mesh.
            Rule::Read => match read(&with(row, json!("nonsense"))) {
                Ok(mesh) => {
                    let is_noticed = shape(mesh.clone()) != plain;
                    assert!(is_noticed || is_looked_at_elsewhere(row), "{row:?}: {mesh:?}");
                }
                Err(error) => assert!(!error.to_string().is_empty()),
            },
            Rule::Refused(advice) => {
                let mut json = with(row, json!({}));
                json["extensionsRequired"] = json!([row.name]);
                let error = read(&json).unwrap_err().to_string();
                assert!(error.contains(row.name) && error.contains(advice), "{row:?}: {error}");
            }
        }
    }
}

/// Rows of another object than the document's: their own tests are in `gltf/tests`.
fn is_looked_at_elsewhere(row: &Row) -> bool {
    let of_node = ["KHR_node_visibility", "MSFT_lod", "EXT_mesh_gpu_instancing"];
    let of_view = ["EXT_meshopt_compression", "KHR_meshopt_compression", "KHR_mesh_quantization"];
    let of_texture = ["EXT_texture_webp", "KHR_texture_transform"];
    let judged_by_what_it_holds = ["KHR_materials_transmission", "KHR_materials_volume"];
    [&of_node[..], &of_view, &of_texture, &judged_by_what_it_holds].concat().contains(&row.name)
}

#[test]
fn what_no_table_knows_is_warned_of_by_name_once() {
    let mut json = document();
    json["materials"][0]["extensions"] = json!({"ACME_glow": {"strength": 3}});
    json["nodes"][0]["leafiness"] = json!(3);
    json["meshes"][0]["primitives"][0]["attributes"]["WIND"] = json!(0);
    json["materials"]
        .as_array_mut()
        .unwrap()
        .push(json!({"extensions": {"ACME_glow": {}}, "extras": {"any": 1}}));
    let warnings = read(&json).unwrap().warnings;
    let expected = [
        "WIND (meshes[0]) is not read: it is not known",
        "leafiness (nodes[0]) is not read: it is not known",
        "the extension ACME_glow (materials[0] and 1 more) is not read: it is not known",
    ];
    assert_eq!(warnings, expected.map(|text| format!("a.gltf: {text}")));
}

#[test]
fn no_row_is_there_twice() {
    for (at, row) in ROWS.iter().enumerate() {
        assert!(
            ROWS[at + 1..].iter().all(|other| (other.place, other.name) != (row.place, row.name)),
            "{row:?}"
        );
        assert_eq!(find(row.place, &name_of(row)).map(|found| found.name), Some(row.name));
    }
    for rows in [OBJ, MTL] {
        for (at, (name, ..)) in rows.iter().enumerate() {
            assert!(rows[at + 1..].iter().all(|(other, ..)| other != name), "{name}");
        }
    }
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 2 0\nvt 0 0\nvn 0 0 1\n";

fn read_obj(obj: &str, mtl: &str) -> Result<Mesh, ImportError> {
    let folder = tempfile::tempdir().unwrap();
    let png = image::RgbaImage::from_pixel(2, 2, image::Rgba([9, 99, 9, 255]));
    png.save(folder.path().join("a.png")).unwrap();
    let path = folder.path().join("a.obj");
    fs::write(&path, obj).unwrap();
    fs::write(folder.path().join("a.mtl"), mtl).unwrap();
    import(&path, &ImportSettings::default())
}

#[test]
fn every_statement_of_obj_and_mtl_is_read_warned_of_or_without_meaning() {
    let plain = format!("mtllib a.mtl\n{TRIANGLE}usemtl leaf\nf 1/1/1 2/1/1 3/1/1\n");
    let material = "newmtl leaf\nKd 0 1 0\n";
    let expected = shape(read_obj(&plain, material).unwrap());
    assert!(expected.warnings.is_empty(), "{:?}", expected.warnings);
    let cases = OBJ.iter().map(|row| (false, row)).chain(MTL.iter().map(|row| (true, row)));
    for (is_mtl, (keyword, rule, example)) in cases {
        let read = |rest: &str| match is_mtl {
            true => read_obj(&plain, &format!("{material}{keyword} {rest}\n")),
            false => read_obj(&format!("{plain}{keyword} {rest}\n"), material),
        };
        let warned =
            |rest: &str| read(rest).map(|mesh| mesh.warnings.join("\n")).unwrap_or_else(|e| e.to_string());
        match rule {
            Rule::Warned(why) => assert!(warned(example).contains(why), "{keyword}: {}", warned(example)),
            Rule::WarnedUnless(why, nothing) => {
                assert!(warned(example).contains(why), "{keyword}: {}", warned(example));
                assert_eq!(warned(nothing), "", "{keyword}");
            }
            Rule::NoMeaning(_) => assert_eq!(shape(read(example).unwrap()), expected, "{keyword}"),
            Rule::Read => {
                // Each has its own tests; here, that it says nothing of not being read.
                assert!(!warned(example).contains("is not read"), "{keyword}: {}", warned(example));
            }
            Rule::Refused(_) => unreachable!("no statement is refused"),
        }
    }
    let unknown = read_obj(&format!("{plain}leafy 3\nleafy 4\n"), &format!("{material}glow 1\n")).unwrap();
    let expected =
        ["leafy (2 times) is not read: it is not known", "glow (a.mtl) is not read: it is not known"];
    assert_eq!(unknown.warnings, expected.map(|text| format!("a.obj: {text}")));
}

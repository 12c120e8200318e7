//! Tiny glTF files made by code: every way to store a triangle, and every way to store it wrongly.

use std::fs;
use std::path::PathBuf;

use base64::Engine;
use serde_json::{Value, json};

use crate::import::{Fault, ImportError, ImportSettings, Up, import};
use crate::mesh::{AlphaMode, Mesh, Wrap};

mod chosen;
mod hostile;
mod instancing;
mod odd;
mod refusals;
mod said;
mod stand;

const TRIANGLE: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]];

fn bytes_of(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

fn data_uri(bytes: &[u8]) -> String {
    format!(
        "data:application/octet-stream;base64,{}",
        base64::engine::general_purpose::STANDARD.encode(bytes)
    )
}

fn png(width: u32, height: u32, alpha: impl Fn(u32) -> u8) -> Vec<u8> {
    let image = image::RgbaImage::from_fn(width, height, |x, _| image::Rgba([10, 200, 30, alpha(x)]));
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

/// One non-indexed triangle in one mesh, node and scene.
fn one_triangle() -> Value {
    let buffer = bytes_of(TRIANGLE.as_flattened());
    json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"name": "leaf", "primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": data_uri(&buffer)}],
    })
}

/// `one_triangle` with the value at each JSON pointer replaced, or added to an object.
fn changed(changes: &[(&str, Value)]) -> Value {
    let mut json = one_triangle();
    for (pointer, value) in changes {
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        match json.pointer_mut(parent).unwrap() {
            Value::Object(map) => drop(map.insert(key.to_owned(), value.clone())),
            Value::Array(list) => match key.parse::<usize>() {
                Ok(index) if index < list.len() => list[index] = value.clone(),
                _ => list.push(value.clone()),
            },
            other => panic!("{pointer} is in {other}"),
        }
    }
    json
}

fn read_with(
    name: &str,
    bytes: &[u8],
    others: &[(&str, &[u8])],
    settings: &ImportSettings,
) -> Result<Mesh, ImportError> {
    let folder = tempfile::tempdir().unwrap();
    for (other, bytes) in others {
        let path = folder.path().join(other);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
    let path: PathBuf = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    import(&path, settings)
}

fn read(json: &Value) -> Result<Mesh, ImportError> {
    read_with("plant.gltf", json.to_string().as_bytes(), &[], &ImportSettings::default())
}

fn glb(json: &Value, binary: &[u8]) -> Vec<u8> {
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + text.len() + 8 + binary.len();
    let mut bytes = b"glTF".to_vec();
    let words = |bytes: &mut Vec<u8>, words: &[u32]| words.iter().for_each(|w| bytes.extend(w.to_le_bytes()));
    words(&mut bytes, &[2, total as u32, text.len() as u32, 0x4E4F_534A]);
    bytes.extend(text);
    words(&mut bytes, &[binary.len() as u32, 0x004E_4942]);
    bytes.extend(binary);
    bytes
}

fn area_of(mesh: &Mesh) -> f64 {
    mesh.triangles
        .iter()
        .map(|t| crate::import::area(t.map(|v| mesh.positions[v as usize].map(f64::from))))
        .sum()
}

#[test]
fn a_triangle_is_read_with_normal_name_and_digest() {
    let mesh = read(&one_triangle()).unwrap();
    assert_eq!(mesh.positions, TRIANGLE);
    assert_eq!(mesh.normals, [[0.0, 0.0, 1.0]; 3]);
    assert_eq!(mesh.triangles, [[0, 1, 2]]);
    assert_eq!(mesh.materials[0].name, "leaf");
    assert_eq!(mesh.sources[0].name, "plant.gltf");
    assert_eq!(
        mesh.sources[0].blake3,
        blake3::hash(one_triangle().to_string().as_bytes()).to_hex().to_string()
    );
    assert!(mesh.warnings.is_empty(), "{:?}", mesh.warnings);
}

#[test]
fn a_glb_holds_the_same_and_none_of_its_prefixes_is_taken() {
    let bytes =
        glb(&changed(&[("/buffers/0", json!({"byteLength": 36}))]), &bytes_of(TRIANGLE.as_flattened()));
    let mesh = read_with("plant.glb", &bytes, &[], &ImportSettings::default()).unwrap();
    assert_eq!(mesh.positions, TRIANGLE);
    for length in 0..bytes.len() {
        let result = read_with("plant.glb", &bytes[..length], &[], &ImportSettings::default());
        assert!(result.is_err(), "{length} bytes of {} were taken", bytes.len());
    }
}

#[test]
fn flags_turn_and_scale_into_model_space() {
    let settings = ImportSettings { up: Some(Up::Z), unit_m: Some(0.01), ..ImportSettings::default() };
    let json = changed(&[("/nodes/0/translation", json!([0.0, 0.0, 100.0]))]);
    let mesh = read_with("plant.gltf", json.to_string().as_bytes(), &[], &settings).unwrap();
    assert_eq!(mesh.positions, [[0.0, 1.0, 0.0], [0.01, 1.0, 0.0], [0.0, 1.0, -0.02]]);
    assert_eq!(mesh.normals[0], [0.0, 1.0, 0.0]);
    for unit_m in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let settings = ImportSettings { unit_m: Some(unit_m), ..settings.clone() };
        let error = read_with("plant.gltf", json.to_string().as_bytes(), &[], &settings).unwrap_err();
        assert!(error.to_string().starts_with("unit: found"), "{error}");
        assert_eq!(error.fault(), Fault::Usage);
    }
}

#[test]
fn node_transforms_multiply_and_a_mirror_turns_the_winding() {
    let json = changed(&[
        ("/scenes/0/nodes/0", json!(1)),
        ("/nodes/0/scale", json!([-1.0, 1.0, 1.0])),
        ("/nodes/1", json!({"children": [0], "translation": [5.0, 0.0, 0.0]})),
    ]);
    let mesh = read(&json).unwrap();
    let corner = |i: usize| mesh.positions[mesh.triangles[0][i] as usize];
    assert_eq!([corner(0), corner(1), corner(2)], [[5.0, 0.0, 0.0], [5.0, 2.0, 0.0], [4.0, 0.0, 0.0]]);
    assert_eq!(mesh.normals, [[0.0, 0.0, 1.0]; 3]);
}

#[test]
fn one_mesh_may_stand_in_several_places() {
    let json = changed(&[
        ("/scenes/0/nodes/9", json!(1)),
        ("/nodes/1", json!({"mesh": 0, "translation": [0.0, 0.0, 3.0], "camera": 0})),
    ]);
    assert_eq!(read(&json).unwrap().triangles.len(), 2);
}

#[test]
fn quantised_interleaved_positions_and_every_index_type_are_read() {
    for (component, width) in [(5121, 1usize), (5123, 2), (5125, 4)] {
        // Positions as normalised i16 at a stride of 12, byte 2 on; then indices.
        let mut bytes = vec![0xEE; 2];
        for corner in [[0i16, 0, 0], [32767, 0, 0], [0, 32767, 0]] {
            corner.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
            bytes.extend([0xEE; 6]);
        }
        for index in [2u32, 0, 1] {
            bytes.extend(&index.to_le_bytes()[..width]);
        }
        let json = changed(&[
            ("/buffers/0", json!({"byteLength": bytes.len(), "uri": data_uri(&bytes)})),
            ("/bufferViews/0", json!({"buffer": 0, "byteLength": 38, "byteStride": 12})),
            ("/bufferViews/1", json!({"buffer": 0, "byteOffset": 38, "byteLength": 3 * width})),
            (
                "/accessors/0",
                json!({"bufferView": 0, "byteOffset": 2, "componentType": 5122, "normalized": true,
                "count": 3, "type": "VEC3"}),
            ),
            (
                "/accessors/1",
                json!({"bufferView": 1, "componentType": component, "count": 3, "type": "SCALAR"}),
            ),
            ("/meshes/0/primitives/0/indices", json!(1)),
            ("/extensionsRequired", json!(["KHR_mesh_quantization"])),
        ]);
        let mesh = read(&json).unwrap();
        let corner = |i: usize| mesh.positions[mesh.triangles[0][i] as usize];
        assert_eq!([corner(0), corner(1), corner(2)], [[0.0, 1.0, 0.0], [0.0; 3], [1.0, 0.0, 0.0]]);
    }
}

#[test]
fn sparse_values_replace_and_a_missing_view_is_zero() {
    let mut bytes = bytes_of(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    bytes.extend([1, 2]);
    let sparse = json!({"count": 2, "indices": {"bufferView": 1, "componentType": 5121},
        "values": {"bufferView": 0}});
    let json = changed(&[
        ("/buffers/0", json!({"byteLength": 26, "uri": data_uri(&bytes)})),
        ("/bufferViews/0", json!({"buffer": 0, "byteLength": 24})),
        ("/bufferViews/1", json!({"buffer": 0, "byteOffset": 24, "byteLength": 2})),
        ("/accessors/0", json!({"componentType": 5126, "count": 3, "type": "VEC3", "sparse": sparse})),
    ]);
    assert_eq!(read(&json).unwrap().positions, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    for indices in [[2u8, 1], [1, 3], [1, 1]] {
        bytes[24..].copy_from_slice(&indices);
        let mut bad = json.clone();
        bad["buffers"][0]["uri"] = json!(data_uri(&bytes));
        let error = read(&bad).unwrap_err().to_string();
        assert!(error.contains("sparse index"), "{error}");
    }
}

#[test]
fn strips_and_fans_wind_as_the_specification_says() {
    let square = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0];
    let fan = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0];
    for (mode, corners) in [(5, square), (6, fan)] {
        let json = changed(&[
            ("/buffers/0", json!({"byteLength": 48, "uri": data_uri(&bytes_of(&corners))})),
            ("/bufferViews/0/byteLength", json!(48)),
            ("/accessors/0/count", json!(4)),
            ("/meshes/0/primitives/0/mode", json!(mode)),
        ]);
        let mesh = read(&json).unwrap();
        assert_eq!(mesh.triangles.len(), 2);
        assert_eq!(area_of(&mesh), 1.0);
        assert!(
            mesh.normals.iter().all(|normal| *normal == [0.0, 0.0, 1.0]),
            "mode {mode}: {:?}",
            mesh.normals
        );
    }
}

#[test]
fn a_meshopt_view_is_unpacked() {
    let packed = meshopt::encode_vertex_buffer(&TRIANGLE).unwrap();
    let view = json!({"buffer": 1, "byteLength": 36, "byteStride": 12, "extensions": {"EXT_meshopt_compression":
        {"buffer": 0, "byteLength": packed.len(), "byteStride": 12, "count": 3, "mode": "ATTRIBUTES"}}});
    let json = changed(&[
        ("/buffers/0", json!({"byteLength": packed.len(), "uri": data_uri(&packed)})),
        (
            "/buffers/1",
            json!({"byteLength": 36, "extensions": {"EXT_meshopt_compression": {"fallback": true}}}),
        ),
        ("/bufferViews/0", view),
        ("/extensionsRequired", json!(["EXT_meshopt_compression"])),
    ]);
    assert_eq!(read(&json).unwrap().positions, TRIANGLE);
    let extension = "/bufferViews/0/extensions/EXT_meshopt_compression";
    for (key, value) in [
        ("count", json!(4_000_000_000u32)),
        ("count", json!(300)),
        ("byteStride", json!(13)),
        ("byteStride", json!(0)),
        ("byteLength", json!(5)),
        ("mode", json!("TRIANGLES")),
        ("filter", json!("OCTAHEDRAL")),
        ("mode", json!("WHATEVER")),
    ] {
        let mut bad = json.clone();
        bad.pointer_mut(extension).unwrap()[key] = value.clone();
        assert!(read(&bad).is_err(), "{key} {value}");
    }
}

#[test]
fn skinned_vertices_follow_their_joints_and_not_their_node() {
    let mut bytes = bytes_of(TRIANGLE.as_flattened());
    bytes.extend([0u8; 12]);
    bytes.extend(bytes_of(&[1.0, 0.0, 0.0, 0.0].repeat(3)));
    let json = changed(&[
        ("/buffers/0", json!({"byteLength": 96, "uri": data_uri(&bytes)})),
        ("/bufferViews/1", json!({"buffer": 0, "byteOffset": 36, "byteLength": 12})),
        ("/bufferViews/2", json!({"buffer": 0, "byteOffset": 48, "byteLength": 48})),
        ("/accessors/1", json!({"bufferView": 1, "componentType": 5121, "count": 3, "type": "VEC4"})),
        ("/accessors/2", json!({"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC4"})),
        ("/meshes/0/primitives/0/attributes", json!({"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2})),
        ("/nodes/0", json!({"mesh": 0, "skin": 0, "translation": [9.0, 9.0, 9.0]})),
        ("/nodes/1", json!({"translation": [0.0, 0.0, 4.0]})),
        ("/scenes/0/nodes/1", json!(1)),
        ("/skins", json!([{"joints": [1]}])),
    ]);
    let mesh = read(&json).unwrap();
    assert_eq!(mesh.positions[1], [1.0, 0.0, 4.0]);
}

/// Materials that show one texture, with the material's own members given.
fn textured(material: Value, image: &[u8]) -> Value {
    let mut bytes = bytes_of(TRIANGLE.as_flattened());
    bytes.extend(bytes_of(&[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 5.0, 5.0, 6.0, 5.0, 5.0, 6.0]));
    changed(&[
        ("/buffers/0", json!({"byteLength": 84, "uri": data_uri(&bytes)})),
        ("/bufferViews/1", json!({"buffer": 0, "byteOffset": 36, "byteLength": 24})),
        ("/bufferViews/2", json!({"buffer": 0, "byteOffset": 60, "byteLength": 24})),
        ("/accessors/1", json!({"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"})),
        ("/accessors/2", json!({"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC2"})),
        (
            "/meshes/0/primitives/0",
            json!({"attributes": {"POSITION": 0, "TEXCOORD_0": 1, "TEXCOORD_1": 2},
            "material": 0}),
        ),
        ("/materials", json!([material])),
        ("/textures", json!([{"source": 0, "sampler": 0}])),
        ("/samplers", json!([{"wrapS": 33071, "wrapT": 33648}])),
        ("/images", json!([{"name": "card", "uri": data_uri(image)}])),
    ])
}

#[test]
fn textures_bring_wrap_transform_and_their_own_coordinates() {
    let transform = json!({"offset": [0.0, 1.0], "rotation": std::f32::consts::FRAC_PI_2, "scale": [0.5, 0.5], "texCoord": 1});
    let info = json!({"index": 0, "extensions": {"KHR_texture_transform": transform}});
    let material = json!({"name": "a", "alphaMode": "MASK", "alphaCutoff": 0.25,
        "pbrMetallicRoughness": {"baseColorTexture": info, "baseColorFactor": [0.5, 0.5, 0.5, 0.5]},
        "extensions": {"KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 0.5}}});
    let mesh = read(&textured(material, &png(4, 4, |x| if x < 2 { 0 } else { 255 }))).unwrap();
    let material = &mesh.materials[0];
    let texture = material.color_texture.unwrap();
    assert_eq!(texture.wrap, [Wrap::Clamp, Wrap::Mirror]);
    assert_eq!(mesh.uvs[0], [5.0, 5.0]);
    assert_eq!(material.diffuse_transmission, Some(0.5));
    assert_eq!(material.alpha_mode, AlphaMode::Cut { cutoff: 0.5 }, "0.25 over the factor 0.5");
    assert!(mesh.images[0].has_cut);
    // The extension's own example: the lower left quadrant.
    let [u, v] = texture.transform.map(|row| row[0] + row[1] + row[2]);
    assert!((u - 0.5).abs() < 1e-6 && (v - 0.5).abs() < 1e-6, "{u} {v}");
}

#[test]
fn a_mask_without_alpha_is_opaque_and_says_so() {
    let material =
        json!({"name": "a", "alphaMode": "MASK", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}});
    let mesh = read(&textured(material, &png(4, 4, |_| 255))).unwrap();
    assert_eq!(mesh.materials[0].alpha_mode, AlphaMode::Opaque);
    assert!(mesh.warnings[0].contains("'card' has no alpha"), "{:?}", mesh.warnings);
}

#[test]
fn a_texture_that_cannot_be_had_is_a_warning() {
    let material = json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}});
    let cases: [(&[u8], &str); 4] = [
        (b"", "empty"),
        (b"\xABKTX 20\xBB\r\n", "KTX2"),
        (b"\x89PNG\r\n\x1a\nxx", "cannot be decoded"),
        (b"??", "unknown kind"),
    ];
    for (image, word) in cases {
        let mesh = read(&textured(material.clone(), image)).unwrap();
        assert_eq!(mesh.materials[0].color_texture, None);
        assert!(mesh.warnings[0].contains(word), "{:?}", mesh.warnings);
    }
    let mut missing = textured(material, b"");
    missing["images"][0] = json!({"uri": "nowhere.png"});
    assert!(read(&missing).unwrap().warnings[0].contains("'nowhere.png', which is not there"));
}

#[test]
fn a_png_that_claims_huge_dimensions_is_over_the_limit() {
    let mut bomb = png(4, 4, |_| 255);
    // Width and height of IHDR, then its checksum.
    bomb[16..24].copy_from_slice(&[0, 0, 0xFF, 0xFF, 0, 0, 0xFF, 0xFF]);
    let mut crc = !0u32;
    for &byte in &bomb[12..29] {
        crc ^= u32::from(byte);
        (0..8).for_each(|_| crc = (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg()));
    }
    bomb[29..33].copy_from_slice(&(!crc).to_be_bytes());
    let material = json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}});
    let error = read(&textured(material, &bomb)).unwrap_err();
    assert_eq!(error.fault(), Fault::Limit, "{error}");
}

#[test]
fn external_files_are_found_under_the_names_that_exporters_write() {
    let buffer = bytes_of(TRIANGLE.as_flattened());
    for (uri, file) in [
        ("my%20data.bin", "my data.bin"),
        ("DATA.BIN", "data.bin"),
        ("sub\\data.bin", "sub/data.bin"),
        ("C:\\somewhere\\data.bin", "data.bin"),
        ("100%.bin", "100%.bin"),
    ] {
        let json = changed(&[("/buffers/0/uri", json!(uri))]).to_string();
        let mesh = read_with("plant.gltf", json.as_bytes(), &[(file, &buffer)], &ImportSettings::default());
        assert_eq!(mesh.unwrap().sources.len(), 2, "{uri}");
    }
    let error = read(&changed(&[("/buffers/0/uri", json!("gone.bin"))])).unwrap_err();
    assert!(error.to_string().contains("buffers[0] names 'gone.bin', which is not there"), "{error}");
}

//! Files made to harm: each has to end in an error that names the trouble, in little time and memory. The same kinds at
//! their full size, under a hard limit of memory, are in `cli/tests/it/hostile.rs`.

use super::*;

/// One triangle whose JSON is edited as text, for what `serde_json` would not write.
fn text_with(member: &str) -> Vec<u8> {
    let json = one_triangle().to_string();
    format!("{{{member},{}", &json[1..]).into_bytes()
}

#[test]
fn names_of_files_stay_inside_the_folder() {
    let outside = tempfile::tempdir().unwrap();
    let folder = outside.path().join("plant");
    fs::create_dir(&folder).unwrap();
    fs::write(outside.path().join("secret.bin"), bytes_of(TRIANGLE.as_flattened())).unwrap();
    let absolute = outside.path().join("secret.bin").display().to_string();
    let read = |uri: &str| {
        let json = changed(&[("/buffers/0/uri", json!(uri))]).to_string();
        fs::write(folder.join("plant.gltf"), json).unwrap();
        import(&folder.join("plant.gltf"), &ImportSettings::default())
    };
    for uri in ["../secret.bin", "a/../../secret.bin", "..%2Fsecret.bin", "..\\secret.bin", &absolute] {
        let error = read(uri).unwrap_err();
        let text = error.to_string();
        assert!(text.starts_with("plant.gltf: buffers[0] names '"), "{uri}: {text}");
        assert!(text.contains("outside the mesh's folder"), "{uri}: {text}");
        assert_eq!(error.fault(), Fault::Input, "{uri}: {text}");
    }
    // What is not there is missing, wherever it would be; the folder may be left and entered again.
    assert!(read("../none.bin").unwrap_err().to_string().contains("which is not there"));
    fs::copy(outside.path().join("secret.bin"), folder.join("own.bin")).unwrap();
    assert_eq!(read("../plant/./own.bin").unwrap().positions, TRIANGLE);
    // A file of that name inside is meant rather than the one outside.
    fs::copy(outside.path().join("secret.bin"), folder.join("secret.bin")).unwrap();
    assert_eq!(read("../secret.bin").unwrap().positions, TRIANGLE);
}

#[cfg(unix)]
#[test]
fn pipes_devices_and_folders_are_no_buffers() {
    let folder = tempfile::tempdir().unwrap();
    let made = std::process::Command::new("mkfifo").arg(folder.path().join("pipe.bin")).status().unwrap();
    assert!(made.success());
    std::os::unix::fs::symlink("/dev/zero", folder.path().join("zero.bin")).unwrap();
    fs::create_dir(folder.path().join("folder.bin")).unwrap();
    let table = [
        ("pipe.bin", "not a regular file"),
        ("zero.bin", "not a regular file"),
        ("/dev/zero", "outside the mesh's folder"),
        ("/proc/self/mem", "outside the mesh's folder"),
        ("folder.bin", "which is not there"),
        ("", "which is not there"),
        (".", "which is not there"),
        ("a\0b", "which is not there"),
        ("file:///etc/passwd", "which is not there"),
        ("https://example.org/a.bin", "which is not there"),
    ];
    for (uri, words) in table {
        let json = changed(&[("/buffers/0/uri", json!(uri))]).to_string();
        fs::write(folder.path().join("plant.gltf"), json).unwrap();
        let error = import(&folder.path().join("plant.gltf"), &ImportSettings::default()).unwrap_err();
        assert!(error.to_string().contains(words), "{uri:?}: {error}");
        assert!(matches!(error.fault(), Fault::Io | Fault::Input), "{uri:?}: {error}");
    }
}

#[test]
fn endless_names_are_over_a_limit_and_not_repeated_in_the_message() {
    let long = "x".repeat(100_000);
    for (pointer, value, words) in [
        ("/buffers/0/uri", json!(long), "bytes of a file's name: 100000"),
        ("/meshes/0/name", json!(long), "bytes of a name: 100000"),
        ("/asset/version", json!(long), "expected 2.x"),
        ("/extensionsRequired", json!([long]), "not supported"),
        ("/asset", json!(long), "invalid type: string"),
        ("/nodes/0/extensions", json!({"EXT_mesh_gpu_instancing": {"attributes": long}}), "invalid type"),
    ] {
        let error = read(&changed(&[(pointer, value)])).unwrap_err().to_string();
        assert!(error.contains(words), "{pointer}: {}", &error[..error.len().min(300)]);
        assert!(error.len() < 1000, "{pointer}: a message of {} bytes", error.len());
    }
    let material = json!({"name": long});
    let error = read(&textured(material, b"")).unwrap_err().to_string();
    assert!(error.starts_with("plant.gltf: materials[0]: bytes of a name: 100000 is over"), "{error}");
}

#[test]
fn more_files_than_anyone_names_are_over_a_limit() {
    let images: Vec<Value> = (0..20_000).map(|i| json!({"uri": format!("{i}.png")})).collect();
    let textures: Vec<Value> = (0..20_000).map(|i| json!({"source": i})).collect();
    let materials: Vec<Value> =
        (0..20_000).map(|i| json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": i}}})).collect();
    let primitives: Vec<Value> =
        (0..20_000).map(|i| json!({"attributes": {"POSITION": 0}, "material": i})).collect();
    let json = changed(&[
        ("/images", json!(images)),
        ("/textures", json!(textures)),
        ("/materials", json!(materials)),
        ("/meshes/0/primitives", json!(primitives)),
    ]);
    let error = read(&json).unwrap_err();
    assert!(error.to_string().contains("files that are named: 16385 is over the limit"), "{error}");
}

#[test]
fn extras_of_any_kind_and_size_cost_nothing() {
    let mut deep = "1".to_owned();
    for i in 0..100_000 {
        deep.push_str(if i % 2 == 0 { ",[]" } else { ",\"\\\"}]\"" });
    }
    for extras in
        [format!("[{deep}]"), "\"a, \\\"extras\\\": {\"".to_owned(), "3".to_owned(), " [ { } ] ".to_owned()]
    {
        let mesh = read_with(
            "plant.gltf",
            &text_with(&format!("\"extras\" :{extras},\"extra\":\"\\u0041\"")),
            &[],
            &ImportSettings::default(),
        );
        assert_eq!(mesh.unwrap().positions, TRIANGLE);
    }
    for broken in
        ["\"extras\":", "\"extras\"", "\"extras\":[", "\"extras\":\"", "\"extras\":3]", "\"extras\"::"]
    {
        for text in [format!("{{{broken}"), format!("{{{broken}}}"), broken.to_owned()] {
            let error = read_with("a.gltf", text.as_bytes(), &[], &ImportSettings::default()).unwrap_err();
            assert!(matches!(error, ImportError::Syntax { .. }), "{text}: {error}");
        }
    }
}

#[test]
fn one_image_that_cuts_many_materials_is_over_a_limit() {
    let edge = 2048;
    let image = png(edge, edge, |x| if x == 0 { 0 } else { 255 });
    let count = (1u32 << 30) / (edge * edge) + 1;
    let material = |i: u32| {
        json!({"name": format!("leaf{i}"), "alphaMode": "MASK", "alphaCutoff": f64::from(i) / 1000.0,
            "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}})
    };
    let mut json = textured(material(1), &image);
    json["materials"] = (1..=count).map(material).collect();
    json["meshes"][0]["primitives"] =
        (0..count).map(|i| json!({"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": i})).collect();
    let error = read(&json).unwrap_err();
    assert!(error.to_string().contains("texels that cut, over all materials"), "{error}");
    json["materials"]
        .as_array_mut()
        .unwrap()
        .iter_mut()
        .for_each(|material| material["alphaMode"] = json!("OPAQUE"));
    assert_eq!(read(&json).unwrap().materials.len(), count as usize);
}

#[test]
fn huge_numbers_in_materials_and_transforms_do_no_harm() {
    let huge = json!({"offset": [3e38, -3e38], "rotation": 3e38, "scale": [1e39, -1e39]});
    let info = json!({"index": 0, "extensions": {"KHR_texture_transform": huge}});
    let material = json!({"alphaMode": "MASK", "alphaCutoff": 1e39, "pbrMetallicRoughness":
        {"baseColorTexture": info, "baseColorFactor": [1e39, -1e39, 0.0, 0.0]}});
    // Any verdict will do; a panic or a loop over as many texels will not.
    let _ = read(&textured(material, &png(4, 4, |x| if x < 2 { 0 } else { 255 })));
    let chain: Vec<Value> = (0..20)
        .map(|i| json!({"children": [i + 1], "scale": [1e38, 1e38, 1e38]}))
        .chain([json!({"mesh": 0})])
        .collect();
    let error = read(&changed(&[("/nodes", json!(chain))])).unwrap_err();
    assert!(matches!(error, ImportError::NotFinite { .. }), "{error}");
}

#[test]
fn views_and_accessors_cannot_reach_past_their_end() {
    let most = u64::MAX;
    let table: Vec<(Vec<(&str, Value)>, &str)> = vec![
        (vec![("/bufferViews/0/byteStride", json!(most))], "to end within"),
        (vec![("/bufferViews/0/byteStride", json!(13))], "13 apart"),
        (vec![("/bufferViews/0/byteOffset", json!(most - 35))], "to end within the 36"),
        (vec![("/accessors/0/byteOffset", json!(1))], "from byte 1"),
        (
            vec![(
                "/accessors/0/sparse",
                json!({"count": most, "indices": {"bufferView": 0, "componentType": 5121},
                "values": {"bufferView": 0}}),
            )],
            "sparse.count",
        ),
        (
            vec![(
                "/accessors/0/sparse",
                json!({"count": 3, "indices": {"bufferView": 0, "byteOffset": most,
                "componentType": 5125}, "values": {"bufferView": 0}}),
            )],
            "to end within",
        ),
        (
            vec![(
                "/accessors/0/sparse",
                json!({"count": 3, "indices": {"bufferView": 9, "componentType": 5125},
                "values": {"bufferView": 0}}),
            )],
            "bufferView 9",
        ),
        (vec![("/accessors/0/count", json!(-1))], "invalid value"),
        (vec![("/buffers/0/byteLength", json!(1e300))], "invalid type"),
        (
            vec![
                ("/accessors/1", json!({"componentType": 5126, "count": 4_000_000, "type": "VEC3"})),
                (
                    "/nodes/0/extensions",
                    json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 1}}}),
                ),
            ],
            "over the limit",
        ),
        (
            vec![
                ("/accessors/1", json!({"componentType": 5125, "count": 4_000_000_000u32, "type": "SCALAR"})),
                ("/meshes/0/primitives/0/indices", json!(1)),
            ],
            "an accessor without bufferView",
        ),
        (vec![("/scenes/0/nodes", json!(vec![0; 5_000_000]))], "bytes of memory"),
        (vec![("/nodes/0/children", json!(vec![0; 5_000_000]))], "bytes of memory"),
    ];
    for (changes, words) in table {
        let error = read(&changed(&changes)).expect_err(words).to_string();
        assert!(error.contains(words), "{words}: {error}");
    }
}

#[test]
fn flipped_bits_do_not_panic() {
    let material = json!({"alphaMode": "MASK", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}});
    let json = textured(material, &png(2, 2, |x| 255 * x as u8));
    let bytes = glb(&json, b"1234");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.glb");
    let mut damaged = bytes.clone();
    for bit in (0..bytes.len() * 8).step_by(3) {
        damaged[bit / 8] ^= 1 << (bit % 8);
        fs::write(&path, &damaged).unwrap();
        // Any verdict will do.
        let _ = import(&path, &ImportSettings::default());
        damaged[bit / 8] ^= 1 << (bit % 8);
    }
}

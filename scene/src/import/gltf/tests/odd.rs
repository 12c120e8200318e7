//! What exporters get wrong, or leave out: joints that are not there, textures without coordinates, numbers that are
//! stored nowhere, two models of one material.

use super::said::{float, with_accessors};
use super::*;
use crate::alpha::Coverage;

#[test]
fn weights_on_joints_that_a_skin_lacks_are_told_and_left_out() {
    let with = |joints: [u8; 4], weights: [f32; 4]| {
        let json = changed(&[
            ("/nodes/0", json!({"mesh": 0, "skin": 0})),
            ("/nodes/1", json!({"translation": [8.0, 0.0, 0.0]})),
            ("/scenes/0/nodes", json!([0, 1])),
            ("/skins", json!([{"joints": [1]}])),
            ("/meshes/0/primitives/0/attributes", json!({"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2})),
        ]);
        let bytes = json!({"componentType": 5121, "count": 3, "type": "VEC4"});
        let accessors =
            vec![([joints; 3].concat(), bytes), (bytes_of(&[weights; 3].concat()), float(3, "VEC4"))];
        let mesh = read(&with_accessors(json, accessors)).unwrap();
        (mesh.bounds().unwrap().min[0], mesh.warnings.join("; "))
    };
    assert_eq!(with([0, 9, 9, 9], [1.0, 0.0, 0.0, 0.0]), (8.0, String::new()));
    let (at, told) = with([0, 9, 0, 0], [0.5, 0.5, 0.0, 0.0]);
    assert_eq!(at, 8.0, "half of a vertex is no vertex");
    assert!(
        told.contains(
            "3 of 3 vertices have no weight, or one on a joint that is not among the 1 of its skin"
        )
    );
    let (at, told) = with([0; 4], [0.0; 4]);
    assert!(at == 0.0 && told.contains("3 of 3 vertices have no weight"), "{at} {told}");
}

#[test]
fn a_texture_without_coordinates_is_told() {
    let textured = |width: u32| {
        let image = image::RgbaImage::from_pixel(width, width, image::Rgba([80, 160, 40, 255]));
        let mut png = std::io::Cursor::new(Vec::new());
        image.write_to(&mut png, image::ImageFormat::Png).unwrap();
        let json = changed(&[
            ("/meshes/0/primitives/0/material", json!(0)),
            ("/materials", json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}])),
            ("/textures", json!([{"source": 0}])),
            ("/images", json!([{"uri": "a.png"}])),
        ]);
        let bytes = json.to_string();
        let settings = ImportSettings::default();
        read_with("plant.gltf", bytes.as_bytes(), &[("a.png", png.get_ref())], &settings).unwrap().warnings
    };
    assert!(textured(2)[0].contains("lacks TEXCOORD_0, which its texture reads: its first texel is taken"));
    assert!(textured(1).is_empty(), "one texel is the same everywhere");
}

#[test]
fn a_share_that_one_point_of_a_palette_shows_is_that_share() {
    let palette = image::RgbaImage::from_fn(4, 4, |x, _| match x {
        0 | 1 => image::Rgba([60, 160, 40, 255]),
        _ => image::Rgba([120, 80, 40, 128]),
    });
    let mut png = std::io::Cursor::new(Vec::new());
    palette.write_to(&mut png, image::ImageFormat::Png).unwrap();
    for (u, factor, expected) in
        [(0.2, 0.4, 0.4), (0.37, 0.4, 0.4), (0.8, 1.0, 0.5), (0.8, 0.4, 0.2), (0.2, 1.0, 1.0)]
    {
        let base = json!({"baseColorTexture": {"index": 0}, "baseColorFactor": [1.0, 1.0, 1.0, factor]});
        let json = changed(&[
            ("/meshes/0/primitives/0/material", json!(0)),
            ("/meshes/0/primitives/0/attributes/TEXCOORD_0", json!(1)),
            ("/materials", json!([{"name": "leaves", "alphaMode": "BLEND", "pbrMetallicRoughness": base}])),
            ("/textures", json!([{"source": 0}])),
            ("/images", json!([{"uri": "a.png"}])),
        ]);
        let json = with_accessors(json, vec![(bytes_of(&[u, 0.6, u, 0.6, u, 0.6]), float(3, "VEC2"))]);
        let settings = ImportSettings::default();
        let bytes = json.to_string();
        let mesh = read_with("plant.gltf", bytes.as_bytes(), &[("a.png", png.get_ref())], &settings).unwrap();
        assert_eq!(mesh.materials.len(), 1, "nothing is left of the whole image");
        let coverage = Coverage::of_all(&mesh, false).unwrap();
        let (mut there, mut color) = (0.0, glam::DVec3::ZERO);
        crate::color::on_surface(&mesh, &coverage, |_, texel, area| {
            there += area;
            color += texel.as_dvec3() * area;
        });
        let all: f64 = mesh.parts.iter().flat_map(|part| &part.uses).map(|used| used.area_m2).sum();
        assert!((there / all - expected).abs() < 0.02, "{u} {factor}: {} of {all}", there / all);
        let bytes: [u8; 3] = if u < 0.5 { [60, 160, 40] } else { [120, 80, 40] };
        let [r, g, b] = bytes.map(|byte| crate::texture::linear(f64::from(byte) / 255.0));
        assert!((color / there - glam::DVec3::new(r, g, b)).length() < 1e-3, "{}", color / there);
    }
}

#[test]
fn a_palette_of_the_nearest_texel_is_not_mixed() {
    let palette = image::RgbImage::from_fn(2, 1, |x, _| image::Rgb([[0, 255, 0], [255, 0, 0]][x as usize]));
    let mut png = std::io::Cursor::new(Vec::new());
    palette.write_to(&mut png, image::ImageFormat::Png).unwrap();
    let of = |sampler: Value| {
        let json = changed(&[
            ("/meshes/0/primitives/0/material", json!(0)),
            ("/materials", json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}])),
            ("/textures", json!([{"source": 0, "sampler": 0}])),
            ("/samplers", json!([sampler])),
            ("/images", json!([{"uri": "a.png"}])),
        ]);
        let bytes = json.to_string();
        let mesh = read_with(
            "plant.gltf",
            bytes.as_bytes(),
            &[("a.png", png.get_ref())],
            &ImportSettings::default(),
        );
        let mesh = mesh.unwrap();
        let table = crate::texture::SrgbTable::new();
        let color = crate::texture::color(&mesh.materials[0], &mesh.images, &table, [0.45, 0.5]);
        let said =
            mesh.warnings.iter().any(|warning| warning.contains("textures[0] has an unknown magFilter"));
        (color.to_array(), said)
    };
    assert_eq!(of(json!({"magFilter": 9728})), ([0.0, 1.0, 0.0], false));
    for mixed in [json!({}), json!({"magFilter": 9729}), json!({"minFilter": 9728})] {
        let (color, said) = of(mixed);
        assert!(color[0] > 0.3 && !said);
    }
    let (color, said) = of(json!({"magFilter": 9984}));
    assert!(color[0] > 0.3 && said);
}

#[test]
fn attributes_without_numbers_are_told_or_refused_with_what_compresses_them() {
    let bare = changed(&[
        ("/meshes/0/primitives/0/attributes/TEXCOORD_0", json!(1)),
        ("/accessors/1", json!({"componentType": 5126, "count": 3, "type": "VEC2"})),
    ]);
    let told = read(&bare).unwrap().warnings.join("; ");
    assert!(
        told.contains("TEXCOORD: its accessor has no bufferView, so that all its numbers are 0"),
        "{told}"
    );
    let mut compressed = bare;
    compressed["meshes"][0]["primitives"][0]["extensions"] = json!({"KHR_draco_mesh_compression": {}});
    let error = read(&compressed).unwrap_err().to_string();
    assert!(
        error.contains("KHR_draco_mesh_compression") && error.contains("TEXCOORD is nowhere else"),
        "{error}"
    );
}

#[test]
fn the_older_model_of_a_material_says_all_of_its_colour_and_an_image_that_is_not_read_has_another() {
    let image = |color: [u8; 4]| {
        let mut png = std::io::Cursor::new(Vec::new());
        let pixel = image::RgbaImage::from_pixel(1, 1, image::Rgba(color));
        pixel.write_to(&mut png, image::ImageFormat::Png).unwrap();
        png.into_inner()
    };
    let files: [(&str, &[u8]); 2] = [("a.png", &image([200, 30, 20, 0])), ("b.webp", b"none")];
    let of = |material: Value, texture: Value| {
        let json = changed(&[
            ("/meshes/0/primitives/0/material", json!(0)),
            ("/materials", json!([material])),
            ("/textures", json!([texture])),
            ("/images", json!([{"uri": "a.png"}, {"uri": "b.webp"}])),
        ]);
        read_with("plant.gltf", json.to_string().as_bytes(), &files, &ImportSettings::default()).unwrap()
    };
    let base = json!({"baseColorTexture": {"index": 0}, "baseColorFactor": [0.5, 0.5, 0.5, 1.0]});
    let older = |members: Value| {
        let extensions = json!({"KHR_materials_pbrSpecularGlossiness": members});
        let mesh = of(json!({"pbrMetallicRoughness": base, "extensions": extensions}), json!({"source": 0}));
        (mesh.materials[0].base_color[0], mesh.materials[0].color_texture.is_some())
    };
    assert_eq!(older(json!({"diffuseFactor": [0.2, 0.2, 0.2, 1.0]})), (0.2, false));
    assert_eq!(older(json!({"diffuseTexture": {"index": 0}})), (1.0, true));
    assert_eq!(older(json!({"glossinessFactor": 0.1})), (0.5, true));
    let webp = json!({"source": 0, "extensions": {"EXT_texture_webp": {"source": 1}}});
    let mesh = of(json!({"pbrMetallicRoughness": base}), webp);
    assert_eq!(mesh.images.first().map(|image| image.name.as_str()), Some("a.png"), "{:?}", mesh.warnings);
    // Without a factor nothing passes, as the extension says.
    let none =
        json!({"KHR_materials_diffuse_transmission": {"diffuseTransmissionColorFactor": [0.1, 0.3, 0.1]}});
    let mesh = of(json!({"extensions": none}), json!({"source": 0}));
    assert_eq!(mesh.materials[0].diffuse_transmission, Some(0.0));
    assert!(mesh.notes[0].contains("light that passes"), "{:?}", mesh.notes);
    // Of what passes, zeros are what they say.
    let passing = json!({"diffuseTransmissionFactor": 0.4, "diffuseTransmissionTexture": {"index": 0}});
    let extensions = json!({"KHR_materials_diffuse_transmission": passing});
    let mesh = of(json!({"extensions": extensions}), json!({"source": 0}));
    assert_eq!(mesh.materials[0].diffuse_transmission, Some(0.0), "{:?}", mesh.warnings);
}

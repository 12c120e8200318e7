//! Writes the inputs that fuzzing starts from: golden files, built-in plants, and small texts that use every feature.
//! `cargo run -p flb-tests --example seeds -- fuzz/corpus`

use std::fs;
use std::path::{Path, PathBuf};

use flb_fixtures::{PlantKind, grow};

/// A glTF of one triangle with everything that a small file can hold; `#` stands for base64 of the buffer.
const RICH: &str = r##"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],"nodes":[{"mesh":0,"children":[2],
"translation":[0,1,0],"rotation":[0,0,0,1],"scale":[1,2,1],"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":0}}}},
{"mesh":0,"skin":0},{"name":"joint","matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}],"skins":[{"joints":[2]}],
"meshes":[{"name":"leaf","primitives":[{"attributes":{"POSITION":0,"NORMAL":0,"TEXCOORD_0":1,"JOINTS_0":2,"WEIGHTS_0":3},"indices":4,
"material":0},{"attributes":{"POSITION":0,"TEXCOORD_0":1},"mode":5,"material":1}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},{"bufferView":0,"componentType":5126,"count":3,"type":"VEC2"},
{"bufferView":0,"componentType":5121,"count":3,"type":"VEC4"},{"bufferView":0,"componentType":5121,"normalized":true,"count":3,"type":"VEC4"},
{"bufferView":1,"componentType":5121,"count":3,"type":"SCALAR","sparse":{"count":1,"indices":{"bufferView":1,"componentType":5121},
"values":{"bufferView":1}}}],"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":3}],
"buffers":[{"byteLength":39,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAAEAAAAAAAAEC"}],
"materials":[{"name":"leaf","alphaMode":"MASK","alphaCutoff":0.5,"pbrMetallicRoughness":{"baseColorFactor":[1,1,1,0.9],
"baseColorTexture":{"index":0,"extensions":{"KHR_texture_transform":{"offset":[0,0.5],"rotation":0.1,"scale":[2,2],"texCoord":0}}}}},
{"alphaMode":"BLEND","extensions":{"KHR_materials_pbrSpecularGlossiness":{"diffuseTexture":{"index":0}},
"KHR_materials_diffuse_transmission":{"diffuseTransmissionFactor":0.5}}}],"textures":[{"source":0,"sampler":0}],
"samplers":[{"wrapS":33071,"wrapT":33648}],"images":[{"uri":"a.png"}],"extras":[1,"x"]}"##;

/// A glTF of a triangle that stands in places of an extension and of a node, with a camera and a sun.
const FOREST: &str = r##"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0,1,2]}],"nodes":[{"name":"grove","mesh":0,"extensions":
{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":0,"ROTATION":1,"SCALE":2,"_ID":3}}}},{"mesh":0,"translation":[1,0,2],
"rotation":[0,0.6,0,0.8],"scale":[2,2,2]},{"camera":0,"rotation":[0,1,0,0],"extensions":{"KHR_lights_punctual":{"light":0}}}],
"meshes":[{"name":"Oak","primitives":[{"attributes":{"POSITION":0}}]}],"cameras":[{"type":"perspective","perspective":{"yfov":0.8,
"znear":0.1}}],"extensions":{"KHR_lights_punctual":{"lights":[{"type":"directional"}]}},"accessors":[{"bufferView":0,"componentType":5126,
"count":3,"type":"VEC3"},{"bufferView":1,"componentType":5120,"normalized":true,"count":3,"type":"VEC4"},{"bufferView":2,
"componentType":5126,"count":3,"type":"VEC3"},{"bufferView":1,"componentType":5121,"count":3,"type":"SCALAR"}],"bufferViews":[{"buffer":0,
"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":12},{"buffer":0,"byteOffset":48,"byteLength":36}],"buffers":[{"byteLength":84,
"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAAEAAAAAAAAAAfwAAAH8AAAB/AACAPwAAgD8AAIA/AACAPwAAgD8AAIA/AACAPwAAgD8AAIA/"}]}"##;

const OBJ: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.4 0\nvt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\n\
    g top\nusemtl m\nf 1/1/1 2/2/1 3/3/1 4/1/1 5/2/1\nf -1//1 -2//1 \\\n-3//1\nusemtl bark\nf 1 2 3\nl 1 2\np 1\n";
const MTL: &str = "newmtl m\nKd 0.2 0.5 0.1\nd 1\nmap_Kd -s 2 2 1 -o 0.5 0 0 -clamp on a.png\nmap_d -imfchan m a.png\n\
    newmtl bark\nKd 0.4\nTr 0.1\n";

const SPECIES: &str = include_str!("../../scene/src/species.rs");
const SCENE: &str = "bands = [\"R\", \"G\"]\n[sky]\nambient = 0.1\n[sun]\n\
    path = { latitude_deg = 50.0, longitude_deg = 8.0, from = 2026-01-01, to = 2026-12-31 }\n\
    [camera]\npath_m = [[0.0, 2.0, 0.0], [1.0, 2.0, 0.0]]\nfov_deg = 60.0\nheight_px = 1080\n\
    [[species]]\nname = \"oak\"\nfile = \"oak.flb\"\nupright = true\n\
    [[instance]]\nspecies = \"oak\"\nposition_m = [1.0, 0.0, 2.0]\nyaw_deg = 30.0\nscale = 1.5\n\
    [[instance]]\nspecies = \"oak\"\nposition_m = [1.0, 0.0, 2.0]\nrotation = [0.0, 0.0, 0.0, 1.0]\n";
/// A scene that writes its instances as an array, before anything else.
const ARRAY: &str = "light = \"\"\"\n[[instance]]\n\"\"\"\ninstance = [\n  { species = \"oak\", position_m = [0, 0, 0] }, # one\n\
    { 'species' = 'fir', position_m = [1,\n2, 3], yaw_deg = -5 },\n]\n\
    species = [{ name = \"oak\" }, { name = \"fir\", upright = true }]\n[ground]\nheight_m = 0\n[water]\nheight_m = 0.5\n";

/// Kinds of images that are read. TGA is written without a mark of its kind.
const IMAGES: [(image::ImageFormat, &str); 5] = [
    (image::ImageFormat::Png, "rgba.png"),
    (image::ImageFormat::Jpeg, "rgb.jpg"),
    (image::ImageFormat::WebP, "rgba.webp"),
    (image::ImageFormat::Bmp, "rgba.bmp"),
    (image::ImageFormat::Tga, "rgba.tga"),
];

fn main() {
    let corpus =
        PathBuf::from(std::env::args().nth(1).expect("the folder to write to, as in `-- fuzz/corpus`"));
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("../format-spec/golden");
    let files = [golden.clone(), golden.join("v0.1")]
        .map(|folder| fs::read_dir(folder).expect("golden files are in the repository"));
    for entry in files.into_iter().flatten() {
        let path = entry.expect("an entry").path();
        let Some(name) = path.file_name().filter(|name| name.to_string_lossy().ends_with(".flb")) else {
            continue;
        };
        let bytes = fs::read(&path).expect("a golden file");
        for target in ["open", "page", "validate", "rewrite"] {
            let draft =
                if path.parent().is_some_and(|folder| folder.ends_with("v0.1")) { "draft-" } else { "" };
            write(&corpus, target, &format!("{draft}{}", name.to_string_lossy()), &bytes);
        }
    }
    for kind in PlantKind::ALL {
        let plant = grow(kind, 1, kind.fewest_triangles()).expect("the fewest triangles are enough");
        write(&corpus, "gltf", &format!("{}.glb", kind.name()), &plant.to_glb());
    }
    write(&corpus, "gltf", "rich.gltf", RICH.as_bytes());
    write(&corpus, "gltf", "forest.gltf", FOREST.as_bytes());
    write(&corpus, "obj", "quad.obj", [OBJ, "\0", MTL].concat().as_bytes());
    // The examples in the documentation of species files: lines of its code blocks, less the marks.
    let documented: Vec<&str> = SPECIES.lines().filter_map(|line| line.strip_prefix("//! ")).collect();
    for (i, block) in documented.split(|line| line.starts_with("```")).enumerate().filter(|(i, _)| i % 2 == 1)
    {
        write(&corpus, "species_file", &format!("species-{i}.toml"), block.join("\n").as_bytes());
    }
    // Servers are bytes that say nothing to a reader, so that the regressions are the only copy.
    let servers = Path::new(env!("CARGO_MANIFEST_DIR")).join("regressions/remote");
    for server in fs::read_dir(servers).expect("a folder") {
        let server = server.expect("an entry");
        let bytes = fs::read(server.path()).expect("it can be read");
        write(&corpus, "remote", &server.file_name().to_string_lossy(), &bytes);
    }
    write(&corpus, "scene", "tables.toml", SCENE.as_bytes());
    write(&corpus, "scene", "array.toml", ARRAY.as_bytes());
    for (format, name) in IMAGES {
        let mut bytes = std::io::Cursor::new(Vec::new());
        let image = image::RgbaImage::from_fn(5, 3, |x, y| {
            image::Rgba([40 * x as u8, 9, 80 * y as u8, 85 * (x % 4) as u8])
        });
        let image = image::DynamicImage::from(image);
        let written = match format {
            image::ImageFormat::Jpeg => image.to_rgb8().write_to(&mut bytes, format),
            _ => image.write_to(&mut bytes, format),
        };
        written.expect("a small image");
        write(&corpus, "texture", name, bytes.get_ref());
    }
}

fn write(corpus: &Path, target: &str, name: &str, bytes: &[u8]) {
    let folder = corpus.join(target);
    fs::create_dir_all(&folder).expect("a folder for the target");
    fs::write(folder.join(name), bytes).expect("a seed");
}

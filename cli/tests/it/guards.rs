//! No command overwrites what it has read, or what another input names; none writes two outputs into one file. Which
//! files a command reads is seen from outside, by `strace`, and not from a list.
#![cfg(target_os = "linux")]

use std::collections::BTreeMap;
use std::os::unix::fs::symlink;

use crate::flb::{self, Folder};
use crate::strace;

/// A plant of all kinds of files: an OBJ with its MTL and texture, a glTF with its buffer and texture, a species file;
/// its light, a scene of it with a height map, the light of the scene, a plan.
fn folder() -> Folder {
    let folder = Folder::with_card();
    let image = |name: &str| {
        let file = std::fs::File::create(folder.path(name)).expect("writable");
        let mut encoder = png::Encoder::new(file, 2, 2);
        encoder.set_color(png::ColorType::Grayscale);
        encoder
            .write_header()
            .and_then(|mut writer| writer.write_image_data(&[9, 200, 120, 30]))
            .expect("a PNG");
    };
    ["tex.png", "ktex.png", "hills.png", "normal.png"].into_iter().for_each(image);
    folder.write("a.mtl", "newmtl leaf\nmap_Kd ktex.png\nmap_Bump -bm 0.5 normal.png\n");
    folder.write(
        "a.obj",
        "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl leaf\nf 1/1 2/2 3/3\n",
    );
    let positions: Vec<u8> =
        [0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].into_iter().flat_map(f32::to_le_bytes).collect();
    folder.write("s.bin", [&positions[..], &positions[..24]].concat());
    folder.write(
        "s.gltf",
        serde_json::json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}],
            "materials": [{"name": "leaf", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
            "textures": [{"source": 0}], "images": [{"uri": "tex.png"}, {"uri": "normal.png"}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
                          {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"}],
            "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 24}],
            "buffers": [{"byteLength": 60, "uri": "s.bin"}],
        })
        .to_string(),
    );
    folder.write("oak.toml", "leaf = [\"leaf\"]\n");
    for (mesh, light) in [("s.gltf", "s.flb"), ("a.obj", "a.flb")] {
        let small = ["--lattice", "16", "--voxels", "64", "--species", "oak.toml"];
        folder.flb_with(&["bake", mesh, "-o", light], &small).expect_code(0);
    }
    folder.write(
        "scene.toml",
        "light = \"stand.flb\"\n[camera]\nposition_m = [0.0, 2.0, 6.0]\nlook_at_m = [0.0, 0.5, 0.0]\nfov_deg = 40.0\n\
         height_px = 16\n[sun]\nfixed = [[90.0, 40.0]]\n\
         [ground]\nheight_map = \"hills.png\"\norigin_m = [-9.0, 0.0, -9.0]\nsize_m = [18.0, 18.0]\nheight_m = [0.0, 0.1]\n\
         [[species]]\nname = \"s\"\nfile = \"s.gltf\"\nspecies_file = \"oak.toml\"\nlight = \"s.flb\"\n\
         [[instance]]\nspecies = \"s\"\nposition_m = [0.0, 0.2, 0.0]\n",
    );
    folder.flb(&["bake-scene", "scene.toml", "--lattice", "16", "-o", "stand.flb"]).expect_code(0);
    folder.flb(&["plan", "scene.toml", "-o", "plan.toml"]).expect_code(0);
    folder
}

/// Words of each command with `OUT` where an output goes, and the ending that the output's name must have.
const COMMANDS: [(&str, &str); 16] = [
    ("bake s.gltf --species oak.toml --lattice 16 --voxels 64 -o OUT --force", ""),
    ("bake s.gltf --species oak.toml --lattice 16 --voxels 64 -o new.flb --keep-fields OUT --force", ""),
    ("bake a.obj --lattice 16 --voxels 64 --model paper -o OUT --force --cache kept", ""),
    ("bake s.gltf --plan plan.toml --species oak.toml --voxels 64 --model paper -o OUT --force", ""),
    ("bake-scene scene.toml --lattice 16 -o OUT --force", ""),
    ("plan scene.toml -o OUT --force", ".toml"),
    ("pack s.flb a.flb -o OUT --force", ""),
    ("migrate s.flb -o OUT --force", ""),
    ("extract s.flb --base 1 --format npy -o OUT --force", ".npy"),
    ("render s.flb --mesh s.gltf --sun 1,40 --size 8x8 -o OUT --force", ".png"),
    ("render scene.toml --size 8x8 -o OUT --force", ".png"),
    ("stream s.flb scene.toml --seconds 0.1 --trace OUT --force", ""),
    (
        "scatter --species s=s.gltf,s.flb --count 2 --area 9,9 --height-map hills.png --height 0..1 -o OUT --force",
        ".toml",
    ),
    ("scene s.gltf --light #0=s.flb --species-file #0=oak.toml -o OUT --force", ".toml"),
    ("scene s.gltf --height-map hills.png --height 0..1 --area 18,18 -o OUT --force", ".toml"),
    ("view scene.toml --size 64x64 --screenshot OUT --force", ".png"),
];

fn contents(folder: &Folder) -> BTreeMap<String, Vec<u8>> {
    let files = folder.names().into_iter().filter(|name| folder.path(name).is_file());
    files.map(|name| (name.clone(), folder.read(&name))).collect()
}

#[test]
fn what_a_command_reads_or_a_scene_names_is_no_output_of_it() {
    let folder = folder();
    let before = contents(&folder);
    let mut tried = 0;
    for (line, ending) in COMMANDS {
        let with = |output: &str| line.replace("OUT", output);
        let good = with(&format!("fresh{ending}"));
        let (run, trace) = strace::trace(&folder, &good.split(' ').collect::<Vec<_>>());
        if run.code == 2 && run.stderr.contains("unrecognized subcommand") {
            continue; // a build without a window
        }
        assert!([0, 3].contains(&run.code), "{good}: {}: {}", run.code, run.stderr);
        let mut inputs: Vec<String> = trace
            .read()
            .iter()
            .filter_map(|path| {
                let name = path.file_name()?.to_string_lossy().into_owned();
                before.contains_key(&name).then_some(name)
            })
            .collect();
        assert!(!inputs.is_empty(), "{good} reads nothing");
        if line.contains("scene.toml") {
            inputs.extend(["s.gltf", "oak.toml", "s.flb", "hills.png"].map(str::to_owned));
            // The light of a scene is what `bake-scene` makes, again and again.
            inputs.extend((!line.starts_with("bake-scene")).then(|| "stand.flb".to_owned()));
        }
        // What a mesh names is its own, whether the command reads it or not.
        if line.contains("scene.toml") || line.contains("s.gltf") {
            inputs.extend(["s.bin", "tex.png", "normal.png"].map(str::to_owned));
        }
        if line.contains("a.obj") {
            inputs.extend(["a.mtl", "ktex.png", "normal.png"].map(str::to_owned));
        }
        inputs.sort();
        inputs.dedup();
        for input in inputs {
            // Under its own name, by way of a link, and, where the output's name must end in another way, by a link
            // that does.
            let link = format!("link{ending}");
            symlink(folder.path(&input), folder.path(&link)).expect("links work");
            let names =
                if input.ends_with(ending) { vec![input.as_str(), &link] } else { vec![link.as_str()] };
            for name in names {
                let words = with(name);
                let run = folder.flb(&words.split(' ').collect::<Vec<_>>());
                assert_eq!(run.code, 2, "{words} ({input}): {}", run.stderr);
                assert!(run.stderr.contains("itself"), "{words}: {}", run.stderr);
                tried += 1;
            }
            std::fs::remove_file(folder.path(&link)).expect("it is ours");
        }
        for name in ["fresh", "fresh.toml", "fresh.npy", "fresh.png", "new.flb"] {
            let _ = std::fs::remove_file(folder.path(name)); // not each command makes each
        }
        let after = contents(&folder);
        assert!(
            after == before,
            "{line}: {:?}",
            after.keys().filter(|name| after.get(*name) != before.get(*name)).collect::<Vec<_>>()
        );
    }
    assert!(tried > 120, "{tried}");
}

#[test]
fn the_light_that_a_scene_names_is_made_again_by_force() {
    let folder = folder();
    let before = folder.read("stand.flb");
    let again = ["bake-scene", "scene.toml", "--lattice", "16", "-o", "stand.flb", "--force"];
    folder.flb(&again).expect_code(0);
    assert!(folder.read("stand.flb") == before);
}

/// A neighbour who may write into the cache leads an artefact's name elsewhere.
#[test]
fn a_link_in_a_cache_is_replaced_and_what_it_leads_to_stays() {
    let folder = Folder::with_plants(&["leaf-card"]);
    let bake = |output: &str, cache: &str| {
        let words =
            ["bake", "leaf-card.glb", "--model", "paper", "--lattice", "16", "--voxels", "64", "--force"];
        folder.flb_with(&words, &["--cache", cache, "-o", output])
    };
    bake("a.flb", "cache").expect_code(0);
    let (good, mesh) = (folder.read("a.flb"), folder.read("leaf-card.glb"));
    for (target, name) in [("../leaf-card.glb", "occupancy"), ("../a.flb", "medium"), ("../other", "field")] {
        folder.write("other", "of a neighbour");
        let artefacts = flb::names_in(&folder.path("cache"));
        let artefact = artefacts.iter().find(|artefact| artefact.starts_with(name)).expect("it is kept");
        let link = folder.path("cache").join(artefact);
        std::fs::remove_file(&link).and_then(|()| symlink(target, &link)).expect("it is ours");
        bake("a.flb", "cache").expect_code(0);
        assert!(folder.read("a.flb") == good && folder.read("leaf-card.glb") == mesh, "{name}");
        assert_eq!(folder.read("other"), b"of a neighbour", "{name}");
        assert!(link.is_file() && !link.is_symlink(), "{name}: the artefact takes the place of the link");
    }
}

#[test]
fn an_input_in_a_cache_stays_and_the_bake_goes_on() {
    let folder = Folder::with_plants(&["leaf-card"]);
    folder.write("oak.toml", "name = \"oak\"\n");
    let bake = |species: &str, cache: &str, output: &str| {
        let words = ["bake", "leaf-card.glb", "--model", "paper", "--lattice", "16", "--voxels", "64"];
        folder.flb_with(&words, &["--species", species, "--cache", cache, "-o", output])
    };
    bake("oak.toml", "cache", "a.flb").expect_code(0);
    let artefacts = flb::names_in(&folder.path("cache"));
    for (i, artefact) in artefacts.iter().enumerate() {
        let (cache, output) = (format!("c{i}"), format!("{i}.flb"));
        let species = format!("{cache}/{artefact}");
        std::fs::create_dir(folder.path(&cache)).expect("writable");
        folder.write(&species, "name = \"oak\"\n");
        let run = bake(&species, &cache, &output);
        assert_eq!(run.code, 0, "{}", run.stderr);
        assert_eq!(folder.read(&species), b"name = \"oak\"\n", "{artefact}");
        assert!(run.stderr.contains("the cache takes nothing more"), "{artefact}: {}", run.stderr);
        assert!(run.stderr.contains("is the input"), "{artefact}: {}", run.stderr);
        folder.flb(&["validate", &output]).expect_code(0);
    }
    assert!(artefacts.len() > 2, "{artefacts:?}");
}

#[test]
fn an_input_that_is_named_as_a_temporary_file_stays() {
    let folder = Folder::with_card();
    let left = ".out.flb.flb-abcdefgh.tmp";
    folder.write(left, folder.read("card.flb"));
    folder.flb(&["pack", left, "-o", "out.flb"]).expect_code(0);
    assert!(folder.path(left).exists() && folder.path("out.flb").exists());
    // One that a mesh names is known only when the mesh has been read.
    let texture = ".b.flb.flb-abcdefgh.tmp";
    folder.write(texture, claim_of_a_png());
    folder.write("m.mtl", format!("newmtl leaf\nmap_Kd {texture}\n"));
    folder.write("m.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl leaf\nf 1/1 2/1 3/1\n");
    let bake = ["bake", "m.obj", "--model", "paper", "--lattice", "16", "--voxels", "64", "-o", "b.flb"];
    folder.flb(&bake).expect_code(0);
    assert!(folder.path(texture).exists() && folder.path("b.flb").exists());
}

/// A grey PNG of one texel.
fn claim_of_a_png() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 1, 1);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.write_header().and_then(|mut writer| writer.write_image_data(&[9])).expect("a PNG");
    bytes
}

#[test]
fn two_outputs_are_two_files() {
    let folder = folder();
    folder.write("there.flb", "old");
    symlink("there.flb", folder.path("link.flb")).expect("links work");
    symlink(".", folder.path("here")).expect("links work");
    let before = contents(&folder);
    for (output, fields) in [
        ("there.flb", "link.flb"),
        ("link.flb", "there.flb"),
        ("new.flb", "here/new.flb"),
        ("new.flb", "./new.flb"),
        ("here/here/there.flb", "link.flb"),
    ] {
        let bake = [
            "bake",
            "s.gltf",
            "--lattice",
            "16",
            "--voxels",
            "64",
            "--force",
            "-o",
            output,
            "--keep-fields",
            fields,
        ];
        folder.flb(&bake).expect_code(2).says(&["named as two outputs at once"]);
        assert!(contents(&folder) == before);
    }
}

#[test]
fn what_is_replaced_gives_its_mode_and_a_read_only_file_stays() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::with_card();
    let mode = |name: &str| folder.path(name).metadata().expect("it is there").permissions().mode() & 0o7777;
    let set = |name: &str, mode: u32| {
        std::fs::set_permissions(folder.path(name), PermissionsExt::from_mode(mode)).expect("it is ours");
    };
    folder.write("secret.flb", "old");
    set("secret.flb", 0o600);
    folder.flb(&["pack", "card.flb", "-o", "secret.flb", "--force"]).expect_code(0);
    assert_eq!(mode("secret.flb"), 0o600);
    let packed = folder.read("secret.flb");
    set("secret.flb", 0o400);
    let run =
        folder.flb(&["pack", "card.flb", "--codec", "raw-f32", "-o", "secret.flb", "--force"]).expect_code(4);
    run.says(&["secret.flb is read-only (mode 400)"]);
    assert!(folder.read("secret.flb") == packed);
}

#[test]
fn an_output_that_cannot_be_written_is_said_before_the_work() {
    let folder = Folder::with_plants(&["leaf-card"]);
    let long = "n".repeat(256);
    // A file system that takes no file from any user.
    for output in ["/proc/x.flb", &long] {
        let (run, trace) = strace::trace(&folder, &["bake", "leaf-card.glb", "-o", output]);
        assert_eq!(run.code, 4, "{}", run.stderr);
        assert!(trace.read().iter().all(|path| !path.ends_with("leaf-card.glb")), "it has read the mesh");
    }
    let longest = format!("{}.flb", "n".repeat(251));
    let bake = ["bake", "leaf-card.glb", "--lattice", "16", "--voxels", "64", "-o", &longest];
    folder.flb(&bake).expect_code(0);
    assert!(folder.path(&longest).exists());
}

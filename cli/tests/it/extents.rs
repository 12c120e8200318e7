//! Sizes that no plant has, plants that lie, light that is of another mesh: said aloud, with the flag that mends it.

use flb_format::Container;
use flb_packer::{EncodeSettings, Existing, encode_species, load_species, write_library};
use serde_json::{Value, json};

use crate::flb::{FEW, Folder, PAPER};
use crate::scene::taken_apart;
use crate::schema::{misfits, schema};

const QUICK: [&str; 4] = ["--lattice", "16", "--voxels", "32"];
const RENDER: [&str; 6] = ["--sun", "90,30", "--size", "16x16", "--samples", "1"];

const MATERIALS: &str = "newmtl leaf\nKd 0 1 0\nnewmtl bark\nKd 1 0 0\nnewmtl material0\nKd 1 1 0\n";

/// A leaf as tall as it is wide.
fn leaf(size: f64) -> String {
    format!("mtllib m.mtl\nv 0 0 0\nv 0 {size} 0\nv {size} 0 0\nusemtl leaf\nf 1 2 3\n")
}

/// With that leaf as `leaf.obj`, and its materials.
fn with_leaf(size: f64) -> Folder {
    let folder = Folder::new();
    folder.write("leaf.obj", leaf(size)).write("m.mtl", MATERIALS);
    folder
}

/// The kinds of doubts in a summary.
fn kinds(doubts: &Value) -> Vec<&str> {
    doubts.as_array().expect("a list").iter().map(|doubt| doubt["kind"].as_str().expect("a word")).collect()
}

#[track_caller]
fn fits(command: &str, value: &Value) {
    assert_eq!(misfits(&schema(command), value), [""; 0], "{command}: {value}");
}

/// With `leaf.obj`, 2 m tall, baked into `leaf.flb`.
fn baked_leaf() -> Folder {
    let folder = with_leaf(2.0);
    folder.flb_with(&["bake", "leaf.obj", "-o", "leaf.flb"], &[&QUICK[..], &FEW].concat()).expect_code(0);
    folder
}

#[test]
fn a_plant_too_large_is_doubted_by_the_flag_that_mends_it_and_a_unit_has_a_name() {
    let folder = with_leaf(150.0);
    let bake = |output: &str, more: &[&str]| {
        let words = [&["bake", "leaf.obj", "-o", output, "--json"], &QUICK[..], &FEW, more].concat();
        folder.flb(&words).expect_code(0)
    };
    let large = bake("m.flb", &[]).says(&[
        "leaf.obj: the plant is 150 x 150 x 0 m",
        "warning: leaf.obj: the plant's longest edge is 150 m, expected 0.05 to 100 m; --unit says the unit",
        "with cm it is 1.5 m, with mm it is 0.15 m, with in it is 3.81 m, with ft it is 45.7 m",
    ]);
    fits("bake", &large.json());
    assert_eq!(large.json()["species"][0]["size_m"], json!([150.0, 150.0, 0.0]));
    assert_eq!(large.json()["species"][0]["doubts"][0]["kind"], "size");
    let right = bake("cm.flb", &["--unit", "cm"]);
    assert_eq!(kinds(&right.json()["species"][0]["doubts"]), ["no-wood"]);
    bake("number.flb", &["--unit", "0.01"]);
    assert_eq!(folder.read("cm.flb"), folder.read("number.flb"), "a unit by its name");

    let small = folder.flb(&["materials", "leaf.obj", "--unit", "0.0001"]).expect_code(0);
    assert!(small.stdout.contains("leaf.obj: 0.015 x 0.015 x 0 m"), "{}", small.stdout);
    small.says(&["longest edge is 0.015 m", "--unit"]);
    for unit in ["yard", "CM", "0", "-1", "nan"] {
        let word = format!("--unit={unit}");
        let run = folder.flb(&["materials", "leaf.obj", &word]).expect_code(2);
        run.says(&["--unit", &format!("found {unit:?}, expected m, cm, mm, in, ft")]);
    }
}

#[test]
fn a_plant_that_lies_is_doubted_and_an_upright_one_is_not() {
    let folder = Folder::with_plants(&["oak", "leaf-card"]);
    let materials = |words: &[&str]| folder.flb_with(&["materials", "--json"], words).expect_code(0);
    for upright in [&["oak.glb"][..], &["leaf-card.glb"], &["leaf-card.glb", "--up", "z"]] {
        let run = materials(upright);
        fits("materials", &run.json());
        let expected: &[&str] = if upright[0] == "leaf-card.glb" { &["no-wood"] } else { &[] };
        assert_eq!(kinds(&run.json()["doubts"]), expected, "{upright:?}: {}", run.stderr);
    }
    let lies = materials(&["oak.glb", "--up", "z"]).says(&[
        "warning: oak.glb: the plant's foot (its thickest wood) is on its side +z, expected at its bottom, -y; --up y turns it",
    ]);
    fits("materials", &lies.json());
    assert_eq!(lies.json()["doubts"][0]["kind"], "foot");
    // What is wood is not known: the size alone is told.
    folder
        .write("open.obj", leaf(900.0).replace("usemtl leaf", "usemtl material0"))
        .write("m.mtl", MATERIALS);
    let open = materials(&["open.obj"]).says(&["longest edge is 900 m"]);
    assert_eq!((&open.json()["decided"], &open.json()["size_m"][1]), (&json!(false), &json!(900.0)));
}

#[test]
fn another_mesh_is_noticed_and_refused_where_it_does_not_fit() {
    let folder = baked_leaf();
    let nearly = leaf(2.0).replace("v 2 0 0", "v 1.9 0 0");
    folder.write("lod.obj", nearly).write("cm.obj", leaf(200.0));
    // Another order of vertices, and a comment: another file, the same mesh.
    folder.write("same.obj", "# again\nmtllib m.mtl\nv 2 0 0\nv 0 0 0\nv 0 2 0\nusemtl leaf\nf 1 2 3\n");
    let render = |mesh: &str, more: &[&str]| {
        let words = ["render", "leaf.flb", "--mesh", mesh, "-o", "x.png", "--force", "--json"];
        folder.flb_with(&words, &[&RENDER, more].concat())
    };
    for mesh in ["leaf.obj", "same.obj"] {
        let run = render(mesh, &[]).expect_code(0);
        assert_eq!(run.json()["mesh_match"], "same");
        assert!(!run.stderr.contains("warning"), "{mesh}: {}", run.stderr);
        assert_eq!(run.stderr.contains("another file"), mesh == "same.obj", "{}", run.stderr);
    }
    let lod = render("lod.obj", &[]).expect_code(0);
    fits("render", &lod.json());
    assert_eq!(lod.json()["mesh_match"], "differs");
    lod.says(&["warning: lod.obj: not the mesh that species \"leaf\" was baked from", "level of detail"]);

    let refused = render("cm.obj", &[]).expect_code(2);
    refused.says(&[
        "cm.obj: does not fit the light of species \"leaf\": it is 200 x 200 x 0 m, the light is of 2 x 2 x 0 m",
        "a side is 198 m off, expected at most 0.2 m",
        "--mesh-differs",
    ]);
    let run = render("cm.obj", &["--mesh-differs"]).expect_code(0);
    assert_eq!(run.json()["mesh_match"], "differs");
    run.says(&["warning: cm.obj: does not fit the light of species \"leaf\""]);

    // Another number of materials, too.
    let two = format!("{}usemtl bark\nv 1 1 0\nf 1 2 4\n", leaf(2.0));
    folder.write("two.obj", two);
    render("two.obj", &[]).expect_code(2).says(&["the mesh has 2 materials", "--mesh-differs"]);
    render("two.obj", &["--mesh-differs"]).expect_code(0);

    // Light to compare with has to fit as well.
    let cm = ["bake", "leaf.obj", "-o", "cm.flb", "--unit", "cm"];
    folder.flb_with(&cm, &[&QUICK[..], &FEW].concat()).expect_code(0).says(&["longest edge is 0.02 m"]);
    render("leaf.obj", &["--against", "cm.flb"]).expect_code(2).says(&["does not fit the light"]);
    render("leaf.obj", &["--against", "cm.flb", "--mesh-differs"]).expect_code(0);
}

#[test]
fn a_file_that_does_not_say_its_mesh_is_rendered_with_what_fits() {
    let folder = baked_leaf();
    let bytes = folder.read("leaf.flb");
    let container = Container::open(&bytes).expect("it was baked");
    let mut fields = load_species(&container, &bytes, 0).expect("it loads");
    assert!(fields.meta.mesh_blake3.take().is_some(), "a bake says it");
    let old = encode_species(&fields, &EncodeSettings::default(), &|_| Ok(())).expect("it encodes");
    write_library(&folder.path("old.flb"), &[&old], Existing::Keep).expect("a fresh file");
    folder.write("other.obj", format!("# another file\n{}", leaf(1.9))).write("far.obj", leaf(4.0));
    let render = |mesh: &str| {
        let words = ["render", "old.flb", "--mesh", mesh, "-o", "x.png", "--force", "--json"];
        folder.flb_with(&words, &RENDER)
    };
    let same = render("leaf.obj").expect_code(0);
    assert_eq!(same.json()["mesh_match"], "unknown");
    assert!(!same.stderr.contains("warning"), "{}", same.stderr);
    render("other.obj").expect_code(0).says(&["warning: other.obj: not the file that species \"leaf\""]);
    render("far.obj").expect_code(2).says(&["does not fit", "--mesh-differs"]);
    let info = folder.flb(&["info", "old.flb"]).expect_code(0);
    assert!(info.stdout.contains("mesh       not said"), "{}", info.stdout);
}

#[test]
fn a_digest_outlasts_containers_and_packing_and_a_diff_tells_it() {
    let folder = Folder::with_plants(&["oak"]);
    let (mut json, binary) = taken_apart(&folder.read("oak.glb"));
    json["buffers"][0]["uri"] = json!("oak.bin");
    folder.write("oak.gltf", json.to_string()).write("oak.bin", binary);
    let flags = [&QUICK[..], &PAPER].concat();
    folder.flb_with(&["bake", "oak.glb", "-o", "a.flb", "--threads", "1"], &flags).expect_code(0);
    folder.flb_with(&["bake", "oak.gltf", "-o", "b.flb", "--threads", "2"], &flags).expect_code(0);
    folder.flb_with(&["bake", "oak.glb", "-o", "feet.flb", "--unit", "ft"], &flags).expect_code(0);
    folder.flb(&["pack", "a.flb", "-o", "packed.flb", "--quality", "draft"]).expect_code(0);
    let digest = |file: &str| {
        let info = folder.flb(&["info", file, "--json"]).expect_code(0).json();
        fits("info", &info);
        info["species"][0]["mesh_blake3"].as_str().expect("a digest").to_owned()
    };
    let baked = digest("a.flb");
    assert_eq!(baked.len(), 64);
    assert_eq!([digest("b.flb"), digest("packed.flb")], [baked.clone(), baked.clone()]);
    assert_ne!(digest("feet.flb"), baked, "another unit is another mesh");
    let info = folder.flb(&["info", "a.flb"]).expect_code(0);
    assert!(info.stdout.contains(&format!("mesh       {baked}")), "{}", info.stdout);
    folder.flb(&["validate", "a.flb"]).expect_code(0);
    let diff = folder.flb(&["diff", "a.flb", "feet.flb", "--json"]).expect_code(1).json();
    let metadata = diff["species"][0]["metadata"].as_array().expect("a list");
    assert!(metadata.iter().any(|one| one["path"] == "mesh_blake3" && one["decides"] == true), "{diff}");
}

#[test]
fn a_scene_tells_sizes_while_it_is_scattered_and_refuses_light_that_does_not_fit() {
    let folder = baked_leaf();
    folder.write("cm.obj", leaf(200.0));
    let scatter = |species: &[&str], output: &str| {
        let words = ["scatter", "--count", "2", "--area", "9,9", "--json", "-o", output];
        let run = folder.flb_with(&words, species).expect_code(0);
        fits("scatter", &run.json());
        run
    };
    let good = scatter(&["--species", "leaf=leaf.obj,leaf.flb"], "good.toml");
    assert_eq!(kinds(&good.json()["species"][0]["doubts"]), ["no-wood"], "{}", good.stderr);
    assert_eq!(good.json()["species"][0]["size_m"], json!([2.0, 2.0, 0.0]));
    let plan = scatter(&["--species", "leaf=leaf.flb"], "plan.toml");
    assert_eq!(plan.json()["species"][0]["size_m"], json!([2.0, 2.0, 0.0]));
    let bad = scatter(&["--species", "leaf=cm.obj,leaf.flb"], "bad.toml");
    assert_eq!(bad.json()["species"][0]["doubts"][0]["kind"], "size");
    bad.says(&["does not fit the light of species \"leaf\"", "longest edge is 200 m", "--unit of flb bake"]);
    let dark = scatter(&["--species", "leaf=cm.obj"], "dark.toml");
    dark.says(&["unit_m of its species file says the unit of the mesh file: with 0.01 it is 2 m"]);

    let render = |scene: &str, more: &[&str]| {
        let words = ["render", scene, "--size", "16x9", "--samples", "1", "--json", "--force", "-o", "x.png"];
        folder.flb_with(&words, more)
    };
    let matched = |scene: &str, more: &[&str]| {
        let rendered = render(scene, more).expect_code(0).json();
        fits("render", &rendered);
        rendered["scene"]["species"][0]["mesh_match"].clone()
    };
    assert_eq!(matched("good.toml", &[]), "same");
    assert_eq!(matched("dark.toml", &[]), Value::Null);
    render("bad.toml", &[]).expect_code(2).says(&["cm.obj: does not fit the light", "--mesh-differs"]);
    assert_eq!(matched("bad.toml", &["--mesh-differs"]), "differs");
    let view = folder.flb(&["view", "bad.toml", "--screenshot", "v.png", "--size", "64x64"]).expect_code(2);
    if !view.stderr.contains("unrecognized subcommand") {
        view.says(&["cm.obj: does not fit the light", "--mesh-differs"]);
    }
}

#[test]
fn a_strict_bake_ends_before_any_work_where_one_mesh_is_doubted() {
    let folder = Folder::with_plants(&["oak"]);
    folder.write("leaf.obj", leaf(2.0)).write("m.mtl", MATERIALS);
    let bake = |meshes: &[&str]| {
        let words = [&["bake", "-o", "x.flb", "--strict", "--cache", "kept", "--model", "paper"], &QUICK[..]];
        folder.flb_with(&words.concat(), meshes)
    };
    bake(&["oak.glb", "leaf.obj"])
        .expect_code(1)
        .says(&["leaf.obj: --strict: the plant has leaves and no wood"]);
    assert!(!folder.path("x.flb").exists() && !folder.path("kept").exists(), "work was begun");
    bake(&["oak.glb"]).expect_code(0);
    let materials = |mesh: &str| folder.flb(&["materials", mesh, "--strict"]);
    materials("oak.glb").expect_code(0);
    materials("leaf.obj").expect_code(1).says(&["--strict: the plant has leaves and no wood"]);
    folder.write("leaf.obj", leaf(2.0) + "glow 3\n");
    materials("leaf.obj").expect_code(1).says(&["warning: leaf.obj: glow is not read: it is not known"]);
}

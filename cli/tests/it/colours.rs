//! What a texel means: said by the colours themselves, by a flag, by a species file; told by `bake`, `materials` and
//! `info`.

use flb_format::Container;
use flb_format::material_surface::Texel;
use flb_packer::{EncodeSettings, Existing, encode_species, load_species, write_library};
use serde_json::{Value, json};

use crate::flb::{FEW, Folder};
use crate::schema::{misfits, schema};

const QUICK: [&str; 4] = ["--lattice", "16", "--voxels", "32"];

/// Two leaves side by side, and a piece of bark below.
fn plant(leaf: &str, petal: &str) -> Folder {
    let folder = Folder::new();
    let materials =
        format!("newmtl leaf\n{leaf}\nnewmtl petal_leaf\n{petal}\nnewmtl bark\nKd 0.2 0.15 0.1\n");
    let mesh = "mtllib m.mtl\nv 0 1 0\nv 1 1 0\nv 0 2 0\nv 1 2 0\nv 2 1 0\nv 2 2 0\nv 0 0 0\nv 1 0 0\n\
                usemtl leaf\nf 1 2 3\nf 3 2 4\nusemtl petal_leaf\nf 2 5 4\nf 4 5 6\nusemtl bark\nf 7 8 1\nf 1 8 2\n";
    folder.write("plant.obj", mesh).write("m.mtl", materials);
    folder
}

const GREEN: &str = "Kd 0.1 0.2 0.05";
const RED: &str = "Kd 0.4 0.02 0.02";

fn bake(folder: &Folder, output: &str, more: &[&str]) -> crate::flb::Run {
    let words = [&["bake", "plant.obj", "-o", output, "--json"], &QUICK[..], &FEW, more].concat();
    folder.flb(&words).expect_code(0)
}

#[track_caller]
fn fits(command: &str, value: &Value) {
    assert_eq!(misfits(&schema(command), value), [""; 0], "{command}: {value}");
}

#[test]
fn red_leaves_say_both_colours_and_the_flag_and_the_file_remembers() {
    let folder = plant(GREEN, RED);
    let run = bake(&folder, "red.flb", &[]).says(&[
        "material \"petal_leaf\" has the colour 0.400 0.020 0.020, measured leaves reflect 0.070 0.125 0.040",
        "--leaf-colour measured",
    ]);
    assert!(!run.stderr.contains("material \"leaf\" has the colour"), "{}", run.stderr);
    fits("bake", &run.json());
    let colours = &run.json()["species"][0]["colours"];
    assert_eq!((&colours[0]["texel"], &colours[1]["texel"]), (&json!("tint"), &json!("albedo")));

    let bytes = folder.read("red.flb");
    let container = Container::open(&bytes).expect("a valid file");
    let meta = &container.species()[0].meta;
    let surfaces = meta.material_surfaces().expect("good").expect("some");
    let texels: Vec<Option<Texel>> =
        surfaces.iter().map(|surface| surface.as_ref().map(|of| of.texel)).collect();
    assert_eq!(texels, [Some(Texel::Tint), Some(Texel::Albedo), None]);
    let red = &meta.physical().expect("physical").0.bands[0].leaf;
    assert!((red.reflectance - (0.07 + 0.4) / 2.0).abs() < 1e-3, "{red:?}");

    let info = folder.flb(&["info", "red.flb"]).expect_code(0);
    assert!(
        info.stdout.contains("of 3 materials the textures of 1 are what they reflect"),
        "{}",
        info.stdout
    );
    fits("info", &folder.flb(&["info", "red.flb", "--json"]).expect_code(0).json());
    folder.flb(&["validate", "red.flb"]).expect_code(0);
    let render =
        ["render", "red.flb", "--mesh", "plant.obj", "--sun", "0,30", "--size", "32x32", "-o", "r.png"];
    folder.flb(&render).expect_code(0);
}

#[test]
fn a_file_that_states_another_colour_than_the_mesh_has_is_told() {
    let folder = plant(GREEN, GREEN);
    folder.write("autumn.toml", "leaf_model = { chlorophyll_ug_cm2 = 2.0, anthocyanins_ug_cm2 = 3.0 }\n");
    let told = "autumn.toml states another colour than the mesh has, and the mesh's is taken; leaf_colour = \"measured\" \
                takes the one that is stated";
    let autumn = ["--species", "autumn.toml"];
    bake(&folder, "a.flb", &autumn).says(&[&format!("warning: plant.obj: material \"leaf\": {told}")]);
    let manifest = "[[species]]\nmesh = 'plant.obj'\nspecies_file = 'autumn.toml'\nbake = { quality = 'draft', lattice = 16, voxels = 64 }\n";
    folder.write("library.toml", manifest);
    folder.flb(&["library", "check"]).expect_code(0).says(&[told]);
    folder.flb(&["library", "build"]).expect_code(0);
    let index: Value = serde_json::from_slice(&folder.read("library/index.json")).expect("JSON");
    let warnings = index["species"]["plant"]["warnings"].to_string();
    assert!(warnings.contains("autumn.toml states another colour"), "{index}");
    folder.write("library.toml", format!("{manifest}plant = {{ leaf_colour = 'measured' }}\n"));
    let run = folder.flb(&["library", "check"]).expect_code(0);
    assert!(!run.stderr.contains("states another colour"), "{}", run.stderr);
}

#[test]
fn a_file_that_states_another_colour_of_wood_than_the_mesh_has_is_told() {
    let folder = plant(GREEN, GREEN);
    folder.write(
        "m.mtl",
        format!("newmtl leaf\n{GREEN}\nnewmtl petal_leaf\n{GREEN}\nnewmtl bark\nKd 0.9 0.9 0.9\n"),
    );
    let told = "states another colour than the mesh has, and the mesh's is taken; wood_colour = \"measured\"";
    for (wood, is_told) in [(0.4_f64, true), (0.15, false)] {
        let bands = [("R", 0.07, wood), ("G", 0.125, wood.min(0.12)), ("B", 0.04, wood.min(0.09))].map(|(name, leaf, wood)| {
            format!("[[surfaces]]\nname = \"{name}\"\nleaf = {{ reflectance = {leaf}, transmittance = 0.05 }}\nwood = {{ reflectance = {wood} }}\n")
        });
        folder.write("stated.toml", bands.concat());
        let run = bake(&folder, "a.flb", &["--species", "stated.toml", "--force"]);
        assert_eq!(run.stderr.contains(told), is_told, "{wood}: {}", run.stderr);
    }
    folder.write("m.toml", "wood_colour = \"measured\"\nleaf_model = { wood = [0.4, 0.4, 0.4] }\n");
    let run = bake(&folder, "a.flb", &["--species", "m.toml", "--force"]);
    assert!(!run.stderr.contains(told), "{}", run.stderr);
}

#[test]
fn green_leaves_bake_to_the_same_bytes_whether_the_flag_is_given_or_not() {
    let folder = plant(GREEN, "Kd 0.02 0.3 0.01");
    let run = bake(&folder, "a.flb", &[]);
    assert!(!run.stderr.contains("has the colour"), "{}", run.stderr);
    bake(&folder, "b.flb", &["--leaf-colour", "measured"]);
    assert_eq!(folder.read("a.flb"), folder.read("b.flb"));
    bake(&folder, "c.flb", &["--leaf-colour", "texture"]);
    assert_ne!(folder.read("a.flb"), folder.read("c.flb"));
    let text = String::from_utf8_lossy(&folder.read("a.flb")).into_owned();
    assert!(!text.contains("surfaces.materials"), "a file of tints says nothing");
}

#[test]
fn what_cannot_be_followed_is_a_warning_with_its_place() {
    let folder = plant("Kd 1 1 1", "Kd 0 0 0");
    let run = folder.flb(&["materials", "plant.obj", "--leaf-colour", "texture"]).expect_code(0).says(&[
        "warning: plant.obj: material \"leaf\": --leaf-colour texture: found neither a texture nor a base colour, expected",
    ]);
    assert!(run.stdout.contains("no colour of its own"), "{}", run.stdout);
    folder
        .flb(&["materials", "plant.obj"])
        .expect_code(0)
        .says(&["material \"petal_leaf\": its colour is black"]);
    fits("materials", &folder.flb(&["materials", "plant.obj", "--json"]).expect_code(0).json());
    folder
        .flb(&["materials", "plant.obj", "--leaf-colour", "green"])
        .expect_code(2)
        .says(&["texture, measured"]);
}

#[test]
fn a_species_file_speaks_of_materials_and_its_patterns_must_match() {
    let folder = plant(GREEN, RED);
    folder.write("a.toml", "leaf_colour = [{ material = \"petal*\", colour = \"measured\" }]\n");
    let table = |species: &str| folder.flb(&["materials", "plant.obj", "--species", species, "--json"]);
    let colours = table("a.toml").expect_code(0).json()["colours"].clone();
    assert_eq!(
        (&colours[1]["texel"], &colours[1]["rule"]),
        (&json!("tint"), &json!("a.toml: leaf_colour measured"))
    );
    folder.write("b.toml", "leaf_colour = [{ material = \"flower*\", colour = \"measured\" }]\n");
    table("b.toml").expect_code(2).says(&["b.toml: leaf_colour", "'flower*'", "'petal_leaf'"]);
    folder.write("c.toml", "leaf_colour = \"green\"\n");
    table("c.toml").says(&["c.toml", "leaf_colour", "expected \"texture\" or \"measured\""]);
}

#[test]
fn an_oak_in_autumn_is_taken_by_its_texture() {
    let folder = Folder::new();
    let grown = ["grow", "oak", "--autumn", "--triangles", "2000", "-o", "red.glb", "--json"];
    fits("grow", &folder.flb(&grown).expect_code(0).json());
    let colours = folder.flb(&["materials", "red.glb", "--json"]).expect_code(0).json()["colours"].clone();
    assert_eq!((&colours[0]["texel"], &colours[1]["texel"]), (&json!("tint"), &json!("albedo")));
    assert!(colours[1]["clamped"].as_f64().expect("a share") < 0.05, "{colours}");
}

#[test]
fn surfaces_in_a_file_that_cannot_be_used_are_told_by_info_and_refused_by_a_picture() {
    let folder = Folder::with_baked(
        &["shrub"],
        &[&["--lattice", "16", "--voxels", "128"], &FEW[..]].concat(),
        &[0, 3],
    );
    let bytes = folder.read("shrub.flb");
    let container = Container::open(&bytes).expect("it was baked");
    let mut fields = load_species(&container, &bytes, 0).expect("it loads");
    let too_much =
        json!([{ "texel": "tint", "reflectance": [2.0, 0.1, 0.1], "transmittance": [0.0, 0.0, 0.0] }]);
    fields.meta.settings.insert("surfaces.materials".to_owned(), too_much);
    let encoded = encode_species(&fields, &EncodeSettings::default(), &|_| Ok(())).expect("it encodes");
    write_library(&folder.path("odd.flb"), &[&encoded], Existing::Keep).expect("a fresh file");
    let said = "settings.surfaces.materials[0].reflectance: 2, expected 0 to 1";
    let info = folder.flb(&["info", "odd.flb", "--json"]).expect_code(0).json();
    fits("info", &info);
    assert_eq!(
        (&info["species"][0]["materials"], &info["species"][0]["materials_error"]),
        (&json!(null), &json!(said))
    );
    let text = folder.flb(&["info", "odd.flb"]).expect_code(0).stdout;
    assert!(text.contains(&format!("cannot be used: {said}")), "{text}");
    let words =
        ["render", "odd.flb", "--mesh", "shrub.glb", "--sun", "90,40", "--size", "16x16", "-o", "x.png"];
    folder.flb(&words).expect_code(1).says(&["odd.flb", said]);
}

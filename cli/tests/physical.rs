//! `--model physical` from bake to picture, and what it refuses.

use serde_json::Value;

use crate::flb::{Folder, SMALL};
use crate::schema::misfits;

mod flb;
mod schema;

#[track_caller]
fn fits(command: &str, value: &Value) {
    assert_eq!(misfits(&schema::schema(command), value), [""; 0], "{command}: {value}");
}

/// Solves in a second or two.
const QUICK: [&str; 6] = ["--model", "physical", "--suns", "sh1", "--ordinates", "50"];

#[test]
fn a_physical_bake_goes_all_the_way_to_a_picture() {
    let folder = Folder::with_plants(&["shrub"]);
    let bake = ["bake", "shrub.glb", "-o", "shrub.flb", "--json"];
    let run = folder.flb_with(&[&bake[..], &QUICK].concat(), &SMALL).expect_code(0);
    fits("bake", &run.json());
    let solve = &run.json()["stages"][4];
    assert_eq!((&solve["name"], &solve["solves"][0]["solver"]), (&"solve".into(), &"ordinates".into()));
    // 26 suns, 5 held out and the sky, in three bands.
    assert_eq!(solve["solves"][0]["solves"], 96);

    let run = folder.flb(&["info", "shrub.flb"]).expect_code(0);
    for words in
        ["physical", "harmonics to degree 1", "8 fields and the sky", "50, 1 ray", "over 5 suns held out"]
    {
        assert!(run.stdout.contains(words), "{words}: {}", run.stdout);
    }
    let info = folder.flb(&["info", "shrub.flb", "--json"]).expect_code(0).json();
    fits("info", &info);
    let error = info["species"][0]["light"]["error"]["suns_rms"].as_f64().unwrap();
    assert!((0.0001..0.05).contains(&error), "{error}");

    folder.flb(&["validate", "shrub.flb"]).expect_code(0);
    folder.flb(&["extract", "shrub.flb", "--base", "8", "--format", "npy", "-o", "b8.npy"]).expect_code(0);
    let extinction =
        ["extract", "shrub.flb", "--base", "extinction", "--format", "exr", "-o", "sigma.exr", "--json"];
    fits("extract", &folder.flb(&extinction).expect_code(0).json());
    folder
        .flb(&["extract", "shrub.flb", "--base", "9", "--format", "npy", "-o", "b9.npy"])
        .expect_code(2)
        .says(&["no base 9"]);

    let render = [
        "render",
        "shrub.flb",
        "--mesh",
        "shrub.glb",
        "--sun",
        "135,40",
        "--size",
        "64x64",
        "--samples",
        "4",
    ];
    let lit = folder.flb_with(&render, &["-o", "lit.exr", "--json"]).expect_code(0);
    fits("render", &lit.json());
    folder.flb_with(&render, &["-o", "traced.exr", "--path-traced"]).expect_code(0);
    folder.flb_with(&render, &["-o", "direct.exr", "--indirect", "off"]).expect_code(0);
    folder.flb_with(&render, &["-o", "direct2.exr", "--indirect", "off", "--path-traced"]).expect_code(0);
    assert_eq!(folder.read("direct.exr"), folder.read("direct2.exr"));
    assert_ne!(folder.read("lit.exr"), folder.read("direct.exr"));
}

#[test]
fn the_file_depends_on_the_settings_and_not_on_the_threads() {
    let folder = Folder::with_plants(&["leaf-card"]);
    let bake = |out: &str, more: &[&str]| {
        let words = ["bake", "leaf-card.glb", "-o", out, "--lattice", "16", "--voxels", "128"];
        folder.flb_with(&[&words[..], &QUICK].concat(), more).expect_code(0);
        folder.read(out)
    };
    let one = bake("one.flb", &["--threads", "1"]);
    assert_eq!(one, bake("three.flb", &["--threads", "3"]));
    for (name, more) in [
        ("rays", &["--rays", "2"][..]),
        ("cut", &["--cut-sites"]),
        ("total", &["--field", "total"]),
        ("flat", &["--leaf-angles", "planophile"]),
    ] {
        assert_ne!(one, bake(&format!("{name}.flb"), more), "{name}");
    }
    folder.flb(&["validate", "one.flb", "rays.flb", "cut.flb", "total.flb", "flat.flb"]).expect_code(0);
    let run = folder.flb(&["diff", "one.flb", "total.flb"]).expect_code(1);
    assert!(run.stdout.contains("total"), "{}", run.stdout);
}

#[test]
fn lattice_directions_are_stored_as_the_papers_do() {
    let folder = Folder::with_plants(&["leaf-card"]);
    let words = ["bake", "leaf-card.glb", "-o", "card.flb", "--lattice", "16", "--voxels", "128", "--json"];
    let run = folder.flb_with(&words, &["--model", "physical", "--suns", "lattice18"]).expect_code(0);
    assert_eq!(run.json()["species"][0]["bases"].as_array().unwrap().len(), 19);
    let run = folder.flb(&["info", "card.flb"]).expect_code(0);
    assert!(run.stdout.contains("18 lattice directions, blended by three"), "{}", run.stdout);
    let render = [
        "render",
        "card.flb",
        "--mesh",
        "leaf-card.glb",
        "--sun",
        "90,60",
        "--size",
        "32x32",
        "-o",
        "card.png",
    ];
    folder.flb(&render).expect_code(0);
}

#[test]
fn surfaces_of_a_species_file_are_used_and_kept() {
    let folder = Folder::with_plants(&["leaf-card"]);
    let bands = |share: f64| {
        let band = |name: &str| {
            format!(
                "[[surfaces]]\nname = \"{name}\"\nleaf = {{ reflectance = {share}, transmittance = 0.1 }}\nwood = {{ reflectance = 0.2 }}\n"
            )
        };
        ["R", "G", "B", "NIR"].map(band).concat()
    };
    folder.write("dark.toml", bands(0.05)).write("bright.toml", bands(0.5));
    for name in ["dark", "bright"] {
        let (species, out) = (format!("{name}.toml"), format!("{name}.flb"));
        let words = [
            "bake",
            "leaf-card.glb",
            "--species",
            &species,
            "-o",
            &out,
            "--lattice",
            "16",
            "--voxels",
            "128",
        ];
        folder.flb_with(&words, &QUICK).expect_code(0);
        let run = folder.flb(&["info", &out]).expect_code(0);
        assert!(run.stdout.contains("R G B NIR"), "{}", run.stdout);
    }
    assert_ne!(folder.read("dark.flb"), folder.read("bright.flb"));
    // Four bands are no picture.
    let render = ["render", "dark.flb", "--mesh", "leaf-card.glb", "--sun", "90,60", "-o", "dark.png"];
    folder.flb(&render).expect_code(2).says(&["4 bands"]);
}

#[test]
fn what_a_model_has_not_is_refused_before_any_work() {
    let folder = Folder::with_card();
    let refused = |more: &[&str], word: &str| {
        let bake = ["bake", "leaf-card.glb", "-o", "no.flb", "--lattice", "16", "--voxels", "128"];
        folder.flb_with(&bake, more).expect_code(2).says(&[word]);
        assert!(!folder.path("no.flb").exists());
    };
    for flag in [
        &["--suns", "sh1"][..],
        &["--ordinates", "50"],
        &["--rays", "2"],
        &["--cut-sites"],
        &["--field", "total"],
        &["--leaf-angles", "measured"],
    ] {
        refused(flag, flag[0]);
    }
    for (more, word) in [
        (&["--ordinates", "20"][..], "expected 18, 50 or 110"),
        (&["--rays", "0"], "expected 1 to 8"),
        (&["--tolerance", "0"], "--tolerance is 0"),
        (&["--max-sweeps", "0"], "--max-sweeps is 0"),
        (&["--solver", "sweep"], "--solver"),
        (&["--plan", "plan.toml"], "--plan is for --model paper"),
    ] {
        refused(&[&["--model", "physical"], more].concat(), word);
    }
    let render = ["render", "card.flb", "--mesh", "leaf-card.glb", "--sun", "90,60", "-o", "card.png"];
    folder.flb_with(&render, &["--path-traced"]).expect_code(2).says(&["needs a physical file"]);
    let bake = ["bake", "leaf-card.glb", "-o", "new.flb", "--lattice", "16", "--voxels", "128"];
    folder.flb_with(&bake, &QUICK).expect_code(0);
    let render = ["render", "new.flb", "--mesh", "leaf-card.glb", "--sun", "90,60", "-o", "card.png"];
    folder
        .flb_with(&render, &["--indirect-scale", "2"])
        .expect_code(2)
        .says(&["--indirect-scale is for paper files"]);
}

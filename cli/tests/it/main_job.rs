//! The main job from end to end: grow, bake, pack, merge, look, compare, extract, render.

use crate::flb::{Folder, PAPER, SMALL};

const PNG: [u8; 8] = [0x89, b'P', b'N', b'G', b'\r', b'\n', 0x1a, b'\n'];
const EXR: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
const NPY: [u8; 6] = [0x93, b'N', b'U', b'M', b'P', b'Y'];
const FLB: [u8; 8] = [0x89, 0x46, 0x4c, 0x42, 0x0d, 0x0a, 0x1a, 0x0a];

#[test]
fn the_main_job_runs_from_plant_to_picture() {
    main_job(&SMALL);
}

#[test]
fn the_main_job_runs_with_the_papers_model() {
    main_job(&[&SMALL[..], &PAPER].concat());
}

fn main_job(flags: &[&str]) {
    let folder = Folder::with_plants(&["oak", "shrub"]);
    let bake = ["bake", "oak.glb", "-o", "oak.flb", "--keep-fields", "fields.flb"];
    let run = folder.flb_with(&bake, flags).expect_code(0);
    for word in ["import", "voxelise", "downsample", "solve", "encode", "write", "oak", "peak memory", "psnr"]
    {
        assert!(run.stdout.contains(word), "{word} is not in the summary: {}", run.stdout);
    }
    assert!(folder.read("oak.flb").starts_with(&FLB));
    folder.flb_with(&["bake", "shrub.glb", "-o", "shrub.flb"], flags).expect_code(0);

    // Packing again with the bake's settings gives the bake's bytes; it never solves.
    let run = folder.flb(&["pack", "fields.flb", "-o", "again.flb", "--json"]).expect_code(0);
    assert!(!run.stdout.contains("\"solve\""), "{}", run.stdout);
    assert_eq!(folder.read("again.flb"), folder.read("oak.flb"));
    folder.flb(&["pack", "fields.flb", "-o", "small.flb", "--quality", "draft", "--compress"]).expect_code(0);
    assert!(folder.read("small.flb").len() < folder.read("oak.flb").len() * 9 / 10);

    folder.flb(&["pack", "oak.flb", "shrub.flb", "-o", "library.flb"]).expect_code(0);
    let run = folder.flb(&["info", "library.flb"]).expect_code(0);
    assert!(run.stdout.contains("species oak") && run.stdout.contains("species shrub"), "{}", run.stdout);
    let run = folder.flb(&["validate", "oak.flb", "fields.flb", "small.flb", "library.flb"]).expect_code(0);
    assert_eq!(run.stdout.matches(": valid").count(), 4, "{}", run.stdout);

    for (format, magic) in [("png", &PNG[..]), ("exr", &EXR), ("npy", &NPY)] {
        let out = format!("oak.{format}");
        folder
            .flb(&[
                "extract",
                "library.flb",
                "--species",
                "oak",
                "--base",
                "3",
                "--format",
                format,
                "-o",
                &out,
            ])
            .expect_code(0);
        assert!(folder.read(&out).starts_with(magic), "{out}");
        let out = format!("density.{format}");
        folder.flb(&["extract", "oak.flb", "--density", "--format", format, "-o", &out]).expect_code(0);
        assert!(folder.read(&out).starts_with(magic), "{out}");
    }
    // 3 bands of 32^3 values behind a header of whole 64-byte lines.
    assert_eq!(folder.read("oak.npy").len() % 64, 0);
    assert!(folder.read("oak.npy").len() > 3 * 32 * 32 * 32 * 4);

    let render = ["render", "oak.flb", "--mesh", "oak.glb", "--size", "48x32", "--samples", "2"];
    for show in ["light", "direct", "indirect"] {
        let out = format!("{show}.png");
        folder.flb_with(&render, &["--sun", "120,30", "--show", show, "-o", &out]).expect_code(0);
        assert!(folder.read(&out).starts_with(&PNG), "{out}");
    }
    assert_ne!(folder.read("light.png"), folder.read("direct.png"));
    assert_ne!(folder.read("light.png"), folder.read("indirect.png"));
    folder.flb_with(&render, &["--sun", "120,30", "-o", "one.exr"]).expect_code(0);
    assert!(folder.read("one.exr").starts_with(&EXR));
    // A sheet of three, from a library that holds another species too.
    let sheet = ["--sun", "90,15", "--sun", "180,60", "--sun", "270,15", "-o", "sheet.png"];
    let render = ["render", "library.flb", "--mesh", "oak.glb", "--size", "48x32", "--samples", "2"];
    let run = folder.flb_with(&render, &sheet).expect_code(0);
    assert!(run.stdout.contains("152 x 32"), "3 pictures and 2 gaps of 4: {}", run.stdout);

    // Settings are history to a tolerant comparison, so recoding within the tolerance is equal.
    folder.flb(&["diff", "oak.flb", "again.flb"]).expect_code(0);
    folder.flb(&["diff", "oak.flb", "small.flb"]).expect_code(1);
    // 38 dB of the light leaves little of its smallest terms.
    folder.flb(&["diff", "fields.flb", "small.flb", "--tolerance", "2"]).expect_code(0);
    folder.flb(&["diff", "fields.flb", "small.flb", "--tolerance", "0.000001"]).expect_code(1);
}

#[test]
fn materials_are_listed_with_class_and_rule() {
    let folder = Folder::with_plants(&["oak"]);
    let run = folder.flb(&["materials", "oak.glb"]).expect_code(0);
    for word in ["bark", "leaves", "wood", "leaf", "cut at 0.5"] {
        assert!(run.stdout.contains(word), "{word} is not in: {}", run.stdout);
    }
    let run = folder.flb(&["materials", "oak.glb", "--wood", "leaves"]).expect_code(0);
    assert!(run.stdout.contains("--wood"), "the rule names the flag: {}", run.stdout);
}

#[test]
fn a_species_file_states_name_unit_up_axis_and_optics() {
    let folder = Folder::with_plants(&["shrub"]);
    folder.write(
        "bush.toml",
        r#"
name = "bush"
up = "z"
unit_m = 0.5
leaf = ["leaves"]
wood = ["bark"]

[[optics]]
name = "PAR"
leaf = { sigma_a = 0.2, g = 0.1 }
wood = { sigma_a = 0.4, g = -1.0 }
"#,
    );
    let paper = [&SMALL[..], &PAPER].concat();
    folder.flb_with(&["bake", "shrub.glb", "-o", "plain.flb"], &paper).expect_code(0);
    let bake = ["bake", "shrub.glb", "-o", "bush.flb", "--species", "bush.toml"];
    folder.flb_with(&bake, &paper).expect_code(0);
    let plain = folder.flb(&["info", "plain.flb", "--json"]).expect_code(0).json();
    let bush = folder.flb(&["info", "bush.flb", "--json"]).expect_code(0).json();
    let (plain, bush) = (&plain["species"][0], &bush["species"][0]);
    assert_eq!(bush["name"], "bush");
    assert_eq!(bush["bands"], serde_json::json!(["PAR"]));
    // Z up: the file's z is the model's y; half the size.
    let extent = |species: &serde_json::Value, axis: usize| {
        let of = |end: usize| species["bounds"][end][axis].as_f64().expect("a number");
        of(1) - of(0)
    };
    let ratio = extent(bush, 1) / extent(plain, 2);
    assert!((ratio - 0.5).abs() < 1e-6, "{ratio}");

    // A picture needs red, green and blue.
    folder
        .flb(&["render", "bush.flb", "--mesh", "shrub.glb", "--sun", "90,30", "-o", "x.png"])
        .expect_code(2)
        .says(&["has the bands PAR", "a picture needs R, G and B"]);
    assert!(!folder.path("x.png").exists());

    // What a species file misspells is refused by name, not ignored.
    folder.write("wrong.toml", "leaves = [\"leaves\"]\n");
    let run = folder.flb_with(&["bake", "shrub.glb", "-o", "x.flb", "--species", "wrong.toml"], &SMALL);
    assert!([1, 2].contains(&run.code), "code {}", run.code);
    run.says(&["wrong.toml", "leaves"]);
}

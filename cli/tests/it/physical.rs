//! `--model physical` from bake to picture, and what it refuses.

use serde_json::{Value, json};

use crate::flb::{Folder, PAPER, SMALL};
use crate::schema::{self, misfits};

#[track_caller]
fn fits(command: &str, value: &Value) {
    assert_eq!(misfits(&schema::schema(command), value), [""; 0], "{command}: {value}");
}

/// Solves in a second or two.
const QUICK: [&str; 4] = ["--suns", "sh1", "--ordinates", "50"];

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
        ["physical", "harmonics to degree 1", "8 fields and the sky", "50, 4 rays", "over 5 suns held out"]
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
    folder.flb_with(&render, &["-o", "direct.exr", "--show", "direct"]).expect_code(0);
    folder.flb_with(&render, &["-o", "direct2.exr", "--show", "direct", "--path-traced"]).expect_code(0);
    assert_eq!(folder.read("direct.exr"), folder.read("direct2.exr"));
    assert_ne!(folder.read("lit.exr"), folder.read("direct.exr"));
}

#[test]
fn a_preset_chooses_what_no_flag_does() {
    let folder = Folder::with_plants(&["leaf-card"]);
    let bake = |out: &str, more: &[&str]| {
        folder.flb_with(&["bake", "leaf-card.glb", "--compress=false", "-o", out], more).expect_code(0);
        let info = folder.flb(&["info", out, "--json"]).expect_code(0).json();
        let species = &info["species"][0];
        let light = &species["light"];
        [
            &species["lattice"],
            &species["target_psnr_db"],
            &light["suns"]["degree"],
            &light["ordinates"],
            &light["rays"],
        ]
        .map(|value| value.as_f64().map_or(-1.0, |value| (value * 1e4).round() / 1e4))
    };
    let setting = |file: &str, word: &str| {
        let bytes = folder.read(file);
        assert!(bytes.windows(word.len()).any(|found| found == word.as_bytes()), "{file}: {word}");
    };
    assert_eq!(bake("draft.flb", &["--quality", "draft"]), [32.0, 38.0, 1.0, 50.0, 4.0]);
    setting("draft.flb", "\"solve.tolerance\":0.01");
    let small = ["--lattice", "16", "--voxels", "64"];
    assert_eq!(bake("plain.flb", &small), [16.0, 45.0, 2.0, 110.0, 4.0]);
    assert_eq!(
        bake("standard.flb", &[&small[..], &["--quality", "standard"]].concat())[..],
        bake("s.flb", &small)
    );
    assert!(folder.read("plain.flb") == folder.read("standard.flb"));
    assert_eq!(
        bake("fine.flb", &[&small[..], &["--quality", "high"]].concat()),
        [16.0, 52.0, 3.0, 110.0, 4.0]
    );
    assert_eq!(
        bake("best.flb", &[&small[..], &["--quality", "reference"]].concat()),
        [16.0, 60.0, 3.0, 110.0, 4.0]
    );
    setting("best.flb", "\"solve.parts\":2");
    let flags =
        ["--target-psnr", "28", "--suns", "sh1", "--ordinates", "18", "--rays", "2", "--tolerance", "0.05"];
    let over = [&["--quality", "reference", "--cut-sites=false"], &flags[..], &small].concat();
    assert_eq!(bake("over.flb", &over), [16.0, 28.0, 1.0, 18.0, 2.0]);
    setting("over.flb", "\"solve.tolerance\":0.05");
    setting("over.flb", "\"solve.parts\":1");
    let over = [&["--quality", "draft", "--cut-sites"], &small[..]].concat();
    assert_eq!(bake("cut.flb", &over)[0], 16.0);
    setting("cut.flb", "\"solve.parts\":2");

    // The papers' model has its own tolerances.
    let paper = [&PAPER[..], &["--lattice", "16", "--voxels", "64"]].concat();
    for (quality, tolerance) in [("draft", "0.001"), ("standard", "0.0001"), ("reference", "0.00001")] {
        let out = format!("paper-{quality}.flb");
        bake(&out, &[&paper[..], &["--quality", quality]].concat());
        setting(&out, &format!("\"solve.tolerance\":{tolerance}"));
    }
}

#[test]
fn monte_carlo_error_goes_into_the_file_and_is_said_with_its_standard_error() {
    let folder = Folder::with_plants(&["shrub"]);
    let bake = |out: &str, more: &[&str]| {
        let words = ["bake", "shrub.glb", "-o", out, "--lattice", "16", "--voxels", "64", "--json"];
        let run = folder.flb_with(&words, more).expect_code(0);
        let info = folder.flb(&["info", out, "--json"]).expect_code(0).json();
        fits("info", &info);
        (run, info["species"][0]["light"]["error"]["monte_carlo"].clone())
    };
    let (_, without) = bake("without.flb", &[]);
    assert_eq!(without, Value::Null);
    let (run, error) = bake("two.flb", &["--monte-carlo", "2", "--threads", "1"]);
    fits("bake", &run.json());
    let names: Vec<_> = run.json()["stages"].as_array().unwrap().iter().map(|s| s["name"].clone()).collect();
    assert!(names.contains(&"monte carlo".into()), "{names:?}");
    assert_eq!((&error["suns"], &error["photons"]), (&2.into(), &(1 << 16).into()));
    let [rms, bias] = ["rms", "bias"].map(|key| error[key].as_f64().unwrap());
    assert!((0.0..0.05).contains(&rms) && bias.abs() < 0.05, "{error}");
    run.says(&["shrub: off Monte Carlo by", "standard error", "2 suns, 2 seeds of 65536 photons each"]);
    let info = folder.flb(&["info", "two.flb"]).expect_code(0);
    assert!(info.stdout.contains(&format!("Monte Carlo {:.2} % rms", 100.0 * rms)), "{}", info.stdout);
    bake("again.flb", &["--monte-carlo", "2", "--threads", "2"]);
    assert!(folder.read("again.flb") == folder.read("two.flb"), "the truth depends on the threads");
    // Coarser fields are further off, and that is seen.
    let (_, bad) = bake("bad.flb", &["--monte-carlo", "2", "--suns", "lattice18", "--ordinates", "18"]);
    assert!(bad["rms"].as_f64() > Some(rms), "{bad}, {error}");
}

#[test]
fn optics_of_the_other_model_are_not_left_out_in_silence() {
    let folder = Folder::with_plants(&["leaf-card"]);
    let optics =
        "[[optics]]\nname = \"R\"\nleaf = { sigma_a = 0.2, g = 0.1 }\nwood = { sigma_a = 0.4, g = -1.0 }\n";
    folder.write("optics.toml", optics).write("leaf.toml", "[leaf_model]\n");
    let words = ["bake", "leaf-card.glb", "-o", "x.flb", "--lattice", "16", "--voxels", "64", "--force"];
    let bake = |more: &[&str]| folder.flb_with(&words, more).expect_code(0);
    bake(&["--species", "optics.toml"]).says(&["optics.toml: its [[optics]] are for --model paper"]);
    bake(&[&PAPER[..], &["--species", "leaf.toml"]].concat())
        .says(&["leaf.toml: its surfaces are for --model physical"]);
    for right in [&[&PAPER[..], &["--species", "optics.toml"]].concat()[..], &["--species", "leaf.toml"]] {
        // A leaf card has no wood and is a lone sheet, which is warned of, too.
        let run = bake(right);
        let warned = run.stderr.lines().filter(|line| line.contains("warning") && line.contains("toml"));
        assert_eq!(warned.count(), 0, "{right:?}: {}", run.stderr);
    }
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
    let run = folder.flb_with(&words, &["--suns", "lattice18"]).expect_code(0);
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
fn lists_of_directions_go_all_the_way_to_a_picture() {
    let folder = Folder::with_plants(&["shrub"]);
    let bake = |out: &str, suns: &str, more: &[&str]| {
        let words = ["bake", "shrub.glb", "-o", out, "--lattice", "16", "--voxels", "128", "--json"];
        let suns = ["--suns", suns, "--ordinates", "50"];
        let run = folder.flb(&[&words[..], &suns, more].concat()).expect_code(0);
        fits("bake", &run.json());
        run
    };
    let run = bake("few.flb", "ico12", &["--keep-fields", "fields.flb"]);
    let species = run.json()["species"][0].clone();
    assert_eq!(species["bases"].as_array().map(Vec::len), Some(13));
    // 12 suns, 3 held out and the sky, in three bands; with 42 suns 5 are held out.
    assert_eq!(run.json()["stages"][4]["solves"][0]["solves"], 3 * 16);
    let run = bake("many.flb", "ico42", &[]);
    assert_eq!(run.json()["stages"][4]["solves"][0]["solves"], 3 * 48);
    folder.flb(&["validate", "few.flb", "many.flb"]).expect_code(0);

    let error = |file: &str, directions: usize, triangles: usize, held_out: u64| {
        let info = folder.flb(&["info", file, "--json"]).expect_code(0).json();
        fits("info", &info);
        let light = &info["species"][0]["light"];
        let length = |of: &Value| of.as_array().map(Vec::len);
        assert_eq!(length(&light["suns"]["directions"]), Some(directions));
        assert_eq!(length(&light["suns"]["triangles"]), Some(triangles));
        assert_eq!(
            (&light["sun_fields"], &light["error"]["held_out"]),
            (&directions.into(), &held_out.into())
        );
        let run = folder.flb(&["info", file]).expect_code(0);
        let words = format!(
            "{directions} directions, blended by the three of a triangle: {directions} fields and the sky"
        );
        assert!(run.stdout.contains(&words), "{}", run.stdout);
        light["error"]["suns_rms"].as_f64().expect("it was judged")
    };
    let [few, many] = [error("few.flb", 12, 20, 3), error("many.flb", 42, 80, 5)];
    assert!(many > 0.0 && many < few, "{many} with 42 suns, {few} with 12");

    let extract = |file: &str, base: &str| {
        folder.flb(&["extract", file, "--base", base, "--format", "npy", "-o", "base.npy", "--force"])
    };
    extract("many.flb", "42").expect_code(0);
    extract("many.flb", "43").expect_code(2).says(&["no base 43"]);
    extract("many.flb", "256").expect_code(2).says(&["--base is \"256\", expected 0 to 255"]);
    let run = folder.flb(&["diff", "few.flb", "many.flb"]).expect_code(1);
    assert!(run.stdout.contains("bases of one number mean other light"), "{}", run.stdout);
    folder.flb(&["diff", "many.flb", "many.flb"]).expect_code(0);

    for codec in ["classed", "haar", "haar-paper", "raw-f16"] {
        let words = ["pack", "fields.flb", "-o", "packed.flb", "--force", "--codec", codec];
        folder.flb(&words).expect_code(0);
        folder.flb(&["validate", "packed.flb"]).expect_code(0);
    }
    let picture = |file: &str, out: &str| {
        let words = ["render", file, "--mesh", "shrub.glb", "--sun", "135,40", "--size", "32x32", "-o", out];
        let run = folder.flb_with(&words, &["--samples", "2", "--json"]).expect_code(0);
        fits("render", &run.json());
        folder.read(out)
    };
    assert_ne!(picture("few.flb", "few.exr"), picture("many.flb", "many.exr"));
    folder
        .flb(&["bake", "shrub.glb", "-o", "no.flb", "--suns", "ico92"])
        .expect_code(2)
        .says(&["ico92", "ico12", "ico42"]);
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
    // A picture takes R, G and B by their names.
    let render = ["render", "dark.flb", "--mesh", "leaf-card.glb", "--sun", "90,60", "-o", "dark.png"];
    folder.flb(&render).expect_code(0);
}

#[test]
fn the_papers_preset_is_their_settings_one_by_one_and_no_loss() {
    let folder = Folder::with_card();
    let bake = |output: &str, more: &[&str]| {
        let words = ["bake", "leaf-card.glb", "--lattice", "16", "--voxels", "128", "-o", output];
        folder.flb_with(&words, more).expect_code(0);
    };
    bake("preset.flb", &["--quality", "papers"]);
    let spelled =
        "--model paper --ignore-alpha --solver explicit --steps 32 --codec haar-paper --threshold 0.05";
    bake("spelled.flb", &spelled.split(' ').collect::<Vec<_>>());
    assert_eq!(folder.read("preset.flb"), folder.read("spelled.flb"));
    let words = ["bake", "leaf-card.glb", "--lattice", "16", "--voxels", "128", "-o", "again.flb", "--json"];
    let run = folder.flb_with(&words, &["--quality", "papers"]).expect_code(0).json();
    let solve = run["stages"].as_array().expect("a list").iter().find(|stage| stage["name"] == "solve");
    let of_plant = &solve.expect("a stage")["solves"][0];
    assert_eq!((&of_plant["sweeps"], &of_plant["solver"]), (&json!(32), &json!("explicit")));
    assert_eq!(of_plant["solves"], of_plant["converged"]);
    // What ends a solve in another way is told.
    for flag in [["--solver", "sweep"], ["--tolerance", "1e-3"]] {
        let words = [&words[..6], &["-o", "told.flb", "--quality", "papers", "--force"], &flag].concat();
        let told = "solves to a tolerance, in place of the 2N steps of --quality papers";
        folder.flb(&words).expect_code(0).says(&[&format!("warning: {}", flag[0]), told]);
    }
    // The f64 iteration of the papers is lossless there, too, where its tolerance is not met.
    bake("literal.flb", &["--quality", "papers", "--solver", "literal"]);
    // Their indirect light counts once.
    let draw = |light: &str, more: &[&str]| {
        let words = ["render", light, "--mesh", "leaf-card.glb", "--sun", "90,60", "--size", "32x32"];
        folder
            .flb_with(&words, &[&["--samples", "1", "--force", "-o", "p.png"], more].concat())
            .expect_code(0);
        folder.read("p.png")
    };
    assert_eq!(draw("preset.flb", &[]), draw("preset.flb", &["--indirect-scale", "1"]));
    assert_ne!(draw("preset.flb", &[]), draw("preset.flb", &["--indirect-scale", "0.5"]));
    // Without blocks that no surface samples the picture is the same, and the file smaller.
    bake("near.flb", &["--quality", "papers", "--near-geometry"]);
    assert_eq!(draw("near.flb", &[]), draw("preset.flb", &[]));
    assert!(folder.read("near.flb").len() < folder.read("preset.flb").len());
    folder.flb(&["validate", "near.flb"]).expect_code(0);
    bake("sweep.flb", &PAPER);
    assert_eq!(draw("sweep.flb", &[]), draw("sweep.flb", &["--indirect-scale", "0.5"]));
}

#[test]
fn what_a_model_has_not_is_refused_before_any_work() {
    let folder = Folder::with_card();
    let refused = |more: &[&str], word: &str| {
        let bake = ["bake", "leaf-card.glb", "-o", "no.flb", "--lattice", "16", "--voxels", "128"];
        folder.flb_with(&bake, more).expect_code(2).says(&[word]);
        assert!(!folder.path("no.flb").exists());
    };
    let near = ["bake", "leaf-card.glb", "-o", "no.flb", "--near-geometry"];
    folder.flb(&near).expect_code(2).says(&["--near-geometry is for --codec haar-paper, not for classed"]);
    for flag in [
        &["--suns", "sh1"][..],
        &["--ordinates", "50"],
        &["--rays", "2"],
        &["--cut-sites"],
        &["--field", "total"],
        &["--leaf-angles", "measured"],
        &["--monte-carlo", "1"],
    ] {
        refused(&[&PAPER, flag].concat(), flag[0]);
    }
    refused(&[&PAPER[..], &["--steps", "0"]].concat(), "--steps is 0");
    refused(&[&PAPER[..], &["--steps", "9", "--solver", "sweep"]].concat(), "--solver sweep");
    refused(&["--quality", "papers", "--model", "physical"], "--quality papers is of the papers' model");
    for (more, word) in [
        (&["--steps", "9"][..], "--steps is for --model paper"),
        (&["--ordinates", "20"], "expected 18, 50 or 110"),
        (&["--rays", "0"], "expected 1 to 8"),
        (&["--tolerance", "0"], "--tolerance is 0"),
        (&["--max-sweeps", "0"], "--max-sweeps is 0"),
        (&["--solver", "sweep"], "--solver"),
        (&["--monte-carlo", "23"], "0..=22"),
    ] {
        refused(more, word);
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

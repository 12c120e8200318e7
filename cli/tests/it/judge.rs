//! `flb judge` on a plant that is baked in a moment: its figures, its pictures, and what it refuses.

use serde_json::Value;

use crate::flb::{FEW, Folder, Run, SMALL};
use crate::schema::{misfits, schema};

/// Few points, paths and suns.
const QUICK: [&str; 7] = ["--points", "200", "--samples", "16", "--suns", "2", "--json"];

fn judge(folder: &Folder, plant: &str, more: &[&str]) -> Run {
    let [file, mesh] = ["flb", "glb"].map(|extension| format!("{plant}.{extension}"));
    folder.flb_with(&[&["judge", &file, "--mesh", &mesh], &QUICK[..]].concat(), more)
}

/// The figures, and what else does not depend on the clock.
fn figures(run: &Run) -> String {
    let mut report = run.json();
    report.as_object_mut().expect("an object").remove("stages");
    report.to_string()
}

fn shrub() -> Folder {
    Folder::with_baked(&["shrub"], &[&SMALL[..], &FEW].concat(), &[0, 3])
}

/// The leaf card at lattice 16 as `leaf-card.flb`, baked with more flags.
fn card(more: &[&str]) -> Folder {
    Folder::with_baked(&["leaf-card"], &[&["--lattice", "16", "--voxels", "64"], more].concat(), &[0])
}

#[test]
fn leaves_and_wood_are_judged_and_the_figures_do_not_depend_on_the_threads() {
    let folder = shrub();
    let run = judge(&folder, "shrub", &["--threads", "1"]).expect_code(0);
    let report = run.json();
    assert_eq!(misfits(&schema("judge"), &report), [""; 0], "{report}");
    assert_eq!((&report["points"], &report["samples"]), (&200.into(), &16.into()));
    assert_eq!(report["suns"].as_array().map(Vec::len), Some(2));
    assert_eq!(report["pictures"], Value::Array(Vec::new()));
    let [leaf, wood] = ["leaf", "wood"].map(|class| &report[class]);
    let count = |figures: &Value| figures["count"].as_u64().expect("a count");
    assert_eq!(count(&leaf["sky"]) + count(&wood["sky"]), 200);
    assert_eq!(count(&leaf["suns"]), 2 * count(&leaf["sky"]));
    assert_eq!(count(&leaf["sides"]), 6 * count(&leaf["sky"]));
    let groups = leaf["by_openness"].as_array().expect("four");
    let in_groups = groups.iter().filter(|group| !group.is_null()).map(count).sum::<u64>();
    assert_eq!(in_groups, 3 * count(&leaf["sky"]));
    assert_eq!(wood["sides"], Value::Null);
    for band in 0..3 {
        let ratio = leaf["sky"]["ratio"][band].as_f64().expect("a ratio");
        assert!((0.8..1.25).contains(&ratio), "band {band}: {}", leaf["sky"]);
    }
    let two = judge(&folder, "shrub", &["--threads", "2"]).expect_code(0);
    assert_eq!(figures(&run), figures(&two));

    let words =
        ["judge", "shrub.flb", "--mesh", "shrub.glb", "--points", "50", "--samples", "4", "--suns", "1"];
    let text = folder.flb(&words).expect_code(0).stdout;
    for words in
        ["50 points, 1 suns and the sky, 4 paths a side", "leaf, sky", "wood, sky", "worst of leaf: at"]
    {
        assert!(text.contains(words), "{words}: {text}");
    }
}

#[test]
fn pictures_are_written_whole_and_not_over_others() {
    let folder = card(&FEW);
    let draw = |more: &[&str]| {
        let few = ["--size", "24x16", "--points", "10", "--picture", "drawn"];
        folder.flb_with(
            &["judge", "leaf-card.flb", "--mesh", "leaf-card.glb", "--suns", "1"],
            &[&few[..], more].concat(),
        )
    };
    let run = draw(&["--json", "--threads", "1"]).expect_code(0);
    let report = run.json();
    assert_eq!(misfits(&schema("judge"), &report), [""; 0], "{report}");
    assert_eq!(report["wood"], Value::Null);
    let files = [("drawn/judge-sky.png", 1), ("drawn/judge-sun.png", 0)];
    let pictures = report["pictures"].as_array().expect("two");
    assert_eq!(pictures.len(), 2);
    for ((name, source), picture) in files.iter().zip(pictures) {
        assert_eq!((&picture["file"], &picture["source"]), (&(*name).into(), &(*source).into()));
        let decoder = png::Decoder::new(std::io::Cursor::new(folder.read(name)));
        let reader = decoder.read_info().expect("a PNG");
        assert_eq!((reader.info().width, reader.info().height), (3 * 24 + 2 * 4, 16), "{name}");
    }
    assert!(pictures[0]["full"].as_f64().is_some_and(|full| full > 0.0), "{report}");
    // A card alone scatters no light of the sun back onto itself.
    assert_eq!(pictures[1]["full"].as_f64(), Some(0.0));

    let before = files.map(|(name, _)| folder.read(name));
    draw(&[]).expect_code(4).says(&["judge-sky.png: exists already", "--force"]);
    let again = draw(&["--force", "--threads", "2"]).expect_code(0);
    assert!(
        again.stdout.contains("drawn/judge-sun.png: baked, path traced and difference"),
        "{}",
        again.stdout
    );
    assert!(files.map(|(name, _)| folder.read(name)) == before);

    std::fs::rename(folder.path("leaf-card.glb"), folder.path("drawn/judge-sun.png")).expect("a file");
    let words = ["judge", "leaf-card.flb", "--mesh", "drawn/judge-sun.png", "--picture", "drawn", "--force"];
    folder.flb(&words).expect_code(2).says(&["judge-sun.png", "itself"]);
    folder.write("taken", "");
    let none = ["judge", "leaf-card.flb", "--mesh", "none.glb", "--picture"];
    folder.flb_with(&none, &["taken"]).expect_code(4).says(&["taken: exists and is not a folder"]);
    folder.flb_with(&none, &["no/where"]).expect_code(4).says(&["no/where", "does not exist"]);
    folder.flb_with(&none, &["new/"]).expect_code(4).says(&["none.glb"]);
    assert!(!folder.path("new").exists());
    let words = ["judge", "leaf-card.flb", "--mesh", "none.glb"];
    folder.flb_with(&words, &["--size", "9x9"]).expect_code(2).says(&["--picture"]);
}

#[test]
fn files_without_scattered_light_and_surfaces_are_refused() {
    for (flags, words) in [
        (&["--model", "paper"][..], "found a paper file"),
        (&["--field", "total", "--ordinates", "18"], "found fields that hold the sun's beam"),
    ] {
        let run = judge(&card(flags), "leaf-card", &[]).expect_code(2);
        assert_eq!(run.stdout, "");
        run.says(&["leaf-card.flb: ", words, "expected"]);
    }
}

#[test]
fn meshes_that_cannot_be_judged_are_refused() {
    let folder = card(&FEW);
    let on = |mesh: &str, more: &[&str]| folder.flb_with(&["judge", "leaf-card.flb", "--mesh", mesh], more);
    on("none.glb", &[]).expect_code(4).says(&["none.glb", "No such file"]);
    on("https://a.example/leaf.glb", &[])
        .expect_code(2)
        .says(&["found a URL, expected a file of this machine"]);
    for flags in [["--suns", "0"], ["--suns", "23"], ["--points", "0"], ["--samples", "1"]] {
        on("leaf-card.glb", &flags).expect_code(2).says(&[flags[0], flags[1]]);
    }
    folder.flb(&["judge", "none.flb", "--mesh", "leaf-card.glb"]).expect_code(4).says(&["none.flb"]);
    folder.flb(&["judge", "leaf-card.flb"]).expect_code(2).says(&["--mesh"]);
    folder.flb(&["grow", "shrub", "--triangles", "500", "-o", "shrub.glb"]).expect_code(0);
    on("shrub.glb", &[]).expect_code(2).says(&["shrub.glb", "was baked with", "not the mesh"]);
}

/// The mesh was baked with a leaf and a pot; later only the pot is left.
#[test]
fn a_mesh_without_leaves_and_wood_is_a_negative_verdict() {
    let folder = Folder::new();
    let vertices = "mtllib plant.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 0.05\nv 1 0 0.05\nv 0 1 0.05\n";
    let pot = "usemtl pot\nf 4 5 6\n";
    folder.write("plant.mtl", "newmtl leaf\nnewmtl pot\n");
    folder.write("plant.obj", format!("{vertices}usemtl leaf\nf 1 2 3\n{pot}"));
    let bake =
        ["bake", "plant.obj", "--ignore", "pot", "--lattice", "16", "--voxels", "64", "-o", "plant.flb"];
    folder.flb_with(&bake, &FEW).expect_code(0);
    // Neither normals nor texture coordinates stand in the file.
    let report = judge_obj(&folder).expect_code(0).json();
    assert_eq!((&report["points"], &report["wood"]), (&10.into(), &Value::Null));
    folder.write("plant.obj", format!("{vertices}usemtl leaf\n{pot}"));
    let run = judge_obj(&folder).expect_code(1);
    run.says(&["plant.obj: found no point of leaf or wood", "expected some surface"]);
}

fn judge_obj(folder: &Folder) -> Run {
    folder.flb(&["judge", "plant.flb", "--mesh", "plant.obj", "--points", "10", "--suns", "1", "--json"])
}

#[test]
fn a_bake_keeps_how_far_its_light_is_off_until_it_is_coded_anew() {
    let folder = card(&["--judge"]);
    let error = |file: &str| {
        let info = folder.flb(&["info", file, "--json"]).expect_code(0).json();
        assert_eq!(misfits(&schema("info"), &info), [""; 0], "{info}");
        info["species"][0]["mesh_error"].clone()
    };
    let kept = error("leaf-card.flb");
    assert_eq!((&kept["suns"], &kept["samples"], &kept["wood"]), (&16.into(), &64.into(), &Value::Null));
    // It is what `flb judge` finds by itself, to the fourth decimal.
    let judged =
        folder.flb(&["judge", "leaf-card.flb", "--mesh", "leaf-card.glb", "--json"]).expect_code(0).json();
    assert_eq!(kept["points"], judged["points"]);
    for (figure, band) in [("ratio", 0), ("ratio", 1), ("rms", 2)] {
        let [kept, judged] =
            [&kept["leaf"], &judged["leaf"]].map(|of| of["sky"][figure][band].as_f64().expect("a number"));
        assert!((kept - judged).abs() <= 5.1e-5, "{figure} {band}: {kept} and {judged}");
    }
    // Nothing scatters the suns' light onto a leaf by itself.
    assert_eq!((&kept["leaf"]["suns"], &judged["leaf"]["suns"]), (&Value::Null, &Value::Null));
    let text = folder.flb(&["info", "leaf-card.flb"]).expect_code(0).stdout;
    let species = text.split("species leaf-card\n").nth(1).expect("the species");
    assert!(species.starts_with("  on mesh    light over truth: leaves "), "{text}");

    folder.flb(&["pack", "leaf-card.flb", "-o", "again.flb", "--codec", "raw-f16"]).expect_code(0);
    assert_eq!(error("again.flb"), Value::Null);
    let text = folder.flb(&["info", "again.flb"]).expect_code(0).stdout;
    assert!(text.contains("  on mesh    not judged: "), "{text}");
}

#[test]
fn a_bake_that_cannot_be_judged_is_refused_before_the_work() {
    let folder = Folder::with_plants(&["leaf-card"]);
    folder.write("bands.toml", "[[surfaces]]\nname = \"NIR\"\nleaf = { reflectance = 0.4, transmittance = 0.4 }\nwood = { reflectance = 0.4 }\n");
    for (flags, found) in [
        (&["--model", "paper"][..], "--model paper"),
        (&["--field", "total"], "--field total"),
        (&["--species", "bands.toml"], "the bands NIR"),
    ] {
        let words = [&["bake", "leaf-card.glb", "-o", "out.flb", "--judge"], flags].concat();
        let run = folder.flb(&words).expect_code(2);
        assert!(run.stderr.contains(found) && run.stderr.contains("--judge expects"), "{}", run.stderr);
        assert!(!folder.path("out.flb").exists());
    }
}

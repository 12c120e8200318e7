//! What is written and what is not: whole files or none, the same bytes every time, data on stdout alone.

use std::fs;

use crate::flb::{self, Folder, MODELS, PAPER, SMALL, names_in};

#[test]
fn a_bake_is_the_same_for_1_and_2_threads() {
    for model in MODELS {
        let folder = Folder::with_plants(&["shrub"]);
        for threads in ["1", "2"] {
            let (out, fields) = (format!("{threads}.flb"), format!("fields{threads}.flb"));
            let bake = ["bake", "shrub.glb", "-o", &out, "--keep-fields", &fields, "--threads", threads];
            folder.flb_with(&bake, &[&SMALL, model].concat()).expect_code(0);
            let render = ["render", &out, "--mesh", "shrub.glb", "--sun", "90,30", "--size", "32x32"];
            // In f32: a PNG hides the last bits.
            folder.flb_with(&render, &["--threads", threads, "-o", &format!("{threads}.exr")]).expect_code(0);
        }
        assert!(folder.read("1.flb") == folder.read("2.flb"), "{model:?}");
        assert!(folder.read("fields1.flb") == folder.read("fields2.flb"), "{model:?}");
        assert!(folder.read("1.exr") == folder.read("2.exr"), "{model:?}");
    }
}

#[test]
fn an_output_that_is_an_input_is_refused_even_with_force() {
    let folder = Folder::with_card();
    fs::hard_link(folder.path("card.flb"), folder.path("other-name.flb")).expect("one file, two names");
    let (mesh, card) = (folder.read("leaf-card.glb"), folder.read("card.flb"));
    for words in [
        &["bake", "leaf-card.glb", "-o", "leaf-card.glb", "--force"][..],
        &["bake", "leaf-card.glb", "-o", "x.flb", "--keep-fields", "./leaf-card.glb", "--force"],
        &["pack", "card.flb", "-o", "./card.flb", "--force"],
        &["pack", "card.flb", "-o", "other-name.flb", "--force"],
        &["extract", "card.flb", "--base", "1", "--format", "npy", "-o", "card.flb", "--force"],
        &["render", "card.flb", "--mesh", "leaf-card.glb", "--sun", "1,1", "-o", "card.flb", "--force"],
    ] {
        folder.flb(words).expect_code(2).says(&["input"]);
    }
    assert_eq!(folder.read("leaf-card.glb"), mesh);
    assert_eq!(folder.read("card.flb"), card);
}

#[test]
fn a_failed_bake_leaves_nothing_behind() {
    let folder = Folder::with_plants(&["leaf-card"]);
    folder.write("broken.glb", &folder.read("leaf-card.glb")[..500]);
    let before = folder.names();
    // The second mesh is only found broken after the first is solved.
    let bake = ["bake", "leaf-card.glb", "broken.glb", "-o", "x.flb", "--keep-fields", "fields.flb"];
    folder.flb_with(&bake, &SMALL).expect_code(1).says(&["broken.glb"]);
    assert_eq!(folder.names(), before);
    // A successful one leaves its outputs and nothing else.
    folder
        .flb_with(&["bake", "leaf-card.glb", "-o", "x.flb", "--keep-fields", "fields.flb"], &SMALL)
        .expect_code(0);
    assert_eq!(folder.names(), ["broken.glb", "fields.flb", "leaf-card.glb", "x.flb"]);
}

#[test]
fn stdout_is_data_and_stderr_is_talk() {
    let folder = Folder::with_plants(&["leaf-card"]);
    let run = folder.flb_with(&["bake", "leaf-card.glb", "-o", "x.flb", "--json"], &SMALL).expect_code(0);
    run.json();
    assert!(run.stderr.contains("material \"leaves\" is leaf"), "{}", run.stderr);
    assert!(
        !run.stderr.contains('\u{1b}'),
        "no bars and no colours where there is no terminal: {}",
        run.stderr
    );
    let run = folder.flb(&["info", "none.flb", "--json"]).expect_code(4);
    assert_eq!(run.stdout, "");
}

#[test]
fn a_cache_is_reused_and_changes_nothing() {
    // Voxels and medium, and the fields: one for each base; the physical model keeps the crown and a report, too.
    cache(&PAPER, "sweep", 2, 19);
    cache(&["--ordinates", "18"], "ordinates", 3, 14);
}

/// With a model whose solver and number of artefacts, shared by all settings and by one, are these.
fn cache(model: &[&str], solver: &str, shared: usize, of_settings: usize) {
    let folder = Folder::with_plants(&["shrub"]);
    let bake = |out: &str, more: &[&str]| {
        let words = ["bake", "shrub.glb", "--name", "shrub", "--json", "-o", out];
        folder.flb(&[&words[..], &SMALL, model, more].concat()).expect_code(0)
    };
    let solve = |run: &flb::Run| {
        let stages = run.json()["stages"].clone();
        let solve = stages.as_array().expect("a list").iter().find(|stage| stage["name"] == "solve");
        let of_species = solve.expect("it solves")["solves"][0].clone();
        assert_eq!(of_species["solver"], solver);
        of_species["cached"] == true
    };
    assert!(!solve(&bake("plain.flb", &[])));
    assert!(!solve(&bake("first.flb", &["--cache", "cache"])));
    // What tells why a stage is redone is no artefact: it may be another after every bake.
    let names = || -> Vec<String> {
        let is_artefact = |name: &String| !name.starts_with("parts-");
        names_in(&folder.path("cache")).into_iter().filter(is_artefact).collect()
    };
    let kept = names();
    assert_eq!(kept.len(), shared + of_settings, "{kept:?}");
    let read = |name: &str| fs::read(folder.path("cache").join(name)).expect("an artefact");
    let bytes: Vec<Vec<u8>> = kept.iter().map(|name| read(name)).collect();
    let times = || -> Vec<_> {
        let modified =
            |name: &String| fs::metadata(folder.path("cache").join(name)).and_then(|m| m.modified());
        kept.iter().map(|name| modified(name).expect("a time")).collect()
    };
    let before = times();
    let run = bake("second.flb", &["--cache", "cache"]);
    assert!(!run.stderr.contains("made again"), "{}", run.stderr);
    assert!(solve(&run));
    assert_eq!(times(), before, "what is reused is not written again");
    let plain = folder.read("plain.flb");
    assert!(folder.read("first.flb") == plain && folder.read("second.flb") == plain);

    let words = ["bake", "shrub.glb", "--name", "shrub", "--cache", "cache", "-o", "fourth.flb"];
    let run = folder.flb(&[&words[..], &SMALL, model].concat()).expect_code(0);
    assert!(run.stdout.contains("solve (cached)"), "{}", run.stdout);

    // Other settings are other artefacts, and what did not converge is not kept.
    let run = bake("loose.flb", &["--cache", "cache", "--tolerance", "0.0011"]);
    assert!(!solve(&run));
    let told = run.stderr.lines().filter(|line| line.contains("redone")).collect::<Vec<_>>();
    assert_eq!(told, ["flb: shrub: solve is redone, as the last bake had other: tolerance"]);
    let all = names().len();
    assert_eq!(all, shared + 2 * of_settings, "the fields are others, voxels and medium are not");
    let words = ["bake", "shrub.glb", "--cache", "cache", "--max-sweeps", "1", "-o", "open.flb"];
    folder.flb(&[&words[..], &SMALL, model].concat()).expect_code(3);
    assert_eq!(names().len(), all);

    // A flipped bit, a cut and an empty file are found, said, and made again.
    for (i, name) in kept.iter().enumerate() {
        let mut broken = bytes[i].clone();
        match i % 3 {
            0 => {
                let middle = broken.len() / 2;
                broken[middle] ^= 1;
            }
            1 => broken.truncate(broken.len() / 2),
            _ => broken.clear(),
        }
        fs::write(folder.path("cache").join(name), broken).expect("a temporary file");
    }
    let run = bake("third.flb", &["--cache", "cache"]);
    assert!(run.stderr.contains("made again") && !solve(&run), "{}", run.stderr);
    assert!(folder.read("third.flb") == plain);
    for (name, bytes) in kept.iter().zip(&bytes) {
        assert!(read(name) == *bytes, "{name} was made again");
    }
}

#[test]
fn the_light_of_another_mesh_is_said_or_refused() {
    let folder = Folder::with_card();
    folder.flb(&["grow", "leaf-card", "--seed", "2", "--triangles", "200", "-o", "other.glb"]).expect_code(0);
    folder
        .flb(&[
            "render",
            "card.flb",
            "--mesh",
            "other.glb",
            "--sun",
            "90,30",
            "--size",
            "16x16",
            "-o",
            "x.png",
        ])
        .expect_code(0)
        .says(&["not the mesh that species"]);
    folder.flb(&["grow", "shrub", "--triangles", "500", "-o", "shrub.glb"]).expect_code(0);
    folder
        .flb(&[
            "render",
            "card.flb",
            "--mesh",
            "shrub.glb",
            "--sun",
            "90,30",
            "--size",
            "16x16",
            "-o",
            "y.png",
        ])
        .expect_code(2)
        .says(&["not the mesh that it was baked from"]);
}

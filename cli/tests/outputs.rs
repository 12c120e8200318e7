//! What is written and what is not: whole files or none, the same bytes every time, data on stdout alone.

use std::fs;

use crate::flb::{Folder, SMALL, names_in};

mod flb;

#[test]
fn a_bake_is_the_same_for_1_and_2_threads() {
    let folder = Folder::with_plants(&["shrub"]);
    for threads in ["1", "2"] {
        let (out, fields) = (format!("{threads}.flb"), format!("fields{threads}.flb"));
        let bake = ["bake", "shrub.glb", "-o", &out, "--keep-fields", &fields, "--threads", threads];
        folder.flb_with(&bake, &SMALL).expect_code(0);
        let render = ["render", &out, "--mesh", "shrub.glb", "--sun", "90,30", "--size", "32x32"];
        folder.flb_with(&render, &["--threads", threads, "-o", &format!("{threads}.png")]).expect_code(0);
    }
    assert_eq!(folder.read("1.flb"), folder.read("2.flb"));
    assert_eq!(folder.read("fields1.flb"), folder.read("fields2.flb"));
    assert_eq!(folder.read("1.png"), folder.read("2.png"));
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
    let folder = Folder::with_plants(&["shrub"]);
    let bake = |out: &str, more: &[&str]| {
        let words = ["bake", "shrub.glb", "--name", "shrub", "--json", "-o", out];
        folder.flb(&[&words[..], &SMALL, more].concat()).expect_code(0)
    };
    bake("plain.flb", &[]);
    bake("first.flb", &["--cache", "cache"]);
    let kept = names_in(&folder.path("cache"));
    assert_eq!(kept.len(), 21, "voxels, medium and 19 fields: {kept:?}");
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
    assert_eq!(times(), before, "what is reused is not written again");
    let plain = folder.read("plain.flb");
    assert!(folder.read("first.flb") == plain && folder.read("second.flb") == plain);

    // Other settings are other artefacts.
    bake("loose.flb", &["--cache", "cache", "--tolerance", "0.001"]);
    assert_eq!(names_in(&folder.path("cache")).len(), 40, "the fields are others, voxels and medium are not");

    // A flipped bit, a cut and an empty file are found, said, and made again.
    for (i, name) in kept.iter().enumerate().take(21) {
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
    assert!(run.stderr.contains("made again"), "{}", run.stderr);
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
        .says(&["not the file that species"]);
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

//! Every exit code of the house, provoked, with the words that go with it.

use flb_format::container::digest::Root;
use flb_format::container::records::{HEADER_BYTES, Header};

use crate::flb::{Folder, MODELS, PAPER, SMALL};

/// `bytes` with another header and a root that fits it, so that only the edit is wrong.
fn with_header(bytes: &[u8], edit: impl FnOnce(&mut Header)) -> Vec<u8> {
    let head = HEADER_BYTES as usize;
    let (mut header, _) = Header::from_bytes(bytes[..head].try_into().expect("a whole header"));
    edit(&mut header);
    let mut root = Root::new(&header.to_bytes());
    root.update(&bytes[head..]);
    header.root = root.finish();
    [&header.to_bytes()[..], &bytes[head..]].concat()
}

#[test]
fn usage_is_2() {
    let folder = Folder::with_card();
    for words in [
        &["bake"][..],
        &["frobnicate"],
        &["bake", "leaf-card.glb", "-o", "x.flb", "--lattice", "33"],
        &["bake", "leaf-card.glb", "-o", "x.flb", "--lattice", "512"],
        &["bake", "leaf-card.glb", "-o", "x.flb", "--lattice", "32", "--voxels", "100"],
        &["bake", "leaf-card.glb", "-o", "x.flb", "--lattice", "32", "--tolerance", "2"],
        &["bake", "leaf-card.glb", "-o", "x.flb", "--threshold", "nan"],
        &["bake", "leaf-card.glb", "-o", "x.flb", "--quality", "best"],
        &["bake", "leaf-card.glb", "-o", "x.flb", "--for", "radio"],
        &["bake", "leaf-card.glb", "-o", "x.flb", "--for", "games", "--quality", "fine"],
        &["pack", "card.flb", "-o", "x.flb", "--threshold", "1", "--quality", "fine"],
        &["bake", "leaf-card.glb", "-o", "x.flb", "--unit", "-1"],
        &["bake", "leaf-card.glb", "-o", "x.flb", "--keep-fields", "x.flb"],
        &["bake", "leaf-card.glb", "leaf-card.glb", "-o", "x.flb", "--name", "two"],
        &["pack", "card.flb", "-o", "x.flb", "--codec", "raw-f32", "--threshold", "1"],
        &["pack", "card.flb", "-o", "x.flb", "--codec", "raw-f16", "--quality", "high"],
        &["pack", "card.flb", "-o", "x.flb", "--codec", "f16"],
        &["extract", "card.flb", "--format", "png", "-o", "x.png"],
        &["extract", "card.flb", "--base", "19", "--format", "png", "-o", "x.png"],
        &["extract", "card.flb", "--species", "fern", "--base", "1", "--format", "png", "-o", "x.png"],
        &["render", "card.flb", "--mesh", "leaf-card.glb", "--sun", "90", "-o", "x.png"],
        &["render", "card.flb", "--mesh", "leaf-card.glb", "--sun", "90,95", "-o", "x.png"],
        &["render", "card.flb", "--mesh", "leaf-card.glb", "--sun", "90,5", "-o", "x.jpeg"],
        &["render", "card.flb", "--mesh", "leaf-card.glb", "--sun", "90,5", "--samples", "0", "-o", "x.png"],
        &["diff", "card.flb", "card.flb", "--tolerance", "-1"],
        &["grow", "oak", "--triangles", "7", "-o", "x.glb"],
        &["grow", "fern", "-o", "x.glb"],
    ] {
        let run = folder.flb(words);
        assert_eq!(run.code, 2, "{words:?}: {}", run.stderr);
        assert!(!run.stderr.is_empty() && run.stdout.is_empty(), "{words:?}: {}", run.stdout);
    }
    assert_eq!(folder.names(), ["card.flb", "leaf-card.glb"]);
}

#[test]
fn a_missing_file_is_4() {
    let folder = Folder::with_card();
    for words in [
        &["bake", "none.glb", "-o", "x.flb"][..],
        &["bake", "leaf-card.glb", "-o", "no/such/folder/x.flb"],
        &["bake", "leaf-card.glb", "-o", "x.flb", "--species", "none.toml"],
        &["materials", "none.glb"],
        &["pack", "none.flb", "-o", "x.flb"],
        &["info", "none.flb"],
        &["validate", "none.flb"],
        &["diff", "card.flb", "none.flb"],
        &["extract", "none.flb", "--base", "1", "--format", "png", "-o", "x.png"],
        &["render", "none.flb", "--mesh", "leaf-card.glb", "--sun", "1,1", "-o", "x.png"],
        &["render", "card.flb", "--mesh", "none.glb", "--sun", "1,1", "-o", "x.png"],
    ] {
        let run = folder.flb(words).expect_code(4);
        assert!(run.stderr.contains("no"), "{words:?}: {}", run.stderr);
    }
}

#[test]
fn an_output_that_is_there_is_4_without_force() {
    let folder = Folder::with_card();
    folder.write("there", "keep me").write("there.png", "keep me").write("there.flb", "keep me");
    folder.flb(&["pack", "card.flb", "-o", "kept.flb", "--codec", "raw-f32"]).expect_code(0);
    let bake = ["bake", "leaf-card.glb", "--lattice", "16", "--voxels", "128"];
    let before = folder.names();
    for words in [
        &[&bake[..], &["-o", "there.flb"]].concat()[..],
        &[&bake[..], &["-o", "x.flb", "--keep-fields", "there.flb"]].concat(),
        &["pack", "kept.flb", "-o", "there.flb"],
        &["extract", "card.flb", "--base", "1", "--format", "png", "-o", "there.png"],
        &["render", "card.flb", "--mesh", "leaf-card.glb", "--sun", "1,1", "-o", "there.png"],
        &["grow", "shrub", "-o", "there"],
    ] {
        folder.flb(words).expect_code(4).says(&["there", "--force"]);
    }
    for name in ["there", "there.png", "there.flb"] {
        assert_eq!(folder.read(name), b"keep me", "{name}");
    }
    assert_eq!(folder.names(), before);
    folder.flb_with(&bake, &[&["-o", "there.flb", "--force"], &PAPER[..]].concat()).expect_code(0);
    assert_eq!(folder.read("there.flb"), folder.read("card.flb"));
    folder.flb(&["grow", "leaf-card", "-o", "there", "--force"]).expect_code(0);
    assert_eq!(folder.read("there"), folder.read("leaf-card.glb"));
}

#[test]
fn a_damaged_file_is_1_with_code_and_place() {
    MODELS.into_iter().zip(["12", "18"]).for_each(|(model, last_base)| damaged(model, last_base));
}

fn damaged(model: &[&str], last_base: &str) {
    let folder = Folder::with_card_of(model);
    let whole = folder.read("card.flb");
    let flipped = |at: usize| {
        let mut bytes = whole.clone();
        bytes[at] ^= 1;
        bytes
    };
    folder
        .write("cut.flb", &whole[..whole.len() - 1])
        .write("half.flb", &whole[..whole.len() / 2])
        .write("head.flb", &whole[..100])
        .write("empty.flb", "")
        .write(
            "text.flb",
            "this is no library of light, only text that is long enough for a header".repeat(4),
        )
        .write("magic.flb", flipped(3))
        .write("contents.flb", flipped(140))
        .write("page.flb", flipped(whole.len() - 9))
        .write("more.flb", [&whole[..], &[0]].concat());
    for name in ["cut", "half", "head", "empty", "text", "magic", "contents", "page", "more"] {
        let file = format!("{name}.flb");
        let run = folder.flb(&["validate", &file]).expect_code(1);
        assert!(run.stdout.contains("INVALID: FLB-"), "{name}: {}", run.stdout);
        let report = folder.flb(&["validate", &file, "--json"]).expect_code(1).json();
        assert_eq!(report["valid"], false, "{name}");
        let issue = &report["issues"][0];
        let code = issue["code"].as_str().expect("a code");
        assert!(code.starts_with("FLB-") && code.len() == 8, "{name}: {code}");
        for key in ["place", "message"] {
            assert!(issue[key].as_str().is_some_and(|text| !text.is_empty()), "{name}: {key} of {issue}");
        }
    }
    // Commands that read say it too; what sits in a page that they do not need may pass.
    for name in ["cut", "head", "text", "magic", "contents"] {
        let file = format!("{name}.flb");
        folder.flb(&["info", &file]).expect_code(1).says(&["FLB-", &file]);
        folder.flb(&["pack", &file, "-o", "x.flb"]).expect_code(1).says(&["FLB-", &file]);
        folder.flb(&["diff", "card.flb", &file]).expect_code(1).says(&["FLB-", &file]);
    }
    folder.flb(&["pack", "page.flb", "-o", "x.flb"]).expect_code(1).says(&["FLB-", "page", "digest"]);
    folder
        .flb(&["extract", "page.flb", "--base", last_base, "--format", "npy", "-o", "x.npy"])
        .expect_code(1)
        .says(&["FLB-", &format!("base {last_base}")]);
    assert!(!folder.path("x.flb").exists() && !folder.path("x.npy").exists());
    // Among several files the damaged one decides.
    let run = folder.flb(&["validate", "card.flb", "page.flb", "card.flb"]).expect_code(1);
    assert_eq!(run.stdout.lines().count(), 3, "{}", run.stdout);
    // A level looks no deeper than it says.
    folder.flb(&["validate", "page.flb", "--level", "tables"]).expect_code(0);
    folder.flb(&["validate", "page.flb", "--level", "pages"]).expect_code(1);
}

#[test]
fn a_future_version_or_feature_is_5() {
    let folder = Folder::with_card();
    let whole = folder.read("card.flb");
    assert_eq!(with_header(&whole, |_| {}), whole, "the helper itself changes nothing");
    folder
        .write("version.flb", with_header(&whole, |header| header.version.0 += 1))
        .write("feature.flb", with_header(&whole, |header| header.required_features |= 1 << 40))
        .write(
            "draco.gltf",
            r#"{"asset": {"version": "2.0"}, "extensionsUsed": ["KHR_draco_mesh_compression"],
            "extensionsRequired": ["KHR_draco_mesh_compression"]}"#,
        );
    for file in ["version.flb", "feature.flb"] {
        folder.flb(&["info", file]).expect_code(5).says(&["FLB-", file]);
        let run = folder.flb(&["validate", file]).expect_code(5);
        assert!(run.stdout.contains("FLB-"), "{}", run.stdout);
        folder.flb(&["pack", file, "-o", "x.flb"]).expect_code(5);
    }
    folder.flb(&["materials", "draco.gltf"]).expect_code(5).says(&["KHR_draco_mesh_compression"]);
    // An optional feature is no reason to refuse.
    folder.write("optional.flb", with_header(&whole, |header| header.optional_features |= 1 << 40));
    folder.flb(&["validate", "optional.flb"]).expect_code(0);
}

#[test]
fn a_limit_is_6() {
    let folder = Folder::with_card();
    let wide = ["--size", "8190x1", "--samples", "1", "--sun", "1,1", "--sun", "2,2", "--sun", "3,3"];
    let render = ["render", "card.flb", "--mesh", "leaf-card.glb", "-o", "x.png"];
    folder.flb_with(&render, &wide).expect_code(6).says(&["16384"]);
}

#[test]
fn a_solve_that_gives_up_is_3_and_still_writes() {
    let folder = Folder::with_plants(&["shrub"]);
    let paper = &["57 of 57 solves did not converge", "the worst is base"];
    let physical = &["the light of 3 of 3 bands did not converge", "the worst is band"];
    for (model, says) in MODELS.into_iter().zip([physical, paper]) {
        let bake = ["bake", "shrub.glb", "-o", "x.flb", "--max-sweeps", "1", "--json", "--force"];
        let run = folder.flb_with(&bake, &[&SMALL, model].concat()).expect_code(3).says(says);
        assert_eq!(run.json()["converged"], false);
        folder.flb(&["validate", "x.flb"]).expect_code(0);
    }
}

#[test]
fn files_that_differ_are_1() {
    let folder = Folder::with_card();
    folder.flb(&["pack", "card.flb", "-o", "draft.flb", "--quality", "draft"]).expect_code(0);
    let run = folder.flb(&["diff", "card.flb", "draft.flb"]).expect_code(1);
    assert!(run.stdout.ends_with("different\n"), "{}", run.stdout);
    let run = folder.flb(&["diff", "card.flb", "card.flb"]).expect_code(0);
    assert!(run.stdout.ends_with("equal\n"), "{}", run.stdout);
}

/// One triangle each of a material named `thing` and one named `stuff`: no rule can know what they are.
const OBJ: &str =
    "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl thing\nf 1 2 3\nusemtl stuff\nf 1 2 4\n";
const MTL: &str = "newmtl thing\nKd 1 1 1\nnewmtl stuff\nKd 1 1 1\n";

#[test]
fn undecided_materials_are_2_and_the_flags_are_named() {
    let folder = Folder::new();
    folder.write("a.obj", OBJ).write("a.mtl", MTL);
    folder
        .flb_with(&["bake", "a.obj", "-o", "x.flb"], &SMALL)
        .expect_code(2)
        .says(&["thing", "stuff", "--leaf", "--wood"]);
    let run =
        folder.flb(&["materials", "a.obj", "--json"]).expect_code(0).says(&["--leaf", "--wood", "--ignore"]);
    assert_eq!(run.json()["decided"], false);
    folder
        .flb_with(&["bake", "a.obj", "-o", "x.flb", "--leaf", "thing", "--wood", "stuff"], &SMALL)
        .expect_code(0);
    // When the rest is leaf, an opaque remainder is wood, and that is said.
    folder
        .flb_with(&["bake", "a.obj", "-o", "y.flb", "--leaf", "thing"], &SMALL)
        .expect_code(0)
        .says(&["\"stuff\" is wood"]);
}

#[test]
fn a_pattern_that_matches_nothing_is_2() {
    let folder = Folder::with_plants(&["leaf-card"]);
    folder.write("fern.toml", "leaf = [\"frond*\"]\n");
    for flag in ["--leaf", "--wood", "--ignore"] {
        folder
            .flb_with(&["bake", "leaf-card.glb", "-o", "x.flb", flag, "frond*"], &SMALL)
            .expect_code(2)
            .says(&["frond*", flag, "leaves"]);
    }
    folder
        .flb_with(&["bake", "leaf-card.glb", "-o", "x.flb", "--species", "fern.toml"], &SMALL)
        .expect_code(2)
        .says(&["frond*", "fern.toml", "leaves"]);
    assert!(!folder.path("x.flb").exists());
}

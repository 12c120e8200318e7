//! `flb library diff`: exit codes, JSON, the page and JUnit XML.

use serde_json::json;

use crate::flb::{Folder, Run, names_in};
use crate::schema::{misfits, schema};

const MANIFEST: &str = "
[bake]
quality = 'draft'
lattice = 16
voxels = 64
codec = 'raw-f32'

[[species]]
mesh = 'leaf-card.glb'
name = 'card'

[[species.variant]]
name = 'pale'
plant = { leaf_model = { chlorophyll_ug_cm2 = 30.0 } }
";

/// Two libraries: `old`, and `new` in which the variant is paler.
fn farm() -> Folder {
    let folder = Folder::with_plants(&["leaf-card"]);
    for (name, chlorophyll) in [("old", "30.0"), ("new", "10.0")] {
        let text = format!("output = '{name}'\n{}", MANIFEST.replace("30.0", chlorophyll));
        folder.write(&format!("{name}.toml"), text);
        folder.flb(&["library", "build", &format!("{name}.toml")]).expect_code(0);
    }
    folder
}

#[track_caller]
fn fits(run: &Run) -> serde_json::Value {
    let found = run.json();
    assert_eq!(misfits(&schema("library-diff"), &found), [""; 0], "{found}");
    found
}

#[test]
fn the_gate_is_open_below_the_tolerance_and_closed_above() {
    let folder = farm();
    let diff = |old: &str, new: &str, more: &[&str]| folder.flb_with(&["library", "diff", old, new], more);
    let same = diff("old", "old", &["--fail-above", "0"]).expect_code(0);
    let summary = "old -> old: 0 changed, 0 removed, 0 added, 2 unchanged; 0 fail, with a tolerance of 0 %\n";
    assert_eq!(same.stdout, summary);

    let run = diff("old", "new", &[]).expect_code(0);
    let mut lines = run.stdout.lines();
    assert_eq!(lines.next(), Some("old -> new: 1 changed, 0 removed, 0 added, 1 unchanged"));
    let line = lines.next().expect("the species that changed");
    assert!(line.starts_with("card-pale: light differs by ") && line.contains(" m under the "), "{line}");
    assert_eq!(lines.next(), None);

    let found = fits(&diff("old", "new", &["--json"]).expect_code(0));
    let light = &found["species"][0]["light"];
    let rms = light["rms"].as_f64().expect("a number");
    assert!(rms > 1e-4 && light["mean"].as_f64().expect("a number") > 0.0, "{found}");
    for (share, code) in [(0.9 * rms, 1), (1.1 * rms, 0)] {
        for word in [share.to_string(), format!("{}%", 100.0 * share)] {
            let run = diff("old", "new", &["--fail-above", &word, "--json"]).expect_code(code);
            let found = fits(&run);
            assert_eq!(
                (&found["passes"], found["count"]["failed"].as_i64()),
                (&json!(code == 0), Some(code.into()))
            );
        }
    }
    // A species that is gone fails, one that is new does not.
    let alone = "old/species/card.flb";
    let run = diff("old", alone, &["--fail-above", "1"]).expect_code(1);
    assert!(run.stdout.contains("\ncard-pale: FAILED: is gone\n"), "{}", run.stdout);
    let run = diff(alone, "old/library.flb", &["--fail-above", "0"]).expect_code(0);
    assert!(run.stdout.ends_with("\ncard-pale: is new\n"), "{}", run.stdout);
    diff("old", alone, &[]).expect_code(0);
}

#[test]
fn a_folder_has_a_page_json_junit_and_pictures() {
    let folder = farm();
    let words = ["library", "diff", "old", "new", "--fail-above", "0.001%", "-o", "report", "--json"];
    let run = folder.flb(&words).expect_code(1);
    fits(&run);
    let expected =
        ["1-after.png", "1-before.png", "1-difference.png", "diff.json", "index.html", "junit.xml"];
    assert_eq!(names_in(&folder.path("report")), expected);
    let text = |name: &str| String::from_utf8(folder.read(&format!("report/{name}"))).expect("text");
    assert_eq!(text("diff.json"), run.stdout);
    assert!(folder.read("report/1-before.png") == folder.read("old/pictures/card-pale.png"));
    let page = text("index.html");
    for part in ["Failed:", "1 changed", "src=\"1-difference.png\"", "times 8", "card-pale"] {
        assert!(page.contains(part), "{part}: {page}");
    }
    assert!(!page.contains("<script") && !page.contains("http"), "{page}");
    let xml = text("junit.xml");
    assert!(
        xml.contains("<testsuite name=\"flb library diff: old -&gt; new\" tests=\"2\" failures=\"1\""),
        "{xml}"
    );
    let case = "<testcase classname=\"species\" name=\"card-pale\"><failure message=\"the light differs by ";
    assert!(xml.contains(case), "{xml}");
    assert!(xml.contains("name=\"card\"><system-out>the same bytes</system-out>"), "{xml}");

    folder.flb(&words).expect_code(4).says(&["exists already", "--force"]);
    let before = text("index.html");
    folder.flb_with(&words, &["--force", "--threads", "1"]).expect_code(1);
    assert_eq!(text("index.html"), before);
    for inner in ["old", "new", "new/species"] {
        let run = folder.flb(&["library", "diff", "old", "new", "-o", inner, "--force"]);
        run.expect_code(2).says(&["which is compared: name another folder"]);
    }
}

#[test]
fn bad_words_and_bad_files_are_told_with_a_code() {
    let folder = farm();
    let diff = |words: &[&str]| folder.flb(&[&["library", "diff"], words].concat());
    for word in ["-1%", "x", "nan", "inf%", ""] {
        diff(&["old", "new", &format!("--fail-above={word}")]).expect_code(2).says(&["as 1% or 0.01"]);
    }
    diff(&["old", "none"]).expect_code(4).says(&["none: cannot open"]);
    diff(&["old", "https://a.example/x.flb"]).expect_code(2).says(&["found a URL"]);
    diff(&["old", ".flb-cache"]).expect_code(1).says(&["a folder without index.json, expected one"]);
    let few = ["old", "new", "--memory-limit", "0.00001"];
    diff(&few).expect_code(6).says(&["card-pale.flb: species \"card-pale\"", "--memory-limit"]);
    let mut bytes = folder.read("new/species/card.flb");
    bytes[3000] ^= 1;
    folder.write("new/species/card.flb", bytes);
    diff(&["old", "new"]).expect_code(1).says(&["new/species/card.flb: found bytes of the digest"]);
    diff(&["old", "new/species/card.flb"]).expect_code(1).says(&["new/species/card.flb: FLB-"]);
    folder.write("new/index.json", "[]");
    diff(&["old", "new"]).expect_code(1).says(&["new/index.json: found", "expected an index"]);
    std::fs::remove_file(folder.path("old/species/card.flb")).expect("it was there");
    diff(&["old", "old"]).expect_code(4).says(&["old/species/card.flb: cannot open"]);
}

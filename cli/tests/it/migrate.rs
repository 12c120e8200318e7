//! Files of older versions are read by every command, and rewritten as the present version.

use std::path::PathBuf;

use serde_json::json;

use crate::flb::Folder;
use crate::schema::{misfits, schema};

fn golden(name: &str) -> Vec<u8> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../format-spec/golden"));
    std::fs::read(folder.join(name)).expect("golden files are in the repository")
}

#[test]
fn a_file_of_the_draft_becomes_one_of_version_1_with_the_same_light() {
    let folder = Folder::new();
    folder.write("old.flb", golden("v0.1/physical.flb"));
    let run = folder.flb(&["migrate", "old.flb", "-o", "new.flb", "--json"]).expect_code(0);
    let summary = run.json();
    assert_eq!(misfits(&schema("migrate"), &summary), [""; 0], "{summary}");
    assert_eq!((&summary["from"], &summary["to"]), (&json!("0.1"), &json!("1.0")));
    assert_eq!(summary["species"], json!(["scattered", "total", "paper"]));
    assert!(
        folder.read("new.flb") == golden("physical.flb"),
        "the file that this version writes of these fields"
    );
    folder.flb(&["validate", "old.flb", "new.flb"]).expect_code(0);
    folder.flb(&["diff", "old.flb", "new.flb"]).expect_code(0);
    let version =
        |file: &str| folder.flb(&["info", file, "--json"]).expect_code(0).json()["format_version"].clone();
    assert_eq!((version("old.flb"), version("new.flb")), (json!("0.1"), json!("1.0")));

    // A file of this version comes out as it went in.
    let run = folder.flb(&["migrate", "new.flb", "-o", "again.flb"]).expect_code(0);
    assert!(run.stdout.contains("version 1.0 to 1.0, 3 species"), "{}", run.stdout);
    assert!(folder.read("again.flb") == folder.read("new.flb"));
}

#[test]
fn what_is_wrong_in_an_old_file_is_not_migrated() {
    let folder = Folder::new();
    let sound = golden("v0.1/raw-f32.flb");
    let mut damaged = sound.clone();
    *damaged.last_mut().expect("a file has bytes") ^= 1;
    let mut future = sound.clone();
    future[8] = 2;
    folder.write("old.flb", &sound).write("damaged.flb", damaged).write("future.flb", future);
    folder
        .flb(&["migrate", "damaged.flb", "-o", "new.flb"])
        .expect_code(1)
        .says(&["damaged.flb", "FLB-4001"]);
    folder.flb(&["migrate", "future.flb", "-o", "new.flb"]).expect_code(5).says(&[
        "future.flb",
        "FLB-1003",
        "version 2.1",
        "0 and 1",
    ]);
    folder.flb(&["migrate", "old.flb", "-o", "old.flb", "--force"]).expect_code(2).says(&["input"]);
    assert!(folder.read("old.flb") == sound);
    assert_eq!(folder.names(), ["damaged.flb", "future.flb", "old.flb"]);
}

//! `flb torture`, and what it makes given to the other commands, under a limit of memory that the system enforces.
#![cfg(unix)]

use std::collections::BTreeMap;
use std::fs;

use flb_format::container::records::*;
use flb_format::testing::{Digests, Page, Parts, golden};
use serde_json::Value;

use crate::flb::{Folder, Run, names_in};
use crate::schema::{misfits, schema};

/// Kilobytes of address space, code and stacks included: 1 GiB.
const MEMORY_KB: u32 = 1 << 20;

/// Runs `flb` in a folder with no more memory than the limit.
fn limited(folder: &Folder, words: &[&str]) -> Run {
    folder.flb_under(&[format!("-v {MEMORY_KB}")], words)
}

#[test]
fn every_file_of_a_torture_gets_its_code_within_the_limit_of_memory() {
    for name in ["classed", "haar-paper-zstd"] {
        let folder = Folder::new();
        folder.write("good.flb", golden(name));
        let manifest = folder.flb(&["torture", "good.flb", "-o", "bad", "--json"]).expect_code(0).json();
        assert_eq!(misfits(&schema("torture"), &manifest), [""; 0]);
        let written: Value = serde_json::from_slice(&folder.read("bad/manifest.json")).expect("JSON");
        assert_eq!(written, manifest);
        assert_eq!((&manifest["agrees"], &manifest["wrong"]), (&Value::Bool(true), &Value::from(0)));

        let cases = manifest["cases"].as_array().expect("a list");
        assert!(cases.len() > 200, "{}", cases.len());
        let mut expected = BTreeMap::new();
        for case in cases {
            let file = format!("bad/{}", case["file"].as_str().expect("a name"));
            assert!(expected.insert(file, case["expected"]["code"].clone()).is_none(), "{case}");
        }
        let mut names: Vec<String> = expected.keys().map(|file| file["bad/".len()..].to_owned()).collect();
        names.push("manifest.json".to_owned());
        names.sort();
        assert_eq!(names_in(&folder.path("bad")), names);

        let mut words = vec!["validate", "--json"];
        words.extend(expected.keys().map(String::as_str));
        let report = limited(&folder, &words).expect_code(4).json();
        for file in report["files"].as_array().expect("a list") {
            let name = file["file"].as_str().expect("a name");
            let mut code = file["issues"].get(0).map_or(Value::Null, |issue| issue["code"].clone());
            if file["valid"].is_null() && file["error"].is_string() {
                code = "FLB-1000".into(); // could not be read, which is no verdict
            }
            assert_eq!(Some(&code), expected.get(name), "{name}");
        }
        assert_eq!(report["files"].as_array().map(Vec::len), Some(expected.len()));
        exit_codes(&folder, cases);
    }
}

/// The exit code of one file of each code.
fn exit_codes(folder: &Folder, cases: &[Value]) {
    let by_code: BTreeMap<&str, &Value> =
        cases.iter().map(|case| (case["expected"]["code"].as_str().unwrap_or("none"), case)).collect();
    assert!(by_code.len() > 25, "{:?}", by_code.keys());
    for case in by_code.into_values() {
        let file = format!("bad/{}", case["file"].as_str().expect("a name"));
        let run = folder.flb(&["validate", &file]);
        assert_eq!(Value::from(run.code), case["expected"]["exit"], "{case}");
    }
}

#[test]
fn a_species_of_gigabytes_in_kilobytes_is_refused_where_fields_are_needed_whole() {
    let folder = Folder::with_card();
    folder.flb(&["torture", "card.flb", "-o", "bad"]).expect_code(0);
    for giant in ["bad/38-giant-haar-paper.flb", "bad/38-giant-haar.flb"] {
        assert!(fs::metadata(folder.path(giant)).expect("it is there").len() < 50_000);
        limited(&folder, &["validate", giant]).expect_code(0);
        limited(&folder, &["info", giant]).expect_code(0);
        // One giant has two bases, the other one, which packs within 8 GB.
        let extract = ["extract", giant, "--base", "0", "--format", "npy", "-o", "x.npy"];
        let (diff, pack) = (["diff", giant, giant], ["pack", giant, "-o", "x.flb"]);
        let refused: &[&[&str]] =
            if giant.contains("paper") { &[&extract, &diff, &pack] } else { &[&extract, &diff] };
        for words in refused {
            let run = limited(&folder, words).expect_code(6);
            run.says(&[giant, "giant", "of memory needed, over the limit of 8 GB (--memory-limit)"]);
        }
        assert!(!folder.path("x.npy").exists() && !folder.path("x.flb").exists());
    }
    // The limit is the user's.
    let few = ["--memory-limit", "0.00001"];
    let render =
        ["render", "card.flb", "--mesh", "leaf-card.glb", "--sun", "90,30", "--size", "8x8", "-o", "x.png"];
    for words in [
        &["extract", "card.flb", "--base", "0", "--format", "npy", "-o", "x.npy"][..],
        &["pack", "card.flb", "-o", "x.flb"],
        &["diff", "card.flb", "card.flb"],
        &render,
    ] {
        folder.flb_with(words, &few).expect_code(6).says(&["card.flb", "over the limit of 0.00001 GB"]);
        folder.flb_with(words, &["--memory-limit", "0"]).expect_code(2).says(&["--memory-limit"]);
        folder.flb(words).expect_code(0);
    }
}

#[test]
fn the_most_metadata_that_a_file_may_have_take_less_than_the_limit() {
    let folder = Folder::new();
    let file = golden("raw-f32");
    let container = flb_format::Container::open(&file).expect("a golden file");
    let mut parts = Parts::of(&file);
    // Small objects take the most memory for their bytes: "{"a":0}," is 8 bytes, and hundreds in a tree.
    let text = String::from_utf8(container.read_metadata(&file, 0).expect("a golden file")).expect("UTF-8");
    let room = MAX_METADATA_BYTES as usize - text.len() - 40;
    let objects = format!("[{}0]", "{\"a\":0},".repeat(room / 8));
    let metadata = |name: String| {
        let text = text.replace("\"name\":\"sphere\"", &format!("\"name\":\"{name}\""));
        format!("{},\"~\":{objects}}}", &text[..text.len() - 1])
    };
    parts.remove(0);
    for species in 0..8u32 {
        let bytes = metadata(format!("species{species}")).into_bytes();
        let pages = [Page::plain(&bytes, bytes.len() as u32)];
        let key = SectionKey { kind: KIND_METADATA, species, item: 0 };
        parts.insert(species as usize, key, FLAG_REQUIRED, &pages).codec = CODEC_JSON;
    }
    parts.lay_out();
    folder.write("many.flb", parts.seal(Digests::Pages));
    // All metadata are read, and the second species has no more than these.
    let run = limited(&folder, &["validate", "many.flb"]).expect_code(1);
    assert!(
        run.stdout.contains("FLB-2008") && run.stdout.contains("species 1 has no density"),
        "{}",
        run.stdout
    );
}

#[test]
fn a_torture_needs_a_good_file_and_a_folder_of_its_own() {
    let folder = Folder::new();
    folder.write("good.flb", golden("raw-f32")).write("bad.flb", &golden("raw-f32")[..4000]);
    let torture = |file: &str, output: &str| folder.flb(&["torture", file, "-o", output]);
    torture("bad.flb", "out").expect_code(1).says(&["bad.flb", "FLB-1008"]);
    torture("none.flb", "out").expect_code(4).says(&["none.flb"]);
    torture("https://example.org/a.flb", "out").expect_code(2).says(&["not a URL"]);
    assert!(!folder.path("out").exists(), "nothing is made before the file is known to be good");
    let good = golden("raw-f32");
    let head: &[u8; HEADER_BYTES as usize] = good.first_chunk().expect("a header");
    let header = Header { file_bytes: 20 << 20, ..Header::from_bytes(head).0 };
    folder.write("large.flb", [&header.to_bytes()[..], &vec![0; (20 << 20) - head.len()]].concat());
    torture("large.flb", "out")
        .expect_code(6)
        .says(&["large.flb", "20971520 bytes, over the limit of 16777216"]);
    fs::create_dir(folder.path("full")).expect("a temporary folder");
    folder.write("full/mine", "keep me");
    torture("good.flb", "full").expect_code(4).says(&["full", "not empty"]);
    assert_eq!(names_in(&folder.path("full")), ["mine"]);
    let run = torture("good.flb", "out").expect_code(0);
    assert!(run.stdout.contains("32-claims-2-63.flb") && !run.stdout.contains("WRONG"), "{}", run.stdout);
    assert!(run.stdout.ends_with(" files, 0 with another verdict than expected\n"), "{}", run.stdout);
}

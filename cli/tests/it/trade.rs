//! `flb trade` on a plant that is solved in a moment: what it writes, that its rows are bakes, and what it refuses.

use serde_json::{Value, json};

use crate::flb::{self, Folder, Run};
use crate::schema::{misfits, schema};

/// Two lattices, few choices, few points.
const QUICK: [&str; 10] =
    ["--quick", "--lattices", "16,32", "--suns", "2", "--points", "256", "--voxels", "128", "--json"];

const FILES: [&str; 7] = [
    "trade-bytes.svg",
    "trade-memory.svg",
    "trade-mesh.svg",
    "trade-seconds.svg",
    "trade.csv",
    "trade.html",
    "trade.json",
];

fn trade(folder: &Folder, more: &[&str]) -> Run {
    folder.flb_with(&[&["trade", "shrub.glb"], &QUICK[..]].concat(), more)
}

fn rows(report: &Value) -> &[Value] {
    report["rows"].as_array().expect("a list")
}

fn weighed(row: &Value) -> [f64; 4] {
    ["seconds", "peak_bytes", "bytes", "finest_percent"].map(|key| row[key].as_f64().expect("a number"))
}

#[test]
fn rows_are_bakes_and_what_is_written_fits_together() {
    let folder = Folder::with_plants(&["shrub"]);
    let run = trade(&folder, &[]).expect_code(0);
    let report = run.json();
    assert_eq!(misfits(&schema("trade"), &report), [""; 0]);
    let written = flb::names_in(&folder.path("shrub-trade"));
    assert_eq!(written, FILES);
    assert_eq!(folder.read("shrub-trade/trade.json"), run.stdout.as_bytes());
    let rows = rows(&report);

    // The finest is the first, at no distance from itself, and nothing else is as near.
    let finest = &rows[0];
    assert_eq!((&finest["lattice"], &finest["suns"]), (&json!(32), &json!("sh3s")));
    assert_eq!((&finest["codec"], &finest["finest_percent"]), (&json!("raw-f32"), &json!(0.0)));
    assert!(rows[1..].iter().all(|row| row["finest_percent"].as_f64().is_some_and(|percent| percent > 0.0)));
    // Halves are half as long as floats, and nearly as near.
    let raw = |codec: &str| {
        rows.iter().find(|row| row["suns"] == "sh2s" && row["codec"] == codec).map(weighed).expect("one")
    };
    let [floats, halves] = ["raw-f32", "raw-f16"].map(raw);
    assert!(halves[2] < 0.6 * floats[2] && (halves[3] - floats[3]).abs() < 0.1, "{floats:?}, {halves:?}");
    let all = |key: &str, of: Value| rows.iter().filter(|row| row[key] == of).count();
    assert!(all("lattice", json!(16)) > 5 && all("model", json!("paper")) == 6, "{report}");
    // Rows of the papers' model are compared with its own finest, too: a looser coding is further off, and a coarser
    // lattice more so.
    let of_paper = |lattice: u32, codec: &str| {
        let is_it =
            |row: &&Value| row["model"] == "paper" && row["lattice"] == lattice && row["codec"] == codec;
        rows.iter().find(is_it).and_then(|row| row["paper_percent"].as_f64()).expect("one")
    };
    assert_eq!(of_paper(32, "raw-f32"), 0.0);
    let [classed, papers] = ["classed", "haar-paper"].map(|codec| of_paper(32, codec));
    assert!(0.0 < classed && classed < papers && papers < 20.0, "{classed} {papers}");
    assert!(of_paper(16, "raw-f32") > papers, "the coarse lattice");
    assert!(rows.iter().all(|row| row["paper_percent"].is_null() == (row["model"] != "paper")));
    assert_eq!(all("presets", json!(["draft"])), 1);
    let draft = rows.iter().find(|row| row["presets"] == json!(["draft"])).expect("one");
    assert_eq!(report["recommended"][0]["built_in"], draft["row"]);
    assert_eq!(report["skipped"].as_array().map(Vec::len), Some(3), "{}", report["skipped"]);

    for row in rows {
        assert!(row["peak_bytes"].as_u64() <= row["predicted_bytes"].as_u64(), "{row}");
    }

    // Coarser codings of one solve are shorter, and further off where what they drop is more than the fit's own error.
    let coded: Vec<&Value> = rows
        .iter()
        .filter(|row| {
            (&row["suns"], &row["ordinates"], &row["lattice"], &row["codec"])
                == (&json!("sh2s"), &json!(110), &json!(32), &json!("haar-paper"))
        })
        .collect();
    assert_eq!(coded.len(), 4);
    for pair in coded.windows(2) {
        let finer = pair[0]["threshold"].as_f64() < pair[1]["threshold"].as_f64();
        assert_eq!(weighed(pair[0])[2] > weighed(pair[1])[2], finer, "{pair:?}");
    }
    let distance = |threshold: f64| {
        let of = coded.iter().find(|row| row["threshold"].as_f64() == Some(threshold)).expect("a preset's");
        weighed(of)[3]
    };
    assert!(distance(0.05) > distance(0.0), "{coded:?}");

    // Every row on the front is unbeaten, every other is beaten; numbers count in steps of 10 %.
    let steps = |row: &Value| weighed(row).map(|value| libm::floor(libm::log(value) / libm::log(1.1)));
    let beats = |a: &Value, b: &Value| {
        let pairs = || steps(a).into_iter().zip(steps(b));
        pairs().all(|(a, b)| a <= b) && pairs().any(|(a, b)| a < b)
    };
    for row in rows {
        let beaten = rows.iter().any(|other| beats(other, row));
        assert_eq!(row["pareto"], !beaten, "{row}");
    }

    // The traced medium tells scattered light within a few per cent, and the paper's model worse.
    let truth = |row: &Value| row["monte_carlo"]["rms_percent"].as_f64().expect("traced");
    let paper = rows.iter().find(|row| row["model"] == "paper").expect("one");
    assert!(truth(finest) < 3.0 && truth(paper) > 3.0 * truth(finest), "{finest}, {paper}");

    // On the mesh, scattered light of either lattice is near the truth; what is no irradiance is not judged.
    for row in rows {
        let is_judged = row["model"] == "physical" && row["field"] == "scattered";
        assert_eq!((row["mesh"].is_object(), row["mesh_missing"].is_null()), (is_judged, is_judged), "{row}");
        if is_judged {
            let of = |key: &str| row["mesh"][key].as_f64().expect("a number");
            assert!((5.0..80.0).contains(&of("rms_percent")) && of("bias_percent").abs() < 40.0, "{row}");
        }
    }
    // The finest is judged as `flb judge` judges its file, whose points are others.
    folder.flb(&["bake", "shrub.glb", "--lattice", "32", "--voxels", "128", "-o", "j.flb"]).expect_code(0);
    let judge = [
        "judge",
        "j.flb",
        "--mesh",
        "shrub.glb",
        "--suns",
        "2",
        "--points",
        "256",
        "--samples",
        "32",
        "--json",
    ];
    let judge = folder.flb(&judge).expect_code(0).json();
    let preset =
        rows.iter().find(|row| row["lattice"] == 32 && row["suns"] == "sh2s" && row["codec"] == "classed");
    let preset = preset.expect("the default's light");
    for (class, source, band) in [("leaf", "sky", 1), ("leaf", "suns", 1), ("wood", "sky", 0)] {
        let [ours, theirs] =
            [&preset["mesh"], &judge].map(|of| of[class][source]["ratio"][band].as_f64().expect("a ratio"));
        assert!((ours - theirs).abs() < 0.06, "{class} {source}: {ours} and {theirs}");
    }

    // A row's file is the one that its flags bake.
    for row in [draft, paper] {
        let flags: Vec<&str> = row["flags"].as_str().expect("words").split(' ').collect();
        let bake = ["bake", "shrub.glb", "-o", "row.flb", "--voxels", "128", "--json", "--force"];
        let baked = folder.flb_with(&bake, &flags).expect_code(0).json();
        assert_eq!(
            (&baked["bytes"], &baked["species"][0]["sites_nonempty"]),
            (&row["bytes"], &row["sites"]),
            "{row}"
        );
    }

    // The table holds the same rows, and the page every plot and every row.
    let csv = String::from_utf8(folder.read("shrub-trade/trade.csv")).expect("UTF-8");
    assert_eq!(csv.lines().count(), 1 + rows.len());
    let columns = csv.lines().next().expect("a head").split(',').count();
    assert!(csv.lines().all(|line| line.split(',').count() == columns), "{csv}");
    let html = String::from_utf8(folder.read("shrub-trade/trade.html")).expect("UTF-8");
    let judged = rows.iter().filter(|row| row["mesh"].is_object()).count();
    for (name, marks) in
        [("bytes", rows.len()), ("memory", rows.len()), ("seconds", rows.len()), ("mesh", judged)]
    {
        let svg = String::from_utf8(folder.read(&format!("shrub-trade/trade-{name}.svg"))).expect("UTF-8");
        assert!(html.contains(&svg), "{name}");
        let tooltips = svg.matches("% from the finest").count();
        assert_eq!(tooltips, marks, "{name}");
    }
    assert!(rows.iter().all(|row| html.contains(&format!("<tr id=\"row{}\"", row["row"]))));
}

#[test]
fn light_and_bytes_come_out_the_same_and_nothing_is_overwritten_unasked() {
    let folder = Folder::with_plants(&["leaf-card"]);
    let words = ["trade", "leaf-card.glb", "--quick", "--lattices", "16", "--voxels", "128", "--json"];
    let trade =
        |more: &[&str]| folder.flb_with(&[&words[..], &["--suns", "2", "--points", "64"]].concat(), more);
    let first = trade(&["--threads", "1"]).expect_code(0).json();
    let before = folder.read("leaf-card-trade/trade.json");
    trade(&[]).expect_code(4).says(&["exists already", "--force"]);
    assert_eq!(folder.read("leaf-card-trade/trade.json"), before);
    let again = trade(&["--force", "--threads", "3"]).expect_code(0).json();
    let same = |report: &Value| -> Vec<Vec<Value>> {
        let keys = ["choice", "bytes", "fields", "finest_percent", "worst_band_percent", "monte_carlo"];
        rows(report).iter().map(|row| keys.iter().map(|key| row[key].clone()).collect()).collect()
    };
    assert_eq!(same(&first), same(&again));
    assert_eq!(flb::names_in(&folder.path("leaf-card-trade")), FILES);
}

#[test]
fn what_needs_too_much_memory_is_skipped_by_name() {
    let folder = Folder::with_plants(&["leaf-card"]);
    let words =
        ["trade", "leaf-card.glb", "--quick", "--suns", "1", "--points", "16", "--voxels", "128", "--json"];
    let some = ["--lattices", "16,128", "--memory-limit", "0.5", "--out", "some"];
    let report = folder.flb_with(&words, &some).expect_code(0).json();
    assert_eq!(misfits(&schema("trade"), &report), [""; 0]);
    assert!(rows(&report).iter().all(|row| row["lattice"] == 16), "{report}");
    let skipped = report["skipped"].as_array().expect("a list");
    let reasons: Vec<&str> = skipped.iter().filter_map(|skipped| skipped["reason"].as_str()).collect();
    assert!(reasons.iter().any(|reason| reason.contains("at most 500.0 MB")), "{reasons:?}");

    let none = ["--lattices", "16", "--memory-limit", "0.01", "--out", "none"];
    folder.flb_with(&words, &none).expect_code(6).says(&["of memory, at most 10.0 MB", "--memory-limit"]);
    assert!(!folder.path("none").exists());
}

#[test]
fn bands_that_only_one_model_has_are_not_compared() {
    let folder = Folder::with_plants(&["leaf-card"]);
    let band = |name| {
        format!(
            "[[surfaces]]\nname = \"{name}\"\nleaf = {{ reflectance = 0.4, transmittance = 0.4 }}\nwood = {{ reflectance = 0.2 }}\n"
        )
    };
    folder.write("nir.toml", band("NIR"));
    let words =
        ["trade", "leaf-card.glb", "--quick", "--suns", "1", "--points", "16", "--voxels", "128", "--json"];
    let more = ["--lattices", "16", "--species", "nir.toml"];
    let report = folder.flb_with(&words, &more).expect_code(0).json();
    assert!(
        rows(&report).iter().all(|row| row["model"] == "physical" && row["worst_band"] == "NIR"),
        "{report}"
    );
    let skipped = report["skipped"].as_array().expect("a list");
    assert!(skipped.iter().any(|s| s["reason"].as_str().is_some_and(|r| r.contains("R G B"))), "{skipped:?}");
}

#[test]
fn bad_words_are_refused_before_any_work() {
    let folder = Folder::with_plants(&["leaf-card"]);
    std::fs::create_dir(folder.path("kept")).expect("a folder");
    folder.write("file", "").write("kept/trade.csv", "");
    let refused = |more: &[&str], code, word: &str| {
        let before = folder.names();
        folder.flb_with(&["trade", "leaf-card.glb"], more).expect_code(code).says(&[word]);
        assert_eq!(folder.names(), before);
    };
    for (lattices, word) in
        [("48", "--lattices names 48"), ("8", "names 8"), ("32,32", "twice"), ("x", "invalid value")]
    {
        refused(&["--lattices", lattices], 2, word);
    }
    refused(&["--voxels", "100"], 2, "--voxels is 100");
    refused(&["--suns", "0"], 2, "--suns");
    refused(&["--points", "0"], 2, "--points");
    refused(&["--memory-limit", "0"], 2, "--memory-limit is 0");
    refused(&["--memory-limit", "nan"], 2, "--memory-limit is NaN");
    refused(&["--out", "none/there"], 4, "does not exist");
    refused(&["--out", "file"], 4, "not a folder");
    refused(&["--out", "kept"], 4, "trade.csv: exists already");
    folder.flb(&["trade", "none.glb"]).expect_code(4).says(&["none.glb"]);
    assert!(!folder.path("none-trade").exists());
}

#[test]
fn an_input_is_not_overwritten_even_with_force() {
    let folder = Folder::with_plants(&["leaf-card"]);
    std::fs::create_dir(folder.path("out")).expect("a folder");
    std::fs::rename(folder.path("leaf-card.glb"), folder.path("out/trade.csv")).expect("a file");
    folder.flb(&["trade", "out/trade.csv", "--out", "out", "--force"]).expect_code(2).says(&["input"]);
}

#[test]
fn what_a_mesh_names_is_refused_as_an_output_before_anything_is_measured() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("out")).expect("a folder");
    folder.write("out/a.obj", "mtllib trade.csv\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl leaf\nf 1 2 3\n");
    folder.write("out/trade.csv", "newmtl leaf\nKd 0.1 0.2 0.1\n");
    // Nothing can be measured in so little memory, which is found later.
    let words = ["trade", "out/a.obj", "--out", "out", "--force", "--memory-limit", "0.001"];
    folder.flb(&words).expect_code(2).says(&["trade.csv", "input"]);
    folder.flb(&["trade", "out/a.obj", "--memory-limit", "0.001"]).expect_code(6);
}

//! `--json` of every command against its schema in `cli/schema/`.

use serde_json::{Value, json};

use crate::flb::{Folder, PAPER, SMALL};
use crate::schema::{commands, misfits, schema};

#[track_caller]
fn fits(command: &str, value: &Value) {
    assert_eq!(misfits(&schema(command), value), [""; 0], "{command}: {value}");
}

/// The keys that the product promises, in whatever order.
#[track_caller]
fn has_keys(value: &Value, keys: &[&str]) {
    for key in keys {
        assert!(value.get(key).is_some(), "{key} is not in {value}");
    }
}

#[test]
fn json_of_every_command_fits_its_schema() {
    let folder = Folder::new();
    let run =
        folder.flb(&["grow", "shrub", "--triangles", "2000", "-o", "shrub.glb", "--json"]).expect_code(0);
    fits("grow", &run.json());
    let run = folder.flb(&["materials", "shrub.glb", "--json"]).expect_code(0);
    fits("materials", &run.json());

    let bake = ["bake", "shrub.glb", "-o", "shrub.flb", "--keep-fields", "fields.flb", "--json"];
    let baked = folder.flb_with(&bake, &[&SMALL[..], &PAPER].concat()).expect_code(0).json();
    fits("bake", &baked);
    has_keys(&baked, &["stages", "species"]);
    let names: Vec<&str> =
        baked["stages"].as_array().expect("a list").iter().filter_map(|s| s["name"].as_str()).collect();
    assert_eq!(names, ["import", "voxelise", "downsample", "solve", "encode", "write"]);
    for stage in baked["stages"].as_array().expect("a list") {
        has_keys(stage, &["name", "seconds", "peak_bytes"]);
    }
    let solve = &baked["stages"][3]["solves"][0];
    assert_eq!((&solve["species"], &solve["solver"]), (&json!("shrub"), &json!("sweep")));
    assert_eq!((&solve["solves"], &solve["converged"]), (&json!(57), &json!(57)));
    let [sweeps, residual, error] =
        ["sweeps", "residual", "error_estimate"].map(|key| solve[key].as_f64().expect("a number"));
    assert!(sweeps > 2.0 && 0.0 < residual && residual < error && error <= 1e-4, "{solve}");
    let species_keys = [
        "name",
        "triangles",
        "leaf_triangles",
        "wood_triangles",
        "lattice",
        "sites_nonempty",
        "bases",
        "bytes",
        "ratio",
        "surface_psnr_db",
        "plan",
    ];
    has_keys(&baked["species"][0], &species_keys);
    assert_eq!(baked["species"][0]["bases"], json!((0..=18).collect::<Vec<u8>>()));

    let packed =
        folder.flb(&["pack", "fields.flb", "-o", "draft.flb", "--quality", "draft", "--json"]).expect_code(0);
    fits("pack", &packed.json());
    has_keys(&packed.json()["species"][0], &species_keys);
    folder
        .flb(&["bake", "shrub.glb", "-o", "b.flb", "--name", "b", "--lattice", "16", "--voxels", "64"])
        .expect_code(0);
    let merged =
        folder.flb(&["pack", "draft.flb", "b.flb", "-o", "library.flb", "--json"]).expect_code(0).json();
    fits("pack", &merged);

    let info = folder.flb(&["info", "library.flb", "--json"]).expect_code(0).json();
    fits("info", &info);
    has_keys(&info, &["format_version", "species", "sections"]);
    has_keys(
        &info["species"][1],
        &["name", "lattice", "bases", "bands", "codec", "bounds", "spacing_m", "bytes"],
    );

    let valid = folder.flb(&["validate", "library.flb", "--json"]).expect_code(0).json();
    fits("validate", &valid);
    assert_eq!((&valid["valid"], &valid["issues"]), (&json!(true), &json!([])));
    folder.write("cut.flb", &folder.read("b.flb")[..5000]);
    let invalid = folder.flb(&["validate", "library.flb", "cut.flb", "--json"]).expect_code(1).json();
    fits("validate", &invalid);
    assert_eq!(invalid["valid"], false);
    has_keys(&invalid["issues"][0], &["code", "place", "message"]);

    for b in ["draft.flb", "b.flb", "library.flb", "fields.flb"] {
        let run = folder.flb(&["diff", "draft.flb", b, "--json"]);
        fits("diff", &run.json());
        assert_eq!(run.json()["equal"], run.code == 0, "{b}");
    }
    let tolerant = ["diff", "draft.flb", "fields.flb", "--tolerance", "0.5", "--json"];
    fits("diff", &folder.flb(&tolerant).expect_code(0).json());

    for what in [["--base", "0"], ["--base", "density"]] {
        let words = ["extract", "draft.flb", "--format", "png", "-o", "x.png", "--force", "--json"];
        fits("extract", &folder.flb_with(&words, &what).expect_code(0).json());
    }
    let words =
        ["render", "draft.flb", "--mesh", "shrub.glb", "--sun", "90,15", "--size", "16x16", "-o", "y.png"];
    let alone = folder.flb_with(&words, &["--json"]).expect_code(0).json();
    fits("render", &alone);
    // The same light has no difference; that of another coding has one, times ten in the third picture.
    for (other, is_same) in [("draft.flb", true), ("fields.flb", false)] {
        let beside = folder
            .flb_with(&words, &["--json", "--force", "--against", other, "--show", "indirect"])
            .expect_code(0)
            .json();
        fits("render", &beside);
        assert_eq!((beside["width"].as_u64(), alone["width"].as_u64()), (Some(3 * 16 + 2 * 4), Some(16)));
        let max = beside["difference"]["max"].as_u64().expect("a byte");
        assert_eq!(max == 0, is_same, "{other}: {beside}");
    }
    fits("doctor", &folder.flb(&["doctor", "--json"]).expect_code(0).json());
}

#[test]
fn doctor_reports_every_extreme() {
    let folder = Folder::new();
    let report = folder.flb(&["doctor", "--extremes", "--json"]).expect_code(0).json();
    fits("doctor", &report);
    let cases = report["extremes"].as_array().expect("a list");
    let of = |name: &str| cases.iter().find(|case| case["name"] == name).expect("a case of this name");
    assert!(cases.iter().all(|case| case["faults"] == json!([])), "{report}");
    assert_eq!(of("a tree, the papers' optics")["measured"]["converged"], 57);
    assert_eq!(of("all leaf, no absorption, backwards")["measured"]["converged"], 0);
    assert_eq!(of("a tree, green light")["model"], "physical");
    assert_eq!(of("1 pass")["measured"]["converged"], 0);
    assert!(of("g one ulp above 1")["refused"].as_str().expect("a reason").contains("expected -1 to 1"));
}

#[test]
fn an_exact_coding_has_no_psnr_and_one_of_16_bits_has_one() {
    let folder = Folder::with_plants(&["leaf-card"]);
    let bake = [
        "bake",
        "leaf-card.glb",
        "-o",
        "x.flb",
        "--keep-fields",
        "f.flb",
        "--lattice",
        "16",
        "--voxels",
        "64",
    ];
    folder.flb(&bake).expect_code(0);
    let packed =
        folder.flb(&["pack", "f.flb", "-o", "raw.flb", "--codec", "raw-f32", "--json"]).expect_code(0).json();
    assert_eq!(packed["species"][0]["surface_psnr_db"], Value::Null);
    fits("pack", &packed);

    let pack = ["pack", "f.flb", "-o", "half.flb", "--codec", "raw-f16", "--json"];
    let packed = folder.flb(&pack).expect_code(0).json();
    fits("pack", &packed);
    let psnr_db = packed["species"][0]["surface_psnr_db"].as_f64().expect("rounding has an error");
    assert!(psnr_db > 66.0, "{psnr_db}");
    assert_eq!(packed["species"][0]["ratio"], 2.0);
    folder.flb(&["validate", "half.flb"]).expect_code(0);
    let info = folder.flb(&["info", "half.flb", "--json"]).expect_code(0).json();
    fits("info", &info);
    assert_eq!(info["species"][0]["codec"], "raw-f16");
    let again = folder.flb(&["pack", "half.flb", "-o", "again.flb", "--codec", "raw-f16"]).expect_code(0);
    assert!(!again.stderr.contains("lost detail"), "{}", again.stderr);
    assert_eq!(folder.read("again.flb"), folder.read("half.flb"));
    folder
        .flb(&["pack", "half.flb", "-o", "haar.flb"])
        .expect_code(0)
        .says(&["lost detail already (rounded to raw-f16)"]);
}

#[test]
fn schemas_refuse_what_is_missing_added_or_of_another_type() {
    for command in commands() {
        let schema = schema(&command);
        assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema", "{command}");
        assert_eq!(schema["additionalProperties"], false, "{command}");
        let keys: Vec<&String> = schema["properties"].as_object().expect("an object").keys().collect();
        assert_eq!(misfits(&schema, &json!({})).len(), keys.len(), "{command}: every key is required");
    }
    let good = json!({"plant": "oak", "seed": 1, "autumn": false, "potted": false, "triangles": 2, "bytes": 3,
        "output": "x"});
    let misfits_of = |edit: fn(&mut Value)| {
        let mut value = good.clone();
        edit(&mut value);
        misfits(&schema("grow"), &value)
    };
    assert_eq!(misfits_of(|_| {}), [""; 0]);
    for edit in [
        (|v| drop(v.as_object_mut().expect("an object").remove("seed"))) as fn(&mut Value),
        |v| v["more"] = json!(1),
        |v| v["seed"] = json!("1"),
        |v| v["triangles"] = json!(1.5),
        |v| v["bytes"] = json!(-1),
        |v| v["plant"] = json!("fern"),
    ] {
        assert_eq!(misfits_of(edit).len(), 1);
    }
}

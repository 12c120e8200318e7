//! Libraries of species: what is baked, what is said of it, and the exit codes.

use serde_json::json;

use crate::flb::{Folder, names_in};
use crate::schema::{misfits, schema};

/// Two species of a shrub, each baked in a second.
pub(crate) const MANIFEST: &str = "
[bake]
quality = 'draft'
lattice = 16
voxels = 64

[[species]]
mesh = 'shrub.glb'

[[species.variant]]
name = 'dense'
bake = { leaf_angles = 'spherical' }
";

fn farm() -> Folder {
    let folder = Folder::with_plants(&["shrub"]);
    folder.write("library.toml", MANIFEST);
    folder
}

fn edit(folder: &Folder, from: &str, to: &str) {
    let text = String::from_utf8(folder.read("library.toml")).expect("text");
    assert!(text.contains(from), "{text}");
    folder.write("library.toml", text.replace(from, to));
}

#[test]
fn a_library_is_checked_built_asked_and_built_again() {
    let folder = farm();
    let run = folder.flb(&["library", "check"]).expect_code(0);
    assert_eq!(run.stdout, "library.toml: 2 species, 0 that cannot be baked\n");
    let run = folder.flb(&["library", "build", "--dry-run"]);
    let expected = "shrub: to bake: it was never built here\nshrub-dense: to bake: it was never built here\n";
    assert_eq!(run.expect_code(0).stdout, expected);
    folder.flb(&["library", "build"]).expect_code(0).says(&["[1/2] ", "[2/2] "]);
    for name in ["species/shrub.flb", "library.flb", "index.html"] {
        assert!(folder.path("library").join(name).is_file(), "{name}");
    }
    let flags = ["--quality", "draft", "--lattice", "16", "--voxels", "64", "-o", "own.flb"];
    folder.flb_with(&["bake", "shrub.glb"], &flags).expect_code(0);
    assert!(folder.read("library/species/shrub.flb") == folder.read("own.flb"), "as `flb bake` writes it");
    let run = folder.flb(&["library", "build"]).expect_code(0);
    assert!(run.stdout.contains("0 baked, 0 from the cache, 2 as they were"), "{}", run.stdout);

    for words in [&["check"][..], &["build", "--dry-run"], &["build"], &["why", "shrub"]] {
        let run = folder.flb(&[&["library"], words, &["--json"]].concat()).expect_code(0).json();
        assert_eq!(misfits(&schema("library"), &run), [""; 0], "{words:?}: {run}");
        let state = if words == ["check"] { "sound" } else { "current" };
        assert_eq!(
            (&run["species"][0]["name"], &run["species"][0]["state"]),
            (&json!("shrub"), &json!(state))
        );
    }

    // What was written is no input: it is written again.
    edit(&folder, "spherical", "planophile");
    let run = folder.flb(&["library", "why", "shrub-dense"]);
    let why =
        "bake.leaf_angles spherical -> planophile: crown, solve, encode, write; import, voxelise reused";
    assert_eq!(run.expect_code(0).stdout, format!("shrub-dense: to bake: {why}\n"));
    let run = folder.flb(&["library", "why", "shrub-dense", "--json"]).expect_code(0).json();
    assert_eq!(misfits(&schema("library"), &run), [""; 0], "{run}");
    let change = json!([{ "part": "bake.leaf_angles", "was": "spherical", "is": "planophile" }]);
    assert_eq!((&run["species"][0]["state"], &run["species"][0]["changes"]), (&json!("due"), &change));
    let run = folder.flb(&["library", "build", "--memory", "0.001"]).expect_code(0);
    let run = run.says(&[
        "shrub-dense: its bake is expected to take ",
        "more than 1.0 MB (--memory): it is baked alone",
    ]);
    assert!(run.stdout.contains("1 baked, 0 from the cache, 1 as they were"), "{}", run.stdout);
}

#[test]
fn what_cannot_be_built_is_told_with_its_place_and_a_code() {
    let folder = farm();
    folder
        .flb(&["library", "why", "shrubb"])
        .expect_code(2)
        .says(&["no species is named \"shrubb\", did you mean \"shrub\"?"]);
    folder
        .flb(&["library", "build", "--memory", "0"])
        .expect_code(2)
        .says(&["--memory is 0, expected a number above 0"]);
    edit(&folder, "lattice = 16", "latice = 16");
    folder
        .flb(&["library", "build"])
        .expect_code(1)
        .says(&["line 4", "unknown field `latice`, did you mean `lattice`?"]);
    edit(&folder, "latice = 16", "lattice = 17");
    let run = folder.flb(&["library", "check"]);
    run.expect_code(1)
        .says(&["shrub: library.toml: line 7: lattice is 17, expected a power of two, 16 to 256"]);
    edit(&folder, "lattice = 17", "lattice = 16");
    let broken = "\n[[species]]\nname = 'broken'\nmesh = 'broken.obj'\n[[species.variant]]\nname = 'x'\nbake = { lattice = 32 }\n";
    edit(&folder, "[[species]]\nmesh", &format!("{broken}[[species]]\nmesh"));
    folder.write("broken.obj", "v 0 0 0\n");
    let run = folder.flb(&["library", "build", "--keep-going"]);
    let run = run.expect_code(3).says(&[
        "broken: failed: ",
        "no triangle is left",
        "flb library build library.toml --only broken",
    ]);
    assert!(run.stdout.contains("2 baked") && run.stdout.contains("2 failed"), "{}", run.stdout);
    assert!(!folder.path("library").join("library.flb").exists());
    folder.flb(&["library", "build"]).expect_code(1).says(&["broken"]);
    edit(&folder, "mesh = 'shrub.glb'", "mesh = 'shrub.glb'\nbudget = { bytes = 10 }");
    let run = folder.flb(&["library", "build", "--only", "shrub"]);
    run.expect_code(3).says(&["warning: shrub: bytes is ", "over its budget of 10"]);
}

#[test]
fn a_folder_of_meshes_becomes_a_library() {
    let folder = Folder::with_plants(&["shrub"]);
    folder.write("odd.obj", "usemtl stuff\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.write("broken.glb", "no glTF");
    let run = folder.flb(&["library", "init"]).expect_code(3);
    run.says(&["odd: leaf or wood? \"stuff\"", "broken: "]);
    let text = String::from_utf8(folder.read("library.toml")).expect("text");
    for line in
        ["mesh = \"shrub.glb\"", "# plant = { leaf = [\"stuff\"], wood = [] }", "# mesh = \"broken.glb\""]
    {
        assert!(text.contains(line), "{line}: {text}");
    }
    folder.flb(&["library", "init"]).expect_code(4).says(&["library.toml: exists already"]);
    let run = folder.flb(&["library", "init", "-o", "other.toml", "--json"]).expect_code(3).json();
    assert_eq!(misfits(&schema("library"), &run), [""; 0], "{run}");
    assert_eq!(run["species"][1]["undecided"], json!(["stuff"]));
    folder.flb(&["library", "check"]).expect_code(1).says(&["odd: ", "stuff"]);
    edit(&folder, "# plant", "plant");
    folder.flb(&["library", "check"]).expect_code(0).says(&["warning: odd: "]);
}

#[test]
fn engines_read_how_far_a_build_is() {
    let folder = farm();
    let both = ["library", "build", "--json", "--progress", "json"];
    folder.flb(&both).expect_code(2).says(&["--json and --progress both write to stdout"]);
    let run = folder.flb(&["library", "build", "--progress", "json", "--jobs", "1"]).expect_code(0);
    let lines: Vec<&str> = run.stdout.lines().collect();
    let (end, events) = lines.split_last().expect("lines");
    assert!(end.contains("2 baked"), "{end}");
    let events: Vec<serde_json::Value> =
        events.iter().map(|line| serde_json::from_str(line).expect("a line of JSON")).collect();
    let of = |kind: &str| events.iter().filter(|event| event["event"] == kind).collect::<Vec<_>>();
    let [planned] = of("planned")[..] else { panic!("{events:?}") };
    assert!(planned["due"] == 2 && planned["seconds"].as_f64() > Some(0.1), "{planned}");
    let stages: Vec<&str> = of("stage").iter().filter_map(|event| event["stage"].as_str()).collect();
    assert!(stages.starts_with(&["import", "voxelise"]) && stages.ends_with(&["render"]), "{stages:?}");
    let [first, last] = of("ended")[..] else { panic!("{events:?}") };
    assert_eq!(
        (&first["ended"], &first["due"], &first["species"]["state"]),
        (&json!(1), &json!(2), &json!("made"))
    );
    assert!(first["seconds"].as_f64() > Some(0.0) && last["seconds"] == 0.0, "{first} {last}");
    let run = folder.flb(&["library", "build", "--progress", "openjd", "--cache", "other"]).expect_code(0);
    assert!(!run.stdout.contains("openjd"), "nothing is due: {}", run.stdout);
}

#[test]
fn a_cache_is_listed_checked_and_cut() {
    let folder = farm();
    folder.flb(&["library", "build"]).expect_code(0);
    folder.write(".flb-cache/notes.txt", "mine");
    for word in ["list", "stats", "verify"] {
        let run = folder.flb(&["cache", word, "--json"]).expect_code(0).json();
        assert_eq!(misfits(&schema("cache"), &run), [""; 0], "{run}");
        assert_eq!(run["kinds"]["species"]["entries"], 2, "{run}");
    }
    let run = folder.flb(&["cache", "list"]).expect_code(0);
    assert!(run.stdout.contains("0 d  shrub-dense\n"), "{}", run.stdout);
    assert!(folder.flb(&["cache", "stats"]).expect_code(0).stdout.contains("\nspecies "));

    let entries = names_in(&folder.path(".flb-cache"));
    let of = |kind: &str, ending: &str| {
        let is_it = |name: &&String| name.starts_with(kind) && name.ends_with(ending);
        format!(".flb-cache/{}", entries.iter().find(is_it).expect("an entry"))
    };
    for name in [of("crown-", ".artefact"), of("species-", ".flb"), of("parts-", ".artefact")] {
        let mut bytes = folder.read(&name);
        let middle = bytes.len() / 2;
        bytes[middle] ^= 0x80;
        folder.write(&name, &bytes);
    }
    let run = folder.flb(&["cache", "verify", "--json"]).expect_code(1).json();
    assert_eq!(misfits(&schema("cache"), &run), [""; 0], "{run}");
    assert_eq!(run["damaged"].as_array().map(Vec::len), Some(3), "{run}");
    folder
        .flb(&["cache", "verify", "--remove"])
        .expect_code(0)
        .says(&["other bytes than were kept; removed"]);
    assert!(folder.flb(&["cache", "verify"]).expect_code(0).stdout.ends_with(", 0 damaged\n"));
    // Made again, to the same bytes.
    let library = folder.read("library/library.flb");
    std::fs::remove_dir_all(folder.path("library")).expect("it was there");
    folder.flb(&["library", "build"]).expect_code(0);
    assert!(folder.read("library/library.flb") == library);

    folder.flb(&["cache", "gc"]).expect_code(2).says(&["expected --max-size, --older-than or both"]);
    let words = ["cache", "gc", "--max-size", "100k", "--dry-run", "--json"];
    let planned = folder.flb(&words).expect_code(0).json();
    assert_eq!(misfits(&schema("cache"), &planned), [""; 0], "{planned}");
    let run = folder.flb(&["cache", "gc", "--max-size", "100k", "--json"]).expect_code(0).json();
    assert_eq!(run["removed"], planned["removed"]);
    assert!(run["bytes"].as_u64().expect("a count") <= 100_000, "{run}");
    assert_eq!(folder.flb(&["cache", "stats", "--json"]).expect_code(0).json()["bytes"], run["bytes"]);
    folder.flb(&["cache", "gc", "--older-than", "0h"]).expect_code(0);
    assert_eq!(names_in(&folder.path(".flb-cache")), ["digests.json", "notes.txt"]);
    folder.flb(&["library", "build"]).expect_code(0);
    folder.flb(&["cache", "stats", "gone"]).expect_code(4).says(&["gone"]);
}

//! `flb bake-scene`, and `flb render` in the light that it makes.

use serde_json::{Value, json};

use crate::flb::{Folder, PAPER, Run, names_in};
use crate::picture::pixels;
use crate::schema::{misfits, schema};

#[track_caller]
fn fits(command: &str, value: &Value) {
    assert_eq!(misfits(&schema(command), value), [""; 0], "{command}: {value}");
}

/// Flags of the quickest bake of a `physical` species.
const QUICK: [&str; 8] = ["--lattice", "16", "--voxels", "128", "--suns", "lattice18", "--ordinates", "18"];
/// Flags of the quickest bake of a scene.
const COARSE: [&str; 4] = ["--lattice", "16", "--ordinates", "18"];
/// Flags of the quickest picture.
const SMALL: [&str; 4] = ["--size", "48x27", "--samples", "1"];

/// With an oak and a shrub, baked small into `oak.flb` and `shrub.flb`, and `stand.toml` with a few of both.
fn stand() -> Folder {
    let folder = Folder::with_baked(&["oak", "shrub"], &QUICK, &[0, 3]);
    let species = ["--species", "oak=oak.glb,oak.flb*2", "--species", "shrub=shrub.glb,shrub.flb"];
    let words = ["scatter", "--count", "12", "--area", "40,30", "-o", "stand.toml"];
    folder.flb_with(&words, &species).expect_code(0);
    folder
}

fn text(folder: &Folder, name: &str) -> String {
    String::from_utf8(folder.read(name)).expect("TOML is text")
}

fn bake_scene(folder: &Folder, more: &[&str]) -> Run {
    folder.flb_with(&["bake-scene", "stand.toml"], &[&COARSE[..], more].concat())
}

fn render(folder: &Folder, more: &[&str]) -> Run {
    folder.flb_with(&["render", "stand.toml"], &[&SMALL[..], more].concat())
}

#[test]
fn a_scene_is_baked_and_drawn_in_its_light_to_the_same_bytes_by_any_number_of_threads() {
    let folder = stand();
    let run = bake_scene(&folder, &["-o", "stand.flb", "--json"]).expect_code(0).json();
    fits("bake-scene", &run);
    assert_eq!(
        (&run["instances"], &run["lattice"], &run["converged"]),
        (&json!(12), &json!(16), &json!(true))
    );
    let counts: Vec<u64> =
        (0..2).map(|i| run["species"][i]["instances"].as_u64().expect("a count")).collect();
    assert_eq!(counts.iter().sum::<u64>(), 12);
    assert!(run["ground_sites"].as_u64().expect("a count") > 100);
    bake_scene(&folder, &["-o", "one.flb", "--threads", "1"]).expect_code(0);
    assert_eq!(folder.read("stand.flb"), folder.read("one.flb"));

    // It is a library like any other.
    folder.flb(&["validate", "stand.flb"]).expect_code(0);
    folder.flb(&["diff", "stand.flb", "one.flb"]).expect_code(0);
    let info = folder.flb(&["info", "stand.flb", "--json"]).expect_code(0).json();
    let names: Vec<&str> =
        info["species"].as_array().expect("a list").iter().filter_map(|s| s["name"].as_str()).collect();
    assert_eq!(names, ["oak alone", "shrub alone", "scene"]);
    let extract =
        ["extract", "stand.flb", "--species", "scene", "--density", "--format", "png", "-o", "d.png"];
    folder.flb(&extract).expect_code(0);

    let with = ["--scene-light", "stand.flb"];
    let run = render(&folder, &[&with[..], &["--json", "-o", "with.png"]].concat()).expect_code(0).json();
    fits("render", &run);
    render(&folder, &[&with[..], &["--threads", "1", "-o", "with-one.png"]].concat()).expect_code(0);
    assert_eq!(folder.read("with.png"), folder.read("with-one.png"));
    render(&folder, &["-o", "without.png"]).expect_code(0);
    assert_ne!(folder.read("with.png"), folder.read("without.png"));
    // The scene may name it.
    folder.write("stand.toml", format!("light = \"stand.flb\"\n{}", text(&folder, "stand.toml")));
    render(&folder, &["-o", "named.png"]).expect_code(0);
    assert_eq!(folder.read("with.png"), folder.read("named.png"));
    // By night there is no sun to shade.
    render(&folder, &["--sun", "0,-10", "-o", "night.png"]).expect_code(0);
}

/// Largest change of a pixel of baked light, of 255, between frames half a degree apart, as without neighbours.
const MAX_CHANGE: u8 = 6;

#[test]
fn light_among_neighbours_changes_little_while_the_sun_moves_half_a_degree() {
    let folder = stand();
    bake_scene(&folder, &["--suns", "sh1", "-o", "stand.flb"]).expect_code(0);
    // In the morning, when shadows are long.
    let suns = ["--sun", "90,4", "--sun", "107,16", "--frames", "41", "--samples", "8", "--show", "indirect"];
    let words = ["render", "stand.toml", "--size", "48x27", "--scene-light", "stand.flb", "-o", "f.png"];
    folder.flb_with(&words, &suns).expect_code(0);
    let frames: Vec<Vec<u8>> =
        (1..=41).map(|frame| pixels(&folder.read(&format!("f-{frame:04}.png")))).collect();
    let largest = |a: &[u8], b: &[u8]| a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().expect("pixels");
    let change = frames.windows(2).map(|pair| largest(&pair[0], &pair[1])).max().expect("frames");
    assert!(change <= MAX_CHANGE, "{change}");
    assert!(largest(&frames[0], &frames[40]) > MAX_CHANGE, "nothing was compared");
}

/// Moves the first plant.
fn move_one(folder: &Folder) {
    let scene = text(folder, "stand.toml");
    let (before, after) = scene.split_once("[[instance]]").expect("an instance");
    let first = after.find("position_m = [").expect("a position") + "position_m = [".len();
    let end = first + after[first..].find(',').expect("a coordinate");
    let x: f64 = after[first..end].parse().expect("a number");
    let moved = format!("{before}[[instance]]{}{:.3}{}", &after[..first], x + 0.75, &after[end..]);
    folder.write("stand.toml", moved);
}

#[test]
fn moving_a_plant_solves_nothing_but_the_scene_again_and_old_light_is_refused() {
    let folder = stand();
    let bake = |output: &str| {
        let run = bake_scene(&folder, &["--cache", "cache", "-o", output, "--json"]).expect_code(0);
        assert!(!run.stderr.contains("made again"), "{}", run.stderr);
        let run = run.json();
        let solves = run["stages"].as_array().expect("a list").iter().find(|stage| stage["name"] == "solve");
        let solves = solves.expect("a stage")["solves"].as_array().expect("a list").clone();
        let of =
            |solve: &Value| (solve["species"].as_str().expect("a name").to_owned(), solve["cached"] == true);
        solves.iter().map(of).collect::<Vec<_>>()
    };
    let said = |cached: [bool; 3]| {
        ["oak alone", "shrub alone", "scene"].map(str::to_owned).into_iter().zip(cached).collect::<Vec<_>>()
    };
    assert_eq!(bake("first.flb"), said([false; 3]));
    assert_eq!(bake("again.flb"), said([true; 3]));
    assert_eq!(folder.read("first.flb"), folder.read("again.flb"));
    move_one(&folder);
    let with = ["--scene-light", "first.flb", "-o", "old.png"];
    let says = ["first.flb", "other plants or another ground", "bake it again"];
    render(&folder, &with).expect_code(2).says(&says);
    assert_eq!(bake("moved.flb"), said([true, true, false]));
    // Nor are the plants by themselves measured again: the cache has both, and takes no third.
    let names = names_in(&folder.path("cache"));
    assert_eq!(names.iter().filter(|name| name.starts_with("alone-")).count(), 2);
    assert_ne!(folder.read("first.flb"), folder.read("moved.flb"));
    render(&folder, &["--scene-light", "moved.flb", "-o", "moved.png"]).expect_code(0);
}

#[test]
fn light_of_another_plant_by_the_same_name_is_refused() {
    let folder = stand();
    bake_scene(&folder, &["-o", "stand.flb"]).expect_code(0);
    let with = ["--scene-light", "stand.flb", "-o", "stand.png", "--force"];
    // The same plants in another file are the same.
    folder.flb(&["pack", "shrub.flb", "oak.flb", "-o", "plants.flb", "--compress"]).expect_code(0);
    let scene = text(&folder, "stand.toml");
    folder.write("stand.toml", scene.replace("oak.flb", "plants.flb").replace("shrub.flb", "plants.flb"));
    render(&folder, &with).expect_code(0);
    folder.write("stand.toml", scene);
    let says = ["stand.flb", "made of another light of species \"oak\"", "oak.flb", "make it again"];
    // One of the other model does not fit its neighbours either.
    let of_models = ["oak.flb", "is of the model paper", "shrub.flb", "expected one model"];
    for (flags, says) in [(&QUICK[4..], &says), (&PAPER[..], &of_models)] {
        let coarser = ["bake", "oak.glb", "-o", "oak.flb", "--force", "--voxels", "64"];
        folder.flb_with(&coarser, &[&QUICK[..2], flags].concat());
        render(&folder, &with).expect_code(2).says(says);
        folder
            .flb(&["view", "stand.toml", "--scene-light", "stand.flb", "--screenshot", "v.png"])
            .expect_code(2)
            .says(says);
    }
}

#[test]
fn what_cannot_be_baked_is_refused_by_name() {
    let folder = stand();
    let refused = |more: &[&str], code: i32, says: &[&str]| {
        bake_scene(&folder, &[&["-o", "x.flb"], more].concat()).expect_code(code).says(says);
        assert!(!folder.path("x.flb").exists());
    };
    let scene = |words: &[&str], code: i32, says: &[&str]| {
        let output: &[&str] = if words.contains(&"-o") { &[] } else { &["-o", "x.flb"] };
        folder.flb_with(&["bake-scene"], &[words, output].concat()).expect_code(code).says(says);
    };
    scene(&["stand.toml", "--lattice", "48"], 2, &["--lattice is 48", "a power of two, 16 to 256"]);
    scene(&["stand.toml", "--ordinates", "17"], 2, &["--ordinates is 17", "18, 50 or 110"]);
    scene(&["stand.toml", "--tolerance", "2"], 2, &["--tolerance is 2", "between 0 and 1"]);
    scene(&["stand.toml", "--max-sweeps", "0"], 2, &["--max-sweeps is 0", "1 or more"]);
    scene(&["stand.toml", "-o", "oak.flb", "--force"], 2, &["oak.flb"]);
    refused(&["--memory-limit", "0.0001"], 6, &["stand.toml", "of memory needed", "--memory-limit"]);
    let good = text(&folder, "stand.toml");
    let written = |name: &str, text: String| {
        folder.write(name, text);
    };
    written("bare.toml", good.replace("light = \"oak.flb\"\n", ""));
    scene(&["bare.toml"], 2, &["bare.toml", "\"oak\" has no light"]);
    written("gone.toml", good.replace("oak.flb", "gone.flb"));
    scene(&["gone.toml"], 4, &["gone.flb"]);
    written(
        "other.toml",
        good.replace("light = \"oak.flb\"\n", "light = \"oak.flb\"\nlight_species = \"ash\"\n"),
    );
    scene(&["other.toml"], 2, &["oak.flb", "\"ash\""]);
    written("empty.toml", "[[species]]\nname = \"oak\"\nlight = \"oak.flb\"\nupright = true\n".to_owned());
    scene(&["empty.toml"], 2, &["empty.toml", "no instances"]);

    let bake = ["bake", "oak.glb", "--lattice", "16", "--voxels", "128"];
    folder.flb_with(&bake, &[&PAPER[..], &["-o", "paper.flb"]].concat());
    written("paper.toml", good.replace("oak.flb", "paper.flb"));
    let says = ["paper.toml", "\"oak\" is of the model paper", "\"shrub\" of physical", "one --model"];
    scene(&["paper.toml"], 2, &says);
    let shrub = ["bake", "shrub.glb", "--lattice", "16", "--voxels", "128"];
    folder.flb_with(&shrub, &[&PAPER[..], &["-o", "paper-shrub.flb"]].concat());
    let both = good.replace("oak.flb", "paper.flb").replace("shrub.flb", "paper-shrub.flb");
    written("papers.toml", both);
    for flag in ["--suns=sh1", "--ordinates=18"] {
        let says = ["papers.toml", flag.split('=').next().expect("a flag"), "of the model physical"];
        scene(&["papers.toml", flag], 2, &says);
    }
    let total = ["bake", "oak.glb", "-o", "total.flb", "--field", "total"];
    folder.flb_with(&total, &QUICK);
    written("mixed.toml", good.replace("oak.flb", "total.flb"));
    scene(&["mixed.toml"], 2, &["\"oak\" is total", "\"shrub\" scattered", "one --field"]);
    // Light of something else.
    let with = ["--scene-light", "oak.flb", "-o", "x.png"];
    render(&folder, &with).expect_code(2).says(&["oak.flb", "an ordinary one", "flb bake-scene"]);
    let plant = [
        "render",
        "oak.flb",
        "--mesh",
        "oak.glb",
        "--sun",
        "90,20",
        "--scene-light",
        "oak.flb",
        "-o",
        "x.png",
    ];
    folder.flb(&plant).expect_code(2).says(&["--scene-light is for scenes"]);
}

#[test]
fn plants_of_the_papers_model_are_scaled_by_either_factor_and_their_ground_is_left_out() {
    let folder = stand();
    for plant in ["oak", "shrub"] {
        let (mesh, light) = (format!("{plant}.glb"), format!("{plant}.flb"));
        let words = ["bake", &mesh, "-o", &light, "--force", "--lattice", "16", "--voxels", "128"];
        folder.flb_with(&words, &PAPER).expect_code(0);
    }
    let bake = |output: &str, more: &[&str]| {
        let words = ["bake-scene", "stand.toml", "--lattice", "16", "--json", "-o", output];
        folder.flb_with(&words, more).expect_code(0)
    };
    let run = bake("stand.flb", &["--cache", "cache"]).says(&["stand.toml", "the ground is left out"]).json();
    fits("bake-scene", &run);
    assert_eq!((&run["ground_left_out"], &run["suns_rms"]), (&json!(true), &Value::Null));
    assert_eq!((&run["ground_sites"], &run["converged"]), (&json!(0), &json!(true)));
    for sites in [&run["sites_nonempty"], &run["species"][0]["sites_nonempty"]] {
        assert!(sites.as_u64().is_some_and(|sites| sites > 10), "{sites}");
    }
    bake("one.flb", &["--threads", "1"]);
    assert_eq!(folder.read("stand.flb"), folder.read("one.flb"));
    folder.flb(&["validate", "stand.flb"]).expect_code(0);
    let light = ["--scene-light", "stand.flb"];
    let draw = |name: &str, more: &[&str]| {
        let indirect = ["--show", "indirect", "--sun", "90,20", "-o", name];
        render(&folder, &[&indirect[..], more].concat()).expect_code(0);
        pixels(&folder.read(name)).iter().map(|byte| f64::from(*byte)).sum::<f64>()
    };
    let without = draw("without.png", &[]);
    let alone = draw("alone.png", &light);
    assert_eq!(alone, draw("said.png", &[&light[..], &["--scene-factor", "alone"]].concat()));
    let empty = draw("empty.png", &[&light[..], &["--scene-factor", "empty"]].concat());
    assert!(alone < without && empty < without && empty != alone, "{without} {alone} {empty}");
    // Of either factor by itself: a share is white where nothing is left out, and no colour.
    for factor in ["alone", "empty"] {
        let name = format!("global-{factor}.png");
        let words = ["--show", "global", "--scene-factor", factor, "--sun", "90,20", "-o", &name];
        render(&folder, &[&light[..], &words].concat()).expect_code(0);
        let grey = pixels(&folder.read(&name));
        assert!(grey.chunks_exact(3).all(|rgb| rgb[0] == rgb[1] && rgb[1] == rgb[2]), "{factor}");
        assert!(grey.iter().any(|value| *value > 60) && grey.iter().any(|value| *value < 60), "{factor}");
    }
    assert_ne!(folder.read("global-alone.png"), folder.read("global-empty.png"));
    let global = ["--show", "global", "-o", "x.png"];
    render(&folder, &global).expect_code(2).says(&["stand.toml", "no scene light", "flb bake-scene"]);
    let on_gpu = [&light[..], &global, &["--backend", "gpu"]].concat();
    render(&folder, &on_gpu).expect_code(2).says(&["on the CPU alone"]);
    let says = ["stand.toml", "--scene-factor needs scene light"];
    render(&folder, &["--scene-factor", "empty", "-o", "x.png"]).expect_code(2).says(&says);
    // One plant moves, and the scene alone is solved again.
    move_one(&folder);
    let run = bake("moved.flb", &["--cache", "cache"]).json();
    let cached: Vec<bool> = (0..2).map(|species| run["species"][species]["cached"] == true).collect();
    assert_eq!(cached, [true, true]);
    assert_ne!(folder.read("stand.flb"), folder.read("moved.flb"));
    render(&folder, &[&light[..], &["-o", "x.png"]].concat()).expect_code(2).says(&["other plants"]);
    render(&folder, &["--scene-light", "moved.flb", "-o", "moved.png"]).expect_code(0);
    // Of the other model, the beam of lists of suns is not known.
    let folder = self::stand();
    bake_scene(&folder, &["--suns", "lattice18", "-o", "stand.flb"]).expect_code(0);
    let says = ["stand.flb", "lack the sun's own beam", "--suns sh1"];
    let empty = ["--scene-light", "stand.flb", "--scene-factor", "empty", "-o", "y.png"];
    render(&folder, &empty).expect_code(2).says(&says);
    bake_scene(&folder, &["--suns", "sh1", "-o", "stand.flb", "--force"]).expect_code(0);
    render(&folder, &empty).expect_code(0);
    assert_ne!(folder.read("y.png"), Vec::<u8>::new());
}

#[test]
fn sites_that_are_larger_than_crowns_are_told() {
    let folder = stand();
    let scene = text(&folder, "stand.toml");
    let first = scene.find("position_m = [").expect("a position") + "position_m = [".len();
    let end = first + scene[first..].find(',').expect("a coordinate");
    // One plant far away stretches the lattice.
    folder.write("stand.toml", format!("{}900{}", &scene[..first], &scene[end..]));
    let says = ["warning", "a site of the scene's lattice is", "times as wide as the crown", "--lattice 16"];
    bake_scene(&folder, &["-o", "wide.flb"]).expect_code(0).says(&says);
}

#[test]
fn a_scene_whose_light_does_not_converge_ends_with_loss() {
    let folder = stand();
    let run = bake_scene(&folder, &["--tolerance", "1e-7", "--max-sweeps", "1", "-o", "loss.flb", "--json"]);
    let run = run.expect_code(3).says(&["did not converge"]);
    assert_eq!(run.json()["converged"], false);
}

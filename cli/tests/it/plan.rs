//! `flb plan`, and bakes, packs and renderings that keep to a plan.

use serde_json::{Value, json};

use crate::flb::{Folder, PAPER, Run};
use crate::schema::{misfits, schema};

/// Flags of the quickest bake of a leaf card.
const QUICK: [&str; 6] = ["--lattice", "16", "--voxels", "64", "--model", "paper"];
/// What upright plants under a sun above the horizon never need.
const UPWARDS: [u8; 5] = [3, 7, 10, 15, 17];

#[track_caller]
fn fits(command: &str, value: &Value) {
    assert_eq!(misfits(&schema(command), value), [""; 0], "{command}: {value}");
}

/// With a leaf card, and a plan for upright plants.
fn folder() -> Folder {
    let folder = Folder::with_plants(&["leaf-card"]);
    folder.flb(&["plan", "--upright", "-o", "upright.toml"]).expect_code(0);
    folder
}

#[track_caller]
fn section(run: &Run, file_key: &str) -> Value {
    run.json()["species"][0][file_key].clone()
}

#[test]
fn a_plan_for_upright_plants_bakes_14_bases_and_its_file_says_what_is_left_out_and_why() {
    let folder = folder();
    let plan = String::from_utf8(folder.read("upright.toml")).expect("TOML is text");
    assert_eq!(
        plan,
        "schema = 1\n\
         reason = \"every sun above the horizon, plants that turn only about the vertical\"\n\
         bases = [0, 1, 2, 4, 5, 6, 8, 9, 11, 12, 13, 14, 16, 18]\n"
    );
    let bake = ["bake", "leaf-card.glb", "-o", "part.flb", "--plan", "upright.toml", "--json"];
    let baked = folder.flb_with(&bake, &QUICK).expect_code(0);
    fits("bake", &baked.json());
    let saving = section(&baked, "plan");
    assert_eq!((&saving["bases_left_out"], &saving["solves_left_out"]), (&json!(UPWARDS), &json!(12)));
    assert_eq!(saving["memory_bytes_left_out"], 5 * 3 * 16 * 16 * 16 * 4);
    assert!(saving["file_bytes_left_out"].as_u64() > Some(0));

    let info = folder.flb(&["info", "part.flb", "--json"]).expect_code(0);
    fits("info", &info.json());
    assert_eq!(section(&info, "bases"), json!([0, 1, 2, 4, 5, 6, 8, 9, 11, 12, 13, 14, 16, 18]));
    assert_eq!(section(&info, "left_out")["bases"], json!(UPWARDS));
    let info = folder.flb(&["info", "part.flb"]).expect_code(0);
    assert!(info.stdout.contains("left out   3 7 10 15 17: every sun above the horizon"), "{}", info.stdout);
    folder.flb(&["validate", "part.flb"]).expect_code(0);

    // Without --json the saving is printed, and another thread count gives the same bytes.
    let bake = ["bake", "leaf-card.glb", "-o", "again.flb", "--plan", "upright.toml", "--threads", "1"];
    let run = folder.flb_with(&bake, &QUICK).expect_code(0);
    assert!(
        run.stdout.contains("leaf-card: left out bases 3 7 10 15 17: 12 solves, about "),
        "{}",
        run.stdout
    );
    assert_eq!(folder.read("again.flb"), folder.read("part.flb"));
}

#[test]
fn a_sun_that_needs_a_base_left_out_is_refused_and_every_other_renders() {
    let folder = folder();
    folder
        .flb_with(&["bake", "leaf-card.glb", "-o", "part.flb", "--plan", "upright.toml"], &QUICK)
        .expect_code(0);
    let render = ["render", "part.flb", "--mesh", "leaf-card.glb", "--size", "8x8", "--samples", "1"];
    for sun in ["0,0", "45,0", "33,1", "90,45", "123,60", "17,90"] {
        folder.flb_with(&render, &["--sun", sun, "-o", "x.png", "--force"]).expect_code(0);
    }
    folder.flb_with(&render, &["--sun", "90,-20", "-o", "below.png"]).expect_code(2).says(&[
        "part.flb: species \"leaf-card\" has no base 10, which the light needs: it was left out (every sun above",
    ]);
    assert!(!folder.path("below.png").exists());
    folder
        .flb(&["extract", "part.flb", "--base", "3", "--format", "npy", "-o", "b.npy"])
        .expect_code(2)
        .says(&["species \"leaf-card\" has no base 3 (left out: every sun above the horizon, "]);
}

#[test]
fn a_bake_by_plan_holds_the_light_of_a_full_bake() {
    let folder = folder();
    folder
        .flb_with(
            &["bake", "leaf-card.glb", "-o", "all.flb", "--quality", "reference", "--codec", "raw-f32"],
            &QUICK,
        )
        .expect_code(0);
    let bake =
        ["bake", "leaf-card.glb", "-o", "part.flb", "--plan", "upright.toml", "--quality", "reference"];
    folder.flb_with(&bake, &[&QUICK[..], &["--codec", "raw-f32"]].concat()).expect_code(0);
    let diff =
        folder.flb(&["diff", "all.flb", "part.flb", "--tolerance", "1e-3", "--json"]).expect_code(1).json();
    let species = &diff["species"][0];
    assert_eq!((&species["bases_only_in_a"], &species["bases_only_in_b"]), (&json!(UPWARDS), &json!([])));
    let bases = species["bases"].as_array().expect("a list");
    assert!(bases.len() == 14 && bases.iter().all(|base| base["equal"] == true), "{bases:?}");
}

#[test]
fn pack_drops_the_bases_that_a_plan_leaves_out_coded_again_or_copied() {
    let folder = folder();
    // Not `classed`, whose classes depend on which bases are coded.
    let bake =
        ["bake", "leaf-card.glb", "-o", "all.flb", "--keep-fields", "fields.flb", "--codec", "haar-paper"];
    folder.flb_with(&bake, &QUICK).expect_code(0);
    folder.flb_with(&["bake", "leaf-card.glb", "-o", "b.flb", "--name", "b"], &QUICK).expect_code(0);
    let pack =
        ["pack", "fields.flb", "-o", "part.flb", "--plan", "upright.toml", "--codec", "haar-paper", "--json"];
    let packed = folder.flb(&pack).expect_code(0);
    fits("pack", &packed.json());
    let saving = section(&packed, "plan");
    assert_eq!((&saving["bases_left_out"], &saving["solves_left_out"]), (&json!(UPWARDS), &json!(0)));
    assert!(saving["file_bytes_left_out"].as_u64() > Some(5 * 3 * 16 * 16 * 16 * 4 - 1));
    let merge = ["pack", "all.flb", "b.flb", "-o", "merged.flb", "--plan", "upright.toml"];
    let run = folder.flb(&merge).expect_code(0);
    assert!(run.stdout.contains("b: left out bases 3 7 10 15 17: 0 solves"), "{}", run.stdout);
    folder.flb(&["validate", "part.flb", "merged.flb"]).expect_code(0);
    let diff = folder.flb(&["diff", "part.flb", "merged.flb", "--tolerance", "0", "--json"]).json();
    let species = &diff["species"][0];
    assert!(species["equal"] == true, "coding kept bases and copying coded ones agree: {species}");

    // What is left out already stays left out, and what a plan needs must be there.
    folder.flb(&["plan", "--upright", "--no-ambient", "-o", "dark.json"]).expect_code(0);
    let run =
        folder.flb(&["pack", "part.flb", "-o", "dark.flb", "--plan", "dark.json", "--json"]).expect_code(0);
    assert_eq!(section(&run, "plan")["bases_left_out"], json!([0, 3, 7, 10, 15, 17]));
    folder
        .flb(&["pack", "dark.flb", "-o", "x.flb", "--plan", "upright.toml"])
        .expect_code(2)
        .says(&["dark.flb: species \"leaf-card\" lacks bases {0}, which the plan needs: bake it again"]);
}

const SCENE: &str = r#"
bands = ["B", "R"]
[camera]
position_m = [0.0, 0.2, 2.0]
fov_deg = 40.0
height_px = 200
[[species]]
name = "leaf-card"
file = "leaf-card.glb"
[[instance]]
species = "leaf-card"
position_m = [0.0, 0.0, -100.0]
yaw_deg = 20.0
"#;

#[test]
fn a_scene_gives_lattice_and_bands_which_the_bake_follows() {
    let folder = Folder::with_plants(&["leaf-card"]);
    folder.write("scene.toml", format!("{SCENE}[sun]\nfixed = [[123.0, 31.0]]\n"));
    let planned = folder.flb(&["plan", "scene.toml", "-o", "plan.json", "--json"]).expect_code(0);
    fits("plan", &planned.json());
    assert_eq!(section(&planned, "bases").as_array().map(Vec::len), Some(4));
    assert_eq!((section(&planned, "lattice"), section(&planned, "instances")), (json!(16), json!(1)));
    planned.says(&["leaf-card: 1 sites along each edge would suit its 0."]);
    let bake = ["bake", "leaf-card.glb", "-o", "part.flb", "--voxels", "64", "--plan", "plan.json", "--json"];
    let baked = folder.flb_with(&bake, &PAPER).expect_code(0).json();
    let species = &baked["species"][0];
    assert_eq!((&species["lattice"], &species["plan"]["bands_left_out"]), (&json!(16), &json!(["G"])));
    assert_eq!(species["plan"]["solves_left_out"], 3 * 18 - 2 * 4);
    let info = folder.flb(&["info", "part.flb", "--json"]).expect_code(0);
    assert_eq!(section(&info, "bands"), json!(["R", "B"]), "the optics' order stays");
    assert_eq!(section(&info, "left_out")["bands"], json!(["G"]));
    let render = ["render", "part.flb", "--mesh", "leaf-card.glb", "--sun", "123,31", "-o", "x.png"];
    folder.flb(&render).expect_code(2).says(&[
        "part.flb: species \"leaf-card\" has the bands R, B; a picture needs R, G and B; left out: G (the sun at 123,31, ",
        "; --show-bands R shows those as grey",
    ]);

    folder.flb(&[&bake[..4], &["--force", "--plan", "plan.json", "--lattice", "32"]].concat()).expect_code(2).says(
        &["plan.json: the plan bakes species \"leaf-card\" at lattice 16; --lattice 32 cannot be given with it"],
    );
    // Turning freely, the plant needs more; the far side of the world, all year, even so no light from below.
    let words = ["plan", "scene.toml", "--upright", "--sun-path", "-33.9,151.2,2026-01-01..2026-12-31"];
    let words = [&words[..], &["-o", "year.toml", "--json"]].concat();
    let year = folder.flb(&words).expect_code(0).says(&["--sun-path takes the place of the suns"]);
    assert_eq!(section(&year, "left_out"), json!(UPWARDS));
}

#[test]
fn a_polar_night_leaves_the_sky_and_says_so_or_nothing_and_fails() {
    let folder = Folder::new();
    let words = ["plan", "--sun-path", "78.2,15.6,2026-12-01..2026-12-31", "-o", "night.toml"];
    let run = folder.flb_with(&words, &["--json"]).expect_code(0);
    assert_eq!((&run.json()["has_sun"], &run.json()["every_species"]["bases"]), (&json!(false), &json!([0])));
    fits("plan", &run.json());
    run.says(&["no sun of the scene is ever above the horizon"]);
    let words = [&words[..4], &["none.toml", "--no-ambient"]].concat();
    folder.flb(&words).expect_code(2).says(&["the plan needs no base at all (no sun rises at latitude 78.2"]);
    assert_eq!(folder.names(), ["night.toml"]);
}

#[test]
fn a_url_in_a_scene_is_refused_wherever_the_scene_lies() {
    let folder = Folder::new();
    let species = "[[species]]\nname = \"s\"\nupright = true\n";
    for entry in [
        format!("light = \"http://127.0.0.1:1/x.flb\"\n{species}"),
        format!("{species}file = \"http://127.0.0.1:1/x.glb\"\n"),
    ] {
        folder.write("u.toml", entry);
        let absolute = folder.path("u.toml");
        for scene in ["u.toml", "./u.toml", absolute.to_str().expect("a plain name")] {
            let run = folder.flb(&["plan", scene, "-o", "p.toml"]).expect_code(2);
            run.says(&["u.toml", "found a URL, expected a file of this machine"]);
        }
    }
}

#[test]
fn what_is_wrong_with_a_plan_is_found_before_the_work() {
    let folder = folder();
    let scene = SCENE.replace("leaf-card.glb", "none.glb");
    folder.write("scene.toml", SCENE).write("nofile.toml", scene).write("wrong.toml", "schema = 2\n");
    folder
        .write("unknown.toml", SCENE.replace("yaw_deg", "yaw"))
        .write("bands.toml", "schema = 1\nreason = \"r\"\nbases = [0]\nbands = [\"NIR\"]\n");
    folder.write("tilted.toml", SCENE.replace("yaw_deg = 20.0", "rotation = [0.6, 0, 0, 0.8]"));
    folder.write("oak.toml", "schema = 1\nreason = \"r\"\n[[species]]\nname = \"oak\"\nbases = [0]\n");
    let before = folder.names();
    let bake = |plan| ["bake", "leaf-card.glb", "-o", "x.flb", "--plan", plan];
    for (code, words, says) in [
        (2, &["plan", "-o", "x.toml"][..], "SCENE.toml"),
        (2, &["plan", "--upright", "-o", "x.flb"], "x.flb: found .flb, expected .toml or .json"),
        (2, &["plan", "--sun-path", "52.5,13.4", "-o", "x.toml"], "expected LAT,LON,DATE..DATE"),
        (
            2,
            &["plan", "tilted.toml", "--upright", "-o", "x.toml"],
            "instance 1 of the scene, of species \"leaf-card\", is tilted",
        ),
        (4, &["plan", "none.toml", "-o", "x.toml"], "none.toml"),
        (4, &["plan", "nofile.toml", "-o", "x.toml"], "none.glb"),
        (4, &["plan", "--upright", "-o", "upright.toml"], "upright.toml: exists already"),
        (1, &["plan", "unknown.toml", "-o", "x.toml"], "unknown field `yaw`"),
        (2, &["plan", "scene.toml", "-o", "scene.toml", "--force"], "scene.toml"),
        (1, &bake("wrong.toml"), "missing field `reason`"),
        (4, &bake("none.toml"), "none.toml"),
        (2, &bake("oak.toml"), "oak.toml: species \"leaf-card\" is not in the plan, which has: oak"),
        (
            2,
            &bake("bands.toml"),
            "the plan asks for band \"NIR\", which species \"leaf-card\" does not have; it has: R, G, B",
        ),
    ] {
        let run = folder.flb(words);
        assert_eq!(run.code, code, "{words:?}: {}", run.stderr);
        assert!(run.stdout.is_empty(), "{words:?}: {}", run.stdout);
        run.says(&[says]);
    }
    let two = ["bake", "leaf-card.glb", "./b.glb", "-o", "x.flb", "--plan", "oak.toml"];
    folder.flb(&two).expect_code(2).says(&["species \"leaf-card\" is not in the plan", "nor is \"b\""]);
    assert_eq!(folder.names(), before);
}

#[test]
fn a_cache_tells_plans_apart() {
    let folder = folder();
    let bake = |out: &str, more: &[&str]| {
        let words = ["bake", "leaf-card.glb", "--cache", "cache", "-o", out];
        folder.flb_with(&[&words[..], more].concat(), &QUICK).expect_code(0);
        folder.read(out)
    };
    let (all, part) = (bake("all.flb", &[]), bake("part.flb", &["--plan", "upright.toml"]));
    assert_eq!(bake("all2.flb", &[]), all);
    assert_eq!(bake("part2.flb", &["--plan", "upright.toml"]), part);
    std::fs::remove_dir_all(folder.path("cache")).expect("the cache is a folder");
    assert_eq!(bake("part3.flb", &["--plan", "upright.toml"]), part);
}

/// The quickest bake with the physical model.
const PHYSICAL: [&str; 6] = ["--lattice", "16", "--voxels", "64", "--ordinates", "50"];

#[test]
fn a_physical_bake_of_lattice_directions_keeps_to_a_plan() {
    let folder = folder();
    let bake = |out: &str, more: &[&str]| {
        let words = ["bake", "leaf-card.glb", "-o", out, "--suns", "lattice18", "--json"];
        folder.flb(&[&words[..], &PHYSICAL, &["--threshold", "0"], more].concat()).expect_code(0)
    };
    bake("all.flb", &[]);
    let baked = bake("part.flb", &["--plan", "upright.toml"]);
    fits("bake", &baked.json());
    let saving = section(&baked, "plan");
    assert_eq!((&saving["bases_left_out"], &saving["solves_left_out"]), (&json!(UPWARDS), &json!(3 * 5)));
    assert_eq!(saving["memory_bytes_left_out"], 5 * 3 * 16 * 16 * 16 * 4);
    let solve = &baked.json()["stages"][4]["solves"][0];
    assert_eq!((&solve["solver"], &solve["solves"]), (&json!("ordinates"), &json!(3 * 14)));
    let info = folder.flb(&["info", "part.flb", "--json"]).expect_code(0);
    assert_eq!(section(&info, "left_out")["bases"], json!(UPWARDS));
    folder.flb(&["validate", "part.flb"]).expect_code(0);

    let diff = folder.flb(&["diff", "all.flb", "part.flb", "--tolerance", "5e-3", "--json"]).expect_code(1);
    let bases = diff.json()["species"][0]["bases"].clone();
    let bases = bases.as_array().expect("a list");
    assert!(bases.len() == 14 && bases.iter().all(|base| base["equal"] == true), "{bases:?}");
    let render = ["render", "part.flb", "--mesh", "leaf-card.glb", "--size", "8x8", "--samples", "1"];
    folder.flb_with(&render, &["--sun", "90,45", "-o", "x.png"]).expect_code(0);
    let below = ["--sun", "90,-20", "-o", "below.png"];
    folder
        .flb_with(&render, &below)
        .expect_code(2)
        .says(&["has no base 10", "it was left out (every sun above"]);

    // No ambient light is the sky's field less; of 3 suns to be judged by, one comes from below and is left out.
    folder.flb(&["plan", "--upright", "--no-ambient", "-o", "dark.toml"]).expect_code(0);
    let dark = bake("dark.flb", &["--plan", "dark.toml", "--monte-carlo", "22"]);
    assert_eq!(section(&dark, "plan")["solves_left_out"], 3 * 6);
    let info = folder.flb(&["info", "dark.flb", "--json"]).expect_code(0);
    let suns = section(&info, "light")["error"]["monte_carlo"]["suns"].as_u64().expect("it was judged");
    assert!((3..22).contains(&suns), "{suns}");
    dark.says(&[&format!("{} of 22 suns are not traced", 22 - suns)]);
}

#[test]
fn harmonics_keep_to_lattice_and_bands_of_a_plan_and_say_that_no_base_can_go() {
    let folder = folder();
    folder.write("scene.toml", format!("{SCENE}[sun]\nfixed = [[123.0, 31.0]]\n"));
    folder.flb(&["plan", "scene.toml", "-o", "plan.json"]).expect_code(0);
    let bake = ["bake", "leaf-card.glb", "-o", "part.flb", "--voxels", "64", "--plan", "plan.json", "--json"];
    let baked = folder.flb_with(&bake, &["--keep-fields", "fields.flb"]).expect_code(0);
    let species = baked.json()["species"][0].clone();
    assert_eq!((&species["lattice"], species["bases"].as_array().map(Vec::len)), (&json!(16), Some(13)));
    let saving = &species["plan"];
    assert_eq!((&saving["bases_left_out"], &saving["bands_left_out"]), (&json!([]), &json!(["G"])));
    // 50 suns, 5 held out and the sky, in one band.
    assert_eq!(saving["solves_left_out"], 56);
    assert_eq!(saving["memory_bytes_left_out"], 13 * 16 * 16 * 16 * 4);
    baked.says(&["leaf-card: every sun needs all fields of harmonics, so all are baked"]);
    let info = folder.flb(&["info", "part.flb", "--json"]).expect_code(0);
    assert_eq!(section(&info, "bands"), json!(["R", "B"]));
    assert_eq!(section(&info, "left_out")["bands"], json!(["G"]));
    assert_eq!(section(&info, "left_out")["bases"], json!([]));
    folder.flb(&["validate", "part.flb"]).expect_code(0);

    let pack = ["pack", "fields.flb", "-o", "packed.flb", "--plan", "upright.toml", "--json"];
    let packed = folder.flb(&pack).expect_code(0).says(&["every sun needs all fields of harmonics"]);
    assert_eq!(section(&packed, "bases").as_array().map(Vec::len), Some(13));
}

#[test]
fn a_list_of_directions_stays_whole_and_says_so() {
    let folder = folder();
    let bake =
        ["bake", "leaf-card.glb", "-o", "list.flb", "--suns", "ico12", "--plan", "upright.toml", "--json"];
    let words = "leaf-card: a list of directions is stored whole, so all are baked; with --suns lattice18";
    let baked = folder.flb(&[&bake[..], &PHYSICAL].concat()).expect_code(0).says(&[words]);
    let saving = section(&baked, "plan");
    assert_eq!((&saving["bases_left_out"], &saving["solves_left_out"]), (&json!([]), &json!(0)));
    let pack = ["pack", "list.flb", "-o", "packed.flb", "--plan", "upright.toml", "--json"];
    let packed = folder.flb(&pack).expect_code(0).says(&["a list of directions is stored whole"]);
    assert_eq!(section(&packed, "bases").as_array().map(Vec::len), Some(13));
}

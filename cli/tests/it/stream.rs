//! `flb stream`: replays over links that are only reckoned.

use serde_json::{Value, json};

use crate::flb::{Folder, PAPER};
use crate::schema::{misfits, schema};

/// Two shrubs that the camera flies by, while the sun crosses the sky.
const SCENE: &str = "
[sky]
ambient = 0.1

[sun]
fixed = [[90.0, 20.0], [180.0, 60.0], [270.0, 20.0]]

[camera]
path_m = [[-4.0, 1.0, 6.0], [4.0, 1.0, 6.0]]
look_at_m = [0.0, 0.5, 0.0]
fov_deg = 50.0
height_px = 720

[[species]]
name = \"shrub\"
file = \"shrub.glb\"

[[instance]]
species = \"shrub\"
position_m = [-1.0, 0.0, 0.0]

[[instance]]
species = \"shrub\"
position_m = [1.0, 0.0, 0.0]
yaw_deg = 70.0
scale = 1.2
";

fn folder(model: &[&str]) -> Folder {
    let flags = [&["--lattice", "32", "--voxels", "256"], model].concat();
    let folder = Folder::with_baked(&["shrub"], &flags, &[0]);
    folder.write("scene.toml", SCENE);
    folder
}

fn stream(folder: &Folder, flags: &[&str]) -> Value {
    let run = folder.flb_with(&["stream", "shrub.flb", "scene.toml", "--json"], flags).expect_code(0);
    assert_eq!(misfits(&schema("stream"), &run.json()), [""; 0], "{}", run.stdout);
    run.json()
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("{key} in {value}"))
}

#[test]
fn a_slow_link_is_slower_and_a_small_budget_is_kept() {
    let folder = folder(&PAPER);
    let usual = stream(&folder, &[]);
    assert_eq!((&usual["instances"], &usual["frames"]), (&json!(2), &json!(600)));
    assert!(number(&usual, "bytes") < number(&usual, "file_bytes"), "the medium is never fetched: {usual}");
    assert_eq!(usual["stalls"]["count"], 0, "bases are there before the sun needs them: {usual}");
    assert!(number(&usual, "first_picture_s") < number(&usual, "final_picture_s") + 1e-9);

    let slow = stream(&folder, &["--rtt", "300", "--bandwidth", "0.5"]);
    assert!(number(&slow, "first_picture_s") > 3.0 * number(&usual, "first_picture_s"));
    assert!(number(&slow, "mean_quality") < number(&usual, "mean_quality"));

    let small = stream(&folder, &["--budget", "0.3"]);
    assert!(number(&small, "peak_bytes") <= 300_000.0 && number(&small, "evictions") > 0.0, "{small}");
    assert!(number(&small, "peak_bytes") < number(&usual, "peak_bytes"));
    assert_eq!(stream(&folder, &["--budget", "0.3"]), small, "the same every time");
}

#[test]
fn a_trace_has_every_frame_and_adds_up() {
    let folder = folder(&[]);
    let streamed = stream(&folder, &["--trace", "trace.json", "--seconds", "2", "--fps", "30"]);
    let trace: Value = serde_json::from_slice(&folder.read("trace.json")).expect("JSON");
    let moments = trace["moments"].as_array().expect("a list");
    assert_eq!(moments.len(), 60);
    let sum = |key: &str| moments.iter().map(|moment| number(moment, key)).sum::<f64>();
    assert_eq!(sum("requests") + 1.0, number(&streamed, "requests"));
    assert_eq!(sum("requested_bytes") + number(&streamed, "opening_bytes"), number(&streamed, "bytes"));
    let most = moments.iter().map(|moment| number(moment, "loaded_bytes")).fold(0.0, f64::max);
    assert_eq!(most, number(&streamed, "peak_bytes"));
    let first = moments.iter().find(|moment| moment["is_complete"] == true).expect("a first picture");
    assert_eq!(first["time_s"], streamed["first_picture_s"]);
    assert_eq!(trace["stalls"], streamed["stalls"]);

    // For people, and not over a file that is there.
    let words = ["stream", "shrub.flb", "scene.toml", "--trace", "trace.json"];
    folder.flb(&words).expect_code(4).says(&["trace.json: exists already; use --force"]);
    let run = folder.flb_with(&words, &["--force"]).expect_code(0);
    assert!(
        run.stdout.contains("first picture") && run.stdout.contains("600 frames in 10 s"),
        "{}",
        run.stdout
    );
}

#[test]
fn plants_that_are_seen_in_water_alone_are_streamed() {
    let folder = folder(&PAPER);
    let down =
        SCENE.replace("look_at_m = [0.0, 0.5, 0.0]", "look_at_path_m = [[-4.0, 0.0, 5.0], [4.0, 0.0, 5.0]]");
    assert!(down != SCENE);
    folder.write("scene.toml", &down);
    let dry = stream(&folder, &[]);
    folder.write("scene.toml", format!("{down}\n[water]\nheight_m = 0.0\n"));
    let wet = stream(&folder, &[]);
    assert_eq!((&dry["peak_bytes"], &dry["requests"]), (&json!(0), &json!(1)), "the file is opened: {dry}");
    assert!(number(&wet, "peak_bytes") > 50_000.0 && number(&wet, "requests") > 1.0, "{wet}");
}

#[test]
fn what_a_replay_cannot_do_without_is_asked_for() {
    let folder = folder(&PAPER);
    let refused = |from: &str, to: &str, says: &str| {
        assert!(SCENE.contains(from));
        folder.write("other.toml", SCENE.replace(from, to));
        folder.flb(&["stream", "shrub.flb", "other.toml"]).expect_code(2).says(&["other.toml", says]);
    };
    refused("look_at_m = [0.0, 0.5, 0.0]\n", "", "[camera] has no look_at_m, which a picture needs");
    let suns = "fixed = [[90.0, 20.0], [180.0, 60.0], [270.0, 20.0]]\n";
    refused(&format!("[sun]\n{suns}"), "", "expected `fixed =");
    let day = "path = { latitude_deg = 52.5, longitude_deg = 13.4, from = 2026-06-21, to = 2026-06-21 }\n";
    folder.write("day.toml", SCENE.replace(suns, day));
    folder.flb(&["stream", "shrub.flb", "day.toml"]).expect_code(0);
    refused(
        "name = \"shrub\"\n",
        "name = \"shrub\"\nlight = \"shrub.flb\"\nlight_species = \"oak\"\n",
        "shrub.flb: no species is named \"oak\"; there are: shrub",
    );
    folder
        .flb(&["stream", "shrub.flb", "scene.toml", "--bandwidth", "0"])
        .expect_code(2)
        .says(&["more than 0"]);
    folder.flb(&["stream", "shrub.flb", "scene.toml", "--rtt", "nan"]).expect_code(2).says(&["--rtt"]);
    folder
        .flb(&["stream", "shrub.flb", "scene.toml", "--seconds", "1e6", "--fps", "60"])
        .expect_code(6)
        .says(&["60000000 frames, expected at most 1000000"]);

    folder.flb(&["pack", "shrub.flb", "-o", "raw.flb", "--codec", "raw-f16"]).expect_code(0);
    folder
        .flb(&["stream", "raw.flb", "scene.toml"])
        .expect_code(5)
        .says(&["species \"shrub\" is coded as raw-f16, expected classed or haar"]);
}

#[test]
fn a_page_that_is_wrong_is_a_loss_and_the_rest_streams() {
    let folder = folder(&PAPER);
    let library = flb_runtime::Library::open(folder.path("shrub.flb")).expect("it opens");
    let container = library.container();
    let sky = container.find_base(0, 0).expect("the sky's base");
    let page = container.pages(sky.detail.expect("coded near geometry"))[0];
    let mut bytes = folder.read("shrub.flb");
    drop(library);
    bytes[page.offset as usize + 5] ^= 1;
    folder.write("shrub.flb", bytes);
    let run = folder.flb(&["stream", "shrub.flb", "scene.toml", "--json"]).expect_code(3);
    let run = run.says(&["flb: shrub.flb: given up: FLB-", "digest"]);
    let streamed = run.json();
    assert_eq!(streamed["failures"].as_array().map(Vec::len), Some(1), "{streamed}");
    assert!(number(&streamed, "first_picture_s") > 0.0 && number(&streamed, "final_picture_s") > 0.0);
}

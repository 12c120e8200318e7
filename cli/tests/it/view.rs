//! `flb view`, without a window and under a virtual screen.

#[cfg(target_os = "linux")]
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::flb::{Folder, PAPER};
use crate::picture;
use crate::schema::{misfits, schema};
#[cfg(target_os = "linux")]
use flb_testkit::xvfb::Xvfb;

const SIZE: [usize; 2] = [480, 270];
/// Of it, the panel takes the rest.
const PICTURE: usize = 220;

/// With a stand of twelve plants in the light of one library.
fn stand(lattice: &str, model: &[&str]) -> Folder {
    let flags = [&["--lattice", lattice, "--voxels", "128"], model].concat();
    let folder = Folder::with_baked(&["oak", "shrub"], &flags, &[0, 3]);
    folder.flb(&["pack", "oak.flb", "shrub.flb", "-o", "plants.flb"]).expect_code(0);
    let species = ["--species", "oak=oak.glb,plants.flb", "--species", "shrub=shrub.glb,plants.flb"];
    folder
        .flb_with(&["scatter", "--count", "12", "--area", "30,20", "-o", "stand.toml"], &species)
        .expect_code(0);
    folder
}

fn pixels(png: &[u8]) -> Vec<[u8; 3]> {
    picture::pixels(png).as_chunks::<3>().0.to_vec()
}

fn shoot(folder: &Folder, show: &str, more: &[&str]) -> (Vec<[u8; 3]>, Value) {
    shoot_at(folder, SIZE, show, more)
}

fn shoot_at(folder: &Folder, size: [usize; 2], show: &str, more: &[&str]) -> (Vec<[u8; 3]>, Value) {
    let size_word = format!("{}x{}", size[0], size[1]);
    let words = ["view", "stand.toml", "--size", &size_word, "--screenshot", "view.png", "--force", "--json"];
    let run = folder.flb_with(&words, &[&["--show", show], more].concat()).expect_code(0);
    let report = run.json();
    assert_eq!(misfits(&schema("view"), &report), [""; 0], "{report}");
    let pixels = pixels(&folder.read("view.png"));
    assert_eq!(pixels.len(), size[0] * size[1]);
    (pixels, report)
}

/// The part of a screenshot beside the panel.
fn picture(pixels: &[[u8; 3]]) -> Vec<[u8; 3]> {
    beside_panel(pixels, SIZE[0])
}

fn beside_panel(pixels: &[[u8; 3]], width: usize) -> Vec<[u8; 3]> {
    pixels.chunks_exact(width).flat_map(|row| row[..width - (SIZE[0] - PICTURE)].to_vec()).collect()
}

fn mean(pixels: &[[u8; 3]]) -> [f64; 3] {
    std::array::from_fn(|band| pixels.iter().map(|p| f64::from(p[band])).sum::<f64>() / pixels.len() as f64)
}

#[test]
fn a_window_shows_the_scene_its_light_and_a_panel() {
    let folder = stand("16", &PAPER);
    let (whole, report) = shoot(&folder, "all", &[]);
    assert_eq!((&report["is_final"], &report["instances"]), (&Value::Bool(true), &Value::from(12)));
    assert!(report["loaded_bytes"].as_u64().expect("a number") > 10_000, "{report}");
    // The panel: text on a dark ground, so pixels of both.
    let panel: Vec<[u8; 3]> =
        whole.chunks_exact(SIZE[0]).flat_map(|row| row[SIZE[0] - 200..].to_vec()).collect();
    let dark = panel.iter().filter(|p| p.iter().all(|v| *v < 60)).count();
    let bright = panel.iter().filter(|p| p.iter().all(|v| *v > 120)).count();
    assert!(dark > panel.len() / 2 && bright > 300, "{dark} dark and {bright} bright of {}", panel.len());
    // The same bytes again, and by one thread.
    assert_eq!(shoot(&folder, "all", &["--threads", "1"]).0, whole);

    let whole = picture(&whole);
    let indirect = picture(&shoot(&folder, "indirect", &[]).0);
    let direct = picture(&shoot(&folder, "direct", &[]).0);
    let [all, baked, sun] = [&whole, &indirect, &direct].map(|pixels| mean(pixels)[1]);
    assert!(all > baked + 5.0 && all > sun + 0.5 && sun > 5.0 && baked > 2.0, "{all} {baked} {sun}");
    let darker = picture(&shoot(&folder, "all", &["--exposure", "-2"]).0);
    assert!(mean(&darker)[1] < 0.75 * all, "two stops are seen");
    let evening = picture(&shoot(&folder, "all", &["--sun", "270,4"]).0);
    assert!(evening != whole);

    // Everything is loaded: plants are green by level, white by residency, and where the error is black.
    let level = mean(&picture(&shoot(&folder, "level", &[]).0));
    assert!(level[1] > 1.5 * level[0] && level[1] > 1.5 * level[2], "{level:?}");
    let count = |pixels: &[[u8; 3]], test: fn(&[u8; 3]) -> bool| pixels.iter().filter(|p| test(p)).count();
    let residency = picture(&shoot(&folder, "residency", &[]).0);
    let green = count(&picture(&shoot(&folder, "level", &[]).0), |p| p[1] > 120 && p[0] < 120);
    let white = count(&residency, |p| p.iter().all(|v| *v > 200));
    assert!(green > 500 && white * 10 > green * 9, "{white} of {green}");
    let error = picture(&shoot(&folder, "error", &[]).0);
    assert_eq!(count(&error, |p| p[0] > 120), 0, "nothing is missing");
    // One base of two is another picture.
    assert_ne!(shoot(&folder, "base:0", &[]).0, shoot(&folder, "base:4", &[]).0);
}

#[test]
fn too_little_memory_shows_in_the_views_of_what_is_missing() {
    let folder = stand("64", &["--suns", "lattice18", "--target-psnr", "60"]);
    let (whole, report) = shoot(&folder, "all", &[]);
    assert!(report["loaded_bytes"].as_u64().expect("bytes") > 1_000_000, "{report}");
    let (small, report) = shoot(&folder, "all", &["--budget", "0.5"]);
    assert!(report["loaded_bytes"].as_u64().expect("bytes") <= 500_000, "{report}");
    assert!(report["quality"].as_f64().expect("a share") < 1.0, "{report}");
    assert_ne!(picture(&small), picture(&whole));
    let white = |show: &str, more: &[&str]| {
        let pixels = picture(&shoot(&folder, show, more).0);
        pixels.iter().filter(|p| p.iter().all(|v| *v > 200)).count()
    };
    let (all, some) = (white("residency", &[]), white("residency", &["--budget", "1"]));
    assert!(some * 10 < all * 9, "{some} of {all} are loaded whole");
    let error = picture(&shoot(&folder, "error", &["--budget", "1"]).0);
    assert!(error.iter().filter(|p| p[0] > 60).count() > 100, "and it is seen where light is off");
}

#[test]
fn plants_stand_in_the_light_that_others_leave_them_as_in_a_render() {
    for suns in ["sh1", "lattice18"] {
        among_neighbours(suns);
    }
}

fn among_neighbours(suns: &str) {
    let folder = stand("16", &["--suns", suns, "--ordinates", "18"]);
    let bake = ["bake-scene", "stand.toml", "-o", "light.flb", "--lattice", "16", "--ordinates", "18"];
    folder.flb(&bake).expect_code(0);
    let with = ["--scene-light", "light.flb"];
    let alone = picture(&shoot(&folder, "indirect", &[]).0);
    let among = picture(&shoot(&folder, "indirect", &with).0);
    let [bright, dark] = [&alone, &among].map(|pixels| mean(pixels)[1]);
    assert!(dark < 0.97 * bright, "{dark} among others, {bright} alone");
    // The same as a render of the picture's size.
    let [width, height] = [SIZE[0] - 250, SIZE[1]];
    let size = format!("{width}x{height}");
    let words =
        ["render", "stand.toml", "--size", &size, "--samples", "4", "--show", "indirect", "-o", "a.png"];
    let clear = ["--scene-light", "light.flb", "--sky", "clear", "--turbidity", "4", "--backend", "cpu"];
    let (under_clear, _) = shoot(&folder, "indirect", &clear);
    let under_clear = picture(&under_clear);
    let is_even_alone = suns == "lattice18";
    let run = folder.flb_with(&["view", "stand.toml", "--screenshot", "view.png", "--force"], &clear);
    let run = run.expect_code(0);
    match is_even_alone {
        true => drop(run.says(&["warning: oak: shown under an even sky"])),
        false => assert!(distance(&under_clear, &among) > 2.0, "{}", distance(&under_clear, &among)),
    }
    let mut cases = vec![(alone, &[][..]), (among, &with)];
    cases.extend((!is_even_alone).then_some((under_clear, &clear[..6])));
    for (view, more) in cases {
        folder.flb_with(&words, &[more, &["--force"]].concat()).expect_code(0);
        let rendered = pixels(&folder.read("a.png"));
        let rendered: Vec<[u8; 3]> =
            rendered.chunks_exact(width).flat_map(|row| row[..PICTURE].to_vec()).collect();
        let apart = distance(&view, &rendered);
        assert!(apart < 1.0, "{suns}: {apart} of 255");
    }
    let scene = String::from_utf8(folder.read("stand.toml")).expect("TOML is text");
    let one_more = "[[instance]]\nspecies = \"oak\"\nposition_m = [0.5, 0.0, 0.5]\n";
    folder.write("more.toml", format!("{scene}\n{one_more}"));
    let run = folder.flb_with(&["view", "more.toml", "--screenshot", "more.png"], &with);
    run.expect_code(2).says(&["light.flb", "bake-scene"]);
}

#[test]
fn water_mirrors_in_the_window_as_in_a_render_and_the_camera_stays_above() {
    let folder = stand("16", &["--suns", "lattice18", "--ordinates", "18"]);
    let dry = picture(&shoot(&folder, "direct", &[]).0);
    let scene = String::from_utf8(folder.read("stand.toml")).expect("TOML is text");
    folder.write("stand.toml", format!("water = {{ height_m = 0.3 }}\n{scene}"));
    let wet = picture(&shoot(&folder, "direct", &[]).0);
    assert!(distance(&dry, &wet) > 5.0);
    let [width, height] = [SIZE[0] - 250, SIZE[1]];
    let size = format!("{width}x{height}");
    let words =
        ["render", "stand.toml", "--size", &size, "--samples", "4", "--show", "direct", "-o", "a.png"];
    folder.flb(&words).expect_code(0);
    let rendered: Vec<[u8; 3]> =
        pixels(&folder.read("a.png")).chunks_exact(width).flat_map(|row| row[..PICTURE].to_vec()).collect();
    let apart = distance(&wet, &rendered);
    assert!(apart < 1.0, "{apart} of 255");
    let by_gpu = picture(&shoot(&folder, "direct", &["--backend", "gpu"]).0);
    let apart = distance(&wet, &by_gpu);
    assert!(apart < 1.0, "{apart} of 255");
    // A camera that stands in the water is lifted out of it, which a render refuses.
    let camera = scene.find("position_m = [").expect("the camera's is the first");
    let end = camera + scene[camera..].find('\n').expect("a line");
    let sunk = [&scene[..camera], "position_m = [0.0, -3.0, 40.0]", &scene[end..]].concat();
    folder.write("stand.toml", format!("water = {{ height_m = 0.3 }}\n{sunk}"));
    folder.flb_with(&words, &["--force"]).expect_code(2).says(&["-3 m", "[water]"]);
    let lifted = [&scene[..camera], "position_m = [0.0, 0.35, 40.0]", &scene[end..]].concat();
    let [sunk, lifted] = [sunk, lifted].map(|scene| {
        folder.write("stand.toml", format!("water = {{ height_m = 0.3 }}\n{scene}"));
        mean(&picture(&shoot(&folder, "indirect", &[]).0))[1]
    });
    assert!(sunk > 0.5 * lifted && lifted > 2.0, "{sunk} from below, {lifted} from above the water");
}

#[test]
fn a_gpu_paints_what_the_cpu_does() {
    // Small, as a GPU in software takes a millisecond for a few pixels.
    let size = [SIZE[0] - 100, 120];
    let shoot = |folder: &Folder, show: &str, more: &[&str]| shoot_at(folder, size, show, more);
    let picture = |pixels: &[[u8; 3]]| beside_panel(pixels, size[0]);
    // Of harmonics, noise of the near beam depends on the last bits of a point.
    let shows = [["all", "level"], ["indirect", "all"]];
    for (model, most) in [(&PAPER[..], 0.7), (&["--suns", "sh1", "--ordinates", "18"], 2.5)] {
        let folder = stand("32", model);
        let bake = ["bake-scene", "stand.toml", "-o", "light.flb", "--lattice", "16", "--ordinates", "18"];
        let is_paper = model == PAPER;
        if !is_paper {
            folder.flb(&bake).expect_code(0);
        }
        for show in shows[usize::from(!is_paper)] {
            let more = [&[][..], &["--scene-light", "light.flb"]][usize::from(show == "indirect")];
            let by = |backend| {
                let (pixels, report) = shoot(&folder, show, &[&["--backend", backend][..], more].concat());
                assert_eq!(report["adapter"].is_string(), backend == "gpu", "{report}");
                assert_eq!(report["is_final"], true, "{report}");
                picture(&pixels)
            };
            let on_gpu = by("gpu");
            let off = distance(&on_gpu, &by("cpu"));
            assert!(off < most, "{model:?} {show}: {off} of 255");
            if !more.is_empty() {
                let alone = distance(&on_gpu, &picture(&shoot(&folder, show, &["--backend", "gpu"]).0));
                assert!(alone > 2.0 * off, "{model:?} {show}: {alone} of 255 without neighbours, {off} off");
            }
        }
        if !is_paper {
            continue;
        }
        // What does not fit is coarse on both.
        let [small, cpu] = ["gpu", "cpu"].map(|backend| {
            let (pixels, report) = shoot(&folder, "indirect", &["--backend", backend, "--budget", "1"]);
            assert!(report["loaded_bytes"].as_u64().expect("bytes") <= 1_000_000, "{report}");
            picture(&pixels)
        });
        let off = distance(&small, &cpu);
        assert!(off < most, "{model:?}: {off} of 255");
    }
    // Software is passed over.
    let folder = stand("16", &PAPER);
    assert_eq!(shoot(&folder, "all", &[]).1["adapter"], Value::Null);
    let scene = String::from_utf8(folder.read("stand.toml")).expect("TOML is text");
    folder.write("two.toml", scene.replacen("plants.flb", "oak.flb", 1));
    let run = folder.flb(&["view", "two.toml", "--screenshot", "two.png", "--backend", "gpu"]);
    run.expect_code(5).says(&["2 files", "flb pack", "CPU"]);
}

#[test]
fn what_cannot_be_shown_is_said() {
    let folder = stand("16", &PAPER);
    let say = |words: &[&str], code: i32, says: &[&str]| {
        folder.flb_with(&["view", "stand.toml"], words).expect_code(code).says(says);
    };
    say(&["--screenshot", "view.jpg"], 2, &["view.jpg", "PNG"]);
    say(&["--show", "base:x"], 2, &["--show", "base:N"]);
    say(&["--show", "base:19", "--screenshot", "view.png"], 2, &["base:19", "bases 0 to 18"]);
    say(&["--exposure", "nan"], 2, &["--exposure", "stops"]);
    say(&["--screenshot", "view.png", "--size", "20000x10"], 6, &["20000 x 10", "pixels"]);
    say(&["--screenshot", "stand.toml"], 2, &["stand.toml"]);
    folder.write("view.png", b"mine");
    say(&["--screenshot", "view.png", "--size", "64x64"], 4, &["view.png", "--force"]);
    assert_eq!(folder.read("view.png"), b"mine");
    folder.flb(&["view", "none.toml", "--screenshot", "a.png"]).expect_code(4).says(&["none.toml"]);
    // No screen: an error that names the way without one.
    let none = [("DISPLAY", ""), ("WAYLAND_DISPLAY", "")];
    let run = folder.flb_in(&none, &["view", "stand.toml", "--seconds", "1"]);
    run.expect_code(5).says(&["window", "--screenshot"]);
}

/// How far two pictures are from each other, of 255.
fn distance(one: &[[u8; 3]], other: &[[u8; 3]]) -> f64 {
    picture::rms(one.as_flattened(), other.as_flattened())
}

#[test]
#[cfg(target_os = "linux")]
fn a_window_on_a_screen_shows_what_a_screenshot_does_and_hears_keys() {
    let folder = stand("16", &PAPER);
    let [whole, direct] = ["all", "direct"].map(|show| picture(&shoot(&folder, show, &[]).0));
    let apart = distance(&whole, &direct);
    assert!(apart > 8.0, "{apart}");
    let screen = Xvfb::start(SIZE.map(|edge| edge as u16));
    let display = [("DISPLAY", screen.display.as_str()), ("WAYLAND_DISPLAY", "")];
    let mut window = folder.start(&display, &["view", "stand.toml", "--size", "480x270", "--seconds", "600"]);
    // As soon as it shows this; else what it shows at last.
    let mut comes = |expected: &[[u8; 3]]| {
        let end = Instant::now() + Duration::from_secs(240);
        loop {
            let photograph = screen.photograph();
            let found = distance(&picture(&photograph), expected);
            let has_ended = window.try_wait().expect("a process").is_some();
            if found < 1.0 || has_ended || Instant::now() > end {
                return (found, photograph);
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    };
    let (found, photograph) = comes(&whole);
    assert!(found < 1.0, "{found} of 255 from the screenshot");
    let bright = photograph.iter().skip(SIZE[0] - 200).step_by(SIZE[0]).filter(|p| p[0] > 20).count();
    assert!(bright > 100, "the panel is beside it: {bright} rows");
    screen.press('3');
    let (found, _) = comes(&direct);
    assert!(found < 1.0, "{found} of 255 from the screenshot of direct light");
    window.kill().expect("it runs");
    window.wait().expect("it ends");

    let run =
        folder.flb_in(&display, &["view", "stand.toml", "--size", "480x270", "--seconds", "0.5", "--json"]);
    let report = run.expect_code(0).json();
    assert_eq!(misfits(&schema("view"), &report), [""; 0], "{report}");
    assert_eq!(report["screenshot"], Value::Null);
}

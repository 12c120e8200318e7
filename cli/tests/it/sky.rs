//! `--sky` and the `[sky]` of a scene: clear skies and images, over a plant and over a stand.

use crate::flb::{FEW, Folder, PAPER, Run};
use crate::picture::{pixels, rms};
use crate::schema::{misfits, schema};

/// With `shrub.glb` and its light by a model in `shrub.flb`.
fn shrub(model: &[&str]) -> Folder {
    let flags = [&["--lattice", "16", "--voxels", "128"], model].concat();
    Folder::with_baked(&["shrub"], &flags, &[0, 3])
}

/// A Radiance picture of 8 x 4 pixels, `[y][x]` bright in the east or in the west.
fn hdr(bright: impl Fn(usize) -> bool) -> Vec<u8> {
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n".to_vec();
    for at in 0..32 {
        // Mantissa and exponent: 0.5, or a hundredth of it.
        bytes.extend(if bright(at % 8) { [128, 128, 128, 128] } else { [1, 1, 2, 128] });
    }
    bytes
}

fn scene(folder: &Folder, name: &str, sky: &str) {
    let text = format!(
        "{sky}[camera]\nposition_m = [0.0, 1.0, 6.0]\nlook_at_m = [0.0, 0.8, 0.0]\nfov_deg = 40.0\nheight_px = 24\n\
         [ground]\n[[species]]\nname = \"shrub\"\nfile = \"shrub.glb\"\nlight = \"shrub.flb\"\n\
         [[instance]]\nspecies = \"shrub\"\nposition_m = [-1.0, 0.0, 0.0]\nyaw_deg = 130.0\n\
         [[instance]]\nspecies = \"shrub\"\nposition_m = [1.0, 0.0, 0.5]\n"
    );
    folder.write(name, text);
}

fn render(folder: &Folder, file: &str, words: &[&str]) -> Run {
    folder.flb_with(&["render", file, "--samples", "1", "-o", "out.png", "--force", "--json"], words)
}

fn seen(folder: &Folder, file: &str, words: &[&str]) -> Vec<u8> {
    render(folder, file, words).expect_code(0);
    pixels(&folder.read("out.png"))
}

/// Mean of a band over columns of a picture of so many in a row.
fn mean(pixels: &[u8], width: usize, columns: std::ops::Range<usize>, band: usize) -> f64 {
    let of = pixels.as_chunks::<3>().0.iter().enumerate().filter(|(at, _)| columns.contains(&(at % width)));
    let (sum, count) =
        of.fold((0.0, 0.0), |(sum, count), (_, rgb)| (sum + f64::from(rgb[band]), count + 1.0));
    sum / count
}

#[test]
fn a_scene_s_sky_and_the_flag_draw_the_same_and_the_flag_wins() {
    let folder = shrub(&FEW);
    let sun = ["--sun", "100,30"];
    scene(&folder, "plain.toml", "");
    scene(&folder, "clear.toml", "[sky]\nclear = { turbidity = 6.0 }\nambient = 0.8\n");
    let even = seen(&folder, "plain.toml", &sun);
    let hazy = seen(&folder, "clear.toml", &sun);
    assert!(rms(&even, &hazy) > 5.0, "{}", rms(&even, &hazy));
    let flags = ["--sky", "clear", "--turbidity", "6", "--ambient", "0.8"];
    assert_eq!(seen(&folder, "plain.toml", &[&sun[..], &flags].concat()), hazy);
    assert_eq!(seen(&folder, "clear.toml", &[&sun[..], &["--threads", "1"]].concat()), hazy);
    assert_eq!(
        seen(&folder, "clear.toml", &[&sun[..], &["--sky", "even", "--ambient", "0.36"]].concat()),
        even
    );
    let clearer = seen(&folder, "clear.toml", &[&sun[..], &["--turbidity", "2"]].concat());
    assert!(rms(&clearer, &hazy) > 1.0, "{}", rms(&clearer, &hazy));
}

#[test]
fn a_day_of_frames_has_the_colours_of_its_sun() {
    let folder = shrub(&FEW);
    scene(&folder, "day.toml", "[sky]\nclear = {}\n");
    let words =
        ["--frames", "3", "--sun-path", "52.5,13.4,2026-06-21T03:30..2026-06-21T21:00", "--exposure", "3"];
    render(&folder, "day.toml", &words).expect_code(0);
    let frame = |number: u32| pixels(&folder.read(&format!("out-{number:04}.png")));
    let [dawn, noon, night] = [frame(1), frame(2), frame(3)];
    let of = |pixels: &[u8], band: usize| mean(pixels, 42, 0..42, band);
    let warmth = |pixels: &[u8]| of(pixels, 0) / of(pixels, 2);
    assert!(warmth(&dawn) > 1.1 * warmth(&noon), "{} and {}", warmth(&dawn), warmth(&noon));
    assert!(of(&noon, 1) > 1.3 * of(&dawn, 1), "{} and {}", of(&noon, 1), of(&dawn, 1));
    assert!(of(&night, 1) < 0.2 * of(&dawn, 1), "{} and {}", of(&night, 1), of(&dawn, 1));
}

#[test]
fn an_image_lights_plants_from_its_bright_side_without_a_sun() {
    let folder = shrub(&FEW);
    // North is in the middle of an image, east in the middle of its right half.
    folder.write("east.hdr", hdr(|column| column >= 4)).write("west.hdr", hdr(|column| column < 4));
    for (name, file) in [("east.toml", "east.hdr"), ("west.toml", "west.hdr")] {
        scene(&folder, name, &format!("[sky]\nimage = \"{file}\"\nambient = 2.0\n"));
    }
    let only = ["--show", "indirect"];
    let [east, west] = ["east.toml", "west.toml"].map(|file| seen(&folder, file, &only));
    let run = render(&folder, "east.toml", &only).expect_code(0).json();
    assert_eq!(misfits(&schema("render"), &run), [""; 0], "{run}");
    assert_eq!(run["suns"], serde_json::json!([]));
    // The eastern plant stands on the right.
    let right_over_left = |pixels: &[u8]| mean(pixels, 42, 28..42, 1) / mean(pixels, 42, 0..14, 1);
    assert!(
        right_over_left(&east) > 1.03 * right_over_left(&west),
        "{} and {}",
        right_over_left(&east),
        right_over_left(&west)
    );
    let plain = ["--mesh", "shrub.glb", "--size", "24x24"];
    let mut one = |file: &str| seen(&folder, "shrub.flb", &[&plain[..], &only, &["--sky", file]].concat());
    let [east, west] = ["east.hdr", "west.hdr"].map(&mut one);
    let right_over_left = |pixels: &[u8]| mean(pixels, 24, 12..24, 1) / mean(pixels, 24, 0..12, 1);
    assert!(right_over_left(&east) > 1.2 * right_over_left(&west));
    // The scene's file is kept, whatever the output is called.
    let over = folder.flb(&["render", "east.toml", "-o", "east.hdr", "--force"]).expect_code(2);
    over.says(&["east.hdr"]);
    folder
        .flb(&[
            "render",
            "shrub.flb",
            "--mesh",
            "shrub.glb",
            "--sky",
            "east.hdr",
            "-o",
            "east.hdr",
            "--force",
        ])
        .expect_code(2);
}

#[test]
fn skies_that_cannot_be_are_refused_by_what_was_found() {
    let folder = shrub(&FEW);
    scene(&folder, "plain.toml", "");
    scene(&folder, "clear.toml", "[sky]\nclear = {}\n");
    scene(&folder, "lost.toml", "[sky]\nimage = \"lost.hdr\"\n");
    folder.write("square.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 2\n0123456789abcdef");
    folder.write("dark.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\0\0\0\0\0\0\0\0");
    folder.write("cut.hdr", &hdr(|_| false)[..80]);
    let sun = ["--sun", "100,30"];
    let plant = ["--mesh", "shrub.glb", "--size", "16x16"];
    for (sky, code, expected) in [
        (&["--sky", "clear", "--turbidity", "11"][..], 2, &["turbidity", "11", "2"][..]),
        (&["--turbidity", "3"], 2, &["--turbidity is for --sky clear"]),
        (&["--sky", "square.hdr"], 1, &["square.hdr", "2 x 2"]),
        (&["--sky", "dark.hdr"], 1, &["dark.hdr", "light"]),
        (&["--sky", "cut.hdr"], 1, &["cut.hdr"]),
        (&["--sky", "none.hdr"], 4, &["none.hdr"]),
        (&["--sky", "shrub.glb"], 1, &["shrub.glb"]),
    ] {
        let words = [&sun[..], sky].concat();
        render(&folder, "plain.toml", &words).expect_code(code).says(expected);
        render(&folder, "shrub.flb", &[&words[..], &plant].concat()).expect_code(code).says(expected);
    }
    render(&folder, "lost.toml", &sun).expect_code(4).says(&["lost.hdr"]);
    render(&folder, "plain.toml", &["--sky", "clear"]).expect_code(2).says(&["no suns of its own"]);
    let paper = shrub(&PAPER);
    scene(&paper, "clear.toml", "[sky]\nclear = {}\n");
    render(&paper, "clear.toml", &sun).expect_code(2).says(&["clear.toml", "uneven sky", "physical"]);
    assert!(!paper.names().contains(&"out.png".to_owned()));
}

#[test]
fn a_viewer_shows_the_sky_of_its_scene_or_of_the_flag_and_refuses_what_a_picture_does() {
    let folder = shrub(&FEW);
    scene(&folder, "plain.toml", "");
    scene(&folder, "clear.toml", "[sky]\nclear = {}\n");
    folder.write("east.hdr", hdr(|column| column >= 4));
    let view = |file: &str, words: &[&str]| {
        let all = ["view", file, "--size", "64x48", "--screenshot", "v.png", "--force"];
        folder.flb_with(&all, words)
    };
    let seen = |file: &str, words: &[&str]| {
        view(file, words).expect_code(0);
        pixels(&folder.read("v.png"))
    };
    let even = seen("plain.toml", &[]);
    let clear = seen("clear.toml", &[]);
    assert!(rms(&even, &clear) > 2.0, "{}", rms(&even, &clear));
    assert_eq!(seen("plain.toml", &["--sky", "clear"]), clear);
    // An image alone, without a sun.
    let image = seen("plain.toml", &["--sky", "east.hdr"]);
    assert!(rms(&even, &image) > 2.0 && image.iter().any(|value| *value > 30), "{}", rms(&even, &image));
    let on_gpu = seen("plain.toml", &["--sky", "east.hdr", "--backend", "gpu"]);
    assert!(rms(&on_gpu, &image) < 0.3 * rms(&even, &image), "{}", rms(&on_gpu, &image));
    // Of one file; its light is of harmonics.
    let on_gpu = seen("clear.toml", &["--backend", "gpu"]);
    assert!(rms(&on_gpu, &clear) < 0.3 * rms(&even, &clear), "{}", rms(&on_gpu, &clear));
    view("plain.toml", &["--turbidity", "3"]).expect_code(2).says(&["--turbidity is for --sky clear"]);
    view("plain.toml", &["--sky", "none.hdr"]).expect_code(4).says(&["none.hdr"]);
    let paper = shrub(&PAPER);
    scene(&paper, "clear.toml", "[sky]\nclear = {}\n");
    let run = paper.flb(&["view", "clear.toml", "--screenshot", "v.png"]);
    run.expect_code(2).says(&["clear.toml", "uneven sky", "physical"]);
    assert!(!paper.names().contains(&"v.png".to_owned()));
}

#[test]
fn a_backdrop_is_drawn_behind_plants_of_either_model_and_lights_none_of_them() {
    for model in [&FEW[..], &PAPER] {
        let folder = shrub(model);
        folder.write("east.hdr", hdr(|column| column >= 4)).write("cut.hdr", &hdr(|_| false)[..80]);
        scene(&folder, "plain.toml", "");
        scene(&folder, "clouds.toml", "[sky]\nbackdrop = \"east.hdr\"\n");
        let sun = ["--sun", "100,30"];
        let (plain, clouds) = (seen(&folder, "plain.toml", &sun), seen(&folder, "clouds.toml", &sun));
        assert!(rms(&plain, &clouds) > 3.0, "{}", rms(&plain, &clouds));
        let by_flag = [&sun[..], &["--backdrop", "east.hdr"]].concat();
        assert_eq!(seen(&folder, "plain.toml", &by_flag), clouds);
        let on_gpu = seen(&folder, "clouds.toml", &[&sun[..], &["--backend", "gpu"]].concat());
        assert!(rms(&on_gpu, &clouds) < 0.3 * rms(&plain, &clouds), "{}", rms(&on_gpu, &clouds));
        // Light alone, before black.
        let light = [&sun[..], &["--show", "indirect"]].concat();
        assert_eq!(seen(&folder, "plain.toml", &light), seen(&folder, "clouds.toml", &light));
        let plant = [&["--mesh", "shrub.glb", "--size", "24x24"], &sun[..]].concat();
        let alone = seen(&folder, "shrub.flb", &plant);
        let before = seen(&folder, "shrub.flb", &[&plant[..], &["--backdrop", "east.hdr"]].concat());
        assert!(rms(&alone, &before) > 3.0, "{}", rms(&alone, &before));
        for file in ["cut.hdr", "none.hdr"] {
            let words = [&sun[..], &["--backdrop", file]].concat();
            let refused = render(&folder, "plain.toml", &words);
            assert_ne!(refused.code, 0);
            refused.says(&[file]);
        }
        let over = folder.flb(&["render", "clouds.toml", "-o", "east.hdr", "--force"]);
        over.expect_code(2).says(&["east.hdr"]);
        let view = ["view", "clouds.toml", "--size", "64x48", "--screenshot", "v.png", "--force"];
        folder.flb(&view).expect_code(0);
        let with = pixels(&folder.read("v.png"));
        folder
            .flb(&["view", "plain.toml", "--size", "64x48", "--screenshot", "v.png", "--force"])
            .expect_code(0);
        assert!(rms(&with, &pixels(&folder.read("v.png"))) > 3.0);
    }
}
